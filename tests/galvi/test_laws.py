"""Laws of motion in lanes: the derivatives against SymPy, and runs against the general kernel."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import sympy as sp

import galvi
from galvi.lanes.dense import factored
from galvi.lanes.laws import planar_chain
from galvi.run.in_lanes.laws import has_law

x, y, vx, vy, t = sp.symbols("x y v_x v_y t", real=True)
PLACE, PACE = (x, y), (vx, vy)
r, phi, vr, vphi = sp.symbols("r phi v_r v_phi", real=True)

# name -> (L, q, v, q0, v0)
LAGRANGIANS: dict[str, tuple[Any, ...]] = {
    "elastic pendulum": (
        (vr**2 + r**2 * vphi**2) / 2 - 5 * (r - 1) ** 2 + 3 * r * sp.cos(phi),
        (r, phi), (vr, vphi), [1.1, 0.7], [0.0, 0.3],
    ),
    "Henon-Heiles": (
        (vx**2 + vy**2 - x**2 - y**2) / 2 - x**2 * y + y**3 / 3,
        PLACE, PACE, [0.1, 0.2], [0.3, -0.1],
    ),
    "polar Kepler": (
        (vr**2 + r**2 * vphi**2) / 2 + 1 / r, (r, phi), (vr, vphi), [0.8, 0.2], [0.1, 1.5],
    ),
    "relativistic": (
        -sp.sqrt(1 - vx**2 - vy**2) - (x**2 + 2 * y**2) / 5, PLACE, PACE, [0.5, 0.3], [0.4, 0.2],
    ),
    "driven": (
        vx**2 / 2 + sp.exp(x / 5) * vy**2 / 2 - x**2 - sp.log(2 + y**2) + x * sp.sin(2 * t),
        PLACE, PACE, [0.4, -0.2], [0.1, 0.6],
    ),
    "rational power": (
        (vx**2 + vy**2 + vx * vy / 3) / 2 - (1 + x**2 + y**2) ** sp.Rational(3, 4),
        PLACE, PACE, [0.4, -0.7], [0.5, 0.2],
    ),
    "from rest at the origin": (
        (vx**2 + vy**2) / 2 + x * sp.sin(2 * t + 1) - y * x, PLACE, PACE, [0.0, 0.0], [0.0, 0.0],
    ),
    "at rest": ((vx**2 + vy**2 - x**2 - y**2) / 2, PLACE, PACE, [0.0, 0.0], [0.0, 0.0]),
    "free": ((vx**2 + 3 * vy**2) / 2, PLACE, PACE, [0.4, -0.7], [0.5, 0.2]),
}  # fmt: skip
BY_NAME = pytest.mark.parametrize("name", LAGRANGIANS)
METHOD = galvi.Galerkin(galvi.Polynomials(6), galvi.gauss(6))


def problem(name: str) -> galvi.Problem:
    L, q, v, q0, v0 = LAGRANGIANS[name]
    found = galvi.Lagrangian.from_sympy(L, q, v, t if L.has(t) else None)
    return galvi.Problem(found, q0, v0, name=name)


@pytest.mark.slow_cases(but=["Henon-Heiles"])
@BY_NAME
def test_a_run_in_lanes_is_that_of_the_general_kernel(name: str) -> None:
    given = problem(name)
    assert has_law(given, METHOD)
    fast = galvi.integrate(given, METHOD, 0.05, 40)
    general = galvi.integrate(given, METHOD, 0.05, 40, solver="newton")
    assert fast.success and general.success, (fast.status, general.status)
    assert fast.counts["linear_solves"] == 0 < general.counts["linear_solves"]
    times = np.linspace(0.0, 2.0, 77)
    for one, other in ((fast.q, general.q), (fast.p, general.p), (fast(times), general(times))):
        np.testing.assert_allclose(one, other, rtol=0.0, atol=2e-14)


@pytest.mark.parametrize("degree", [1, 2, 3, 8, 9, 17])
def test_every_number_of_stages_has_its_lanes(degree: int) -> None:
    method = galvi.Galerkin(galvi.Polynomials(degree), galvi.gauss(degree))
    given = galvi.problems.double_pendulum()
    fast = galvi.integrate(given, method, 0.02, 30)
    general = galvi.integrate(given, method, 0.02, 30, solver="newton")
    np.testing.assert_allclose(fast.q, general.q, rtol=0.0, atol=1e-13)
    np.testing.assert_allclose(fast.p, general.p, rtol=0.0, atol=1e-12)


def test_a_step_too_long_for_the_iteration_is_left_to_newtons_method() -> None:
    given = galvi.problems.double_pendulum()
    run = galvi.integrate(given, METHOD, 0.25, 8)
    general = galvi.integrate(given, METHOD, 0.25, 8, solver="newton")
    assert run.success and run.counts["linear_solves"] > 0
    np.testing.assert_allclose(run.q, general.q, rtol=0.0, atol=1e-12)
    left = run.counts["newton_steps"]
    assert 0 < left <= 8 and "newton_steps" not in general.counts
    assert run.status.startswith(f"Completed. Newton's method did {left} of 8 steps,")
    assert general.status == "Completed."


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


def test_a_mass_without_a_first_pivot_is_left_to_the_general_kernel() -> None:
    L = vx * vy - x * y
    given = galvi.Problem(galvi.Lagrangian.from_sympy(L, PLACE, PACE), [0.4, -0.7], [0.5, 0.2])
    run = galvi.integrate(given, METHOD, 0.05, 20)
    assert run.success and run.counts["linear_solves"] > 0


def test_constants_of_any_order_have_a_law() -> None:
    a, b = sp.symbols("a b", real=True)
    L = (b - a) ** sp.Rational(7, 3) * vx**2 / 2 - x**2 / 2
    system = galvi.Lagrangian.from_sympy(L, (x,), (vx,), parameters={a: 1.0, b: 3.0})
    run = galvi.integrate(galvi.Problem(system, [0.4], [0.5]), METHOD, 0.05, 20)
    assert run.success and run.counts["linear_solves"] == 0
