"""Series over commits, and no false alarm."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from benchmarks.statistics.rank_test import slower
from benchmarks.timings.catalogue import CASES
from reports.tracking.benches import COLUMNS, TIME, read_history
from reports.tracking.record import history
from reports.tracking.together import FURTHER_ROUNDS, Together, means

# Equal code is not called slower: a thousand comparisons drawn from recorded samples.
#
# `equal_code.csv` has the samples of `track --against` of a commit with itself, in A B B A, on an
# Intel Xeon at work with something else: seconds of both sides, 14 benchmarks.

RECORDED = pd.read_csv(Path(__file__).with_name("equal_code.csv"))
SIZES = {case.name: case.slower for case in CASES}
COMPARISONS = 1000


def samples(random):
    """Both sides of each benchmark, drawn from all of its samples, whichever side they are from."""
    drawn = {}
    for name, rows in RECORDED.groupby("benchmark", sort=False):
        count = int((rows["side"] == "base").sum())
        drawn[str(name)] = tuple(random.choice(rows["seconds"].to_numpy(), (2, count)))
    return drawn


# Equal code in two processes differs by its memory layout, by a factor for all benchmarks of a
# process and a factor for each: standard deviations of the logarithm of a time.
PROCESS_SPREAD, BENCHMARK_SPREAD = 0.015, 0.02


def random_round(random, growth):
    """Mean times of BENCHMARKS benchmarks of an integrator, whose head is slower by `growth`."""
    processes = np.array([1.0, 1.0 + growth]) * np.exp(PROCESS_SPREAD * random.standard_normal(2))
    benchmarks = [rows["seconds"].to_numpy() for _, rows in RECORDED.groupby("benchmark")]
    chosen = random.choice(len(benchmarks), BENCHMARKS, replace=False)
    drawn = []
    for seconds in (benchmarks[k] for k in chosen):
        factors = processes * np.exp(BENCHMARK_SPREAD * random.standard_normal(2))
        drawn.append(tuple(random.choice(seconds, (2, 14)) * factors[:, None]))
    return means(drawn)


BENCHMARKS = 6


@pytest.mark.slow(beside="test_track_gates.py::test_equal_sides_are_green_in_one_sentence")
def test_a_thousand_comparisons_of_equal_code_raise_no_alarm():
    """As in `track`: slower in a first round, and again in a second one."""
    random, alarms, suspects = np.random.Generator(np.random.Philox(7)), 0, 0
    for _ in range(COMPARISONS):
        first = slower(samples(random), SIZES)
        suspects += len(first)
        alarms += bool(first and first & slower(samples(random), SIZES))
    print(
        f"{COMPARISONS} comparisons of equal code: {alarms} alarms, {suspects} suspects in round 1"
    )
    assert alarms == 0
    assert suspects <= 4  # the level is 0.002 a comparison; 0 when this was written


def alarms_together(comparisons, growth):
    random, alarms = np.random.Generator(np.random.Philox(11)), 0
    for _ in range(comparisons):
        first = Together("mine:Mine", frozenset(), (random_round(random, growth),), size=0.05)
        if first.suspicious:
            further = tuple(random_round(random, growth) for _ in range(FURTHER_ROUNDS))
            alarms += bool(replace(first, rounds=first.rounds + further).alarms)
    print(f"{comparisons} comparisons with {growth:.0%} more time: {alarms} alarms")
    return alarms


@pytest.mark.slow(
    beside="test_track_gates.py::test_what_is_below_the_size_of_each_is_red_by_all_together"
)
def test_benchmarks_together_raise_no_alarm_for_equal_code_and_see_seven_percent():
    """As in `track`; each round has a new memory layout of its processes."""
    assert alarms_together(COMPARISONS, 0.0) == 0
    assert alarms_together(100, 0.07) > 50


def test_code_that_is_slower_is_seen_in_the_same_samples():
    random = np.random.Generator(np.random.Philox(8))
    for name in SIZES.keys() & set(RECORDED["benchmark"]):
        drawn = samples(random)
        base, head = drawn[name]
        assert name in slower({**drawn, name: (base, 2.0 * head)}, SIZES)


NAME = "test_a_run_of_galvi[Kepler, degree 8]"


def bench(k, time=1.0, cpu="A", **extra):
    """A file of pytest-benchmark with one benchmark, of the k-th day."""
    extra_info = {
        "kind": "trajectory",
        "problem": "kepler",
        "error": 1e-9,
        "counts": {"iterations": 100, "steps": 10},
        "status": "Completed.",
        "versions": {"numba": "1", "numpy": "2"},
        "yardstick": {"name": "y", "seconds": 0.5},
    }
    return {
        "machine_info": {"cpu": {"brand_raw": cpu}, "system": "S", "python_version": "3"},
        "commit_info": {"id": f"{k:012}", "dirty": k % 2 == 1},
        "benchmarks": [
            {
                "name": NAME,
                "stats": {"median": time, "mean": time},
                "extra_info": extra_info | extra,
            }
        ],
        "datetime": f"2026-01-{k + 1:02}T00:00:00+00:00",
        "version": "5",
    }


@pytest.fixture
def keep_benches(tmp_path):
    """Keep benches as files of these names in `out`."""

    def keep(**benches):
        folder = tmp_path / "out" / "benchmarks"
        (folder / "machine").mkdir(parents=True, exist_ok=True)
        for name, content in benches.items():
            text = content if isinstance(content, str) else json.dumps(content)
            (folder / "machine" / f"{name}.json").write_text(text)
        return folder

    return keep


def test_each_quantity_of_each_bench_is_a_row(keep_benches):
    history_rows = read_history(keep_benches(b=bench(1, 3.0), a=bench(2, 1.0)), pytest.fail)
    assert tuple(history_rows.columns) == COLUMNS
    times = history_rows[history_rows["quantity"] == TIME]
    assert list(times["value"]) == [6.0, 2.0]
    assert list(times["commit"]) == ["000000000001+", "000000000002"]
    assert set(times["benchmark"]) == {"Kepler, degree 8"}
    assert {"iterations", "error", "seconds"} < set(history_rows["quantity"])


@pytest.mark.parametrize(
    "content",
    [
        json.dumps(bench(2))[:100],
        {"version": "0.1", "things": []},
        [],
        bench(1) | {"benchmarks": [{"name": "x"}]},
        bench(1) | {"machine_info": {}},
    ],
)
def test_a_file_that_is_no_bench_is_left_out_with_a_sentence(keep_benches, content):
    messages: list[str] = []
    history_rows = read_history(keep_benches(other=content, good=bench(1)), messages.append)
    assert set(history_rows["file"]) == {"good.json"}
    (sentence,) = messages
    assert sentence.startswith("Failed to load ") and "other.json: " in sentence


def test_benches_of_somebody_else_have_seconds_and_nothing_invented(keep_benches):
    plain = [bench(k) for k in range(2)]
    for content in plain:
        content["benchmarks"][0]["extra_info"] = {}
    folder = keep_benches(a=plain[0], b=plain[1])
    assert list(read_history(folder, pytest.fail)["quantity"]) == ["seconds"] * 2
    (series,) = history(folder.parent).places
    assert series.benches == 2 and series.extremes == "" and series.pictures == ()
    assert series.rows["changes"].tolist() == ["too few runs"]


def test_another_machine_or_version_is_another_series(keep_benches):
    variants = (
        {"cpu": "B"},
        {"versions": {"numba": "2", "numpy": "2"}},
        {"yardstick": {"name": "another", "seconds": 0.5}},
    )
    benches = {
        f"{k}_{n}": bench(k, 1.0 + n, **variant)
        for k in range(6)
        for n, variant in enumerate(({}, *variants))
    }
    all_series = history(keep_benches(**benches).parent).places
    assert len({series.name for series in all_series}) == 4
    for n, series in enumerate(sorted(all_series, key=lambda series: series.rows[TIME].iloc[0])):
        assert series.benches == 6 and not series.changes
        (row,) = series.rows.to_dict("records")
        times = row["runs"], row[TIME], row["over the median of earlier runs"]
        assert times == (6, 2.0 + 2.0 * n, 1.0)
        assert series.commits["time, relative"].tolist() == [1.0] * 6


def test_changes_are_stated_with_the_commit_they_came_with(keep_benches):
    late = {"counts": {"iterations": 101}, "error": 2e-9}
    benches = {
        f"b{k}": bench(k, (1.0 if k < 10 else 1.3) + 1e-3 * (k % 3), **(late if k >= 15 else {}))
        for k in range(20)
    }
    (series,) = history(keep_benches(**benches).parent).places
    assert series.rows["changes"].tolist() == [3]
    assert list(series.changes) == [
        "Kepler, degree 8: time over yardstick +30.0 % near 000000000010",
        "Kepler, degree 8: iterations +1.0 % near 000000000015+",
        "Kepler, degree 8: error +100.0 % near 000000000015+",
    ]


def test_a_quantity_that_some_benches_lack_stands_at_its_own(keep_benches):
    errors = (None, 0.0, 0.0, None, 0.0, 1.0)
    benches = {f"b{k}": bench(k, error=error) for k, error in enumerate(errors)}
    (series,) = history(keep_benches(**benches).parent).places
    assert series.changes == ("Kepler, degree 8: error 0 became 1 near 000000000005+",)
    (row,) = series.rows.to_dict("records")
    assert (row["runs"], row["error"], row["changes"]) == (6, 1.0, 1)


def test_an_empty_history_is_a_sentence_and_still_a_page(ask):
    completed = ask("track")
    assert completed.status == 0 and "There is no benchmark run in " in completed.out
    page = Path("out/results/history.html").read_text()
    assert "No timings of earlier commits are kept" in page
    assert Path("out/history.csv").read_text().startswith("file,date,commit,benchmark")


@pytest.mark.slow(beside="test_an_empty_history_is_a_sentence_and_still_a_page")
def test_the_page_has_each_machine_its_pictures_its_slowest_commit_and_its_start_up(
    ask, keep_benches
):
    for k, time in enumerate((1.0, 1.1, 3.0, 0.9)):
        late = {"counts": {"iterations": 101}} if k else {}
        start_up = {"import [s]": 0.5 + k, "cold start [s]": 9.0, "memory [MiB]": 180.0}
        content = bench(k, time, first_call=7.25, start_up=start_up, **late)
        keep_benches(**{f"b{k}": content}, other=bench(1, cpu="Quite another"), bad="{")
    assert ask("track").status == 0
    page = Path("out/results/history.html").read_text()
    for text in (
        "Quite another",
        "bad.json: ",
        "shown separately",
        "fastest: 000000000003+",
        "Slowest commit: 000000000002, at 2.86 times the median",
        "So few runs cannot tell a change from noise.",
    ):
        assert text in page
    assert page.count("<img ") == 2 and Path("out/figures/track-kepler-degree-8.svg").exists()
    for cell in ("7.25", "3.50", "9.00", "180"):
        assert f'<td class="number">{cell}</td>' in page
    assert "iterations +1.0 % near 000000000001+" in page[page.index("Changes of level") :]
