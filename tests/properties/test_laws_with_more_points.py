"""Laws in lanes with more points than curve coefficients: what is outside them, and drift."""

from __future__ import annotations

import numpy as np
import pytest

import galvi
from galvi.run.in_lanes.tables import tables_on_space
from galvi.tableau import Tableau
from tests.agreement.on_vector_spaces import symbolic

PIECES = galvi.composite(galvi.gauss(4), 2)
METHODS = (
    galvi.Galerkin(galvi.Polynomials(5), galvi.gauss(6)),
    galvi.Galerkin(galvi.Polynomials(4), galvi.gauss(10)),
    galvi.Galerkin(galvi.Polynomials(1), galvi.lobatto(2)),
    galvi.Galerkin(galvi.Polynomials(5), galvi.lobatto(7)),
    galvi.Galerkin(galvi.Polynomials(6), galvi.clenshaw_curtis(9)),
    galvi.Galerkin(galvi.PolynomialFourier(1, 2), galvi.gauss(16)),
    galvi.Galerkin(galvi.PiecewisePolynomials(3, 2), PIECES),
    galvi.Galerkin(galvi.PiecewiseHermite(2), PIECES),
)


@pytest.mark.parametrize("points", [8, 9, 14])
def test_more_points_cost_few_more_passes(points: int) -> None:
    start = galvi.problems.double_pendulum()
    passes = [
        galvi.integrate(start, galvi.Galerkin(galvi.Polynomials(7), rule), 0.05, 400).counts
        for rule in (galvi.gauss(7), galvi.gauss(points))
    ]
    assert passes[1]["linear_solves"] == 0
    assert passes[1]["iterations"] < 1.1 * passes[0]["iterations"]  # 1.02, 1.01, 0.98


def complement(table: Tableau) -> np.ndarray:
    return tables_on_space(table, None).complement.T


@pytest.mark.parametrize("method", METHODS, ids=lambda method: method.name)
def test_the_complement_of_the_slopes_is_an_orthogonal_projection(method: galvi.Galerkin) -> None:
    table = method.table
    C, weights = complement(table), np.diag(table.b)
    size = np.max(np.abs(table.slope))
    np.testing.assert_allclose(C @ table.slope, 0.0, atol=1e-14 * size)
    np.testing.assert_allclose(C @ C, C, atol=1e-14)
    np.testing.assert_allclose(weights @ C, (weights @ C).T, atol=1e-15)
    assert np.trace(C) == pytest.approx(table.psi.shape[0] - table.psi.shape[1])


@pytest.mark.parametrize(
    "steps", [100_000, pytest.param(1_000_000, marks=pytest.mark.slow)], ids=["1e5", "1e6"]
)
@pytest.mark.parametrize("points", [9, 16])
def test_energy_does_not_drift(points: int, steps: int) -> None:
    method = galvi.Galerkin(galvi.Polynomials(8), galvi.gauss(points))
    start = symbolic("elastic pendulum")
    run = galvi.integrate(start, method, 0.02, steps, save_every=steps // 500)
    energy = galvi.energy(run)
    assert run.success and run.counts["linear_solves"] == 0
    slope = np.polyfit(np.arange(energy.size) * (steps // 500), energy, 1)[0]
    assert abs(slope) < 2e-19 * np.max(np.abs(energy))  # 3.2e-20 a step
