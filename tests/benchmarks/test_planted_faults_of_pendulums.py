"""L6 to L9, L11, L14 and L15 catch a wrong table, a wrong motion, and bounds that are too wide."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import pytest

import galvi
from benchmarks.checks.bounds import CONTRADICTED
from benchmarks.checks.claim import Claim
from benchmarks.claims.lie_groups import l08_pendulum_energy as l08
from benchmarks.claims.lie_groups import l09_pendulum_near_chart_limit as l09
from benchmarks.claims.lie_groups import l14_other_charts_and_groups as l14
from benchmarks.claims.lie_groups.l06_pendulum_convergence_in_n import L6
from benchmarks.claims.lie_groups.l07_pendulum_order import L7
from benchmarks.claims.lie_groups.l08_pendulum_energy import L8
from benchmarks.claims.lie_groups.l09_pendulum_near_chart_limit import L9
from benchmarks.claims.lie_groups.l11_minima_of_the_action import L11
from benchmarks.claims.lie_groups.l14_other_charts_and_groups import L14
from benchmarks.claims.lie_groups.l15_curves_between_ends import L15
from benchmarks.measures import second_variation
from galvi import Problem
from tests.benchmarks.planted_tables import contradicted, faulty, reversed_clock, rows


def only_refinement(patch: pytest.MonkeyPatch) -> None:
    """Of L8."""
    patch.setattr(l08, "STEPS", 20)
    patch.setattr(l08, "short_runs", lambda *given: [])


def only_the_light_body(patch: pytest.MonkeyPatch) -> None:
    """Of L9."""
    patch.setattr(l09, "QUICK_WEIGHTS", (l09.LIGHT,))
    patch.setattr(l09, "CHARTS", ())
    patch.setattr(l09, "single_steps", lambda *given: [])


def only_one_case(patch: pytest.MonkeyPatch) -> None:
    """Of L14."""
    name = "SE(3), Cayley chart"
    patch.setattr(l14, "CASES", {name: l14.CASES[name]})
    patch.setattr(l14, "CHARTS", ())


PARTS = {"L8": only_refinement, "L9": only_the_light_body, "L14": only_one_case}


@pytest.mark.parametrize(
    ("claim", "make", "quantities"),
    [
        (L6, faulty(b=1.0 + 1e-9), {"smallest one-step error"}),
        (
            L6,
            faulty(integral=1.0 + 1e-4),
            {"base of the one-step error", "base of the curve error"},
        ),
        (L7, faulty(b=1.0 + 1e-4), {"order of the one-step error, n = 5"}),
        (L7, faulty(b=1.0 + 1e-6), {"order of the one-step error, n = 4"}),
        (L7, faulty(integral=1.0 + 1e-4), {"order of the curve error, n = 4"}),
        (L8, faulty(integral=1.0 + 1e-4), {"order of the largest energy error, n = 8"}),
        (L9, faulty(b=1.0 + 1e-9), {"largest energy error, m g = 9.81, Cayley chart"}),
        (L14, faulty(b=1.0 + 1e-6), {"order of the one-step error, SE(3), Cayley chart, n = 4"}),
        (L15, faulty(b=1.0 + 1e-6), {"base of the step's error"}),
        (L15, faulty(integral=1.0 + 1e-4), {"order of the curve's distance, n = 6"}),
    ],
)
def test_a_table_that_is_slightly_wrong_is_caught(
    claim: Claim, make: Any, quantities: set[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """In the part of the study that these quantities are from."""
    PARTS.get(claim.id, lambda patch: None)(monkeypatch)
    assert quantities <= contradicted(claim, make)


def heavier(problem: Problem) -> Problem:
    """By a millionth."""
    system: Any = problem.system
    weight = replace(system.potential, mass=system.potential.mass * (1.0 + 1e-6))
    return Problem(galvi.RigidBody(system.inertia, weight), problem.q0, problem.v0, problem.t0)


@pytest.mark.parametrize("claim", [L6, L7, L15], ids=["L6", "L7", "L15"])
@pytest.mark.parametrize("change", [reversed_clock, heavier])
def test_a_wrong_motion_is_caught_by_the_truth(
    claim: Claim, change: Callable[[Problem], Problem], monkeypatch: pytest.MonkeyPatch
) -> None:
    sound = galvi.integrate
    monkeypatch.setattr(galvi, "integrate", lambda problem, *rest: sound(change(problem), *rest))
    assert contradicted(claim) != set()


def test_energy_alone_does_not_see_a_wrong_motion(monkeypatch: pytest.MonkeyPatch) -> None:
    sound = galvi.integrate
    monkeypatch.setattr(
        galvi, "integrate", lambda problem, *rest: sound(reversed_clock(problem), *rest)
    )
    assert contradicted(L8) == set()


def test_single_steps_of_the_other_chart_do_not_jump(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(l09, "QUICK_WEIGHTS", ())
    monkeypatch.setattr(l09, "CHARTS", ())

    def exponential(space: Any, rule: Any, chart: Any = None) -> galvi.Galerkin:
        return galvi.Galerkin(space, rule, galvi.Exponential())

    found = contradicted(L9, exponential)
    assert any("growth of the median change of energy" in quantity for quantity in found)


def test_a_chart_taken_for_the_other_does_not_end_where_it_should(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(l14, "CASES", {})

    def exponential(space: Any, rule: Any, chart: Any = None) -> galvi.Galerkin:
        return galvi.Galerkin(space, rule, galvi.Exponential())

    limit = "largest turn of one step done right, over pi, Cayley chart"
    told = "share of turns beyond pi that end the run with a status, Cayley chart"
    assert {limit, told} <= contradicted(L14, exponential)


@pytest.mark.parametrize("group", ["SO(3) x R^3", "SE(2)"])
def test_a_motion_that_is_a_millionth_off_is_caught(
    group: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(l14, "CASES", {k: v for k, v in l14.CASES.items() if group in k})
    monkeypatch.setattr(l14, "CHARTS", ())
    thrown: Any = {"SO(3) x R^3": l14.thrown_point, "SE(2)": l14.thrown_plate}[group]
    sound = thrown.exact
    monkeypatch.setattr(thrown, "exact", lambda *arguments: sound(*arguments) * (1.0 + 1e-6))
    assert any(group in quantity for quantity in contradicted(L14))


@pytest.mark.parametrize(
    ("name", "change"),
    [
        ("speed", lambda value: 4.0 * value),
        ("well", lambda value: 0.0 * value),
    ],
)
def test_constants_that_are_too_good_are_caught(
    name: str, change: Callable[[float], float], monkeypatch: pytest.MonkeyPatch
) -> None:
    sound = second_variation.constants

    def wrong(run: Any) -> Any:
        known = sound(run)
        return replace(known, **{name: change(getattr(known, name))})

    monkeypatch.setattr("benchmarks.claims.lie_groups.l11_minima_of_the_action.constants", wrong)
    assert contradicted(L11) != set()


def test_a_second_variation_without_its_potential_has_no_zero_there(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(second_variation, "_potential", lambda run, z: 0.0 * z[:, 0])
    least = [row for row in rows(L11) if "least eigenvalue at h" in row.quantity]
    assert [row.verdict for row in least] == [CONTRADICTED]
