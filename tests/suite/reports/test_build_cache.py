"""Cached results of a build: equal to the last bit, measured again if damaged; workers."""

from __future__ import annotations

import os
import pickle
import signal
import subprocess
import sys
import time
from dataclasses import replace
from functools import partial
from unittest.mock import Mock

import numpy as np
import pandas as pd
import pytest

from benchmarks.applications.external.integrator import ExternalIntegrator
from benchmarks.store.provenance import ROOT
from reports.build.workers import WORKER_COUNT, processors, study_in_workers
from reports.contents import SECTIONS, load
from reports.results.cache import CACHE_FOLDER, BuildCache, Study
from reports.results.claim_results import check
from reports.results.own_problems import with_contenders
from tests.suite.reports.small_reports import claim
from tests.suite.reports.small_studies import broken, dying, meet, quiet

FRAMES = (
    pd.DataFrame({"x": [0.1 + 0.2, -0.0, np.nan, np.inf, -np.inf, 5e-324, 1e308]}),
    pd.DataFrame({"n": [2**62, -1], "good": [True, False], "text": ["a", ""]}),
    pd.DataFrame({"mixed": pd.Series(["a", None, np.nan, 1, 2.5, True], dtype=object)}),
    pd.DataFrame(columns=["a", "b"]).astype({"a": "float64"}),
    pd.DataFrame(),
)


def cache_of(out, build="mine"):
    """The loaded cache of a build whose run is called "monday"."""
    cache = BuildCache(out / CACHE_FOLDER / build, "monday")
    cache.load()
    return cache


@pytest.mark.parametrize("table", FRAMES)
def test_a_kept_frame_is_the_same_to_the_last_bit(tmp_path, table):
    cache_of(tmp_path).keep("V1", table, 0.1 + 0.2)
    cached = cache_of(tmp_path).entries["V1"]
    assert (cached.seconds, cached.run) == (0.1 + 0.2, "monday")
    pd.testing.assert_frame_equal(cached.table, table, check_exact=True)
    for name in table.select_dtypes("float"):
        assert cached.table[name].to_numpy().tobytes() == table[name].to_numpy().tobytes()


def test_results_of_other_sources_are_neither_seen_nor_removed(tmp_path):
    for name in ("a", "b c"):
        cache_of(tmp_path).keep(name, FRAMES[0], 1.0)
    cache_of(tmp_path, "other").keep("a", FRAMES[1], 1.0)
    assert set(cache_of(tmp_path).entries) == {"a", "b c"}
    cache_of(tmp_path).forget()
    assert cache_of(tmp_path).entries == {}
    assert list(cache_of(tmp_path, "other").entries) == ["a"]
    cache_of(tmp_path, "other").forget()
    assert list(tmp_path.iterdir()) == []


def test_a_damaged_result_is_measured_again(tmp_path):
    for name in ("V1", "V2", "V3", "V4"):
        cache_of(tmp_path).keep(name, FRAMES[1], 1.0)
    first, second, third, _ = sorted((tmp_path / CACHE_FOLDER).rglob("*.json"))
    first.write_bytes(first.read_bytes()[:-3])
    second.write_text("0.2")
    third.write_text('["V1", {"run": "monday"}]')
    assert len(cache_of(tmp_path).entries) == 1


def test_results_of_other_sources_are_removed_after_a_week(tmp_path):
    for build in ("old", "new"):
        cache_of(tmp_path, build).keep("V1", FRAMES[0], 1.0)
    os.utime(tmp_path / CACHE_FOLDER / "old", (0, 0))
    cache_of(tmp_path).forget()
    assert not cache_of(tmp_path, "old").entries and cache_of(tmp_path, "new").entries


class Evil:
    """Runs a command where it is unpickled."""

    def __reduce__(self):
        return os.system, ("touch ran",)


