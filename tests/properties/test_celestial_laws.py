"""Forces of velocity: written out for lanes, or called by the general kernel."""

from __future__ import annotations

import pickle
from typing import Any

import numpy as np
import pytest
from numba import njit

import galvi
from galvi.tracing import traced_lagrangian
from tests.properties.celestial_cases import OF_VELOCITY, bodies, drag_in_python

METHOD = galvi.Galerkin(galvi.Polynomials(6), galvi.gauss(6))
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


@pytest.mark.slow(beside="test_external_forces.py::test_a_wrong_sign_of_the_force_is_seen")
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
