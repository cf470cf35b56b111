"""galvi agrees with every reference; absent, failing and wrong ones have different verdicts."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

import galvi
from benchmarks.checks.bounds import CONTRADICTED, HOLDS, NOT_RUN
from benchmarks.checks.claim import Claim
from benchmarks.claims import AGREEMENTS
from benchmarks.claims.agreements import ENGINES, TRUTHS, WithGalvi, engines
from benchmarks.claims.documents import all_documents, measuring_object
from benchmarks.work_precision.galvi_methods import Variational
from galvi import Problem
from references import REFERENCES
from tests.suite.benchmarks.planted_tables import rows

CLAIM = {claim.id: claim for claim in AGREEMENTS}
BY_ID = pytest.mark.parametrize("claim", AGREEMENTS, ids=lambda claim: claim.id)
ALL = [
    pair
    for part in all_documents()[-1].parts
    for section in part.sections
    for pair in measuring_object(section).pairs
]


def test_every_reference_is_met_once_on_a_problem_that_it_solves() -> None:
    pairs = [pair for pair in ALL if isinstance(pair, WithGalvi)]
    names = [pair.contender.name for pair in pairs]
    assert sorted(names) == sorted(contender.name for contender in REFERENCES)
    assert all(pair.contender.supports(pair.problem) for pair in pairs)
    assert [claim.id for claim in AGREEMENTS] == [f"A{k + 1}" for k in range(len(AGREEMENTS))]


@pytest.mark.slow_cases("A1", "A2", "A3", "A4", "A9")
@BY_ID
def test_every_row_is_as_expected_and_says_what_it_was_held_against(claim: Claim) -> None:
    for row in rows(claim):
        assert row.verdict == row.expected, row
        assert row.id == claim.id and row.bound and row.setup and row.reason
        pair = next(pair for pair in ALL if pair.quantity == row.quantity)
        assert row.reference.startswith(pair.references[-1].name)
        absent = any(reference.missing for reference in pair.references)
        assert row.verdict == (NOT_RUN if absent else HOLDS)


def test_a_run_that_fails_or_raises_is_not_run_and_was_expected_to_hold(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def broken(self: Variational, problem: Problem, *_: Any) -> Any:
        raise ValueError("no such method")

    monkeypatch.setattr(Variational, "run", broken)
    assert {(row.verdict, row.expected) for row in rows(CLAIM["A2"])} == {(NOT_RUN, HOLDS)}
    table = CLAIM["A2"].study(galvi.Galerkin, True, lambda sentence: None)
    assert set(table["status"]) == {"ValueError: no such method"}


def test_engines_are_known_by_what_is_installed() -> None:
    expected = {"rebound", "mujoco", "heyoka", "jplephem", "pinocchio"}
    assert set(engines()) == set(ENGINES) == expected


@pytest.mark.slow(beside="test_claims.py::test_a_planted_fault_is_caught")
def test_a_truth_of_another_motion_is_confirmed_by_none(monkeypatch: pytest.MonkeyPatch) -> None:
    class Perturbed:
        """The second truth, from a start that differs by 1e-9."""

        def __init__(self, second: Any) -> None:
            self.name, self.missing, self._second = second.name, second.missing, second

        def run(self, problem: Problem, *arguments: Any) -> Any:
            return self._second.run(
                replace(problem, v0=(1.0 + 1e-9) * problem.v0 + 1e-9), *arguments
            )

    def stored(pair: Any) -> bool:
        """Whether the second truth is stored, and so refuses other starts."""
        return pair.second.name.startswith("stored")

    wrong = [
        pair if stored(pair) else replace(pair, second=Perturbed(pair.second))
        for pair in TRUTHS.pairs
    ]
    monkeypatch.setattr(TRUTHS, "pairs", wrong)
    verdicts = [row.verdict for row in rows(CLAIM["A9"])]
    expected = [HOLDS if stored(pair) else CONTRADICTED for pair in wrong]
    assert verdicts == expected
