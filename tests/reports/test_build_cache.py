"""Results of a build: kept to the last bit, measured again when damaged, studied by workers."""

from __future__ import annotations

import os
import pickle
import signal
import subprocess
import sys
import time
from dataclasses import replace
from functools import partial
from pathlib import Path
from unittest.mock import Mock

import numpy as np
import pandas as pd
import pytest

from benchmarks.applications.external.integrator import ExternalIntegrator
from benchmarks.store.provenance import ROOT
from benchmarks.store.result_cache import FOLDER, ResultCache
from reports.build.verify import verify
from reports.build.workers import WORKERS, processors, study_in_workers
from reports.contents import SECTIONS, load
from reports.results.cache import BuildCache, CachedResult
from reports.results.claim_results import check
from reports.results.options import Options
from reports.results.own_problems import joined
from reports.results.section_result import measure_sections
from tests.reports.small_reports import SKY
from tests.reports.small_studies import broken, dying, nothing, quiet

FRAMES = (
    pd.DataFrame({"x": [0.1 + 0.2, -0.0, np.nan, np.inf, -np.inf, 5e-324, 1e308]}),
    pd.DataFrame({"n": [2**62, -1], "good": [True, False], "text": ["a", ""]}),
    pd.DataFrame({"mixed": pd.Series(["a", None, np.nan, 1, 2.5, True], dtype=object)}),
    pd.DataFrame(columns=["a", "b"]).astype({"a": "float64"}),
    pd.DataFrame(),
)


@pytest.mark.parametrize("frame", FRAMES)
def test_a_kept_frame_is_the_same_to_the_last_bit(tmp_path, frame):
    store = ResultCache(tmp_path, "state")
    BuildCache(store, "monday").keep("V1", frame, 0.1 + 0.2)
    back = CachedResult.from_json(store.results()["V1"])
    assert (back.seconds, back.run) == (0.1 + 0.2, "monday")
    pd.testing.assert_frame_equal(back.frame, frame, check_exact=True)
    for name in frame.select_dtypes("float"):
        assert back.frame[name].to_numpy().tobytes() == frame[name].to_numpy().tobytes()


def test_results_of_other_sources_are_neither_seen_nor_removed(tmp_path):
    mine, other = ResultCache(tmp_path, "mine"), ResultCache(tmp_path, "other")
    for name in ("a", "b c"):
        mine.keep(name, 1)
    other.keep("a", 2)
    assert mine.results() == {"a": 1, "b c": 1} and other.results() == {"a": 2}
    mine.forget(["a"])
    assert mine.results() == {"b c": 1}
    mine.forget()
    assert mine.results() == {} and other.results() == {"a": 2}
    other.forget()
    assert list(tmp_path.iterdir()) == []


def test_a_damaged_result_is_measured_again(tmp_path):
    store = ResultCache(tmp_path, "state")
    for name in ("V1", "V2", "V3"):
        store.keep(name, ["a", 0.1])
    one, two, _ = sorted((tmp_path / FOLDER).rglob("*.json"))
    one.write_bytes(one.read_bytes()[:-3])
    two.write_text("0.2")
    assert list(store.results().values()) == [["a", 0.1]]
    store.forget()
    assert list(tmp_path.iterdir()) == []


def test_results_of_other_sources_are_removed_after_a_week(tmp_path):
    old, new = ResultCache(tmp_path, "old"), ResultCache(tmp_path, "new")
    for store in (old, new):
        store.keep("V1", 1)
    os.utime(next((tmp_path / FOLDER / "old").iterdir()), (0, 0))
    ResultCache(tmp_path, "mine").forget()
    assert old.results() == {} and new.results() == {"V1": 1}


class Evil:
    """Runs a command where it is unpickled."""

    def __reduce__(self):
        return os.system, ("touch ran",)


