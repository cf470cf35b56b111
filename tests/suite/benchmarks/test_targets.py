"""Targets against planted times: what is missed says so, and nothing is met without a run."""

from __future__ import annotations

import math
import re
from typing import Any

import pandas as pd
import pytest

from benchmarks.work_precision.fronts import NOT_REACHED
from benchmarks.work_precision.labels import LABELS, label_of
from benchmarks.work_precision.problem import WorkPrecisionProblem
from benchmarks.work_precision.problems import work_precision_problems
from benchmarks.work_precision.targets import FRAMES, ORBITS, PLAIN, TARGETS, TURNS, VECTORS, Target
from benchmarks.work_precision.targets_met import COLUMNS, MET, MISSED, NOT_RUN, targets_met

GALVI, PEER = "galvi degree 8, Gauss 8", "peer"


def rows(points: dict[str, list[tuple[float, float]]], problem: str = "p") -> pd.DataFrame:
    planted: list[dict[str, Any]] = [
        {
            "problem": problem,
            "contender": name,
            "error": error,
            "seconds": seconds,
            "settings": "",
            "is_truth": False,
            "status": "",
        }
        for name, some in points.items()
        for error, seconds in some
    ]
    return pd.DataFrame(planted)


def judged(
    points: dict[str, list[tuple[float, float]]],
    error: float | None = 1e-6,
    ratio: float | None = 4.0,
    contenders: tuple[str, ...] = (PEER,),
) -> dict[str, Any]:
    table = targets_met(rows(points), [Target("p", contenders, error, ratio)])
    assert tuple(table.columns) == COLUMNS and len(table) == 1
    return dict(table.iloc[0])


OURS = [(1e-2, 1.0), (1e-8, 1.0)]


@pytest.mark.parametrize(
    ("seconds", "verdict"), [(4.0, MET), (400.0, MET), (3.99, MISSED), (0.25, MISSED)]
)
def test_a_target_is_met_from_its_ratio_on_and_missed_below_it(
    seconds: float, verdict: str
) -> None:
    seen = judged({GALVI: OURS, PEER: [(1e-9, seconds)]})
    assert seen["verdict"] == verdict
    assert seen["ratio"] == pytest.approx(seconds)
    assert (seen["contender"], seen["galvi"]) == (PEER, GALVI)


def test_a_peer_whose_front_ends_above_the_error_says_not_reached() -> None:
    seen = judged({GALVI: OURS, PEER: [(1e-5, 100.0)]})
    assert (seen["ratio"], seen["verdict"]) == (NOT_REACHED, NOT_REACHED)
    assert (seen["contender"], seen["galvi"]) == ("", GALVI)


@pytest.mark.parametrize("theirs", [1e-9, 1e-5])
def test_where_galvi_does_not_get_there_the_target_is_missed_whoever_else_does(
    theirs: float,
) -> None:
    for ours in ({GALVI: [(1e-5, 1.0)]}, {}):
        seen = judged({**ours, PEER: [(theirs, 1e6)]})
        assert (seen["ratio"], seen["verdict"]) == (f"galvi: {NOT_REACHED}", MISSED)


@pytest.mark.parametrize("theirs", [{}, {PEER: [(math.nan, 1.0)]}, {PEER: [(1e-9, math.nan)]}])
def test_a_peer_without_a_run_is_not_run_and_has_no_ratio(
    theirs: dict[str, list[tuple[float, float]]],
) -> None:
    for error in (1e-6, None):
        seen = judged({GALVI: OURS, **theirs}, error)
        assert seen["verdict"] == NOT_RUN and math.isnan(seen["ratio"])


def test_the_fastest_of_a_peer_s_lines_counts_and_of_galvi_s() -> None:
    points = {
        GALVI: OURS,
        "galvi degree 16, Gauss 16": [(1e-8, 0.5)],
        PEER: [(1e-9, 9.0)],
        "peer, looser": [(1e-7, 2.0)],
        "another": [(1e-9, 0.1)],
    }
    seen = judged(points, contenders=(PEER, "peer, looser"))
    assert seen["ratio"] == pytest.approx(4.0) and seen["verdict"] == MET
    assert (seen["contender"], seen["galvi"]) == ("peer, looser", "galvi degree 16, Gauss 16")
    assert judged(points, 1e-8, 18.0, (PEER, "peer, looser"))["ratio"] == pytest.approx(18.0)


