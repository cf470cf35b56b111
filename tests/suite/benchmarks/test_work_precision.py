"""A small work-precision study, times without a clock, and what the cost table counts."""

from __future__ import annotations

import math
import statistics
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pandas as pd
import pytest

import galvi
from benchmarks.statistics import timing
from benchmarks.statistics.paired import read
from benchmarks.statistics.repeated_run import NetTime, net_time, repeated_run
from benchmarks.work_precision import run as work_precision
from benchmarks.work_precision.cost import COLUMNS, cost_table
from benchmarks.work_precision.galvi_methods import gauss_collocation
from benchmarks.work_precision.participants import readable_setting
from benchmarks.work_precision.problem import Participant, Truth, WorkPrecisionProblem
from benchmarks.work_precision.problems.pendulums import henon_heiles
from benchmarks.work_precision.problems.planets import kepler, solar_system
from benchmarks.work_precision.problems.rigid_bodies import free_body
from galvi import Problem, Trajectory

GALVI, IAS15 = "galvi degree 8, Gauss 8", "REBOUND IAS15"
FEW_LABELS = (GALVI, "Stormer-Verlet", "SciPy DOP853", IAS15)


def with_participants(
    case: WorkPrecisionProblem, *labels: str, **changes: Any
) -> WorkPrecisionProblem:
    participants = tuple(
        participant for participant in case.participants if participant.label in labels
    )
    return replace(case, participants=participants, **changes)


def study(case: WorkPrecisionProblem) -> pd.DataFrame:
    return work_precision.work_precision(quick=True, cases=[case])


def test_every_row_has_error_time_with_interval_status_and_truth() -> None:
    case = with_participants(kepler(2, quick=True), *FEW_LABELS)
    rows = study(case)
    assert tuple(rows.columns) == work_precision.COLUMNS
    assert set(rows["rounds"].map(read).map(len)) == {work_precision.ROUNDS}
    assert list(rows["seconds"]) == pytest.approx(
        [statistics.median(read(rounds)) for rounds in rows["rounds"]], rel=1e-4
    )
    assert ((rows["again"] != "") == rows["contender"].str.startswith("galvi")).all()
    assert set(rows["contender"]) == set(FEW_LABELS) and rows["error"].notna().all()
    assert rows["seconds"].between(rows["seconds_low"], rows["seconds_high"]).all()
    assert set(rows["reference"]) == {"Kepler, closed form"}
    assert set(rows["truth_error"]) == {case.truth().error}
    assert rows["settings"].str.len().min() > 0
    galvi_rows = rows[rows["contender"] == GALVI]
    assert (
        galvi_rows["error"].min() < 1e-9 and (galvi_rows["evaluations"] > galvi_rows["steps"]).all()
    )


def test_the_truth_is_not_judged_by_itself() -> None:
    case = with_participants(kepler(2, quick=True), IAS15)
    source = (IAS15, readable_setting(case.participants[0].settings[-1]))
    truth = Truth(case.truth().end, 0.0, IAS15, source)
    rows = study(replace(case, truth=lambda: truth, notes={IAS15: "A note."}))
    *compared, last = rows.to_dict("records")
    assert last["is_truth"] and math.isnan(last["error"]) and last["status"] == "A note."
    assert compared and all(row["error"] > 0.0 and not row["is_truth"] for row in compared)
    assert rows["seconds"].notna().all()


def test_without_the_engine_of_the_truth_every_row_says_why() -> None:
    def absent() -> Truth:
        raise ModuleNotFoundError("Install the engine.")

    rows = study(with_participants(kepler(2, quick=True), *FEW_LABELS, truth=absent))
    assert len(rows) and (rows["status"] == "Install the engine.").all()
    assert rows["error"].isna().all()


def test_a_tolerance_and_a_number_of_passes_stop_an_iteration_early() -> None:
    converged, cut = (gauss_collocation(4, galvi.KeplerFrame(passes=n)) for n in (None, 2))
    assert cut.stops_early({}) and gauss_collocation(4).stops_early({"tolerance": 1e-9})
    assert not converged.stops_early({}) and not gauss_collocation(4).stops_early({"step": 1.0})


