"""Laws of motion in lanes: their derivatives, and constants of any order."""

from __future__ import annotations

import numpy as np
import pytest
import sympy as sp

import galvi
from galvi.lanes.dense import factored
from galvi.lanes.laws import planar_chain

METHOD = galvi.Galerkin(galvi.Polynomials(6), galvi.gauss(6))


@pytest.mark.parametrize("links", [1, 2, 3, 5])
def test_the_law_of_a_chain_has_the_derivatives_of_its_lagrangian(links: int) -> None:
    random = np.random.default_rng(links)
    chain = galvi.PlanarChain(random.uniform(1, 2, links), random.uniform(1, 2, links))
    q, v = random.normal(size=(2, links))
    forces, momenta, mass = planar_chain(links)(q, v, 0.0, chain.numbers)
    np.testing.assert_allclose(np.append(momenta, forces), chain.slopes(q, v), rtol=1e-13)
    full = np.array([[mass[max(i, j)][min(i, j)] for j in range(links)] for i in range(links)])
    np.testing.assert_allclose(full @ v, momenta, rtol=1e-13)


def test_the_factors_of_a_mass_are_l_and_1_over_d() -> None:
    random = np.random.default_rng(3)
    root = random.normal(size=(5, 5))
    matrix = root @ root.T + np.eye(5)
    rows = factored([list(matrix[i, : i + 1]) for i in range(5)])
    L = np.array([[*row[:-1], 1.0, *[0.0] * (4 - i)] for i, row in enumerate(rows)])
    D = np.diag([1.0 / row[-1] for row in rows])
    np.testing.assert_allclose(L @ D @ L.T, matrix, rtol=1e-12)


def test_constants_of_any_order_have_a_law() -> None:
    a, b, x, vx = sp.symbols("a b x v_x", real=True)
    L = (b - a) ** sp.Rational(7, 3) * vx**2 / 2 - x**2 / 2
    system = galvi.Lagrangian.from_sympy(L, (x,), (vx,), parameters={a: 1.0, b: 3.0})
    run = galvi.integrate(galvi.Problem(system, [0.4], [0.5]), METHOD, 0.05, 20)
    assert run.success and run.counts["linear_solves"] == 0
