"""Lagrangians of a user's own functions: in vector instructions where they can be traced."""

from __future__ import annotations

import dataclasses
import logging
import math
import pickle
from typing import Any

import numpy as np
import pytest
import sympy as sp
from numba import njit

import galvi
from galvi.run.in_lanes.laws import has_law
from tests.galvi.lagrangians import opaque

METHOD = galvi.Galerkin(galvi.Polynomials(6), galvi.gauss(6))
M, K, G = np.array([[2.0, 0.3], [0.3, 1.0]]), (1.5, 2.5, 0.7), 9.81


@njit
def spring(x, k):
    return 0.5 * k * x * x


@njit
def masses_and_springs(q, v):
    total = spring(q[0], K[0]) + spring(q[-1], K[-1])
    for i in range(1, q.size):
        total += spring(q[i] - q[i - 1], K[i]) + 0.1 * (q[i] - q[i - 1]) ** 4
    return 0.5 * np.sum(v**2) - total


def elastic_pendulum(k: float) -> Any:
    def L(q: Any, v: Any) -> Any:
        (r, angle), place = q, np.zeros(2)
        place[:] = r * math.sin(angle), -r * math.cos(angle)
        return 0.5 * (v[0] ** 2 + (r * v[1]) ** 2) - G * place[1] - 0.5 * k * (r - 1.0) ** 2

    return L


def with_mass_matrix(q: Any, v: Any) -> Any:
    return 0.5 * v @ M @ v * (1.0 + 0.2 * np.cos(q).sum()) - 0.5 * q @ q


def driven(q: Any, v: Any, t: float) -> Any:
    return 0.5 * v @ v - np.linalg.norm(q - np.array([2.0, 0.0])) ** 1.5 + q[0] * math.sin(2.0 * t)


@njit
def magnetic_slopes(q, v):
    out = np.empty(4)
    out[0], out[1] = v[0] - 0.4 * q[1], v[1] + 0.4 * q[0]
    out[2], out[3] = 0.4 * v[1] - q[0], -0.4 * v[0] - q[1]
    return out


def magnetic(q: Any, v: Any) -> Any:
    return 0.5 * v @ v - 0.5 * q @ q + 0.4 * (q[0] * v[1] - q[1] * v[0])


SYSTEMS = {
    "masses and springs": (
        galvi.Lagrangian(masses_and_springs, galvi.Rn(3)), [0.3, -0.2, 0.5], [0.1, 0.4, -0.3],
    ),
    "elastic pendulum": (
        galvi.Lagrangian(elastic_pendulum(40.0), galvi.Rn(2)), [1.1, 0.7], [0.0, 0.3],
    ),
    "mass matrix": (galvi.Lagrangian(with_mass_matrix, galvi.Rn(2)), [0.4, 0.7], [0.5, -0.3]),
    "driven": (
        galvi.Lagrangian(driven, galvi.Rn(2), explicit_time=True), [0.4, 0.7], [0.5, -0.3],
    ),
    "magnetic": (
        galvi.Lagrangian(magnetic, galvi.Rn(2), magnetic_slopes), [0.4, 0.7], [0.5, -0.3],
    ),
    "slopes of Python": (
        galvi.Lagrangian(magnetic, galvi.Rn(2), magnetic_slopes.py_func), [0.4, 0.7], [0.5, -0.3],
    ),
    "braked": (
        galvi.Lagrangian(
            magnetic, galvi.Rn(2), magnetic_slopes, force=lambda q, v, t: -0.2 * v * math.cos(t),
            timed_force=True,
        ),
        [0.4, 0.7], [0.5, -0.3],
    ),
}  # fmt: skip
BY_NAME = pytest.mark.parametrize("name", SYSTEMS)


def twin(system: Any) -> Any:
    """The same system, of functions that cannot be traced."""
    names = ("function", "slopes", "force")
    own = {name: getattr(system, name) for name in names if getattr(system, name) is not None}
    return galvi.Lagrangian(
        group=system.group, explicit_time=system.explicit_time, timed_force=system.timed_force,
        **{name: opaque(function) for name, function in own.items()},
    )  # fmt: skip


