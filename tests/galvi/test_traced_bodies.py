"""Lagrangians on groups and bodies in potentials of a user's own functions, in vector instructions.

The oracle is the general kernel, with functions that cannot be traced.
"""

from __future__ import annotations

import dataclasses
import math
import pickle
from typing import Any

import numpy as np
import pytest
import sympy as sp
from numba import njit

import galvi
from galvi.lanes import group_rows
from galvi.run.in_lanes.laws import has_group_law
from galvi.systems.traces import Untraceable
from galvi.tracing.graph import Graph
from galvi.tracing.traced_lagrangian import traced_lagrangian
from tests.galvi.group_bodies import MOMENTS, R0, SPIN, bent, bent_slope
from tests.galvi.group_matrices import element
from tests.galvi.lagrangians import opaque

METHOD = galvi.Galerkin(galvi.Polynomials(6), galvi.gauss(6))
ARM, STIFF = np.array([0.1, 0.2, 0.3]), 3.0


def swelling(q: Any, v: Any) -> Any:
    """Not quadratic in v, with a mass that depends on q, on any group."""
    entries = np.asarray(q).ravel()
    s = np.dot(np.linspace(0.3, -0.2, entries.size), entries)
    square = v @ v + 0.3 * v[0] * v[-1]
    return 0.5 * square * (1.0 + 0.2 * s * s) + 0.05 * square**2 - 0.5 * s * s - np.sin(s)


def tether(q: Any) -> Any:
    """A spring from the origin to a point of a body."""
    return 0.5 * STIFF * np.sum((q[:3, 3] + q[:3, :3] @ ARM) ** 2)


def tether_slope(q: Any) -> Any:
    pull = STIFF * (q[:3, 3] + q[:3, :3] @ ARM)
    out = np.zeros((4, 4))
    out[:3, :3], out[:3, 3] = np.outer(pull, ARM), pull
    return out


def symbolic() -> Any:
    R = sp.MatrixSymbol("R", 3, 3)
    return sp.lambdify(R, R[0, 1] ** 2 / 2 + sp.sin(R[2, 0]) - R[2, 2])


def drag(q: Any, v: Any) -> Any:
    return -0.2 * v * math.sqrt(1.0 + v @ v)


GRAVITY = galvi.UniformGravity(1.0, (0.1, 0.0, 1.0), 2.0)
BODY = 2.0, (1.0, 2.0, 2.5), (0.0, 0.0, -1.0)
Q0 = np.block([[R0, np.array([[0.5], [-0.2], [0.8]])], [np.zeros((1, 3)), np.ones((1, 1))]])
V0 = np.array([0.3, 1.0, 0.2, 0.5, -0.4, 0.7])


def on(group: Any, system: Any) -> galvi.Problem:
    d = group.dimension
    return galvi.Problem(
        system, element(group, np.linspace(0.5, -0.4, d)), np.linspace(0.6, 0.2, d)
    )


GROUPS = galvi.SE2(), galvi.SE3(), galvi.Product((galvi.SO3(), galvi.Rn(1)))
SYSTEMS = {
    "a potential": galvi.Problem(galvi.RigidBody(MOMENTS, bent), R0, SPIN),
    "a compiled gradient": galvi.Problem(
        galvi.RigidBody(MOMENTS, njit(bent), njit(bent_slope)), R0, SPIN
    ),
    "SymPy": galvi.Problem(galvi.RigidBody(MOMENTS, symbolic()), R0, SPIN),
    "a driven top with drag": galvi.Problem(
        galvi.RigidBody(
            MOMENTS, lambda R, t: math.cos(3.0 * t) * R[0, 2] - R[2, 2], force=drag,
            explicit_time=True,
        ),
        R0, SPIN,
    ),
    "gravity and drag": galvi.Problem(galvi.RigidBody(MOMENTS, GRAVITY, force=drag), R0, SPIN),
    "a tether": galvi.Problem(galvi.FreeBody(*BODY, tether, tether_slope), Q0, V0),
    "drag": galvi.Problem(galvi.FreeBody(*BODY, force=drag), Q0, V0),
    **{
        type(group).__name__: on(group, galvi.Lagrangian(swelling, group)) for group in GROUPS
    },
    "a braked Lagrangian": on(
        galvi.SE2(), galvi.Lagrangian(swelling, galvi.SE2(), force=drag)
    ),
}  # fmt: skip


def twin(system: Any) -> Any:
    """The same system, of functions that cannot be traced."""
    names = ("function", "potential", "gradient", "force")
    own = {name: getattr(system, name, None) for name in names}
    user = {name: f for name, f in own.items() if f is not None and f is not GRAVITY}
    return dataclasses.replace(
        system, check=False, **{name: opaque(function) for name, function in user.items()}
    )


