"""galvi agrees with every reference, and a motion that is slightly wrong agrees with none."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

import galvi
from benchmarks.checks.bounds import CONTRADICTED, HOLDS, NOT_RUN
from benchmarks.checks.claim import Claim, Row
from benchmarks.claims import agreement
from benchmarks.claims.agreements import AGREEMENTS, CASES, ENGINES, STORED, engines
from benchmarks.claims.truths import TRUTHS
from benchmarks.store.frames import frame
from benchmarks.work_precision.galvi_methods import Variational
from galvi import Problem
from references import REFERENCES

(OF_TRUTHS,) = (claim for claim in AGREEMENTS if claim.id == "A9")
WITH_GALVI = [claim for claim in AGREEMENTS if claim is not OF_TRUTHS]
BY_ID = pytest.mark.parametrize("claim", WITH_GALVI, ids=lambda claim: claim.id)


def rows(claim: Claim, make: Any = galvi.Galerkin) -> list[Row]:
    return claim.judge(claim.study(make, True, lambda sentence: None))


def test_every_reference_is_met_once_on_a_problem_that_it_solves() -> None:
    met = [case.contender.name for case in CASES]
    assert sorted(met) == sorted(contender.name for contender in REFERENCES)
    assert all(case.contender.supports(case.problem) for case in CASES)
    assert [claim.id for claim in AGREEMENTS] == [f"A{k + 1}" for k in range(len(AGREEMENTS))]


@pytest.mark.slow_cases("A1", "A2", "A3", "A4")
@BY_ID
def test_every_row_is_as_expected_and_says_what_it_was_held_against(claim: Claim) -> None:
    for row in rows(claim):
        assert row.verdict == row.expected, row
        assert row.id == claim.id and row.bound and row.setup and row.reason
        case = next(one for one in CASES if one.quantity == row.quantity)
        assert row.reference.startswith(case.contender.name)
        assert row.verdict == (NOT_RUN if case.contender.missing else HOLDS)


@BY_ID
def test_nothing_measured_is_never_an_agreement(claim: Claim) -> None:
    empty = claim.judge(agreement.frame([]))
    assert empty and all((row.verdict, row.expected) == (NOT_RUN, HOLDS) for row in empty)


def slower(problem: Problem) -> Problem:
    """By a tenth and more, which no reference's own error explains."""
    return replace(problem, v0=0.9 * problem.v0 + 0.05)


@pytest.mark.slow_cases("A3")
@BY_ID
def test_another_motion_agrees_with_none(claim: Claim, monkeypatch: pytest.MonkeyPatch) -> None:
    sound = Variational.run
    monkeypatch.setattr(
        Variational, "run", lambda self, problem, *rest: sound(self, slower(problem), *rest)
    )
    found = [row for row in rows(claim) if row.expected != NOT_RUN]
    assert found or claim.id in ("A3", "A4", "A5", "A8", "A10")
    assert [row.quantity for row in found if row.verdict != CONTRADICTED] == []


def test_weights_wrong_in_the_ninth_digit_agree_with_no_closed_form() -> None:
    def make(space: Any, rule: Any) -> galvi.Galerkin:
        method = galvi.Galerkin(space, replace(rule, name=f"{rule.name}, wrong"))
        table = method.table
        vars(method)["table"] = replace(
            table, b=table.b * (1.0 + 1e-9), beta=table.beta * (1.0 + 1e-9)
        )
        return method

    assert {row.verdict for row in rows(AGREEMENTS[0], make)} == {CONTRADICTED}


def test_a_run_that_fails_or_raises_is_not_run_and_was_expected_to_hold(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def broken(self: Variational, problem: Problem, *rest: Any) -> Any:
        raise ValueError("no such method")

    monkeypatch.setattr(Variational, "run", broken)
    claim = agreement.agreement("A9", "title", STORED)
    assert [(row.verdict, row.expected) for row in rows(claim)] == [(NOT_RUN, HOLDS)] * len(STORED)
    frame = claim.study(galvi.Galerkin, True, lambda sentence: None)
    assert set(frame["status"]) == {"ValueError: no such method"}


def test_an_absent_engine_is_named_and_its_row_is_expected_not_to_run() -> None:
    class Absent:
        name, missing, engine = "absent engine", "No module named 'absent'. Install it.", "absent"

    one = replace(STORED[1], contender=Absent())  # type: ignore[arg-type]
    (row,) = rows(agreement.agreement("A9", "title", (one,)))
    assert (row.verdict, row.expected, row.reason) == (NOT_RUN, NOT_RUN, Absent.missing)
    assert row.absent == "absent"


def test_engines_are_known_by_what_is_installed() -> None:
    known = {"rebound", "mujoco", "heyoka", "jplephem", "pinocchio"}
    assert set(engines()) == set(ENGINES) == known


@pytest.mark.slow(beside="test_every_row_is_as_expected_and_says_what_it_was_held_against")
def test_each_truth_of_the_claims_is_confirmed_by_a_second_one() -> None:
    for row in rows(OF_TRUTHS):
        assert row.verdict == row.expected == HOLDS, row
        assert row.slack is not None and row.slack > 1.0


@pytest.mark.slow(beside="test_another_motion_agrees_with_none")
def test_a_truth_of_another_motion_is_confirmed_by_none() -> None:
    class Perturbed:
        """The second truth, from a start that differs by 1e-9."""

        def __init__(self, second: Any) -> None:
            self.name, self.missing, self._second = second.name, second.missing, second

        def run(self, problem: Problem, *rest: Any) -> Any:
            return self._second.run(replace(problem, v0=(1.0 + 1e-9) * problem.v0 + 1e-9), *rest)

    for case in TRUTHS:
        if case.second.name.startswith("stored"):
            continue  # it knows its own starts only, and refuses others
        wrong = replace(case, second=Perturbed(case.second))
        table = frame([wrong.measured(galvi.Galerkin)])
        assert wrong.judged("A9", table).verdict == CONTRADICTED
