"""V30 catches bounds without a term and wrong motions; no verdict is built in."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pandas as pd
import pytest

import galvi
from benchmarks.checks.bounds import CONTRADICTED, HOLDS, NOT_RUN
from benchmarks.claims.vector_spaces import solution_map, theorem_three
from benchmarks.claims.vector_spaces import v30_solution_map as v30
from benchmarks.claims.vector_spaces.solution_map import Stability
from benchmarks.claims.vector_spaces.v30_solution_map import V30
from galvi import Problem
from tests.benchmarks.planted_tables import contradicted
from tests.benchmarks.quick_studies import quick

INTEGRATE = galvi.integrate
OVER = "largest of {} over its bound, {}"
EVERYWHERE = (*v30.MOTIONS, *v30.RULES)


@pytest.fixture
def few(monkeypatch: pytest.MonkeyPatch) -> None:
    """V30 at few degrees and steps."""
    monkeypatch.setattr(v30, "DEGREES", (1, 4))
    monkeypatch.setattr(v30, "THIRD_DEGREES", (1, 4))


def little_momentum(self: Stability, du: Any, dp: Any) -> Any:
    """With 1 for 3: a free particle alone goes sqrt(2 h) |dp|."""
    root = self.h**0.5
    return (abs(du) / root + root * abs(dp)) / (1.0 - self.eta)


def little_pull(self: Stability, du: Any, dp: Any) -> Any:
    return abs(dp) + 0.5 * self.pull * self.path(du, dp)


@pytest.mark.slow_cases(but=["momentum"])
@pytest.mark.usefixtures("few")
@pytest.mark.parametrize(
    ("name", "wrong", "quantity", "places"),
    [
        ("path", little_momentum, v30.PATH, EVERYWHERE),
        ("momentum", little_pull, v30.MOMENTUM, EVERYWHERE),
        ("both", property(lambda self: 1.0 / (1.0 - self.eta)), v30.SUM, tuple(v30.MOTIONS)),
    ],
    ids=["path", "momentum", "both"],
)
def test_a_bound_with_too_small_a_term_is_caught(
    monkeypatch: pytest.MonkeyPatch, name: str, wrong: Any, quantity: str, places: Any
) -> None:
    monkeypatch.setattr(Stability, name, wrong)
    assert {OVER.format(quantity, place) for place in places} <= contradicted(V30)


@pytest.mark.usefixtures("few")
def test_a_force_that_is_steeper_than_its_constant_is_caught(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    steep = galvi.Canonical(1.0, galvi.CosinePotential(4.0))

    def steeper(problem: Problem, *rest: Any) -> Any:
        return INTEGRATE(replace(problem, system=steep), *rest)

    def faster(u0: Any, v0: Any, t: Any) -> Any:
        u, v = solution_map.oscillations(u0, v0 / 2.0, 2.0 * t)
        return u, 2.0 * v

    monkeypatch.setattr(galvi, "integrate", steeper)
    monkeypatch.setattr(v30, "MOTIONS", {"oscillator": faster, "pendulum": solution_map.swings})
    found = contradicted(V30)
    places = ("oscillator", *v30.RULES)
    assert {OVER.format(v30.MOMENTUM, place) for place in places} <= found


ACCUSED = {
    v30.INF_SUP: ("least inf-sup constant over m", 0.4),
    v30.SINGULAR: ("least singular value of the equations (8), over the largest", 1e-3),
    v30.PROOF: (f"largest of {v30.PROOF}, {v30.GAUSS}", 0.9),
}


@pytest.mark.slow_cases("inf-sup")
@pytest.mark.parametrize("quantity", ACCUSED)
def test_what_is_true_is_not_accused(quantity: str) -> None:
    name, value = ACCUSED[quantity]
    table = quick(V30)
    assert verdicts(table)[name] == CONTRADICTED
    table.loc[table["quantity"] == quantity, "value"] = value
    assert verdicts(table)[name] == HOLDS


def test_theorem_2_is_not_accused_of_a_step_that_it_excludes() -> None:
    table = quick(V30)
    table.loc[table["quantity"] == v30.ETA, "value"] = 1.01
    found = verdicts(table)
    assert found[ACCUSED[v30.SINGULAR][0]] == NOT_RUN
    assert found["eta C_N^2 of that pair"] == CONTRADICTED


def verdicts(table: pd.DataFrame) -> dict[str, str]:
    return {row.quantity: row.verdict for row in V30.judge(table)}


def test_the_right_side_of_theorem_3_grows_with_the_error_of_the_rule() -> None:
    """Lobatto N errs in |u'|^2, and not in the force more than N + 1 points: only I_2 tells."""
    case = theorem_three.COMPARISONS[0]
    best = [theorem_three.consistency(case, v30.nodes(galvi.lobatto(k)), 3, 0.2)[0] for k in (3, 4)]
    assert best[0] > 10.0 * best[1]