@pytest.mark.slow_cases(but=["slopes of Python", "braked"])
@BY_NAME
def test_a_run_in_lanes_is_that_of_the_general_kernel_and_of_the_functions(name: str) -> None:
    system, q0, v0 = SYSTEMS[name]
    problem = galvi.Problem(system, q0, v0)
    assert has_law(problem, METHOD) and not system.untraced
    run = galvi.integrate(problem, METHOD, 0.05, 20)
    general = galvi.integrate(problem, METHOD, 0.05, 20, solver="newton")
    assert run.success and general.success, (run.status, general.status)
    assert run.counts["linear_solves"] == 0 < general.counts["linear_solves"]
    np.testing.assert_allclose(run.q, general.q, rtol=0.0, atol=1e-13)
    np.testing.assert_allclose(run.p, general.p, rtol=0.0, atol=1e-13)
    called = galvi.integrate(galvi.Problem(twin(system), q0, v0), METHOD, 0.05, 2)
    np.testing.assert_allclose(called.q, run.q[:3], rtol=0.0, atol=2e-10)  # 5e-12: differenced
    np.testing.assert_allclose(galvi.energy(called), galvi.energy(run)[:3], atol=2e-10)


@pytest.mark.slow_cases("masses and springs")
@BY_NAME
def test_momenta_and_energies_are_those_of_the_functions(name: str) -> None:
    system, q0, v0 = SYSTEMS[name]
    problem = galvi.Problem(system, q0, v0)
    called = galvi.Problem(twin(system), q0, v0)
    np.testing.assert_allclose(problem.p0, called.p0, rtol=0.0, atol=1e-10)
    args = np.array([q0]), np.array([v0]), np.zeros(1)
    np.testing.assert_allclose(system.energy(*args), called.system.energy(*args), atol=1e-10)


x, y, vx, vy = sp.symbols("x y v_x v_y", real=True)
FORCED = {
    "a canonical system": galvi.Canonical(
        0.145, lambda q: 0.145 * G * q[1], force=lambda q, v: -9e-4 * np.linalg.norm(v) * v
    ),
    "a gradient of the time": galvi.Canonical(
        M, lambda q, t: 0.5 * q @ q + t * q[0], lambda q, t: q + t * np.array([1.0, 0.0]),
        force=njit(lambda q, v: -0.3 * v), explicit_time=True,
    ),
    "a chain": galvi.Lagrangian(
        galvi.PlanarChain([1.0, 0.5], [1.0, 0.8]), galvi.Rn(2), force=lambda q, v: -0.1 * v
    ),
    "a SymPy Lagrangian": dataclasses.replace(
        galvi.Lagrangian.from_sympy((vx**2 + vy**2 - x**2 * y**2) / 2, (x, y), (vx, vy)),
        force=lambda q, v, t: np.array([math.sin(3.0 * t), -0.2 * v[1]]), timed_force=True,
    ),
}  # fmt: skip


@pytest.mark.slow_cases("a gradient of the time", "a SymPy Lagrangian")
@pytest.mark.parametrize("name", FORCED)
def test_a_users_force_is_traced_beside_every_kind_of_system(name: str) -> None:
    system = FORCED[name]
    problem = galvi.Problem(system, [0.4, 0.7], [0.5, -0.3])
    assert has_law(problem, METHOD) and not system.untraced
    run = galvi.integrate(problem, METHOD, 0.05, 6)
    assert run.counts["linear_solves"] == 0
    called = dataclasses.replace(system, force=opaque(system.force))
    assert "branches on, or converts" in untraced(called)
    general = galvi.integrate(galvi.Problem(called, problem.q0, problem.v0), METHOD, 0.05, 6)
    assert general.counts["linear_solves"] > 0
    np.testing.assert_allclose(run.q, general.q, rtol=0.0, atol=2e-12)  # a potential is differenced


