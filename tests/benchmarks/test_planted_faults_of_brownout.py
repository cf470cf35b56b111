"""The claims about the brownout particle catch a wrong table, force, solve and cost."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import galvi
from benchmarks.checks.bounds import CONTRADICTED
from benchmarks.claims.vector_spaces.brownout_particle import ACROSS, AWAY, STARTS
from benchmarks.claims.vector_spaces.v23_brownout_order import TOLERANCES, V23
from benchmarks.claims.vector_spaces.v24_brownout_cost import ERROR, EULER, EVALUATIONS, V24
from galvi import Problem
from galvi.kernels.forces.rotor_wind import rotor_wind
from galvi.problems import brownout
from tests.benchmarks.planted_tables import contradicted, faulty
from tests.benchmarks.quick_studies import quick

INTEGRATE = galvi.integrate


@pytest.mark.parametrize("array", ["b", "integral"])
def test_a_table_that_is_slightly_wrong_is_caught(array: str) -> None:
    found = contradicted(V23, faulty(**{array: 1.0 + 1e-6}))
    assert f"order, N = 4, {AWAY}" in found
    assert f"distance to DOP853 [m], M's reference, N = 12, {AWAY}" in found


def other_drag(problem: Problem) -> Problem:
    """Stronger by a millionth."""
    known = problem.parameters["diameter"], problem.q0, problem.v0
    return brownout(*known, drag_coefficient=0.44 * (1.0 + 1e-6))


def no_drag(problem: Problem) -> Problem:
    """The force left out."""
    return replace(problem, system=replace(problem.system, force=None, timed_force=False))


def stopped_clock(problem: Problem) -> Problem:
    """The rotor a millionth of a second late."""
    return replace(problem, t0=problem.t0 - 1e-6)


@pytest.mark.parametrize("change", [other_drag, no_drag, stopped_clock])
def test_a_wrong_motion_is_caught_by_the_truth(
    change: Callable[[Problem], Problem], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(
        galvi, "integrate", lambda problem, *rest, **how: INTEGRATE(change(problem), *rest, **how)
    )
    found = contradicted(V23)
    assert {f"order, N = {N}, {AWAY}" for N in (3, 4)} <= found
    assert f"distance to DOP853 [m], M's reference, N = 12, {ACROSS}" in found


def test_a_saturation_that_is_not_of_the_tolerance_is_caught(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def deaf(*given: Any, tolerance: float | None = None, **how: Any) -> Any:
        return INTEGRATE(*given, **how)

    monkeypatch.setattr(galvi, "integrate", deaf)
    found = contradicted(V23)
    assert sum("solve stopped at" in quantity for quantity in found) == len(TOLERANCES)
    assert "power of the tolerance that this error falls with, N = 4" in found


def slowest(start: str) -> float:
    """The smallest velocity relative to the wind on the way [m/s]."""
    problem = STARTS[start].problem()
    four = galvi.Galerkin(galvi.Polynomials(4), galvi.gauss(5))
    run = galvi.integrate(problem, four, STARTS[start].duration / 64, 64)
    v = problem.system.velocity(run.p)
    w = [a - rotor_wind(*q, t) for a, q, t in zip(v, run.q, run.t, strict=True)]
    return float(np.min(np.linalg.norm(w, axis=1)))


def test_the_starts_are_what_their_words_say() -> None:
    assert slowest(AWAY) > 3.0 and "|w| > 3 m/s" in STARTS[AWAY].words  # 3.16
    assert slowest(ACROSS) < 0.1  # 0.015


def test_a_high_order_that_is_dear_is_caught() -> None:
    table = quick(V24)
    ours = (table["study"] != EULER) & (table["quantity"] == EVALUATIONS)
    table.loc[ours, "value"] *= 1000.0
    verdicts = {row.quantity: row.verdict for row in V24.judge(table)}
    asked = next(q for q in verdicts if q.startswith("force evaluations of semi-implicit Euler"))
    assert verdicts[asked] == CONTRADICTED


def test_a_cost_that_grows_as_fast_as_eulers_is_caught() -> None:
    """N steps of the same order as Euler's: the ratio of evaluations would not grow."""
    table = quick(V24)
    ours = table["study"] != EULER
    errors = table[ours & (table["quantity"] == ERROR)].set_index(["study", "steps"])["value"]
    for index in table[ours & (table["quantity"] == EVALUATIONS)].index:
        table.loc[index, "value"] = 1.0 / errors[tuple(table.loc[index, ["study", "steps"]])]
    verdicts = {row.quantity: row.verdict for row in V24.judge(table)}
    grows = next(q for q in verdicts if q.startswith("power of the inverse error"))
    assert verdicts[grows] == CONTRADICTED