def test_nothing_that_lies_in_the_folder_is_run(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    store = ResultCache(tmp_path, "state")
    store.keep("V1", 1)
    place = tmp_path / FOLDER / "state"
    for name in ("cache.db", "0.json", "x.val", "x.pickle"):
        (place / name).write_bytes(pickle.dumps((Evil(), "V1")))
    assert store.results() == {"V1": 1} and not (tmp_path / "ran").exists()


@pytest.mark.parametrize("error", [OSError("No space left"), PermissionError("is read only")])
def test_a_result_that_cannot_be_kept_is_used_all_the_same(tmp_path, monkeypatch, capsys, error):
    def full(*more: object) -> None:
        raise error

    monkeypatch.setattr(ResultCache, "keep", full)
    frame = FRAMES[0]
    assert BuildCache(ResultCache(tmp_path, "s")).result("V1", lambda: frame).frame is frame
    assert f"V1 is not kept for a build that is resumed: {error}." in capsys.readouterr().err


@pytest.mark.slow(beside="test_two_workers_study_beside_each_other_and_leave_out_what_raises")
def test_a_build_measures_sections_beside_its_claims_and_only_once(
    make_suite, make_claim, tmp_path
):
    def never(quick, report):
        raise AssertionError("measured in its turn")

    section = replace(SKY, measure=never)
    names = [f"V{k}" for k in range(1, 5)]
    studies = {**dict.fromkeys(names, nothing), section.title: partial(quiet, 0.0)}
    suite = make_suite(*map(make_claim, names), sections=(section,), in_workers=studies)
    cache = BuildCache()
    results = verify(suite, Options(True, out=tmp_path), cache, [section.title])
    assert [result.claim.id for result in results.checked] == names
    (result,) = measure_sections(suite, Options(True, out=tmp_path), suite.sections, cache)
    assert not result.failure and list(result.frame) == list(quiet(0.0, True))
    assert measure_sections(suite, Options(out=tmp_path), suite.sections)[0].failure


def test_sections_open_to_external_integrators_are_then_measured_with_them(monkeypatch):
    mine = Mock()
    mine.name = "mine"
    monkeypatch.setattr(ExternalIntegrator, "open", lambda path, limit: mine)
    with joined(load(), ["mine:Mine"]) as suite:
        here = {
            section.title for section in suite.sections if section.title not in suite.in_workers
        }
    assert here == {section.title for section in SECTIONS if section.open or section.timed}


def test_claims_with_results_are_judged_and_the_others_are_studied(make_claim, tmp_path, capsys):
    store = ResultCache(tmp_path, "state")
    cache = BuildCache(store, "now")
    cache.keep("V2", pd.DataFrame({"there": [1.0]}), 7.0)
    claims = [make_claim("V1"), make_claim("V2", raises=RuntimeError("not here")), make_claim("V3")]
    results = check(claims, None, True, cache)
    assert [result.claim.id for result in results] == ["V1", "V2", "V3"]
    assert results[1].seconds == 7.0 and list(results[1].frame) == ["there"]
    studied = capsys.readouterr().err.splitlines()
    assert [line.partition(":")[0] for line in studied] == [
        "[1/2] V1 title of V1",
        "[2/2] V3 title of V3",
    ]
    assert set(store.results()) == {"V1", "V2", "V3"}


@pytest.mark.skipif(processors() < WORKERS, reason="one processor")
def test_two_workers_study_beside_each_other_and_leave_out_what_raises(capfd):
    studies = {name: broken if name == "b" else partial(quiet, 0.3) for name in "abcd"}
    found = {name: (frame, seconds) for name, frame, seconds in study_in_workers(studies, True)}
    assert set(found) == {"a", "c", "d"} and capfd.readouterr() == ("", "")
    processes = {int(frame["process"][0]) for frame, _ in found.values()}
    assert len(processes) == 2 and os.getpid() not in processes
    assert all(seconds >= 0.3 and frame["quick"].all() for frame, seconds in found.values())
    assert list(study_in_workers({"a": partial(quiet, 0.0)}, True)) == []  # too few


@pytest.mark.skipif(processors() < WORKERS, reason="one processor")
@pytest.mark.slow(beside="test_two_workers_study_beside_each_other_and_leave_out_what_raises")
def test_the_death_of_a_worker_is_no_more_than_missing_results():
    studies = {**dict.fromkeys("abc", partial(quiet, 0.0)), "d": dying, "e": partial(quiet, 0.0)}
    assert {name for name, *_ in study_in_workers(studies, True)} <= set("abce")
    del studies["d"]
    assert {name for name, *_ in study_in_workers(studies, True)} == set("abce")


KILLED = """
import os, signal, sys
from functools import partial
from reports.build.workers import study_in_workers
from tests.reports.small_studies import quiet
if __name__ == "__main__":
    studies = {"a": partial(quiet, 0.0), **{str(k): partial(quiet, 300.0) for k in range(9)}}
    (one,) = next(study_in_workers(studies, True))[1]["process"]
    print(one, flush=True)
    if sys.argv[1] == "kill":
        os.kill(os.getpid(), signal.SIGKILL)
"""


@pytest.mark.slow(beside="test_two_workers_study_beside_each_other_and_leave_out_what_raises")
@pytest.mark.skipif(processors() < WORKERS, reason="one processor")
@pytest.mark.parametrize("how", ["kill", "end"])
def test_workers_end_with_the_build_however_it_ends(tmp_path: Path, how: str) -> None:
    (tmp_path / "script.py").write_text(KILLED)
    done = subprocess.run(
        [sys.executable, str(tmp_path / "script.py"), how],
        env=os.environ | {"PYTHONPATH": str(ROOT)}, stdout=subprocess.PIPE, text=True, timeout=120,
    )  # fmt: skip
    assert done.returncode == (-signal.SIGKILL if how == "kill" else 0)
    for _ in range(100):
        try:
            os.kill(int(done.stdout), 0)
        except ProcessLookupError:
            return
        time.sleep(0.1)
    pytest.fail("a worker goes on without its build")