@pytest.mark.slow_cases(but=["a compiled gradient"])
@pytest.mark.parametrize("name", SYSTEMS)
def test_a_run_in_lanes_is_that_of_the_general_kernel_and_of_the_functions(name: str) -> None:
    problem = SYSTEMS[name]
    system: Any = problem.system
    assert has_group_law(problem) and not system.untraced
    run = galvi.integrate(problem, METHOD, 0.05, 12)
    general = galvi.integrate(problem, METHOD, 0.05, 12, solver="newton")
    assert run.success and general.success, (run.status, general.status)
    assert run.counts["linear_solves"] == 0 < general.counts["linear_solves"]
    assert "potential_evaluations" not in run.counts
    np.testing.assert_allclose(run.q, general.q, rtol=0.0, atol=1e-14)  # 1e-15
    np.testing.assert_allclose(run.p, general.p, rtol=0.0, atol=2e-14)  # 3e-15
    few = galvi.Galerkin(galvi.Polynomials(2), galvi.gauss(2))
    called = galvi.Problem(twin(system), problem.q0, problem.v0)
    assert called.system.untraced and not has_group_law(called)  # type: ignore[attr-defined]
    known, unknown = (galvi.integrate(each, few, 0.05, 1) for each in (problem, called))
    np.testing.assert_allclose(known.q, unknown.q, rtol=0.0, atol=2e-11)  # 2e-13: differenced
    np.testing.assert_allclose(known.p, unknown.p, rtol=0.0, atol=5e-10)  # 1e-11
    np.testing.assert_allclose(galvi.energy(known), galvi.energy(unknown), atol=5e-10)


def test_a_planted_fault_of_a_groups_derivative_is_caught(monkeypatch: pytest.MonkeyPatch) -> None:
    group, derivative = galvi.SE3(), group_rows.Chart.left_derivative

    def wrong(chart: Any, g: Any, slope: Any) -> Any:
        found = derivative(chart, g, slope)
        return [found[1], found[0], *found[2:]] if hasattr(g[0], "graph") else found

    def trace() -> Any:
        scales = np.ones(6), np.ones(6)
        return traced_lagrangian(swelling, None, group, Q0, V0, 0.0, False, scales)

    assert trace().holds
    monkeypatch.setattr(group_rows.Chart, "left_derivative", wrong)
    with pytest.raises(Untraceable, match="its derivatives are not those of the function"):
        trace()


@pytest.mark.slow(
    beside="test_celestial_laws.py::test_a_function_is_traced_again_when_a_number_that_it_refers_to_changes"
)
def test_a_number_that_changes_between_two_runs_is_used() -> None:
    numbers = {"k": 1.0}
    body = galvi.RigidBody(MOMENTS, lambda R: -numbers["k"] * R[2, 2])
    problem = galvi.Problem(body, R0, SPIN)
    for k in (1.0, 4.0):
        numbers["k"] = k
        run = galvi.integrate(problem, METHOD, 0.05, 5)
        gravity = galvi.RigidBody(MOMENTS, galvi.UniformGravity(1.0, (0.0, 0.0, -1.0), k))
        heavy = galvi.integrate(galvi.Problem(gravity, R0, SPIN), METHOD, 0.05, 5)
        assert run.counts["linear_solves"] == 0 and run.status == "Completed."
        np.testing.assert_allclose(run.q, heavy.q, rtol=0.0, atol=1e-14)


@pytest.mark.slow(
    beside="test_laws_with_forces.py::test_a_grain_too_stiff_for_the_iteration_is_left_to_newtons_method"
)
def test_a_step_too_long_for_the_iteration_is_left_to_newtons_method() -> None:
    run = galvi.integrate(SYSTEMS["a potential"], METHOD, 2.0, 4)
    assert run.failed_step is None and run.counts["newton_steps"] > 0


def test_a_body_in_a_potential_can_be_pickled_and_refused_in_words() -> None:
    again = pickle.loads(pickle.dumps(SYSTEMS["a tether"]))
    assert has_group_law(again)
    with pytest.raises(ValueError, match="must be the derivative of the Lagrangian"):
        galvi.Problem(galvi.FreeBody(*BODY, tether, lambda q: 2.0 * tether_slope(q)), Q0, V0)
    with pytest.raises(ValueError, match="are those of a potential; received none"):
        galvi.FreeBody(*BODY, gradient=tether_slope)
    with pytest.raises(TypeError, match="potential must be a function of q; received 5"):
        galvi.FreeBody(*BODY, 5)


def test_symbols_of_a_matrix_have_its_shape() -> None:
    assert Graph().variables("q", 3, 3)[1, 2].arguments[0] == "q[5]"
