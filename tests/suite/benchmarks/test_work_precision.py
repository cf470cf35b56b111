"""A small work-precision study, a stopwatch without a clock, and what the cost table counts."""

from __future__ import annotations

import math
import statistics
from dataclasses import replace
from typing import Any

import pandas as pd
import pytest

import galvi
from benchmarks.statistics import timing
from benchmarks.statistics.paired import read
from benchmarks.work_precision import run as work_precision
from benchmarks.work_precision.cost import COLUMNS, cost_table
from benchmarks.work_precision.galvi_methods import InClock, gauss_collocation
from benchmarks.work_precision.participants import readable_setting
from benchmarks.work_precision.problem import Truth, WorkPrecisionProblem
from benchmarks.work_precision.problems import work_precision_problems
from benchmarks.work_precision.problems.arms import skew_arm
from benchmarks.work_precision.problems.encounters import MET, clock_label
from benchmarks.work_precision.problems.planets import (
    applegate,
    kepler,
    outer_solar_system,
    solar_system,
)
from reports.figures.drawing import UNITS

FEW = ("galvi degree 8, Gauss 8", "Stormer-Verlet", "SciPy DOP853", "REBOUND IAS15")


def small() -> WorkPrecisionProblem:
    case = kepler(2, quick=True)
    return replace(case, participants=tuple(one for one in case.participants if one.label in FEW))


@pytest.fixture
def study(monkeypatch: pytest.MonkeyPatch) -> pd.DataFrame:
    monkeypatch.setattr(work_precision, "work_precision_problems", lambda quick: (small(),))
    return work_precision.work_precision(quick=True)


def test_of_a_contender_that_is_the_truth_only_the_run_that_it_is_is_not_compared() -> None:
    pytest.importorskip("mujoco")
    case = skew_arm(quick=False)
    source = case.truth().source
    labels = [(one.label, readable_setting(setting))
              for one in case.participants for setting in one.settings]  # fmt: skip
    assert labels.count(source) == 1 and [label for label, _ in labels].count(source[0]) > 2


def test_every_row_has_error_time_with_interval_status_and_truth(study: pd.DataFrame) -> None:
    assert tuple(study.columns) == work_precision.COLUMNS
    assert set(study["rounds"].map(read).map(len)) == {work_precision.ROUNDS}
    assert list(study["seconds"]) == pytest.approx(
        [statistics.median(read(rounds)) for rounds in study["rounds"]], rel=1e-4
    )
    assert ((study["again"] != "") == study["contender"].str.startswith("galvi")).all()
    assert set(study["contender"]) == set(FEW)
    done = study[study["error"].notna()]
    assert len(done) == len(study)
    assert (done["seconds_low"] <= done["seconds"]).all()
    assert (done["seconds"] <= done["seconds_high"]).all()
    assert set(study["reference"]) == {"Kepler, closed form"}
    assert set(study["truth_error"]) == {small().truth().error}
    assert study["settings"].str.len().min() > 0
    ours = study[study["contender"] == FEW[0]]
    assert ours["error"].min() < 1e-9 and (ours["evaluations"] > ours["steps"]).all()


def test_the_truth_is_not_judged_by_itself(monkeypatch: pytest.MonkeyPatch) -> None:
    case = small()
    end = case.truth().end
    (settings,) = (one.settings for one in case.participants if one.label == "REBOUND IAS15")
    source = ("REBOUND IAS15", readable_setting(settings[-1]))
    truth = Truth(end, 0.0, "REBOUND IAS15", source)
    monkeypatch.setattr(
        work_precision,
        "work_precision_problems",
        lambda quick: (replace(case, truth=lambda: truth, notes={"REBOUND IAS15": "A note."}),),
    )
    rows = work_precision.work_precision(quick=True)
    own = rows[rows["contender"] == "REBOUND IAS15"]
    *others, last = own.to_dict("records")
    assert last["is_truth"] and math.isnan(last["error"]) and last["status"] == "A note."
    assert others and all(one["error"] > 0.0 and not one["is_truth"] for one in others)
    assert own["seconds"].notna().all()