def test_only_galvi_s_lines_that_a_target_names_count_and_a_rival_may_be_galvi_s() -> None:
    kernel, other = f"{GALVI}, general kernel", "galvi degree 8, Gauss 9"
    points = {GALVI: [(1e-8, 1.0)], kernel: [(1e-8, 6.0)], other: [(1e-8, 2.0)]}
    table = rows({**points, PEER: [(1e-8, 8.0)]})
    asked = [
        Target("p", (rival,), 1e-6, 5.0, ours=ours)
        for rival in (PEER, kernel)
        for ours in ((), (other,))
    ]
    found = targets_met(table, asked)
    assert list(found["ratio"]) == pytest.approx([8.0, 4.0, 6.0, 3.0])
    assert list(found["verdict"]) == [MET, MISSED, MET, MISSED]
    assert list(found["galvi"]) == [GALVI, other, GALVI, other]
    assert list(found["counted"]) == ["any", "degree 8, Gauss 9"] * 2
    assert list(found["against"]) == [PEER, PEER, kernel, kernel]
    assert Target("p", PLAIN, 1e-6, 5.0).against == "galvi without frame, best"


def test_a_peer_s_own_error_is_reached_or_missed_at_a_ratio() -> None:
    reached = judged({GALVI: OURS, PEER: [(1e-7, 3.0), (1e-4, 1.0)]}, None, None)
    assert (reached["error"], reached["verdict"]) == (1e-7, MET)
    assert reached["ratio"] == pytest.approx(3.0) and math.isnan(reached["target"])
    alone = judged({GALVI: OURS, PEER: [(1e-5, 3.0)]}, 1e-7, None)
    assert (alone["ratio"], alone["verdict"]) == (NOT_REACHED, MET)
    missed = judged({GALVI: OURS, PEER: [(1e-9, 3.0)]}, None, None)
    assert (missed["ratio"], missed["verdict"]) == (f"galvi: {NOT_REACHED}", MISSED)


def test_a_warning_about_the_peer_s_own_error_is_told() -> None:
    table = rows({GALVI: OURS, PEER: [(1e-7, 3.0)]})
    table.loc[table["contender"] == PEER, "status"] = "Take it as a bound."
    own, other = (Target("p", (PEER,), error, None) for error in (None, 1e-6))
    assert list(targets_met(table, [own, other])["remark"]) == ["Take it as a bound.", ""]


def test_another_problem_s_rows_do_not_count() -> None:
    table = rows({GALVI: OURS, PEER: [(1e-9, 100.0)]}, problem="q")
    assert list(targets_met(table, [Target("p", (PEER,), 1e-6, 4.0)])["verdict"]) == [NOT_RUN]
    assert targets_met(table, ()).empty


@pytest.fixture(scope="module")
def cases() -> tuple[WorkPrecisionProblem, ...]:
    return work_precision_problems(False)


@pytest.mark.parametrize("quick", [True, False])
def test_every_target_names_contenders_that_take_part(quick: bool, cases) -> None:
    known = {
        case.problem.name: {label for label, _, _ in case.participants}
        for case in (work_precision_problems(True) if quick else cases)
    }
    for target in TARGETS:
        assert {*target.contenders, *target.ours} <= known[target.problem]
        assert target.ratio is None or target.ratio > 0.0
        assert (target.note != "") == ("general kernel" in target.contenders[0])
    asked = [(one.problem, one.contenders[0], one.ours, one.error) for one in TARGETS]
    assert len(set(asked)) == len(asked)
    for target in TARGETS:  # of orbits and rotations, the rival's own error too
        assert target.source == VECTORS or target.problem in {
            one.problem for one in TARGETS if one.error is None
        }
    assert {target.source for target in TARGETS} == {FRAMES, ORBITS, TURNS, VECTORS}
    assert "N bodies" in ORBITS and "rigid bodies" in TURNS


def test_readers_are_told_what_every_problem_is(cases) -> None:
    assert [case.problem.name for case in cases] == list(LABELS)
    for case in cases:
        year = 1.0 if "Applegate" in case.problem.name else 365.25  # of 365 days, and in days
        year = math.tau if "2 pi" in case.problem.units else year
        units = {"units of time": 1.0, "s": 1.0, "periods": math.tau, "years": year}
        units["revolutions"] = math.tau
        seen = label_of(case.problem.name)
        ((length, unit),) = re.findall(
            r"over ([\d,.]+) (units of time|s|periods|revolutions|years)", seen.text
        )
        assert float(length.replace(",", "")) * units[unit] == pytest.approx(
            case.duration, rel=1e-3
        )
        assert seen.text.endswith(".")
        assert (seen.time == "") == (case.problem.units.split(",")[0] not in ("au", "m", "kg"))
    assert len({one.title for one in LABELS.values()}) == len(LABELS)
    assert label_of("my own") == ("My own", "", "")