def test_point_masses_have_an_error_of_energy_beside_that_of_position() -> None:
    rows = study(with_participants(solar_system(quick=True), "galvi degree 12, Gauss 12"))
    assert rows["error"].min() < 1e-10 and rows["energy"].min() < 1e-13  # 3e-12


# ---- times


@dataclass(frozen=True)
class Counted:
    """Records the durations and settings of its runs; fails from the duration `until` on."""

    requests: list[tuple[float, Any]]
    until: float = np.inf
    missing: str = ""

    def run(self, problem: Problem, duration: float, setting: Any) -> Trajectory:
        self.requests.append((duration, dict(setting)))
        run = gauss_collocation(4).run(problem, 1.0, {"step": 0.5})
        return run if duration < self.until else replace(run, success=False, status="It broke.")


def test_a_run_is_made_longer_by_a_whole_number_and_keeps_its_last_state() -> None:
    problem, recorder = galvi.problems.free_rigid_body(), Counted([])
    repeated = repeated_run(recorder, problem, 2.0, {"step": 0.5, "save_every": 4}, 1e-3, 0.01)
    assert recorder.requests[0] == (20.0, {"step": 0.5, "save_every": 40})
    assert repeated.times >= 10 and repeated.failure == "" and repeated.seconds > 0.0
    repeated.call()
    assert recorder.requests[-1] == (
        2.0 * repeated.times,
        {"step": 0.5, "save_every": 4 * repeated.times},
    )
    slow = repeated_run(recorder, problem, 2.0, {"samples": 1}, 5.0, 0.01)
    assert recorder.requests[-1][1] == {"samples": 1} and slow.times >= 1


def test_the_short_run_of_a_net_time_is_one_step() -> None:
    recorder, problem = Counted([]), galvi.problems.harmonic_oscillator()
    net = net_time(recorder, problem, 2.0, {"step": 0.5, "save_every": 4}, 4)
    assert recorder.requests == [(0.5, {"step": 0.5, "save_every": 1})]
    net()
    assert recorder.requests[-1] == (2.0, {"step": 0.5, "save_every": 4}) and net.failure == ""
    net_time(recorder, problem, 2.0, {"samples": 1, "tolerance": 1e-9}, 4)
    assert recorder.requests[-1] == (2e-6, {"samples": 1, "tolerance": 1e-9})


def test_a_setting_that_fails_later_has_its_error_and_no_time() -> None:
    case = free_body(True)
    fails = Counted([], until=case.duration + 1.0)
    participant = Participant(GALVI, fails, [{"step": 0.5, "save_every": 40}])
    start = Truth(np.eye(3), 0.0, "the start")
    (row,) = study(replace(case, participants=(participant,), truth=lambda: start)).to_dict(
        "records"
    )
    assert np.isfinite(row["error"]) and np.isnan(row["seconds"])
    assert row["status"] == "Not timed, it fails later: It broke."


@dataclass
class Taking:
    """A call in another process, which takes these times."""

    times: list[float]

    def __call__(self) -> Any: ...

    def seconds(self, repeats: int) -> float:
        return self.times.pop(0)


def test_a_net_time_is_of_the_steps_alone() -> None:
    disturbed = Taking([4.5e-3, 4e-3, 5e-3, 4.5e-3, 4.5e-3])
    assert NetTime(disturbed, Taking([1e-3] * 5), steps=4).seconds(1) == pytest.approx(4e-3)
    assert math.isnan(NetTime(Taking([1e-3] * 6), Taking([4e-3] * 6), steps=4).seconds(6))
    seconds = NetTime(Taking([3.0]), Taking([1e-3]), steps=4).seconds(6)
    assert seconds == pytest.approx(2.999 * 4 / 3)


