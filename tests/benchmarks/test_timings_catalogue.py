"""The catalogue of what is timed: every problem, unique names, truths that are there."""

from __future__ import annotations

import json
import math
from dataclasses import asdict, replace

import pytest

import galvi
from benchmarks.timings.case import ROUND_OFF, STEP, TRAJECTORY, Case
from benchmarks.timings.catalogue import CASES
from benchmarks.timings.truth import Unknown, error_of, true_ends
from references import reference


@pytest.mark.parametrize("kind", [STEP, TRAJECTORY])
def test_every_problem_has_a_case_of_this_kind(kind: str) -> None:
    assert {case.problem for case in CASES if case.kind == kind} == set(galvi.problems.__all__)


def test_names_are_unique_and_a_case_is_plain_data() -> None:
    names = [case.name for case in CASES]
    assert len(set(names)) == len(names)
    for case in CASES:
        assert Case(**json.loads(json.dumps(asdict(case)))) == case


def test_every_truth_is_a_reference_that_solves_the_problem() -> None:
    for case in CASES:
        problem = getattr(galvi.problems, case.problem)(**case.arguments)
        assert not case.truth or reference(case.truth).supports(problem), case.name


def test_rounding_and_trajectories_are_among_the_quick_ones() -> None:
    quick = [case for case in CASES if case.quick]
    assert {case.kind for case in quick} == {STEP, TRAJECTORY, ROUND_OFF}
    assert len(quick) < len(CASES) / 2


def test_a_case_without_a_truth_says_so() -> None:
    with pytest.raises(Unknown, match="no truth but galvi's own"):
        true_ends(replace(CASES[0], truth=""))


def test_the_error_is_the_rms_over_starts_and_nan_for_a_failed_run() -> None:
    truth = [[0.0, 0.0], [0.0, 0.0]]
    assert error_of([[3.0, 0.0], [0.0, -4.0]], truth) == pytest.approx(12.5**0.5)
    assert math.isnan(error_of([[math.nan, 0.0], [0.0, 0.0]], truth))
