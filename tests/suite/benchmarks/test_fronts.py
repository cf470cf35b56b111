"""Fronts keep what no other setting beats; ratios compare at matched error."""

from __future__ import annotations

import math
import statistics
from typing import Any

import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st

from benchmarks.statistics.paired import FASTER, SLOWER, written
from benchmarks.work_precision.dependable import bounds, dependable, resolution
from benchmarks.work_precision.fronts import (
    NOT_REACHED,
    OURS,
    at_smallest,
    front,
    ratios,
    seconds_at,
    unfounded,
)


def table(points: dict[str, list[tuple[float, float]]]) -> pd.DataFrame:
    rows: list[dict[str, Any]] = [
        {"problem": "p", "contender": name, "settings": f"step={k}", "error": error,
         "seconds": seconds, "is_truth": False, "status": ""}
        for name, some in points.items()
        for k, (error, seconds) in enumerate(some)
    ]  # fmt: skip
    return pd.DataFrame(rows)


POSITIVE = st.floats(1e-15, 1e3)


@given(st.lists(st.tuples(POSITIVE, POSITIVE), min_size=1, max_size=20))
def test_nothing_beats_a_point_of_the_front_and_something_beats_every_other(
    points: list[tuple[float, float]],
) -> None:
    kept = front(table({"a": points}))
    ends = set(zip(kept["error"], kept["seconds"], strict=True))
    assert kept["error"].is_monotonic_decreasing and kept["seconds"].is_monotonic_increasing
    for point in points:
        beaten = any(e <= point[0] and s <= point[1] for e, s in ends)
        assert beaten
    for end in ends:
        assert not any((e < end[0] and s <= end[1]) or (e <= end[0] and s < end[1])
                       for e, s in points)  # fmt: skip


def test_a_time_is_that_of_a_run_that_reaches_the_error() -> None:
    assert seconds_at([1e-2, 1e-6], [1.0, 4.0], 1e-4) == 4.0
    assert seconds_at([1e-2, 1e-6], [1.0, 4.0], 1.0) == 1.0
    assert seconds_at([1e-2, 1e-6], [1.0, 4.0], 1e-6) == 4.0
    assert math.isnan(seconds_at([1e-2, 1e-6], [1.0, 4.0], 1e-7))
    assert math.isnan(seconds_at([], [], 1e-7))


def test_ratios_are_taken_to_the_fastest_method_of_galvi() -> None:
    points = {
        "galvi low": [(1e-2, 1.0), (1e-4, 8.0)],
        "galvi high": [(1e-2, 3.0), (1e-8, 5.0)],
        "peer": [(1e-2, 10.0), (1e-6, 40.0)],
    }
    found = ratios(table(points), [1e-2, 1e-8]).set_index(["contender", "error"])
    assert found.loc[("peer", 1e-2), "ratio"] == pytest.approx(10.0)
    assert found.loc[(OURS, 1e-8), "seconds"] == pytest.approx(5.0)
    assert found.loc[("peer", 1e-8), "ratio"] == NOT_REACHED
    assert found.loc[("galvi low", 1e-8), "ratio"] == NOT_REACHED


def test_where_only_a_peer_gets_there_the_table_says_so() -> None:
    found = ratios(table({"galvi": [(1e-2, 1.0)], "peer": [(1e-9, 2.0)]}), [1e-6])
    said = found.set_index("contender")["ratio"]
    assert said["galvi"] == NOT_REACHED
    assert said["peer"] == f"galvi: {NOT_REACHED}"