def test_without_the_engine_of_the_truth_every_row_says_why(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def absent() -> Truth:
        raise ModuleNotFoundError("Install the engine.")

    monkeypatch.setattr(
        work_precision, "work_precision_problems", lambda quick: (replace(small(), truth=absent),)
    )
    rows = work_precision.work_precision(quick=True)
    assert len(rows) and (rows["status"] == "Install the engine.").all()
    assert rows["error"].isna().all()


@pytest.mark.parametrize("quick", [True, False])
def test_the_arenas_name_each_contender_once_and_use_whole_steps(quick: bool) -> None:
    for case in work_precision_problems(quick):
        labels = [label for label, _, _ in case.participants]
        assert len(set(labels)) == len(labels)
        for _, contender, settings in case.participants:
            assert settings and contender.supports(case.problem)
            for setting in settings:
                if "step" in setting and not isinstance(contender, InClock):
                    assert (case.duration / setting["step"]) == pytest.approx(
                        setting["save_every"], rel=1e-12
                    )


def test_a_tolerance_and_a_number_of_passes_stop_an_iteration_early() -> None:
    whole, cut = (gauss_collocation(4, galvi.KeplerFrame(passes=n)) for n in (None, 2))
    assert cut.stops_early({}) and gauss_collocation(4).stops_early({"tolerance": 1e-9})
    assert not whole.stops_early({}) and not gauss_collocation(4).stops_early({"step": 1.0})


@pytest.mark.parametrize("make", [outer_solar_system, solar_system, applegate])
def test_planets_meet_every_peer_at_its_default_and_its_best(make: Any) -> None:
    case = make(quick=True)
    participants = {label: settings for label, _, settings in case.participants}
    assert {f"galvi degree {s}, Gauss {s}" for s in (8, 12, 16)} <= set(participants)
    assert participants["REBOUND IAS15"][0]["adaptive_mode"] == "PRS23"
    assert participants["REBOUND IAS15, GLOBAL"][0]["adaptive_mode"] == "GLOBAL"
    assert all(one["safe_mode"] == 0 for one in participants["REBOUND WHFast, best"])
    assert all(one["safe_mode"] == 1 for one in participants["REBOUND WHFast, default"])
    assert {"REBOUND SABA", "heyoka"} <= set(participants)
    assert ("SciPy DOP853" in participants) == (make is not applegate)
    assert ("REBOUND WHFast512" in participants) == (make is solar_system)


def test_applegate_s_planets_meet_the_contenders_of_the_outer_planets_but_for_the_slowest() -> None:
    ours, theirs = (
        {label: settings for label, _, settings in make(False).participants}
        for make in (applegate, outer_solar_system)
    )
    assert set(theirs) - set(ours) == {
        "SciPy DOP853", *(f"galvi Kepler frame, Gauss {s}, 2 passes" for s in (8, 16))
    }  # fmt: skip
    assert set(ours) <= set(theirs)
    assert all(len(ours[label]) <= len(theirs[label]) for label in ours)
    assert ours["heyoka"] == theirs["heyoka"][: len(ours["heyoka"])]
    assert {one["tolerance"] for one in ours["heyoka"]} == {2.0**-52, 1e-18}
    steps = {make: make(False).duration / make(False).participants[0][2][0]["step"]
             for make in (applegate, outer_solar_system)}  # fmt: skip
    assert steps[applegate] == pytest.approx(steps[outer_solar_system], rel=1e-3)  # a day: 7e-4


def test_the_quick_report_leaves_applegate_out_and_most_encounters() -> None:
    names = [
        [case.problem.name for case in work_precision_problems(quick)] for quick in (True, False)
    ]
    met = {make(False).problem.name for make in MET}
    left = set(names[1]) - set(names[0])
    assert left - met == {"outer solar system after Applegate"}
    assert met - left == {"Burrau's problem", "two bodies, e = 0.99"}
    assert set(names[0]) < set(names[1])


def test_encounters_meet_galvi_in_a_clock_and_the_codes_made_for_them() -> None:
    for make in MET:
        case = make(False)
        participants = {label: settings for label, _, settings in case.participants}
        assert {clock_label(s) for s in (8, 12, 16)} <= set(participants)
        assert {"REBOUND IAS15", "REBOUND BS", "heyoka", "SciPy DOP853"} <= set(participants)
        dominant = case.problem.name == "HD 80606 and a companion"
        assert ("REBOUND TRACE" in participants) == dominant
        assert case.truth().error < 1e-10


@pytest.mark.parametrize("quick", [True, False])
def test_the_truth_of_the_planets_is_better_than_any_contender_and_none_of_galvi_s(
    quick: bool,
) -> None:
    for make in (outer_solar_system, solar_system, applegate):
        truth = make(quick).truth()
        assert "quadruple" in truth.description or "real128" in truth.description
        assert truth.error < 1e-11 and truth.source is None


def test_planets_are_timed_against_the_stored_truth(monkeypatch: pytest.MonkeyPatch) -> None:
    few = ("galvi degree 12, Gauss 12", "REBOUND IAS15", "REBOUND WHFast, default")
    case = solar_system(quick=True)
    case = replace(case, participants=tuple(one for one in case.participants if one.label in few))
    monkeypatch.setattr(work_precision, "work_precision_problems", lambda quick: (case,))
    best = work_precision.work_precision(quick=True).groupby("contender")["error"].min()
    assert best[few[0]] < 1e-10  # 3e-12 when this was written
    if few[1] in best.dropna():
        assert best[few[1]] < 1e-10 < best[few[2]]


def test_calls_take_turns_and_short_ones_are_repeated(monkeypatch: pytest.MonkeyPatch) -> None:
    clock = {"now": 0.0}
    order: list[str] = []
    monkeypatch.setattr(timing.time, "perf_counter", lambda: clock["now"])
    monkeypatch.setattr(timing, "LONG", 1.0)

    def call(name: str, seconds: list[float]) -> Any:
        times = iter(seconds)

        def made() -> None:
            order.append(name)
            clock["now"] += next(times)

        return made

    timings = timing.interleaved(
        [call("A", [1.0, 5.0, 3.0]), call("B", [0.5] * 6)], 3, 1.0, warm=[1.0, 0.5]
    )
    assert "".join(order) == "ABBABBABB"
    assert (timings[0].low, timings[0].seconds, timings[0].high) == (1.0, 3.0, 5.0)
    assert timings[1].seconds == pytest.approx(0.5)
    order.clear()
    calls = [call("A", [2.0, 4.0]), call("B", [1.0, 0.5]), call("C", [0.5] * 6)]
    long, known, short = timing.interleaved(
        calls, 3, 1.0, warm=[9.0, 0.9, 0.5], counted=[False, True, True]
    )
    assert "".join(order) == "ABCCABCCCC"  # two rounds of A; B's warm call is its first
    assert (long.low, long.seconds, long.high) == (2.0, 3.0, 4.0)
    assert (known.low, known.seconds, known.high) == (0.5, 0.9, 1.0)
    assert (short.low, short.high) == (0.5, 0.5)


def test_all_calls_take_turns_in_the_same_rounds_and_long_ones_in_the_first_of_them(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    clock = {"now": 0.0}
    order: list[str] = []
    monkeypatch.setattr(timing.time, "perf_counter", lambda: clock["now"])

    def call(name: str, seconds: float) -> Any:
        def made() -> None:
            order.append(name)
            clock["now"] += seconds * (1.0 + 0.1 * len(order))  # on a machine that slows down

        return made

    long = 2.0 * timing.LONGEST
    found = timing.seconds_in_turn([call("A", 0.1), call("B", long), call("C", 0.1)], 4, 0.1)
    assert "".join(order) == "ABC" + "CBA" + "AC" + "CA"
    assert [len(samples) for samples in found] == [4, timing.ENOUGH, 4]
    order.clear()
    (short,) = timing.seconds_in_turn([call("A", 0.01)], 2, 0.06)
    assert len(order) == 1 + 2 * timing.PARTS * 2 and len(short) == 2


@pytest.mark.slow(
    beside="test_coordinate_problems.py::test_the_cost_of_some_problems_alone_has_their_rows"
)
def test_the_cost_table_counts_each_solver() -> None:
    table = cost_table(quick=True)
    assert tuple(table.columns) == tuple(column.name for column in COLUMNS)
    assert (table["status"] == "").all() and (table["seconds_per_step"] > 0.0).all()
    assert set(table["solver"]) >= {"fixed point"}
    oscillator = table[table["problem"] == "harmonic oscillator"]
    assert oscillator["solver"].str.contains("Newton").all()
    assert (table["forces_per_step"] >= table["iterations_per_step"]).all()
    assert not math.isnan(float(table["order"].sum()))


def test_every_quantity_has_a_figure() -> None:
    quantities = {case.quantity for case in work_precision_problems(False)}
    assert quantities <= set(UNITS)
