"""Lagrangians on groups, and bodies in potentials, of a user's own functions in vector code."""

from __future__ import annotations

import pickle
from typing import Any

import numpy as np
import pytest

import galvi
from galvi.lanes.group_collocation import Chart
from galvi.run.in_lanes.lagrangian import has_group_law
from galvi.systems.traces import Untraceable
from galvi.tracing.graph import Graph
from galvi.tracing.traced_lagrangian import traced_lagrangian
from tests.agreement.on_groups import (
    BODY,
    OF_FUNCTIONS,
    Q0,
    V0,
    bulging,
    tether,
    tether_slope,
)
from tests.properties.group_bodies import MOMENTS, R0, SPIN

METHOD = galvi.Galerkin(galvi.Polynomials(6), galvi.gauss(6))


def test_a_planted_fault_of_a_groups_derivative_is_caught(monkeypatch: pytest.MonkeyPatch) -> None:
    group, derivative = galvi.SE3(), Chart.left_derivative

    def wrong(chart: Any, g: Any, slope: Any) -> Any:
        found = derivative(chart, g, slope)
        return [found[1], found[0], *found[2:]] if hasattr(g[0], "graph") else found

    def trace() -> Any:
        scales = np.ones(6), np.ones(6)
        return traced_lagrangian(bulging, None, group, Q0, V0, 0.0, False, scales)

    assert trace().holds
    monkeypatch.setattr(Chart, "left_derivative", wrong)
    with pytest.raises(Untraceable, match="its derivatives are not those of the function"):
        trace()


@pytest.mark.slow(
    beside="test_celestial_forces.py::test_a_function_is_traced_again_when_a_number_that_it_refers_to_changes"
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


def test_a_body_in_a_potential_can_be_pickled_and_refused_in_words() -> None:
    again = pickle.loads(pickle.dumps(galvi.Problem(*OF_FUNCTIONS["a tether"])))
    assert has_group_law(again)
    with pytest.raises(ValueError, match="must be the derivative of the Lagrangian"):
        galvi.Problem(galvi.FreeBody(*BODY, tether, lambda q: 2.0 * tether_slope(q)), Q0, V0)
    with pytest.raises(ValueError, match="are those of a potential; received none"):
        galvi.FreeBody(*BODY, gradient=tether_slope)
    with pytest.raises(TypeError, match="potential must be a function of q; received 5"):
        galvi.FreeBody(*BODY, 5)


def test_symbols_of_a_matrix_have_its_shape() -> None:
    assert Graph().variables("q", 3, 3)[1, 2].arguments[0] == "q[5]"