def test_each_contender_is_asked_for_the_smallest_error_that_it_reaches() -> None:
    points = {
        "galvi low": [(1e-2, 1.0), (1e-4, 8.0)],
        "galvi high": [(1e-2, 3.0), (1e-8, 5.0)],
        "near": [(1e-2, 10.0), (1e-6, 40.0), (1e-5, 80.0)],
        "far": [(1e-9, 50.0)],
        "failed": [(math.nan, 1.0)],
    }
    found = at_smallest(table(points)).set_index("contender")
    assert found["error"].to_dict() == {
        OURS: 1e-8, "galvi low": 1e-4, "galvi high": 1e-8, "near": 1e-6, "far": 1e-9,
    }  # fmt: skip
    assert found.loc["near", "ratio"] == pytest.approx(40.0 / 5.0)
    assert found.loc["far", "ratio"] == f"galvi: {NOT_REACHED}"
    assert found.loc[OURS, "seconds"] == pytest.approx(5.0)
    assert at_smallest(table({"galvi": [(math.nan, 1.0)]})).empty


def test_one_lucky_end_does_not_count_and_growing_round_off_is_not_held_against_coarser_steps():
    errors = {8.0: 1e-4, 4.0: 1e-13, 2.0: 1e-9, 1.0: 2e-13, 0.5: 1e-13, 0.25: 3e-13}
    rows = table({"a": [(error, 1.0 / step) for step, error in errors.items()]})
    rows["settings"] = [f"kernel=LAZY step={step:g}" for step in errors]
    rows.loc[6] = dict(rows.loc[5]) | {"settings": "kernel=OTHER step=0.1", "error": 1.0}
    found = dependable(rows)
    assert list(found["error"]) == [1e-4, 1e-9, 1e-9, 2e-13, 3e-13, 3e-13, 1.0]
    assert list(dependable(rows.sample(frac=1, random_state=1)).sort_index()["error"]) == list(
        found["error"]
    )
    failed = dependable(rows.assign(error=rows["error"].mask(rows["settings"].str.contains("=2$"))))
    assert failed.loc[1, "error"] == 2e-13 and math.isnan(failed.loc[2, "error"])


def test_no_run_counts_as_better_than_what_the_truth_can_tell():
    rows = table({"galvi": [(1e-9, 1.0), (1e-11, 2.0)], "peer": [(2e-10, 1.0), (5e-10, 1.0)]})
    rows["settings"] = ["step=2", "step=1", "tolerance=1e-9", "tolerance=1e-6"]
    assert resolution(rows) == 0.0
    for some in (rows, rows[:2]):  # whoever took part
        told = some.assign(truth_error=[3e-11] * len(some))
        assert resolution(told) == resolution(dependable(told)) == 10.0 * 3e-11
        assert list(dependable(told)["error"]) == [1e-9, 3e-10, 3e-10, 5e-10][: len(some)]
        assert list(bounds(dependable(told), told)) == [False, True, True, False][: len(some)]
        counted = dependable(told)
        assert list(counted["error_is_bound"]) == [False, True, True, False][: len(some)]
        assert list(counted["own_error"]) == list(told["error"])
        assert dependable(counted).equals(counted)


def test_a_run_that_failed_has_no_place_and_the_truth_stands_beside_the_front() -> None:
    rows = table({"galvi": [(1e-2, 1.0), (math.nan, 0.1)], "truth": [(math.nan, 7.0)]})
    rows["is_truth"] = rows["contender"] == "truth"
    assert len(front(rows)) == 1
    found = ratios(rows, [1e-1]).set_index("contender")
    assert found.loc["truth", "ratio"] == pytest.approx(7.0)
    rows.loc[len(rows)] = dict(rows.loc[0]) | {
        "is_truth": False,
        "contender": "truth",
        "error": 1e-3,
        "seconds": 2.0,
    }
    own = ratios(rows, [1e-1, 1e-4]).set_index(["contender", "error"])["seconds"]
    assert own["truth", 1e-1] == 2.0 and own["truth", 1e-4] == 7.0


TIME = st.floats(1e-4, 1e2)
ROUNDS = st.sampled_from([0, 2, 7]).flatmap(lambda n: st.lists(TIME, min_size=n, max_size=n))
RUN = st.tuples(st.sampled_from(["galvi a", "galvi b", "peer"]), st.floats(1e-9, 1.0), TIME, ROUNDS)


