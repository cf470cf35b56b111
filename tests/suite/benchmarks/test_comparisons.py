"""Comparisons: fronts keep what no other setting beats, ratios compare at matched error, profiles
count each problem once, and a target is met by a run or not at all."""

from __future__ import annotations

import math
import re
import statistics
from collections.abc import Callable
from typing import Any

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import binom

from benchmarks.statistics.paired import FASTER, SLOWER, written
from benchmarks.work_precision.dependable import dependable, error_is_bound, resolution
from benchmarks.work_precision.fronts import (
    NOT_REACHED,
    OURS,
    at_smallest,
    front,
    ratios,
    seconds_at,
    unfounded,
)
from benchmarks.work_precision.labels import LABELS, label_of
from benchmarks.work_precision.problem import WorkPrecisionProblem
from benchmarks.work_precision.problems import work_precision_problems
from benchmarks.work_precision.profiles import FAILED_COST, Share, costs, profile, share
from benchmarks.work_precision.targets import (
    FRAME_SOURCE,
    NBODY_SOURCE,
    RIGID_BODY_SOURCE,
    TARGETS,
    VECTOR_SOURCE,
    WITHOUT_FRAME,
    Target,
)
from benchmarks.work_precision.targets_met import COLUMNS, MET, MISSED, NOT_RUN, targets_met

NONE = f"galvi: {NOT_REACHED}"
Points = dict[str, list[tuple[float, float]]]


def table(points: Points, problem: str = "p", **columns: Any) -> pd.DataFrame:
    """A table of runs; `points` has the (error, seconds) of each contender's runs."""
    rows: list[dict[str, Any]] = [
        {
            "problem": problem,
            "contender": name,
            "settings": f"step={k}",
            "error": error,
            "seconds": seconds,
            "is_truth": False,
            "status": "",
            "steps": 1.0,
        }
        for name, pairs in points.items()
        for k, (error, seconds) in enumerate(pairs)
    ]
    return pd.DataFrame(rows).assign(evaluations=math.nan, **columns)


# ---- fronts and ratios

POSITIVE = st.floats(1e-15, 1e3)


@given(st.lists(st.tuples(POSITIVE, POSITIVE), min_size=1, max_size=20))
def test_nothing_beats_a_point_of_the_front_and_something_beats_every_other(
    points: list[tuple[float, float]],
) -> None:
    front_rows = front(table({"a": points}))
    front_points = set(zip(front_rows["error"], front_rows["seconds"], strict=True))
    assert (
        front_rows["error"].is_monotonic_decreasing
        and front_rows["seconds"].is_monotonic_increasing
    )
    for point in points:
        assert any(e <= point[0] and s <= point[1] for e, s in front_points)
    for end in front_points:
        assert not any(
            (e < end[0] and s <= end[1]) or (e <= end[0] and s < end[1]) for e, s in points
        )


def test_a_time_is_that_of_a_run_that_reaches_the_error() -> None:
    for target, seconds in ((1e-4, 4.0), (1.0, 1.0), (1e-6, 4.0), (1e-7, math.nan)):
        time = seconds_at([1e-2, 1e-6], [1.0, 4.0], target)
        assert time == pytest.approx(seconds, nan_ok=True)


def test_ratios_are_taken_to_the_fastest_method_of_galvi() -> None:
    points = {
        "galvi low": [(1e-2, 1.0), (1e-4, 8.0)],
        "galvi high": [(1e-2, 3.0), (1e-8, 5.0)],
        "peer": [(1e-2, 10.0), (1e-6, 40.0)],
    }
    ratio_rows = ratios(table(points), [1e-2, 1e-8]).set_index(["contender", "error"])
    assert ratio_rows.loc[("peer", 1e-2), "ratio"] == pytest.approx(10.0)
    assert ratio_rows.loc[(OURS, 1e-8), "seconds"] == pytest.approx(5.0)
    assert ratio_rows.loc[("peer", 1e-8), "ratio"] == NOT_REACHED
    assert ratio_rows.loc[("galvi low", 1e-8), "ratio"] == NOT_REACHED


