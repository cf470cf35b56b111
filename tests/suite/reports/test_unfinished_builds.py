"""A build that was stopped is resumed; one that ended leaves nothing to resume."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pandas as pd
import pytest

from benchmarks.work_precision.run import problems, work_precision
from reports.build.kept import LOCK
from reports.figures.drawing import Gallery
from reports.results import cache
from reports.results.cache import FOLDER, open_cache
from reports.results.comparison import Comparison
from reports.results.options import Options
from reports.results.rows import MARKS
from tests.suite.reports.counted_suite import Bench

HOLD = """
import sys
from filelock import FileLock
with FileLock(sys.argv[1]):
    print("held", flush=True)
    sys.stdin.read()
"""


NOTHING = Comparison(None, None)
ALL = ["V1", "V3", "ball", "top", "cost", "sky", "study"]


@pytest.fixture
def bench(make_suite, make_claim, monkeypatch: pytest.MonkeyPatch) -> Bench:
    monkeypatch.setattr("reports.build.build.draw", lambda *measured: Gallery({}, {}))
    monkeypatch.setattr("reports.build.build.first_look", lambda suite: ([], NOTHING))
    monkeypatch.setattr("reports.tables.writing.as_latex", lambda *frame: "")
    monkeypatch.setattr("reports.tables.writing.as_markdown", lambda frame: "")
    monkeypatch.setattr(cache, "digest_of_sources", lambda code: "as they are")
    return Bench(make_suite, make_claim)


def stopped(bench: Bench, part: str, *words: str) -> None:
    """A run that ends in this part."""
    bench.stop = part
    assert bench(*words)[0] == 2
    bench.stop, bench.faults[:] = "", []


def kept(out: Path) -> list[str]:
    """The results of all builds in this folder that were stopped."""
    if not (out / FOLDER).exists():
        return []
    return list((out / FOLDER).rglob("*.json"))


@pytest.mark.slow_cases(but=["top"])
@pytest.mark.parametrize("last", ["V1", "top", "study"])
def test_a_build_that_was_stopped_resumes_with_what_it_was_measuring(bench, tmp_path, capsys, last):
    out, where = ["--out", str(tmp_path)], ALL.index(last)
    stopped(bench, last, *out)
    assert len(kept(tmp_path)) == where
    bench.date = "2026-01-01 00:20 UTC"
    capsys.readouterr()
    status, calls = bench(*out)
    assert calls == ALL[where:]
    said = capsys.readouterr().out
    told = f"{where} results of the build of 2026-01-01 00:00 UTC, which was stopped; --anew starts"
    assert (told in said) == (where > 0) and status == (last != "study")  # "top" reports a fault
    assert not (tmp_path / FOLDER).exists()
    assert bench(*out)[1] == ALL
    assert "Resuming" not in capsys.readouterr().out


def test_an_interrupted_build_says_that_it_can_be_resumed(bench, tmp_path, capsys):
    bench.stop, bench.how = "ball", KeyboardInterrupt
    assert bench("--out", str(tmp_path)) == (130, ALL[:3])
    said = capsys.readouterr().err
    assert "Finished results are kept: the same command resumes the build.\nInterrupted" in said
    assert len(kept(tmp_path)) == 2


@pytest.mark.slow(beside="test_a_build_that_was_stopped_resumes_with_what_it_was_measuring")
def test_a_resumed_build_is_the_same_report_and_says_which_run_measured_what(bench, tmp_path):
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
    told = "3 results of the build of 2026-01-01 00:00 UTC, which was stopped"
    origins = json.loads((tmp_path / "two" / "provenance.json").read_text())
    assert all(told in origin["resumed"] for origin in origins.values())
    assert told in (tmp_path / "two" / "results" / "provenance.html").read_text()
    assert "was stopped" not in (tmp_path / "whole" / "results" / "provenance.html").read_text()
    dates = set(pd.read_csv(tmp_path / "two" / "claims.csv")["date"])
    assert dates == {"2026-01-01 00:00 UTC"}
    assert set(pd.read_csv(tmp_path / "two" / "study.csv")["date"]) == {"2026-01-01"}


@pytest.mark.slow(beside="test_what_it_depends_on_makes_another_build")
def test_anew_starts_over_and_another_setting_leaves_what_was_kept(bench, tmp_path):
    out = ["--out", str(tmp_path)]
    stopped(bench, "study", *out)
    assert bench("--claims", "V1", *out)[1] == ["V1", *ALL[2:]]
    assert len(kept(tmp_path)) == 6
    assert bench("--anew", *out)[1] == ALL


def test_what_it_depends_on_makes_another_build(bench, tmp_path, monkeypatch):
    def state(**asked: object) -> str:
        return open_cache(bench.suite, Options(out=tmp_path, **asked)).folder.name

    seen = [state(), state(quick=True), state(claims=("V1",))]
    bench.date = "2027-01-01 00:00 UTC"
    assert state() == state(command="python -m reports build") == seen[0]
    bench.commit = "abd"
    seen += [state()]
    monkeypatch.setattr(cache, "digest_of_sources", lambda code: "other")
    seen += [state()]
    assert len(set(seen)) == len(seen) == 5


def test_nothing_is_kept_of_a_build_with_external_integrators(bench, tmp_path):
    assert open_cache(bench.suite, Options(out=tmp_path, contenders=("mine:A",))).folder is None


@pytest.mark.slow_cases("False")
@pytest.mark.parametrize("changes", [False, True])
def test_an_edit_during_a_build_is_reported_and_no_result_is_kept_from_then_on(
    bench, tmp_path, monkeypatch, capsys, changes
):
    states = iter("aaa" + ("b" if changes else "a") * 1000)
    monkeypatch.setattr(cache, "digest_of_sources", lambda code: next(states))
    stopped(bench, "study", "--out", str(tmp_path))  # at the start, then at each result
    assert len(kept(tmp_path)) == (2 if changes else 6)
    said = "ball is not kept for a build that is resumed: the sources changed since the build"
    assert (said in capsys.readouterr().err) == changes


@pytest.mark.slow(
    beside="test_an_edit_during_a_build_is_reported_and_no_result_is_kept_from_then_on"
)
def test_an_edit_during_a_build_is_on_the_page(bench, tmp_path, monkeypatch, capsys):
    states = iter("aaaaa" + "b" * 1000)
    monkeypatch.setattr(cache, "digest_of_sources", lambda code: next(states))
    bench("--out", str(tmp_path))
    told = "the sources, after this run began: results may be of either state"
    assert f"Changed: {told}.\n" in capsys.readouterr().err
    assert told in (tmp_path / "results" / "provenance.html").read_text()
    origins = json.loads((tmp_path / "provenance.json").read_text())
    assert origins["index.html"]["changed"] == told
    assert "changed" not in origins["claims.csv"]


@contextmanager
def held(out: Path) -> Iterator[None]:
    """Another process that builds there."""
    out.mkdir(exist_ok=True)
    words = [sys.executable, "-c", HOLD, str(out / LOCK)]
    with subprocess.Popen(words, stdin=-1, stdout=-1, text=True) as process:
        assert process.stdout is not None and process.stdout.readline() == "held\n"
        yield
        process.kill()


@pytest.mark.slow(beside="test_a_folder_that_nothing_can_be_written_in_is_answered_in_a_sentence")
def test_two_builds_in_one_folder_are_refused_until_the_first_is_gone(bench, tmp_path, capsys):
    with held(tmp_path):
        assert bench("--out", str(tmp_path)) == (2, [])
        assert capsys.readouterr().err == (
            f"Another build is at work in {tmp_path}; wait until it ends, or choose another folder "
            "with --out.\n"
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
