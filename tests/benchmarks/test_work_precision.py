"""A small work-precision study, a stopwatch without a clock, and what the cost table counts."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import pandas as pd
import pytest

from benchmarks import stopwatch, work_precision
from benchmarks.arena import Arena, Truth, arenas, kepler
from benchmarks.cost import COLUMNS as COST
from benchmarks.cost import cost_table

FEW = ("galvi degree 8, Gauss 8", "Stormer-Verlet", "SciPy DOP853", "REBOUND IAS15")


def small() -> Arena:
    arena = kepler(2, quick=True)
    return replace(arena, entries=tuple(e for e in arena.entries if e[0] in FEW))


@pytest.fixture
def study(monkeypatch: pytest.MonkeyPatch) -> pd.DataFrame:
    monkeypatch.setattr(work_precision, "arenas", lambda quick: (small(),))
    return work_precision.work_precision(quick=True)


def test_every_row_has_error_time_with_interval_status_and_truth(study: pd.DataFrame) -> None:
    assert tuple(study.columns) == work_precision.COLUMNS
    assert set(study["contender"]) == set(FEW)
    done = study[study["error"].notna()]
    assert len(done) == len(study)
    assert (done["seconds_low"] <= done["seconds"]).all()
    assert (done["seconds"] <= done["seconds_high"]).all()
    assert set(study["reference"]) == {"Kepler, closed form"}
    assert study["settings"].str.len().min() > 0
    ours = study[study["contender"] == FEW[0]]
    assert ours["error"].min() < 1e-9 and (ours["evaluations"] > ours["steps"]).all()


def test_the_truth_is_not_judged_by_itself(monkeypatch: pytest.MonkeyPatch) -> None:
    arena = small()
    end = arena.truth().end
    truth = Truth(end, 0.0, "REBOUND IAS15", source="REBOUND IAS15")
    monkeypatch.setattr(
        work_precision, "arenas", lambda quick: (replace(arena, truth=lambda: truth),)
    )
    rows = work_precision.work_precision(quick=True)
    own = rows[rows["contender"] == "REBOUND IAS15"]
    assert len(own) and own["error"].isna().all() and (own["status"] == "truth").all()
    assert own["seconds"].notna().all()


def test_without_the_engine_of_the_truth_every_row_says_why(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def absent() -> Truth:
        raise ModuleNotFoundError("Install the engine.")

    monkeypatch.setattr(work_precision, "arenas", lambda quick: (replace(small(), truth=absent),))
    rows = work_precision.work_precision(quick=True)
    assert len(rows) and (rows["status"] == "Install the engine.").all()
    assert rows["error"].isna().all()


@pytest.mark.parametrize("quick", [True, False])
def test_the_arenas_name_each_contender_once_and_use_whole_steps(quick: bool) -> None:
    for arena in arenas(quick):
        labels = [label for label, _, _ in arena.entries]
        assert len(set(labels)) == len(labels)
        for _, contender, settings in arena.entries:
            assert settings and contender.supports(arena.problem)
            for setting in settings:
                if "step" in setting:
                    assert (arena.duration / setting["step"]) == pytest.approx(
                        setting["save_every"], rel=1e-12
                    )


def test_calls_take_turns_and_short_ones_are_repeated(monkeypatch: pytest.MonkeyPatch) -> None:
    clock = {"now": 0.0}
    order: list[str] = []
    monkeypatch.setattr(stopwatch.time, "perf_counter", lambda: clock["now"])

    def call(name: str, seconds: list[float]) -> Any:
        times = iter(seconds)

        def made() -> None:
            order.append(name)
            clock["now"] += next(times)

        return made

    timings = stopwatch.interleaved(
        [call("A", [1.0, 5.0, 3.0]), call("B", [0.5] * 6)], 3, 1.0, warm=[1.0, 0.5]
    )
    assert "".join(order) == "ABBABBABB"
    assert (timings[0].low, timings[0].seconds, timings[0].high) == (1.0, 3.0, 5.0)
    assert timings[1].seconds == pytest.approx(0.5)


def test_the_cost_table_counts_each_solver() -> None:
    table = cost_table(quick=True)
    assert tuple(table.columns) == COST
    assert (table["status"] == "").all() and (table["seconds_per_step"] > 0.0).all()
    assert set(table["solver"]) >= {"fixed point"}
    oscillator = table[table["problem"] == "harmonic oscillator"]
    assert oscillator["solver"].str.contains("Newton").all()
    assert (table["forces_per_step"] >= table["iterations_per_step"]).all()
    assert not math.isnan(float(table["order"].sum()))