def test_each_contender_is_asked_for_the_smallest_error_that_it_reaches() -> None:
    points = {
        "galvi low": [(1e-2, 1.0), (1e-4, 8.0)],
        "galvi high": [(1e-2, 3.0), (1e-8, 5.0)],
        "near": [(1e-2, 10.0), (1e-6, 40.0), (1e-5, 80.0)],
        "far": [(1e-9, 50.0)],
        "failed": [(math.nan, 1.0)],
    }
    smallest = at_smallest(table(points)).set_index("contender")
    assert smallest["error"].to_dict() == {
        OURS: 1e-8,
        "galvi low": 1e-4,
        "galvi high": 1e-8,
        "near": 1e-6,
        "far": 1e-9,
    }
    assert smallest.loc["near", "ratio"] == pytest.approx(40.0 / 5.0)
    assert smallest.loc["far", "ratio"] == f"galvi: {NOT_REACHED}"
    assert smallest.loc[OURS, "seconds"] == pytest.approx(5.0)
    assert at_smallest(table({"galvi": [(math.nan, 1.0)]})).empty


def test_one_lucky_end_does_not_count_and_growing_round_off_is_not_held_against_coarser_steps():
    errors = {8.0: 1e-4, 4.0: 1e-13, 2.0: 1e-9, 1.0: 2e-13, 0.5: 1e-13, 0.25: 3e-13}
    rows = table({"a": [(error, 1.0 / step) for step, error in errors.items()]})
    rows["settings"] = [f"kernel=LAZY step={step:g}" for step in errors]
    rows.loc[6] = dict(rows.loc[5]) | {"settings": "kernel=OTHER step=0.1", "error": 1.0}
    dependable_rows = dependable(rows)
    assert list(dependable_rows["error"]) == [1e-4, 1e-9, 1e-9, 2e-13, 3e-13, 3e-13, 1.0]
    assert list(dependable(rows.sample(frac=1, random_state=1)).sort_index()["error"]) == list(
        dependable_rows["error"]
    )
    failed = dependable(rows.assign(error=rows["error"].mask(rows["settings"].str.contains("=2$"))))
    assert failed.loc[1, "error"] == 2e-13 and math.isnan(failed.loc[2, "error"])


def test_no_run_counts_as_better_than_what_the_truth_can_tell():
    rows = table({"galvi": [(1e-9, 1.0), (1e-11, 2.0)], "peer": [(2e-10, 1.0), (5e-10, 1.0)]})
    rows["settings"] = ["step=2", "step=1", "tolerance=1e-9", "tolerance=1e-6"]
    assert resolution(rows) == 0.0
    for chosen in (rows, rows[:2]):  # whoever took part
        with_truth = chosen.assign(truth_error=[3e-11] * len(chosen))
        assert resolution(with_truth) == resolution(dependable(with_truth)) == 10.0 * 3e-11
        assert list(dependable(with_truth)["error"]) == [1e-9, 3e-10, 3e-10, 5e-10][: len(chosen)]
        assert (
            list(error_is_bound(dependable(with_truth), with_truth))
            == [False, True, True, False][: len(chosen)]
        )
        counted = dependable(with_truth)
        assert list(counted["error_is_bound"]) == [False, True, True, False][: len(chosen)]
        assert list(counted["own_error"]) == list(with_truth["error"])
        assert dependable(counted).equals(counted)


def test_a_run_that_failed_has_no_place_and_the_truth_stands_beside_the_front() -> None:
    rows = table({"galvi": [(1e-2, 1.0), (math.nan, 0.1)], "truth": [(math.nan, 7.0)]})
    rows["is_truth"] = rows["contender"] == "truth"
    assert len(front(rows)) == 1
    ratio_rows = ratios(rows, [1e-1]).set_index("contender")
    assert ratio_rows.loc["truth", "ratio"] == pytest.approx(7.0)
    rows.loc[len(rows)] = dict(rows.loc[0]) | {
        "is_truth": False,
        "contender": "truth",
        "error": 1e-3,
        "seconds": 2.0,
    }
    seconds = ratios(rows, [1e-1, 1e-4]).set_index(["contender", "error"])["seconds"]
    assert seconds["truth", 1e-1] == 2.0 and seconds["truth", 1e-4] == 7.0


TIME = st.floats(1e-4, 1e2)
ROUNDS = st.sampled_from([0, 2, 7]).flatmap(lambda n: st.lists(TIME, min_size=n, max_size=n))
RUN = st.tuples(st.sampled_from(["galvi a", "galvi b", "peer"]), st.floats(1e-9, 1.0), TIME, ROUNDS)


