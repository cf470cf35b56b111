"""Laws in lanes with an external force: the formulas, and runs against the general kernel."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import sympy as sp

import galvi
from galvi.lanes import laws
from galvi.run.in_lanes.laws import has_law, lane_law
from galvi.tracing.laws import SLOPES
from tests.galvi.test_laws import LAGRANGIANS, t
from tests.galvi.test_laws_with_more_points import differences

METHODS = (
    galvi.Galerkin(galvi.Polynomials(4), galvi.gauss(4)),
    galvi.Galerkin(galvi.Polynomials(4), galvi.gauss(5)),
    galvi.Galerkin(galvi.Polynomials(8), galvi.gauss(11)),
)
WITH_METHODS = pytest.mark.parametrize("method", METHODS, ids=lambda method: method.name)
rate = sp.Symbol("rate", positive=True)


def forced(name: str, force: Any) -> galvi.Problem:
    """A problem of test_laws with the force of (q, v)."""
    L, q, v, q0, v0 = LAGRANGIANS[name]
    system = galvi.Lagrangian.from_sympy(
        L, q, v, t, parameters={rate: 0.3}, force=[force(*pair) for pair in zip(q, v, strict=True)]
    )
    return galvi.Problem(system, q0, v0)


FORCES: dict[str, tuple[str, Any]] = {
    "linear drag": ("elastic pendulum", lambda q, v: -rate * v),
    "quadratic drag": ("relativistic", lambda q, v: -rate * sp.Abs(v) * v),
    "driven": ("elastic pendulum", lambda q, v: sp.cos(3 * t) * sp.exp(-rate * q**2) - v**3),
    "constant": ("driven", lambda q, v: sp.Integer(1) / 4),
    "none": ("driven", lambda q, v: sp.Integer(0)),
}


@pytest.mark.slow_cases(
    but=[
        "linear drag-Gauss collocation, 4 stages",
        "linear drag-Galerkin degree 4, Gauss 5",
        "quadratic drag-Gauss collocation, 4 stages",
        "quadratic drag-Galerkin degree 4, Gauss 5",
        "constant-Galerkin degree 4, Gauss 5",
        "none-Galerkin degree 4, Gauss 5",
    ]
)
@WITH_METHODS
@pytest.mark.parametrize("name", FORCES)
def test_a_forced_run_is_that_of_the_general_kernel(name: str, method: galvi.Galerkin) -> None:
    assert differences(forced(*FORCES[name]), method, 0.04, 30) < 1e-14


@pytest.mark.slow_cases(
    "1e-05-0.44-Gauss collocation, 4 stages",
    "1e-05-0.44-Galerkin degree 8, Gauss 11",
    "5e-05-None-Galerkin degree 4, Gauss 5",
    "5e-05-None-Galerkin degree 8, Gauss 11",
)
@WITH_METHODS
@pytest.mark.parametrize(
    ("diameter", "coefficient"),
    [(10e-6, 0.44), (100e-6, 0.44), (400e-6, 0.44), (50e-6, None), (400e-6, None)],
)
def test_a_grain_in_the_wind_is_that_of_the_general_kernel(
    diameter: float, coefficient: float | None, method: galvi.Galerkin
) -> None:
    start = galvi.problems.brownout(diameter, drag_coefficient=coefficient)
    assert differences(start, method, 0.005, 100) < 1e-14


def test_a_force_that_is_wrong_is_caught(monkeypatch: pytest.MonkeyPatch) -> None:
    start = galvi.problems.brownout(400e-6)
    law = lane_law(start.system, 3)
    assert law is not None
    lines, constants = law
    for wrong in (constants * np.append(np.ones(12), -1.0), constants * np.append(np.ones(12), 0)):
        monkeypatch.setattr(
            "galvi.run.in_lanes.laws.lane_law",
            lambda system, d, wrong=wrong: (lines, wrong),
        )
        with pytest.raises(AssertionError):
            assert differences(start, METHODS[0], 0.005, 100) < 1e-13


def test_a_grain_too_stiff_for_the_iteration_is_left_to_newtons_method() -> None:
    start = galvi.problems.brownout(3e-6)
    run = galvi.integrate(start, METHODS[0], 0.05, 60)
    general = galvi.integrate(start, METHODS[0], 0.05, 60, solver="newton")
    assert run.success and run.counts["linear_solves"] > 0
    np.testing.assert_allclose(run.q, general.q, rtol=0.0, atol=1e-11)


@pytest.mark.slow(beside="test_a_grain_in_the_wind_is_that_of_the_general_kernel")
def test_a_million_steps_of_a_grain() -> None:
    method = galvi.Galerkin(galvi.Polynomials(2), galvi.gauss(2))
    run = galvi.integrate(galvi.problems.brownout(), method, 0.01, 1_000_000, save_every=1_000_000)
    assert run.success and run.counts["linear_solves"] == 0


@pytest.mark.parametrize(
    "law", [galvi.QuadraticDrag(), galvi.SchillerNaumann(7.0)], ids=lambda law: law.name
)
def test_the_drag_is_that_of_the_kernel(law: Any) -> None:
    random = np.random.default_rng(5)
    q, v = random.normal(scale=6.0, size=(3, 50)), random.normal(scale=4.0, size=(3, 50))
    times, found = random.uniform(0, 5, 50), np.zeros((50, 2, 3))
    kernel, constants = galvi.RotorDrag(0.3, law).compiled()
    for k in range(50):
        kernel(q[:, k], v[:, k], times[k], constants, found[k])
    drag = np.array(getattr(laws, f"{law.name}_drag")(q, v, times, constants))
    np.testing.assert_allclose(drag, found[:, 1].T, rtol=1e-12, atol=1e-14)


@pytest.mark.parametrize(
    "potential",
    [galvi.UniformField([0.3, -0.2, 1.0]), galvi.CentralForce(1.3), galvi.LinearSpring(0.7),
     galvi.CosinePotential(1.1), galvi.SpringChain(0.2, 0.3)],
    ids=lambda potential: type(potential).__name__,
)  # fmt: skip
def test_the_law_of_a_canonical_system_has_its_derivatives(potential: Any) -> None:
    random = np.random.default_rng(2)
    q, v = random.normal(size=(2, 3))
    root = random.normal(size=(3, 3))
    slopes = getattr(laws, SLOPES[type(potential)])
    for mass in (2.0, [1.0, 2.0, 3.0], root @ root.T + np.eye(3)):
        system = galvi.Canonical(mass, potential)
        full = system.momentum(np.eye(3))
        constants = np.append(full.ravel(), potential.law().constants)
        law = laws.canonical(slopes, 3, system.mass.ndim < 2)
        forces, momenta, rows = law(q, v, 0.0, constants)
        np.testing.assert_allclose(forces, -potential.gradient(q), rtol=1e-13)
        np.testing.assert_allclose(momenta, system.momentum(v), rtol=1e-13)
        np.testing.assert_array_equal([x for row in rows for x in row], full[np.tril_indices(3)])


def test_forces_without_a_form_in_lanes_are_left_to_the_general_kernel() -> None:
    L, q, v, q0, v0 = LAGRANGIANS["elastic pendulum"]
    steps = galvi.Lagrangian.from_sympy(L, q, v, force=[sp.Max(v[0], 0), 0])
    python = galvi.Lagrangian(steps.function, steps.group, force=lambda q, v: np.maximum(v, 0.0))
    for system in (steps, python):
        assert not has_law(galvi.Problem(system, q0, v0), METHODS[0])
