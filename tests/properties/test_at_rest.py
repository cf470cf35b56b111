"""Trees some of whose coordinates rest: relative equilibria, as of wheels, panels, hanging arms.

A coordinate at rest is rounding error, and its changes are not small beside it.
"""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

import galvi
from galvi.run import group_system

TINY = (0.0, 1e-300, 1e-16, 1e-9)
CHARTS = (galvi.Cayley(), galvi.Exponential(), galvi.ModifiedRodrigues())
STEP, STEPS, NEAR = 0.02, 15, 1e-6


@cache
def tree(tree_name: str) -> galvi.Multibody:
    """A spinning hub with panels on springs, or a body in flight with an arm and a wheel."""
    hub = galvi.Link(
        galvi.Joint("ball" if tree_name == "hub" else "free"), 1.0, (0, 0, 0), (2, 2, 2)
    )
    hinge = galvi.Joint("hinge", axis=(0, 1, 0), stiffness=0.5 if tree_name == "hub" else 0.0)
    outer = galvi.Joint("slide", axis=(1, 0, 0), stiffness=3.0)
    panel = galvi.Link(hinge, 1.0, (0.25, 0, 0), (0.03, 0.02, 0.05), parent=0, place=(0.5, 0, 0))
    tip = galvi.Link(outer, 0.2, (0.1, 0, 0), (1e-3, 1e-3, 1e-3), parent=1, place=(0.5, 0, 0))
    return galvi.Multibody(
        [hub, panel, tip], gravity=(0, 0, -9.81 if tree_name == "flight" else 0.0)
    )


def start(tree_name: str, small: Any, turning: Any) -> galvi.Problem:
    """Coordinates and velocities of both joints are ``small``, (4,), and the hub turns."""
    system = tree(tree_name)
    hub_position = (
        [1.0, 0.0, 0.0, 0.0] if tree_name == "hub" else [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]
    )
    hub_velocity = list(turning) if tree_name == "hub" else [0.0, 0.0, 0.0, *turning]
    q, v = system.from_mujoco(
        np.array([*hub_position, *small[:2]]), np.array([*hub_velocity, *small[2:]])
    )
    return galvi.Problem(system, q, v)


def method(chart: Any, degree: int = 8) -> galvi.Galerkin:
    return galvi.Galerkin(galvi.Polynomials(degree), galvi.gauss(degree), chart=chart)


@pytest.mark.slow(beside="test_what_no_mass_couples_is_solved_as_if_alone")
@settings(max_examples=12)
@example("hub", (0.0, 0.0, 0.0, 0.0), (0.0, 0.3, 0.0), CHARTS[0], 8, "auto")
@example("flight", (0.0, 1e-16, 1e-300, 0.0), (0.0, 0.3, 0.0), CHARTS[1], 4, "newton")
@given(
    tree_name=st.sampled_from(("hub", "flight")),
    small=st.tuples(*[st.sampled_from(TINY)] * 4),
    turning=st.tuples(*[st.sampled_from((*TINY, 0.3, -1.0))] * 3),
    chart=st.sampled_from(CHARTS),
    degree=st.sampled_from((2, 4, 8, 12)),
    solver=st.sampled_from(("auto", "newton")),
)
def test_what_rests_is_stepped_and_agrees_with_a_start_nearby(
    tree_name: str, small: Any, turning: Any, chart: Any, degree: int, solver: str
) -> None:
    run = galvi.integrate(
        start(tree_name, small, turning), method(chart, degree), STEP, STEPS, solver=solver
    )
    assert run.status == "Completed.", run.status
    nearby = start(tree_name, np.array(small) + NEAR, turning)
    neighbour = galvi.integrate(nearby, method(chart, degree), STEP, STEPS, solver=solver)
    assert neighbour.success
    assert (
        max(np.max(np.abs(run.q - neighbour.q)), np.max(np.abs(run.v - neighbour.v))) < 10.0 * NEAR
    )


@pytest.mark.slow_cases("ensemble-1000000000000.0")
@pytest.mark.parametrize(
    ("solver", "size"), [("auto", 1e12), ("newton", 1e6), ("newton", 1e12), ("ensemble", 1e12)]
)
def test_what_no_mass_couples_is_solved_as_if_alone(solver: str, size: float) -> None:
    """One factor moves alone, and beside another whose motion is ``size`` times larger."""
    line = galvi.Rn(1)

    def both(q: Any, v: Any) -> Any:
        return 0.5 * v[0] ** 2 - 0.5 * q[0] ** 2 + small(q[1:], v[1:])

    def small(q: Any, v: Any) -> Any:
        return 0.5 * v[0] ** 2 - 0.25 * q[0] ** 4

    single = galvi.Problem(galvi.Lagrangian(small, line), [1.0], [0.0])
    system = galvi.Lagrangian(both, galvi.Product((line, line)))
    beside = galvi.Problem(system, [size, 1.0], [0.0, 0.0])
    six = galvi.Galerkin(galvi.Polynomials(6), galvi.gauss(6))
    truth = galvi.integrate(single, six, 0.5, 200).q[-1, 0]
    if solver == "ensemble":
        end = galvi.integrate_ensemble(beside, beside.q0, beside.v0, six, 0.5, 200)[0][0, 1]
    else:
        end = galvi.integrate(beside, six, 0.5, 200, solver=solver).q[-1, 1]
    assert abs(end - truth) < 1e-12


def test_the_floor_is_what_makes_them_agree(monkeypatch: pytest.MonkeyPatch) -> None:
    """Planted: all factors count as coupled."""
    monkeypatch.setattr(group_system, "COUPLING", -1.0)
    group_system._coupled_layout.cache_clear()
    with pytest.raises(AssertionError):
        test_what_no_mass_couples_is_solved_as_if_alone("newton", 1e12)
    group_system._coupled_layout.cache_clear()