def test_nothing_that_lies_in_the_folder_is_run(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    cache = cache_of(tmp_path)
    cache.keep("V1", FRAMES[0], 1.0)
    for name in ("cache.db", "0.json", "x.val", "x.pickle"):
        (cache.folder / name).write_bytes(pickle.dumps((Evil(), "V1")))
    assert list(cache_of(tmp_path).entries) == ["V1"] and not (tmp_path / "ran").exists()


def test_a_result_that_cannot_be_kept_is_used_all_the_same(tmp_path, monkeypatch, capsys):
    def full(*_):
        raise PermissionError("is read only")

    monkeypatch.setattr("reports.results.cache.write", full)
    table, cache = FRAMES[0], cache_of(tmp_path)
    assert cache.measure([Study("V1", "V1", "title", lambda report: table)]) == {}
    assert cache.entries["V1"].table is table
    assert "V1 is not kept for a build that is resumed: is read only." in capsys.readouterr().err


def test_sections_open_to_external_integrators_are_then_measured_with_them(monkeypatch):
    contender = Mock()
    contender.name = "mine"
    monkeypatch.setattr(ExternalIntegrator, "open", lambda path, limit: contender)
    with with_contenders(load(), ["mine:Mine"]) as suite:
        titles = {section.title for section in suite.sections if section.timed}
    assert titles == {section.title for section in SECTIONS if section.open or section.timed}


def test_claims_with_results_are_judged_and_the_others_are_studied(tmp_path, capsys):
    cache = cache_of(tmp_path)
    cache.keep("V2", pd.DataFrame({"there": [1.0]}), 7.0)
    claims = [claim(), claim("V2", raises=RuntimeError("not here")), claim("V3")]
    checked = check(claims, True, cache)
    assert [claim_result.claim.id for claim_result in checked] == ["V1", "V2", "V3"]
    assert checked[1].seconds == 7.0 and list(checked[1].table) == ["there"]
    studied = capsys.readouterr().err.splitlines()
    assert [line.partition(":")[0] for line in studied] == [
        "[1/2] V1 title of V1",
        "[2/2] V3 title of V3",
    ]
    assert set(cache_of(tmp_path).entries) == {"V1", "V2", "V3"}


def study(name, measure):
    return Study(name, "study", name, partial(measure, True), timed=False)


@pytest.mark.skipif(processors() < WORKER_COUNT, reason="one processor")
def test_two_workers_study_beside_each_other_and_leave_out_what_raises(capfd, tmp_path):
    cache = BuildCache()
    first, last = tmp_path / "a", tmp_path / "d"
    meeting = {
        "a": partial(meet, first, last),
        "b": broken,
        "c": partial(quiet, 0.3),
        "d": partial(meet, last, first),
    }
    studies = [study(name, measure) for name, measure in meeting.items()]
    seconds = {finished.name: seconds for finished, seconds in study_in_workers(studies, cache)}
    assert set(seconds) == set(cache.entries) == {"a", "c", "d"}
    assert capfd.readouterr() == ("", "")
    tables = [entry.table for entry in cache.entries.values()]
    processes = {int(table["process"][0]) for table in tables}
    assert len(processes) == 2 and os.getpid() not in processes
    assert seconds["c"] >= 0.3 and all(table["quick"].all() for table in tables)
    assert list(study_in_workers(studies[:1], BuildCache())) == []  # too few
    timed = [replace(part, timed=True) for part in studies]
    assert list(study_in_workers(timed, BuildCache())) == []


@pytest.mark.skipif(processors() < WORKER_COUNT, reason="one processor")
@pytest.mark.slow(beside="test_two_workers_study_beside_each_other_and_leave_out_what_raises")
def test_the_death_of_a_worker_is_no_more_than_missing_results():
    studies = [study(name, dying if name == "d" else partial(quiet, 0.0)) for name in "abcde"]
    assert {finished.name for finished, _ in study_in_workers(studies, BuildCache())} <= set("abce")
    del studies[3]
    assert {finished.name for finished, _ in study_in_workers(studies, BuildCache())} == set("abce")


KILLED = """
import os, signal, sys
from functools import partial
from reports.build.workers import study_in_workers
from reports.results.cache import BuildCache, Study
from tests.suite.reports.small_studies import quiet
if __name__ == "__main__":
    cache, seconds = BuildCache(), [0.0] + 9 * [300.0]
    studies = [
        Study(str(k), "", "", partial(quiet, after, True), timed=False)
        for k, after in enumerate(seconds)
    ]
    next(finished := study_in_workers(studies, cache))
    (process,) = cache.entries["0"].table["process"]
    print(process, flush=True)
    if sys.argv[1] == "kill":
        os.kill(os.getpid(), signal.SIGKILL)
    finished.close()
"""


@pytest.mark.slow(beside="test_two_workers_study_beside_each_other_and_leave_out_what_raises")
@pytest.mark.skipif(processors() < WORKER_COUNT, reason="one processor")
@pytest.mark.parametrize("how", ["kill", "end"])
def test_workers_end_with_the_build_however_it_ends(tmp_path, how):
    (tmp_path / "script.py").write_text(KILLED)
    completed = subprocess.run(
        [sys.executable, str(tmp_path / "script.py"), how],
        env=os.environ | {"PYTHONPATH": str(ROOT)},
        stdout=subprocess.PIPE,
        text=True,
        timeout=120,
    )
    assert completed.returncode == (-signal.SIGKILL if how == "kill" else 0)
    for _ in range(100):
        try:
            os.kill(int(completed.stdout), 0)
        except ProcessLookupError:
            return
        time.sleep(0.1)
    pytest.fail("a worker goes on without its build")
