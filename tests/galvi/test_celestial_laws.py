"""Forces of velocity: written out for lanes, or called by the general kernel."""

from __future__ import annotations

import pickle
from typing import Any

import numpy as np
import pytest
from numba import njit

import galvi
from galvi.tracing import traced_lagrangian
from tests.galvi.celestial_cases import MASSES, OF_VELOCITY, Q, V, bodies, drag_in_python

METHOD = galvi.Galerkin(galvi.Polynomials(6), galvi.gauss(6))
PLAIN = galvi.Problem(galvi.NBody(MASSES), Q, V)
pytestmark = pytest.mark.skipif(not galvi.FAST, reason="the general kernel alone has none")


def run(forces: Any, **options: Any) -> galvi.Trajectory:
    return galvi.integrate(bodies(forces), METHOD, 0.05, 40, **options)


@pytest.mark.slow_cases(but=["tides"])
@pytest.mark.parametrize("name", ["EIH", "tides", "a function of time"])
def test_a_law_too_long_to_be_written_out_gives_the_same_run_in_the_general_kernel(
    name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    written = run(OF_VELOCITY[name])
    monkeypatch.setattr(traced_lagrangian, "LONGEST_KNOWN", 0)
    called = run(OF_VELOCITY[name])
    assert (written.engine, called.engine) == ("lanes", "general")
    assert written.counts["linear_solves"] == 0
    assert np.max(np.abs(written.q - called.q)) < 1e-14


@pytest.mark.slow_cases(but=["1.0"])
@pytest.mark.parametrize("power", [0.5, 1.0, 1.3, 2.0, 3.0])
def test_a_drag_has_a_value_at_rest(power: float) -> None:
    system = galvi.NBody(MASSES, forces=galvi.Drag([1e-3] * 3, power))
    problem = galvi.Problem(system, Q, 0.0 * V)
    lanes = galvi.integrate(problem, METHOD, 0.02, 10)
    general = galvi.integrate(problem, METHOD, 0.02, 10, solver="newton")
    assert (lanes.engine, general.engine) == ("lanes", "general")
    assert np.max(np.abs(lanes.q - general.q)) < 1e-13


@pytest.mark.parametrize("power", [-4, -3, -2.5, -2, 0.25, 1, 2, 7, -2.13, 0.7, 40.3])
def test_a_power_in_lanes_is_that_of_the_c_library(power: float) -> None:
    system = galvi.NBody(MASSES, forces=galvi.PowerLaw(0, -(0.1 ** (2 + abs(power) / 3)), power))
    problem = galvi.Problem(system, Q, V)
    lanes = galvi.integrate(problem, METHOD, 0.01, 5)
    general = galvi.integrate(problem, METHOD, 0.01, 5, solver="newton")
    assert (lanes.engine, general.engine) == ("lanes", "general") and lanes.success
    assert np.max(np.abs(lanes.q - galvi.integrate(PLAIN, METHOD, 0.01, 5).q)) > 1e-9
    assert np.max(np.abs(lanes.q - general.q)) < 2e-15


def test_a_function_is_traced_again_when_a_number_that_it_refers_to_changes() -> None:
    strength = [-1e-3]

    def drag(q: Any, v: Any) -> Any:
        return strength[0] * v

    problem = bodies(galvi.Force(drag, takes_velocity=True))
    runs = []
    for k in (-1e-3, -2e-3):
        strength[0] = k
        runs.append(galvi.integrate(problem, METHOD, 0.05, 40))
    fresh = galvi.integrate(bodies(problem.system.forces), METHOD, 0.05, 40)
    assert np.array_equal(runs[1].q, fresh.q) and fresh.engine == "lanes"
    assert np.max(np.abs(runs[1].q - runs[0].q)) > 1e-6


@pytest.mark.slow(beside="test_external_forces.py::test_many_forced_runs_equal_single_ones")
def test_a_function_that_branches_is_called_by_the_general_kernel() -> None:
    def drag(q: Any, v: Any) -> Any:
        return -1e-3 * v if q[1, 0] > 0.0 else -2e-3 * v

    python, jitted = (run(galvi.Force(one, takes_velocity=True)) for one in (drag, njit(drag)))
    assert (python.engine, jitted.engine) == ("general", "general")
    assert "branches" in jitted.problem.system.untraced
    assert np.max(np.abs(python.q - jitted.q)) < 1e-13


def test_a_problem_whose_function_was_traced_is_pickled() -> None:
    again = pickle.loads(pickle.dumps(bodies(galvi.Force(drag_in_python, takes_velocity=True))))
    assert galvi.integrate(again, METHOD, 0.05, 4).engine == "lanes"