def test_a_setting_without_a_net_time_says_so() -> None:
    case = replace(henon_heiles(True), repeated_run=False, net_time=True)
    participant = case.participants[0]
    measured = work_precision._first_run(
        case, participant.label, participant.contender, participant.settings[0], 0.001
    )
    measured.rounds = [1e-4, math.nan]
    row = work_precision._row(case, measured, case.truth())
    assert math.isnan(row["seconds"]) and row["rounds"] == ""
    assert row["error"] < 1.0 and row["status"].startswith("Not timed: its steps took no longer")


@pytest.fixture
def called(monkeypatch: pytest.MonkeyPatch) -> Any:
    """(a function that makes calls of given seconds, names of the calls made, in order). The last
    time is repeated; with `slower` each call takes longer than the one before."""
    clock_time, order = [0.0], []
    monkeypatch.setattr(timing.time, "perf_counter", lambda: clock_time[0])

    def call(name: str, *seconds: float, slower: float = 0.0) -> Any:
        times = iter(seconds)

        def run_once() -> None:
            order.append(name)
            clock_time[0] += next(times, seconds[-1]) * (1.0 + slower * len(order))

        return run_once

    return call, order


def test_calls_take_turns_and_short_ones_are_repeated(
    called: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    call, order = called
    monkeypatch.setattr(timing, "LONG_SECONDS", 1.0)
    first, second = timing.interleaved(
        [call("A", 1.0, 5.0, 3.0), call("B", 0.5)], 3, 1.0, warm=[1.0, 0.5]
    )
    assert "".join(order) == "ABBABBABB"
    assert (first.low, first.seconds, first.high) == (1.0, 3.0, 5.0)
    assert second.seconds == pytest.approx(0.5)
    order.clear()
    long, middle, short = timing.interleaved(
        [call("A", 2.0, 4.0), call("B", 1.0, 0.5), call("C", 0.5)],
        3,
        1.0,
        warm=[9.0, 0.9, 0.5],
        counted=[False, True, True],
    )
    assert "".join(order) == "ABCCABCCCC"  # two rounds of A; B's warm call is its first
    assert (long.low, long.seconds, long.high) == (2.0, 3.0, 4.0)
    assert (middle.low, middle.seconds, middle.high) == (0.5, 0.9, 1.0)
    assert (short.low, short.high) == (0.5, 0.5)


def test_all_calls_take_turns_in_the_same_rounds_and_long_ones_in_the_first_of_them(
    called: Any,
) -> None:
    call, order = called
    seconds = {"A": 0.1, "B": 2.0 * timing.EVERY_ROUND_SECONDS, "C": 0.1}
    calls = [call(name, duration, slower=0.1) for name, duration in seconds.items()]
    rounds = timing.seconds_in_turn(calls, 4, 0.1)
    assert "".join(order) == "ABC" + "CBA" + "AC" + "CA"
    assert [len(samples) for samples in rounds] == [4, timing.LONG_ROUNDS, 4]
    order.clear()
    (short,) = timing.seconds_in_turn([call("A", 0.01, slower=0.1)], 2, 0.06)
    assert len(order) == 1 + 2 * timing.ROUND_PARTS * 2 and len(short) == 2


# ---- what a step costs


@pytest.mark.slow(beside="test_the_cost_of_some_problems_alone_has_their_rows")
def test_the_cost_table_counts_each_solver() -> None:
    table = cost_table(quick=True)
    assert tuple(table.columns) == tuple(column.name for column in COLUMNS)
    assert (table["status"] == "").all() and (table["seconds_per_step"] > 0.0).all()
    assert set(table["solver"]) >= {"fixed point"}
    oscillator = table[table["problem"] == "harmonic oscillator"]
    assert oscillator["solver"].str.contains("Newton").all()
    assert (table["forces_per_step"] >= table["iterations_per_step"]).all()
    assert not math.isnan(float(table["order"].sum()))


def test_the_cost_of_some_problems_alone_has_their_rows() -> None:
    table = cost_table(quick=True, only=("free rigid body", "elastic pendulum"))
    assert list(table["problem"]) == ["elastic pendulum", "free rigid body", "free rigid body"]
    assert list(table["method"])[1:] != [] and table["seconds_per_step"].gt(0.0).all()
    assert (table["status"] == "").all()