@given(st.lists(RUN, min_size=1, max_size=12))
def test_no_row_of_galvi_is_below_its_best_and_no_time_falls_with_the_error(
    runs: list[tuple[str, float, float, list[float]]],
) -> None:
    """Also on a busy machine: each setting has one time, by which it is chosen and shown."""
    rows = pd.DataFrame(
        [
            {
                "problem": "p",
                "contender": name,
                "settings": f"step={k}",
                "error": error,
                "seconds": seconds,
                "rounds": written(rounds),
                "is_truth": False,
            }
            for k, (name, error, seconds, rounds) in enumerate(runs)
        ]
    )
    errors = (1e-2, 1e-4, 1e-6)
    cells = ratios(rows, errors)
    for error in errors:
        times = cells[cells["error"] == error].set_index("contender")["seconds"]
        best = times[times.index.str.startswith("galvi ")].min()
        assert times[OURS] == best or (math.isnan(best) and math.isnan(times[OURS]))
    for _, line in cells.groupby("contender"):
        assert line["seconds"].dropna().is_monotonic_increasing
    assert cells["seconds"].dropna().isin(rows["seconds"]).all()


def in_rounds(
    galvi_times: list[float], peer_times: list[float], again: list[float] | None = None
) -> pd.DataFrame:
    rows = table({"galvi": [(1e-6, 1.0)], "peer": [(1e-6, 1.5)]})
    rows["seconds"] = [statistics.median(galvi_times), statistics.median(peer_times or [1.5])]
    rows["rounds"] = [written(galvi_times), written(peer_times)]
    rows["again"] = [written(again or galvi_times), ""]
    return rows


def test_a_ratio_is_of_the_times_of_the_same_rounds() -> None:
    load = [1.0, 3.0, 1.0, 2.0, 1.0, 5.0, 1.0]
    ratio_rows = ratios(in_rounds(load, [2.0 * time for time in load]), [1e-6]).set_index(
        "contender"
    )
    peer = ratio_rows.loc["peer"]
    assert (peer["low"], peer["ratio"], peer["high"], peer["outcome"]) == (2, 2, 2, FASTER)
    assert ratio_rows.loc[OURS, "seconds"] == 1.0 and peer["seconds"] == 2.0
    slower = ratios(in_rounds(load, [0.5 * time for time in load]), [1e-6]).set_index("contender")
    assert slower.loc["peer", "outcome"] == SLOWER and slower.loc["galvi", "outcome"] == ""


def test_without_enough_rounds_in_common_there_is_a_ratio_but_no_outcome() -> None:
    """A long run takes part in the first rounds only."""
    for galvi_times, peer_times, ratio in (
        ([1.0] * 7, [], 1.5),
        ([1.0, 2.0, 9.0, 9.0, 9.0, 9.0, 9.0], [30.0, 60.0], 30.0),
    ):
        peer = ratios(in_rounds(galvi_times, peer_times), [1e-6]).set_index("contender").loc["peer"]
        assert peer["ratio"] == ratio and math.isnan(peer["low"]) and peer["outcome"] == ""


def test_a_contender_whose_loosest_run_is_far_more_accurate_than_asked_is_told() -> None:
    points = {
        "galvi": [(5e-3, 1.0), (1e-8, 3.0)],
        "tight": [(2e-4, 1.0), (1e-7, 2.0)],
        "near": [(1e-2, 9.0), (2e-4, 1.0)],  # a looser one is there, and slower
    }
    cells = ratios(table(points), [1e-2, 1e-4, 1e-6]).set_index(["contender", "error"])["closer"]
    assert cells["tight", 1e-2] == pytest.approx(50.0)
    assert cells["tight", 1e-4] == pytest.approx(1000.0)
    assert cells[OURS, 1e-6] == cells["galvi", 1e-6] == pytest.approx(100.0)
    not_closer = [("galvi", 1e-2), (OURS, 1e-2), ("near", 1e-2), ("near", 1e-4), ("tight", 1e-6)]
    assert cells[not_closer].isna().all()


def test_a_winner_that_was_never_run_is_told() -> None:
    rows = table({"galvi": [(1e-2, 1.0), (1e-6, 3.0)], "peer": [(1e-2, 2.0), (1e-8, 9.0)]})
    cells = ratios(rows, [1e-2, 1e-4, 1e-8])
    assert unfounded(cells, rows) == []
    for planted in (
        {"settings": "step=0.5"},  # between two that were run
        {"settings": "step=0", "error": 1e-4},  # run, but above the error
    ):
        row = {**cells[cells["contender"] == "peer"].iloc[0], **planted}
        (message,) = unfounded(pd.concat([cells, pd.DataFrame([row])], ignore_index=True), rows)
        assert "peer" in message and row["settings"] in message


# ---- profiles

ERROR = 1e-6