def untraced(system: Any) -> str:
    """Why functions of the system could not be traced."""
    galvi.Problem(system, [0.4, 0.7], [0.5, -0.3])
    return str(system.untraced)


def test_the_solver_fixed_point_is_refused_with_the_reason() -> None:
    problem = galvi.Problem(galvi.Lagrangian(branching, galvi.Rn(2)), [0.4, 0.7], [0.5, -0.3])
    with pytest.raises(ValueError, match=r"could be traced; .* branches on"):
        galvi.integrate(problem, METHOD, 0.05, 6, solver="fixed_point")


def branching(q: Any, v: Any) -> Any:
    return 0.5 * v @ v - (q @ q if q[0] > 0.0 else 2.0 * q @ q)


def solving(q: Any, v: Any) -> Any:
    return 0.5 * v @ np.linalg.solve(M, v) - 0.5 * q @ q


def converting(q: Any, v: Any) -> Any:
    return 0.5 * v @ v - 0.5 * float(q[0]) ** 2 - 0.5 * q[1] ** 2


COARSE = galvi.Galerkin(galvi.Polynomials(2), galvi.gauss(2))


@pytest.mark.parametrize("function", [branching, solving, converting])
def test_a_function_that_cannot_be_traced_is_called_and_this_is_said_once(
    function: Any, caplog: pytest.LogCaptureFixture
) -> None:
    system = galvi.Lagrangian(function, galvi.Rn(2))
    problem = galvi.Problem(system, [0.4, 0.7], [0.5, -0.3])
    assert not has_law(problem, METHOD) and system.untraced
    with caplog.at_level(logging.WARNING, logger="galvi"):
        for _ in range(2):
            run = galvi.integrate(problem, COARSE, 0.05, 1)
    assert run.status == "Completed." and run.counts["linear_solves"] > 0
    said = [record.getMessage() for record in caplog.records]
    assert sum("could be traced" in message for message in said) == 1


def test_a_number_that_changes_between_two_runs_is_used() -> None:
    numbers = {"k": 1.0}
    system = galvi.Lagrangian(lambda q, v: 0.5 * v @ v - 0.5 * numbers["k"] * q @ q, galvi.Rn(1))
    problem = galvi.Problem(system, [1.0], [0.0])
    for k in (1.0, 4.0):
        numbers["k"] = k
        run = galvi.integrate(problem, METHOD, 0.1, 10)
        assert abs(run.q[-1, 0] - math.cos(math.sqrt(k))) < 1e-9
        assert run.counts["linear_solves"] == 0 and run.status == "Completed."
        general = galvi.integrate(problem, METHOD, 0.1, 10, solver="newton")
        np.testing.assert_allclose(general.q, run.q, rtol=0.0, atol=1e-13)


def test_a_start_where_only_the_trace_has_no_derivatives_is_run_as_before() -> None:
    system = galvi.Lagrangian(lambda q, v: 0.5 * v @ v - (q @ q) ** 0.75 * q[0] ** 2, galvi.Rn(1))
    away = galvi.Problem(system, [0.5], [0.0])
    assert has_law(away, METHOD)
    at_rest = galvi.Problem(system, [0.0], [0.0])
    run = galvi.integrate(at_rest, COARSE, 0.1, 2)
    assert run.success and not np.any(run.q)


def test_a_step_too_long_for_the_iteration_is_left_to_newtons_method() -> None:
    system, q0, v0 = SYSTEMS["elastic pendulum"]
    run = galvi.integrate(galvi.Problem(system, q0, v0), METHOD, 0.9, 8)
    assert run.success and run.counts["linear_solves"] > 0


def test_a_traced_problem_can_be_pickled() -> None:
    problem = galvi.Problem(galvi.Lagrangian(with_mass_matrix, galvi.Rn(2)), [0.4, 0.7], [0.5, 0.1])
    again = pickle.loads(pickle.dumps(problem))
    assert has_law(again, METHOD)
    one, other = (galvi.integrate(each, METHOD, 0.05, 3) for each in (problem, again))
    assert np.array_equal(one.q, other.q)
