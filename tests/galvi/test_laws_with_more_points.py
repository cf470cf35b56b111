"""Laws in lanes with more points than curve coefficients, against the general kernel."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import galvi
from galvi.run.in_lanes import laws as law_stepper
from galvi.run.in_lanes.laws import has_law
from galvi.tableau import Tableau
from tests.galvi.test_laws import LAGRANGIANS, problem

NAMES = ("elastic pendulum", "relativistic", "driven")
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


def differences(start: galvi.Problem, method: galvi.Galerkin, step: float, steps: int) -> float:
    """The largest difference of q, p and the curves between the kernels, over their sizes."""
    fast = galvi.integrate(start, method, step, steps)
    general = galvi.integrate(start, method, step, steps, solver="newton")
    assert fast.success and general.success, (fast.status, general.status)
    assert fast.counts["linear_solves"] == 0 < general.counts["linear_solves"]
    times = start.t0 + step * np.linspace(0.0, steps, 77)
    pairs = (fast.q, general.q), (fast.p, general.p), (fast(times), general(times))
    return max(float(np.max(np.abs(x - y)) / (np.max(np.abs(y)) or 1.0)) for x, y in pairs)


@pytest.mark.parametrize("method", METHODS, ids=lambda method: method.name)
@pytest.mark.parametrize("name", NAMES)
def test_spaces_and_rules_agree_with_the_general_kernel(name: str, method: galvi.Galerkin) -> None:
    assert differences(problem(name), method, 0.05, 40) < 1e-14


@pytest.mark.slow(beside="test_spaces_and_rules_agree_with_the_general_kernel")
@given(
    st.sampled_from([*LAGRANGIANS, "chain"]),
    st.integers(1, 12),
    st.integers(0, 12),
    st.floats(0.01, 0.04) | st.floats(-0.04, -0.01),
)
@settings(max_examples=40, deadline=None)
def test_any_number_of_points_agrees_with_the_general_kernel(
    name: str, degree: int, more: int, step: float
) -> None:
    chain = galvi.PlanarChain([1.0, 0.7, 1.3], [1.0, 0.8, 0.6], rods=True)
    start = problem(name) if name != "chain" else galvi.Problem(
        galvi.Lagrangian(chain, galvi.Rn(3)), [0.5, 1.0, -0.4], [0.1, 0.0, 0.3]
    )  # fmt: skip
    method = galvi.Galerkin(galvi.Polynomials(degree), galvi.gauss(degree + more))
    assert differences(start, method, step, 8) < 1e-14


@pytest.mark.parametrize("more", [0, 2])
@pytest.mark.parametrize("degrees", [(6, 4), (2, 7), (8, 3), (5, 5)])
@pytest.mark.parametrize("name", ["elastic pendulum", "driven"])
def test_a_degree_for_each_component_agrees_with_the_general_kernel(
    name: str, degrees: tuple[int, int], more: int
) -> None:
    space = galvi.ComponentPolynomials(degrees)
    method = galvi.Galerkin(space, galvi.gauss(max(degrees) + more))
    assert differences(problem(name), method, 0.04, 30) < 1e-14  # 1e-15


def test_components_of_other_degrees_that_the_mass_couples_are_left_to_the_general_kernel() -> None:
    start, rule = galvi.problems.double_pendulum(), galvi.gauss(5)
    other, same = (galvi.Galerkin(galvi.ComponentPolynomials(x), rule) for x in ((5, 4), (4, 4)))
    assert has_law(start, same) and not has_law(start, other)
    run = galvi.integrate(start, other, 0.02, 5)
    assert run.counts["linear_solves"] > 0 and "newton_steps" not in run.counts


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
    s = table.c.size
    return law_stepper.law_tables(table, 0.1, 8)[4][:s, :s].T


@pytest.mark.parametrize("method", METHODS, ids=lambda method: method.name)
def test_the_complement_of_the_slopes_is_an_orthogonal_projection(method: galvi.Galerkin) -> None:
    table = method.table
    C, weights = complement(table), np.diag(table.b)
    size = np.max(np.abs(table.slope))
    np.testing.assert_allclose(C @ table.slope, 0.0, atol=1e-14 * size)
    np.testing.assert_allclose(C @ C, C, atol=1e-14)
    np.testing.assert_allclose(weights @ C, (weights @ C).T, atol=1e-15)
    assert np.trace(C) == pytest.approx(table.psi.shape[0] - table.psi.shape[1])


@pytest.mark.parametrize("fault", ["sign", "none", "of a smaller space", "transposed"])
def test_a_wrong_complement_is_caught(fault: str, monkeypatch: pytest.MonkeyPatch) -> None:
    method, right = METHODS[1], law_stepper.law_tables
    smaller = galvi.Galerkin(galvi.Polynomials(3), galvi.gauss(10)).table
    transpose = complement(method.table)

    def wrong(table: Tableau, step: float, lanes: int, *_: None) -> tuple[np.ndarray, ...]:
        tables = list(right(table, step, lanes))
        turned = np.zeros_like(tables[4])
        turned[: len(transpose), : len(transpose)] = transpose  # C in place of C^T
        tables[4] = {
            "sign": -tables[4],
            "none": np.zeros_like(tables[4]),
            "of a smaller space": right(smaller, step, lanes)[4],
            "transposed": turned,
        }[fault]
        return tuple(tables)

    monkeypatch.setattr(law_stepper, "law_tables", wrong)
    with pytest.raises(AssertionError):
        assert differences(problem("elastic pendulum"), method, 0.05, 40) < 1e-14


@pytest.mark.parametrize(
    "steps", [100_000, pytest.param(1_000_000, marks=pytest.mark.slow)], ids=["1e5", "1e6"]
)
@pytest.mark.parametrize("points", [9, 16])
def test_energy_does_not_drift(points: int, steps: int) -> None:
    method = galvi.Galerkin(galvi.Polynomials(8), galvi.gauss(points))
    start = problem("elastic pendulum")
    run = galvi.integrate(start, method, 0.02, steps, save_every=steps // 500)
    energy = galvi.energy(run)
    assert run.success and run.counts["linear_solves"] == 0
    slope = np.polyfit(np.arange(energy.size) * (steps // 500), energy, 1)[0]
    assert abs(slope) < 2e-19 * np.max(np.abs(energy))  # 3.2e-20 a step