def costs_by_code(runs: pd.DataFrame) -> pd.DataFrame:
    return costs(runs, ratios(runs, [ERROR]), ERROR).set_index(["problem", "code"])


EIGHT = "galvi degree 8"
THREE: dict[str, Points] = {
    "a": {EIGHT: [(1e-7, 1.0)], "galvi degree 4": [(1e-7, 3.0)], "peer": [(1e-7, 2.0)]},
    "b": {EIGHT: [(1e-7, 4.0)], "peer": [(1e-7, 1.0)]},
    "c": {EIGHT: [(1e-7, 1.0)], "peer": [(1e-3, 1.0), (1e-5, 1.0)]},
}


def runs(*added: tuple[str, Points]) -> pd.DataFrame:
    """Runs of the problems of THREE, and of the added ones."""
    parts = [table(points, problem) for problem, points in (*THREE.items(), *added)]
    return pd.concat(parts, ignore_index=True)


def test_a_ratio_is_to_the_fastest_code_and_a_failure_counts_once_as_never() -> None:
    cost_rows = costs_by_code(runs())
    assert cost_rows["ratio"].to_dict() == {
        ("a", "galvi"): 1.0,
        ("a", "peer"): 2.0,
        ("b", "galvi"): 4.0,
        ("b", "peer"): 1.0,
        ("c", "galvi"): 1.0,
        ("c", "peer"): FAILED_COST,
    }
    peer = cost_rows.xs("peer", level="code")
    assert [point.share for point in profile(peer["ratio"], [1.0, 2.0, 1e9])] == [
        1 / 3,
        2 / 3,
        2 / 3,
    ]
    assert list(peer["outcome"]) == [FASTER, SLOWER, FASTER]


def test_a_code_that_fails_everywhere_is_flat_at_zero_and_changes_no_other_ratio() -> None:
    failures = {"broken": [(math.nan, math.nan)] * 4}
    cost_rows, before = (
        costs_by_code(runs(*((problem, failures) for problem in THREE))),
        costs_by_code(runs()),
    )
    broken = cost_rows.xs("broken", level="code")
    assert len(broken) == 3 and (broken["ratio"] == FAILED_COST).all()
    assert all(point.share == point.low == 0.0 for point in profile(broken["ratio"], [1.0, 1e300]))
    without_broken = cost_rows["ratio"].drop("broken", level="code")
    assert without_broken.to_dict() == before["ratio"].to_dict()


def test_where_nobody_gets_there_nobody_is_the_fastest() -> None:
    cost_rows = costs_by_code(table({EIGHT: [(1e-2, 1.0)], "peer": [(1e-3, 1.0)]}))
    assert (cost_rows["ratio"] == FAILED_COST).all() and (cost_rows["outcome"] == "").all()


def test_what_was_never_run_has_no_place() -> None:
    """A missing engine leaves rows without costs; a row with a time and no error wins nothing."""
    absent = runs(("a", {"heyoka": [(math.nan, math.nan)]}))
    absent.loc[absent["contender"] == "heyoka", "steps"] = math.nan
    assert "heyoka" not in costs_by_code(absent).index.get_level_values("code")
    never = [(math.nan, 1e-9)]
    cost_rows = costs_by_code(runs(("a", {"peer": never}), ("b", {"faster": never})))
    assert (
        cost_rows.loc[("a", "peer"), "cost"] == 2.0 and cost_rows.loc[("b", "peer"), "ratio"] == 1.0
    )
    assert cost_rows.loc[("b", "faster"), "cost"] == FAILED_COST


def test_a_problem_whose_truth_cannot_tell_the_error_is_not_counted() -> None:
    with_truth = runs()
    with_truth["truth_error"] = [
        1e-6 if problem == "b" else 1e-16 for problem in with_truth["problem"]
    ]
    assert set(costs_by_code(with_truth).index.get_level_values("problem")) == {"a", "c"}


Band = Callable[[int, int], Share]


def covered(problems: int, true: float, band: Band = share) -> float:
    """Probability that the band of `problems` problems contains the true share."""
    probability = 0.0
    for solved in range(problems + 1):
        low, _, high = band(solved, problems)
        probability += float(binom.pmf(solved, problems, true)) * (low <= true <= high)
    return probability


def too_narrow(solved: int, problems: int) -> Share:
    low, middle, high = share(solved, problems)
    return Share(middle - 0.3 * (middle - low), middle, middle + 0.3 * (high - middle))


