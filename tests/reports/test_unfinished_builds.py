"""A build that was stopped goes on where it was; one that ended leaves nothing to go on with."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pandas as pd
import pytest

from benchmarks.timings.unfinished import FOLDER, Unfinished
from benchmarks.work_precision.run import problems, work_precision
from reports.build.lock import LOCK
from reports.cli.options import Order
from reports.figures.drawing import Gallery
from reports.results import unfinished_build
from reports.results.kept_rows import MARKS
from reports.results.unfinished_build import parts_of
from tests.reports.counted_suite import Bench, Killed

HOLD = """
import fcntl, sys
file = open(sys.argv[1], "w")
fcntl.lockf(file, fcntl.LOCK_EX)
print(77, file=file, flush=True)
print("held", flush=True)
sys.stdin.read()
"""


ALL = ["V1", "V3", "ball", "top", "cost", "sky", "study"]


@pytest.fixture
def bench(make_suite, make_claim, monkeypatch: pytest.MonkeyPatch) -> Bench:
    monkeypatch.setattr("reports.build.build.draw", lambda *measured: Gallery({}, {}))
    monkeypatch.setattr("reports.tables.writing.as_latex", lambda frame: "")
    monkeypatch.setattr("reports.tables.writing.as_markdown", lambda frame: "")
    monkeypatch.setattr(unfinished_build, "digest_of_sources", lambda code: "as they are")
    return Bench(make_suite, make_claim)


def stopped(bench: Bench, part: str, *words: str) -> None:
    """A run that ends in this part."""
    bench.stop = part
    with pytest.raises(Killed):
        bench(*words)
    bench.stop, bench.faults[:] = "", []


def kept(out: Path) -> list[Path]:
    return sorted((out / FOLDER).rglob("*.json"))


@pytest.mark.parametrize("last", ["V1", "top", "study"])
def test_a_build_that_was_stopped_goes_on_with_the_part_it_was_in(bench, tmp_path, capsys, last):
    out, where = ["--out", str(tmp_path)], ALL.index(last)
    stopped(bench, last, *out)
    assert len(kept(tmp_path)) == where
    bench.date = "2026-01-01 00:20 UTC"
    capsys.readouterr()
    status, calls = bench(*out)
    assert calls == ALL[where:]
    said = capsys.readouterr().out
    told = f"of 2026-01-01 00:00 UTC that did not end: {where} of 7 parts are there; --anew starts"
    assert (told in said) == (where > 0)
    assert status == 1  # the fault of a contender is told again, whichever run saw it
    assert not (tmp_path / FOLDER).exists()
    assert bench(*out)[1] == ALL
    assert "Goes on" not in capsys.readouterr().out


def test_an_interrupted_build_says_that_it_can_be_gone_on_with(bench, tmp_path, capsys):
    bench.stop, bench.how = "ball", KeyboardInterrupt
    assert bench("--out", str(tmp_path)) == (130, ALL[:3])
    said = capsys.readouterr().err
    assert "What was measured is kept: the same command goes on from there.\nInterrupted" in said
    assert len(kept(tmp_path)) == 2


def test_what_goes_on_is_the_same_report_and_says_which_run_measured_what(bench, tmp_path):
    for part, folder in (("", "whole"), ("top", "two")):
        out = ["--out", str(tmp_path / folder)]
        if part:
            stopped(bench, part, *out)
            bench.date = "2026-01-01 00:20 UTC"
        bench(*out)
    for name in ("claims", "work_precision", "cost", "sky_and_model", "study"):
        whole, two = (
            pd.read_csv(tmp_path / folder / f"{name}.csv").drop(
                columns=list(MARKS), errors="ignore"
            )
            for folder in ("whole", "two")
        )
        pd.testing.assert_frame_equal(whole, two, check_exact=True)
    told = "of 7 parts, 3 by a run of 2026-01-01 00:00 UTC that was stopped"
    origins = json.loads((tmp_path / "two" / "provenance.json").read_text())
    assert all(told in origin["runs"] for origin in origins.values())
    assert told in (tmp_path / "two" / "index.html").read_text()
    old, new = "by the run of 2026-01-01 00:00 UTC", "by the run of 2026-01-01 00:20 UTC"
    assert {name: origin.get("measured") for name, origin in origins.items()} == {
        "claims.csv": None, "index.html": None, "cost.csv": None, "sky_and_model.csv": None,
        "study.csv": None,
        "work_precision.csv": f"work-precision, ball {old}; work-precision, top {new}",
    }  # fmt: skip
    assert "that was stopped" not in (tmp_path / "whole" / "index.html").read_text()
    dates = set(pd.read_csv(tmp_path / "two" / "claims.csv")["date"])
    assert dates == {"2026-01-01 00:00 UTC"}
    assert set(pd.read_csv(tmp_path / "two" / "study.csv")["date"]) == {"2026-01-01"}


def test_a_fault_in_a_part_that_is_taken_up_is_told_again(bench, tmp_path, capsys):
    stopped(bench, "cost", "--out", str(tmp_path))
    capsys.readouterr()
    assert bench("--out", str(tmp_path)) == (1, ["cost", "sky", "study"])
    assert "It hung." in capsys.readouterr().err


def test_anew_starts_over_and_another_setting_leaves_what_was_kept(bench, tmp_path):
    out = ["--out", str(tmp_path)]
    stopped(bench, "study", *out)
    assert bench("--claims", "V1", *out)[1] == ["V1", *ALL[2:]]
    assert len(kept(tmp_path)) == 6
    assert bench("--anew", *out)[1] == ALL


def test_what_it_depends_on_makes_another_build(bench, tmp_path, monkeypatch):
    def key(**asked: object) -> Path:
        return parts_of(bench.suite, Order(out=tmp_path, **asked)).store.folder

    first = key()
    seen = [first, *(key(**asked) for asked in ({"quick": True}, {"claims": ("V1",)}))]
    bench.date = "2027-01-01 00:00 UTC"
    assert key() == first and key(command="python -m reports build") == first
    bench.commit = "abd"
    seen += [key()]
    bench.commit = "abc"
    monkeypatch.setattr(unfinished_build, "digest_of_sources", lambda code: "other")
    seen += [key()]
    assert len(set(seen)) == len(seen) == 5


def test_nothing_is_kept_of_a_build_with_an_external_integrator(bench, tmp_path):
    parts = parts_of(bench.suite, Order(out=tmp_path / "out", contenders=("mine:A",)))
    assert parts.store is None


@pytest.mark.parametrize("changes", [False, True])
def test_an_edit_during_a_build_is_told_and_no_part_is_kept_from_then_on(
    bench, tmp_path, monkeypatch, capsys, changes
):
    states = iter("aaa" + ("b" if changes else "a") * 1000)
    monkeypatch.setattr(unfinished_build, "digest_of_sources", lambda code: next(states))
    stopped(bench, "study", "--out", str(tmp_path))  # at the start, then at each part
    assert len(kept(tmp_path)) == (2 if changes else 6)
    said = "ball is not kept for a build that goes on: the suite's sources changed since the build"
    assert (said in capsys.readouterr().err) == changes


def test_an_edit_during_a_build_is_on_the_page(bench, tmp_path, monkeypatch, capsys):
    states = iter("aaaaa" + "b" * 1000)
    monkeypatch.setattr(unfinished_build, "digest_of_sources", lambda code: next(states))
    bench("--out", str(tmp_path))
    told = "the suite's sources, after this run began: parts may be of either state"
    assert f"Changed: {told}.\n" in capsys.readouterr().err
    assert told.replace("'", "&#39;") in (tmp_path / "index.html").read_text()
    origins = json.loads((tmp_path / "provenance.json").read_text())
    assert origins["index.html"]["changed"] == told
    assert "changed" not in origins["claims.csv"]


def test_a_part_that_cannot_be_kept_is_told_of_and_the_build_goes_on(
    bench, tmp_path, monkeypatch, capsys
):
    def full(*more: object) -> None:
        raise OSError("No space left on device")

    monkeypatch.setattr(Unfinished, "keep", full)
    assert bench("--out", str(tmp_path))[1] == ALL
    told = "V1 is not kept for a build that goes on: No space left on device."
    assert told in capsys.readouterr().err


@contextmanager
def held(out: Path) -> Iterator[None]:
    """Another process that builds there."""
    out.mkdir(exist_ok=True)
    words = [sys.executable, "-c", HOLD, str(out / LOCK)]
    with subprocess.Popen(words, stdin=-1, stdout=-1, text=True) as process:
        assert process.stdout is not None and process.stdout.readline() == "held\n"
        yield
        process.kill()


def test_two_builds_in_one_folder_are_refused_until_the_first_is_gone(bench, tmp_path, capsys):
    with held(tmp_path):
        assert bench("--out", str(tmp_path)) == (2, [])
        assert capsys.readouterr().err == (
            f"Another build is at work in {tmp_path} (process 77); wait until it ends, or choose "
            "another folder with --out.\n"
        )
        assert bench("verify", "--out", str(tmp_path))[1] == ["V1", "V3"]
    assert bench("--out", str(tmp_path))[1] == ALL


def test_work_precision_takes_one_problem_at_a_time_and_knows_their_names():
    assert len(set(problems())) == len(problems()) > len(problems(quick=True)) > 3
    with pytest.raises(ValueError, match="there is no problem 'ball' to compare on; known: "):
        work_precision(quick=True, problem="ball")


def test_a_folder_that_nothing_can_be_written_in_is_answered_in_a_sentence(bench, tmp_path, capsys):
    (tmp_path / LOCK).mkdir()  # as if it were not ours: whoever may do everything is refused, too
    assert bench("--out", str(tmp_path)) == (2, [])
    said = capsys.readouterr().err
    assert "--out expects a folder to write in; " in said and len(said.splitlines()) == 1


@pytest.mark.parametrize("command", ["build", "verify", "compare"])
def test_nothing_is_measured_for_a_folder_that_is_not_ours(
    bench, tmp_path, monkeypatch, capsys, command
):
    def refused(dir: Path) -> None:
        raise PermissionError(13, "Permission denied", str(dir))

    monkeypatch.setattr("tempfile.TemporaryFile", refused)
    assert bench(command, "--out", str(tmp_path)) == (2, [])
    said = capsys.readouterr().err
    assert "--out expects a folder to write in; " in said and "Permission denied" in said