@given(st.lists(RUN, min_size=1, max_size=12))
def test_no_row_of_galvi_is_below_its_best_and_no_time_falls_with_the_error(
    runs: list[tuple[str, float, float, list[float]]],
) -> None:
    """Whatever the rounds of a busy machine: a setting has one time, by which it is chosen too."""
    rows = pd.DataFrame(
        [
            {"problem": "p", "contender": name, "settings": f"step={k}", "error": error,
             "seconds": seconds, "rounds": written(rounds), "is_truth": False}
            for k, (name, error, seconds, rounds) in enumerate(runs)
        ]
    )  # fmt: skip
    asked = (1e-2, 1e-4, 1e-6)
    cells = ratios(rows, asked)
    for error in asked:
        here = cells[cells["error"] == error].set_index("contender")["seconds"]
        mine = here[here.index.str.startswith("galvi ")].min()
        assert here[OURS] == mine or (math.isnan(mine) and math.isnan(here[OURS]))
    for _, line in cells.groupby("contender"):
        assert line["seconds"].dropna().is_monotonic_increasing
    assert cells["seconds"].dropna().isin(rows["seconds"]).all()


def in_rounds(
    ours: list[float], theirs: list[float], again: list[float] | None = None
) -> pd.DataFrame:
    rows = table({"galvi": [(1e-6, 1.0)], "peer": [(1e-6, 1.5)]})
    rows["seconds"] = [statistics.median(ours), statistics.median(theirs or [1.5])]
    rows["rounds"] = [written(ours), written(theirs)]
    rows["again"] = [written(again or ours), ""]
    return rows


def test_a_ratio_is_of_the_times_of_the_same_rounds() -> None:
    load = [1.0, 3.0, 1.0, 2.0, 1.0, 5.0, 1.0]
    found = ratios(in_rounds(load, [2.0 * one for one in load]), [1e-6]).set_index("contender")
    peer = found.loc["peer"]
    assert (peer["low"], peer["ratio"], peer["high"], peer["outcome"]) == (2, 2, 2, FASTER)
    assert found.loc[OURS, "seconds"] == 1.0 and peer["seconds"] == 2.0
    slower = ratios(in_rounds(load, [0.5 * one for one in load]), [1e-6]).set_index("contender")
    assert slower.loc["peer", "outcome"] == SLOWER and slower.loc["galvi", "outcome"] == ""


def test_without_rounds_in_common_there_is_a_ratio_but_no_outcome() -> None:
    rows = in_rounds([1.0] * 7, [])
    peer = ratios(rows, [1e-6]).set_index("contender").loc["peer"]
    assert peer["ratio"] == 1.5 and math.isnan(peer["low"]) and peer["outcome"] == ""


def test_a_long_run_is_compared_in_the_rounds_in_which_it_took_part() -> None:
    rows = in_rounds([1.0, 2.0, 9.0, 9.0, 9.0, 9.0, 9.0], [30.0, 60.0])
    peer = ratios(rows, [1e-6]).set_index("contender").loc["peer"]
    assert peer["ratio"] == 30.0 and math.isnan(peer["low"]) and peer["outcome"] == ""


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
    others = [("galvi", 1e-2), (OURS, 1e-2), ("near", 1e-2), ("near", 1e-4), ("tight", 1e-6)]
    assert cells[others].isna().all()


def test_a_winner_that_was_never_run_is_told() -> None:
    rows = table({"galvi": [(1e-2, 1.0), (1e-6, 3.0)], "peer": [(1e-2, 2.0), (1e-8, 9.0)]})
    cells = ratios(rows, [1e-2, 1e-4, 1e-8])
    assert unfounded(cells, rows) == []
    for planted in (
        {"settings": "step=0.5"},  # between two that were run
        {"settings": "step=0", "error": 1e-4},  # run, but above the error
    ):
        row = {**cells[cells["contender"] == "peer"].iloc[0], **planted}
        (said,) = unfounded(pd.concat([cells, pd.DataFrame([row])], ignore_index=True), rows)
        assert "peer" in said and row["settings"] in said