def without_ends(solved: int, problems: int) -> Share:
    """The bootstrap alone, whose draws are all equal where no problem, or each, is solved."""
    bootstrapped = share(solved, problems)
    return Share(*[bootstrapped.share] * 3) if solved in (0, problems) else bootstrapped


@pytest.mark.parametrize("problems", [5, 12])
def test_bands_cover_and_ones_that_are_too_small_are_seen(problems: int) -> None:
    true_shares = [0.02 * k for k in range(1, 50)]

    def cover(band: Band) -> list[float]:
        return [covered(problems, true, band) for true in true_shares]

    assert np.mean(cover(share)) > 0.93 and min(cover(share)) > 0.8
    assert np.mean(cover(too_narrow)) < 0.6
    assert min(cover(without_ends)) < 0.5


def test_no_problems_have_no_share() -> None:
    assert math.isnan(share(0, 0).share)


# ---- targets

GALVI, PEER = "galvi degree 8, Gauss 8", "peer"
GALVI_POINTS = {GALVI: [(1e-2, 1.0), (1e-8, 1.0)]}
MISSING = (math.nan, NOT_RUN)


@pytest.mark.parametrize(
    ("points", "error", "ratio", "expected"),
    [
        (GALVI_POINTS | {PEER: [(1e-9, 4.0)]}, 1e-6, 4.0, (4.0, MET)),
        (GALVI_POINTS | {PEER: [(1e-9, 3.99)]}, 1e-6, 4.0, (3.99, MISSED)),
        (GALVI_POINTS | {PEER: [(1e-5, 100.0)]}, 1e-6, 4.0, (NOT_REACHED, NOT_REACHED)),
        ({GALVI: [(1e-5, 1.0)], PEER: [(1e-9, 1e6)]}, 1e-6, 4.0, (NONE, MISSED)),
        ({GALVI: [(1e-5, 1.0)], PEER: [(1e-5, 1e6)]}, 1e-6, 4.0, (NONE, MISSED)),
        ({PEER: [(1e-9, 1e6)]}, 1e-6, 4.0, (NONE, MISSED)),
        (GALVI_POINTS, 1e-6, 4.0, MISSING),
        (GALVI_POINTS | {PEER: [(math.nan, 1.0)]}, 1e-6, 4.0, MISSING),
        (GALVI_POINTS | {PEER: [(1e-9, math.nan)]}, None, 4.0, MISSING),
        (GALVI_POINTS | {PEER: [(1e-7, 3.0), (1e-4, 1.0)]}, None, None, (3.0, MET)),
        (GALVI_POINTS | {PEER: [(1e-5, 3.0)]}, 1e-7, None, (NOT_REACHED, MET)),
        (GALVI_POINTS | {PEER: [(1e-9, 3.0)]}, None, None, (NONE, MISSED)),
    ],
)
def test_a_target_is_met_from_its_ratio_on_and_not_without_runs(
    points: Points, error: float | None, ratio: float | None, expected: tuple[Any, str]
) -> None:
    verdicts = targets_met(table(points), [Target("p", (PEER,), error, ratio)])
    assert tuple(verdicts.columns) == COLUMNS and len(verdicts) == 1
    row, peer_errors = verdicts.iloc[0], [e for e, _ in points.get(PEER, [])]
    assert row["verdict"] == expected[1]
    assert row["ratio"] == pytest.approx(expected[0], nan_ok=True)
    if expected != MISSING:
        assert row["error"] == (min(peer_errors) if error is None else error)
        assert row["contender"] == (PEER if min(peer_errors) <= row["error"] else "")
        assert row["galvi"] == ("" if expected[0] == NONE else GALVI)
        assert (ratio is None) == math.isnan(row["target"])


def test_the_fastest_of_a_peer_s_lines_counts_and_of_galvi_s() -> None:
    fast = "galvi degree 16, Gauss 16"
    points = GALVI_POINTS | {
        fast: [(1e-8, 0.5)],
        PEER: [(1e-9, 9.0)],
        "peer, looser": [(1e-7, 2.0)],
        "another": [(1e-9, 0.1)],
    }
    targets = [Target("p", (PEER, "peer, looser"), error, 4.0) for error in (1e-6, 1e-8)]
    verdicts = targets_met(table(points), targets)
    assert list(verdicts["ratio"]) == pytest.approx([4.0, 18.0]) and set(verdicts["verdict"]) == {
        MET
    }
    assert list(verdicts["contender"]) == ["peer, looser", PEER] and set(verdicts["galvi"]) == {
        fast
    }


def test_only_galvi_s_lines_that_a_target_names_count_and_a_rival_may_be_galvi_s() -> None:
    kernel, degree_8 = f"{GALVI}, general kernel", "galvi degree 8, Gauss 9"
    points = {GALVI: [(1e-8, 1.0)], kernel: [(1e-8, 6.0)], degree_8: [(1e-8, 2.0)]}
    runs = table({**points, PEER: [(1e-8, 8.0)]})
    targets = [
        Target("p", (rival,), 1e-6, 5.0, galvi_contenders=lines)
        for rival in (PEER, kernel)
        for lines in ((), (degree_8,))
    ]
    verdicts = targets_met(runs, targets)
    assert list(verdicts["ratio"]) == pytest.approx([8.0, 4.0, 6.0, 3.0])
    assert list(verdicts["verdict"]) == [MET, MISSED, MET, MISSED]
    assert list(verdicts["galvi"]) == [GALVI, degree_8, GALVI, degree_8]
    assert list(verdicts["counted"]) == ["any", "degree 8, Gauss 9"] * 2
    assert list(verdicts["against"]) == [PEER, PEER, kernel, kernel]
    assert Target("p", WITHOUT_FRAME, 1e-6, 5.0).against == "galvi without frame, best"


def test_a_warning_about_the_peer_s_own_error_is_told() -> None:
    runs = table(GALVI_POINTS | {PEER: [(1e-7, 3.0)]})
    runs.loc[runs["contender"] == PEER, "status"] = "Take it as a bound."
    at_own_error, at_fixed_error = (Target("p", (PEER,), error, None) for error in (None, 1e-6))
    assert list(targets_met(runs, [at_own_error, at_fixed_error])["remark"]) == [
        "Take it as a bound.",
        "",
    ]


def test_another_problem_s_rows_do_not_count() -> None:
    runs = table(GALVI_POINTS | {PEER: [(1e-9, 100.0)]}, problem="q")
    assert list(targets_met(runs, [Target("p", (PEER,), 1e-6, 4.0)])["verdict"]) == [NOT_RUN]
    assert targets_met(runs, ()).empty


@pytest.fixture(scope="module")
def cases() -> tuple[WorkPrecisionProblem, ...]:
    return work_precision_problems(False)


@pytest.mark.parametrize("quick", [True, False])
def test_every_target_names_contenders_that_take_part(quick: bool, cases) -> None:
    participants = {
        case.problem.name: {label for label, _, _ in case.participants}
        for case in (work_precision_problems(True) if quick else cases)
    }
    for target in TARGETS:
        assert {*target.contenders, *target.galvi_contenders} <= participants[target.problem]
        assert target.ratio is None or target.ratio > 0.0
        assert (target.note != "") == ("general kernel" in target.contenders[0])
    keys = [
        (target.problem, target.contenders[0], target.galvi_contenders, target.error)
        for target in TARGETS
    ]
    assert len(set(keys)) == len(keys)
    for target in TARGETS:  # targets of orbits and rotations have the rival's own error too
        assert target.source == VECTOR_SOURCE or target.problem in {
            entry.problem for entry in TARGETS if entry.error is None
        }
    assert {target.source for target in TARGETS} == {
        FRAME_SOURCE,
        NBODY_SOURCE,
        RIGID_BODY_SOURCE,
        VECTOR_SOURCE,
    }
    assert "N bodies" in NBODY_SOURCE and "rigid bodies" in RIGID_BODY_SOURCE


def test_readers_are_told_what_every_problem_is(cases) -> None:
    assert [case.problem.name for case in cases] == list(LABELS)
    for case in cases:
        year = (
            1.0 if "Applegate" in case.problem.name else 365.25
        )  # Applegate's unit is a year of 365 days, that of others a day
        year = math.tau if "2 pi" in case.problem.units else year
        units = {"units of time": 1.0, "s": 1.0, "periods": math.tau, "years": year}
        units["revolutions"] = math.tau
        label = label_of(case.problem.name)
        ((length, unit),) = re.findall(
            r"over ([\d,.]+) (units of time|s|periods|revolutions|years)", label.text
        )
        assert float(length.replace(",", "")) * units[unit] == pytest.approx(
            case.duration, rel=1e-3
        )
        assert label.text.endswith(".")
        assert (label.time == "") == (case.problem.units.split(",")[0] not in ("au", "m", "kg"))
    assert len({label.title for label in LABELS.values()}) == len(LABELS)
    assert label_of("my own") == ("My own", "", "")
