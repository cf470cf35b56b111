"""A build shows a page early and fills it as it goes on; one that was stopped is resumed."""

from __future__ import annotations

import json
import subprocess
import sys
from contextlib import contextmanager
from dataclasses import replace

import pandas as pd
import pytest

from benchmarks.work_precision.run import problems, work_precision
from reports.build.first_look import remembering
from reports.build.kept import LOCK_FILE
from reports.cli.commands import run
from reports.results import cache
from reports.results.cache import CACHE_FOLDER, open_cache
from reports.results.comparison import Comparison
from reports.results.options import Options
from reports.results.rows import ORIGIN_COLUMNS
from reports.results.section import Section
from tests.suite.reports.small_reports import claim, suite_of


class Killed(BaseException):
    """An exception that only the command's outermost handler catches, with status 2."""


class Bench:
    """A suite of two claims, two problems, a cost table and two sections.

    calls         names of the parts that the last command measured
    stop          the part in which the run ends; empty for none
    how           the exception that ends it
    date, commit  of the build's provenance
    faults        sentences on faults; the problem "top" adds one
    """

    def __init__(self):
        self.calls: list[str] = []
        self.stop, self.date, self.commit = "", "2026-01-01 00:00 UTC", "abc"
        self.faults: list[str] = []
        self.how: type[BaseException] = Killed
        plain, recorded = suite_of(), self._recorded
        study = recorded("study", lambda quick, report: pd.DataFrame({"n": [1, 2], "date": ""}))
        (sky,) = plain.sections
        self.suite = suite_of(
            *(
                replace(claim(name), study=recorded(name, claim(name).study), timed=True)
                for name in ("V1", "V3")
            ),
            work_precision=recorded("", plain.work_precision),
            problems=lambda quick: ("ball", "top"),
            cost=recorded("cost", plain.cost),
            sections=(
                replace(sky, measure=recorded("sky", sky.measure), timed=True),
                Section(
                    "study", "A study", "", study, lambda rows: (rows.astype(str), {}), timed=True
                ),
            ),
            faults=lambda: self.faults,
        )
        self.suite = replace(
            self.suite,
            provenance=lambda command: {
                "date": self.date,
                "commit": self.commit,
                "command": command,
            },
        )

    def __call__(self, *arguments):
        """Run the command; returns its status and the names of the parts that it measured."""
        self.calls = []
        status = run(lambda: self.suite, list(arguments))
        return status, self.calls

    def _ran(self, name):
        self.calls.append(name)
        if name == "top":
            self.faults.append("It hung.")
        if name == self.stop:
            raise self.how

    def _recorded(self, name, measure):
        def measure_and_record(*arguments, problem=""):
            self._ran(problem or name)
            table = measure(*arguments)
            return table.assign(problem=problem) if problem else table

        return measure_and_record


NOTE = "Still measuring"


@pytest.fixture
def bench(undrawn: None):
    return Bench()


@pytest.mark.slow_cases("study-the studies")
@pytest.mark.parametrize(
    ("part", "to_come"),
    [("ball", "all comparisons, the studies"), ("study", "the studies")],
)
def test_a_build_that_goes_on_has_a_page_that_says_what_is_to_come(bench, tmp_path, part, to_come):
    bench.stop = part
    assert bench("build", "--out", str(tmp_path))[0] == 2
    page = (tmp_path / "results" / "index.html").read_text()
    assert f"{NOTE}.</strong> To come: {to_come}." in page


@pytest.mark.slow(beside="test_a_build_that_goes_on_has_a_page_that_says_what_is_to_come")
def test_the_page_has_the_claims_that_finish_soon_and_is_whole_at_the_end(
    bench, tmp_path, capsys, monkeypatch
):
    def finishing(studies, cache):
        assert [study.name for study in studies] == ["V1", "V3"]
        for study in studies:
            cache.keep(study.name, study.measure(print), 0.1)
            yield study, 0.1

    monkeypatch.setattr("reports.build.first_look.study_in_workers", finishing)
    monkeypatch.setattr("reports.build.first_look.PATIENCE_SECONDS", 0.0)
    _, calls = bench("build", "--out", str(tmp_path))
    assert calls[:4] == ["V1", "V1", "V3", "ball"]  # V3 was too late for the first page
    lines = [line for line in capsys.readouterr().out.splitlines() if "The page is" in line]
    assert [line.count(",") for line in lines] == [2, 1, 0, 0]
    assert lines[-1].startswith("The page is")
    assert NOTE not in (tmp_path / "results" / "index.html").read_text()


@pytest.mark.slow_cases("options1")
@pytest.mark.parametrize("options", [["--quick"], ["--claims", "V1"]])
def test_a_short_build_measures_each_claim_once(bench, tmp_path, options):
    _, calls = bench("build", "--out", str(tmp_path), *options)
    assert calls.count("V1") == 1


def test_what_was_drawn_is_not_drawn_again():
    class Figure:
        name = "orbit"

    drawn = []

    def draw_all(function, jobs):
        drawn.extend(table for _, table in jobs)
        return [function(job) for job in jobs]

    draw = remembering(draw_all)
    left, right = pd.DataFrame({"x": [1]}), pd.DataFrame({"x": [2]})
    first = draw(lambda job: object(), [(Figure, left)])
    second = draw(lambda job: object(), [(Figure, left), (Figure, right)])
    assert second[0] is first[0] and second[1] is not first[0]
    assert len(drawn) == 2


HOLD = """
import sys
from filelock import FileLock
with FileLock(sys.argv[1]):
    print("held", flush=True)
    sys.stdin.read()
"""
NO_COMPARISON = Comparison(None, None)
PARTS = ["V1", "V3", "ball", "top", "cost", "sky", "study"]


@pytest.fixture
def fast_bench(bench: Bench, monkeypatch: pytest.MonkeyPatch):
    """A bench without first pages, with empty LaTeX and Markdown tables and a constant digest of
    the sources."""
    monkeypatch.setattr("reports.build.build.first_look", lambda suite: ([], NO_COMPARISON))
    monkeypatch.setattr("reports.tables.writing.as_latex", lambda *_: "")
    monkeypatch.setattr("reports.tables.writing.as_markdown", lambda table: "")
    monkeypatch.setattr(cache, "digest_of_sources", lambda code: "as they are")
    return bench


def stopped(bench, part, *arguments):
    """Run the command and end it in this part."""
    bench.stop = part
    assert bench(*arguments)[0] == 2
    bench.stop, bench.faults[:] = "", []


def stored_results(out):
    """Paths of the cached results of all stopped builds in this folder."""
    if not (out / CACHE_FOLDER).exists():
        return []
    return list((out / CACHE_FOLDER).rglob("*.json"))


@pytest.mark.slow_cases(but=["top"])
@pytest.mark.parametrize("stopped_part", ["V1", "top", "study"])
def test_a_build_that_was_stopped_resumes_with_what_it_was_measuring(
    fast_bench, tmp_path, capsys, stopped_part
):
    out, count = ["--out", str(tmp_path)], PARTS.index(stopped_part)
    stopped(fast_bench, stopped_part, *out)
    assert len(stored_results(tmp_path)) == count
    fast_bench.date = "2026-01-01 00:20 UTC"
    capsys.readouterr()
    status, calls = fast_bench(*out)
    assert calls == PARTS[count:]
    printed = capsys.readouterr().out
    phrase = (
        f"{count} results of the build of 2026-01-01 00:00 UTC, which was stopped; --anew starts"
    )
    # "top" reports a fault.
    assert (phrase in printed) == (count > 0) and status == (stopped_part != "study")
    assert not (tmp_path / CACHE_FOLDER).exists()
    assert fast_bench(*out)[1] == PARTS
    assert "Resuming" not in capsys.readouterr().out


def test_an_interrupted_build_says_that_it_can_be_resumed(fast_bench, tmp_path, capsys):
    fast_bench.stop, fast_bench.how = "ball", KeyboardInterrupt
    assert fast_bench("--out", str(tmp_path)) == (130, PARTS[:3])
    errors = capsys.readouterr().err
    assert "Finished results are kept: the same command resumes the build.\nInterrupted" in errors
    assert len(stored_results(tmp_path)) == 2


@pytest.mark.slow(beside="test_a_build_that_was_stopped_resumes_with_what_it_was_measuring")
def test_a_resumed_build_is_the_same_report_and_says_which_run_measured_what(fast_bench, tmp_path):
    at_once, in_two = tmp_path / "whole", tmp_path / "two"
    fast_bench("--out", str(at_once))
    stopped(fast_bench, "top", "--out", str(in_two))
    fast_bench.date = "2026-01-01 00:20 UTC"
    fast_bench("--out", str(in_two))
    for name in ("claims", "work_precision", "cost", "sky_and_model", "study"):
        left, right = (pd.read_csv(folder / f"{name}.csv") for folder in (at_once, in_two))
        columns = [column for column in left if column not in ORIGIN_COLUMNS]
        pd.testing.assert_frame_equal(left[columns], right[columns], check_exact=True)
    phrase = "3 results of the build of 2026-01-01 00:00 UTC, which was stopped"
    origins = json.loads((in_two / "provenance.json").read_text())
    assert all(phrase in origin["resumed"] for origin in origins.values())
    assert phrase in (in_two / "results" / "provenance.html").read_text()
    assert set(pd.read_csv(in_two / "claims.csv")["date"]) == {"2026-01-01 00:00 UTC"}


@pytest.mark.slow(beside="test_a_change_of_options_commit_or_sources_makes_another_build")
def test_anew_starts_over_and_another_setting_leaves_what_was_kept(fast_bench, tmp_path):
    out = ["--out", str(tmp_path)]
    stopped(fast_bench, "study", *out)
    assert fast_bench("--claims", "V1", *out)[1] == ["V1", *PARTS[2:]]
    assert len(stored_results(tmp_path)) == 6
    assert fast_bench("--anew", *out)[1] == PARTS


def test_a_change_of_options_commit_or_sources_makes_another_build(
    fast_bench, tmp_path, monkeypatch
):
    def state(**options):
        return open_cache(fast_bench.suite, Options(out=tmp_path, **options)).folder.name

    folders = [state(), state(quick=True), state(claims=("V1",))]
    fast_bench.date = "2027-01-01 00:00 UTC"
    assert state() == state(command="python -m reports build") == folders[0]
    fast_bench.commit = "abd"
    folders += [state()]
    monkeypatch.setattr(cache, "digest_of_sources", lambda code: "other")
    folders += [state()]
    assert len(set(folders)) == len(folders) == 5


def test_nothing_is_kept_of_a_build_with_external_integrators(fast_bench, tmp_path):
    assert (
        open_cache(fast_bench.suite, Options(out=tmp_path, contenders=("mine:A",))).folder is None
    )


@pytest.mark.slow_cases("False")
@pytest.mark.parametrize("changes", [False, True])
def test_an_edit_during_a_build_is_reported_and_no_result_is_kept_from_then_on(
    fast_bench, tmp_path, monkeypatch, capsys, changes
):
    # The digest is read at the start and at each result, and changes at the third result.
    states = iter("aaa" + ("b" if changes else "a") * 1000)
    monkeypatch.setattr(cache, "digest_of_sources", lambda code: next(states))
    stopped(fast_bench, "study", "--out", str(tmp_path))
    assert len(stored_results(tmp_path)) == (2 if changes else 6)
    message = "ball is not kept for a build that is resumed: the sources changed since the build"
    assert (message in capsys.readouterr().err) == changes


@contextmanager
def another_build(out):
    """A context in which another process holds the lock of a build there."""
    out.mkdir(exist_ok=True)
    command = [sys.executable, "-c", HOLD, str(out / LOCK_FILE)]
    with subprocess.Popen(command, stdin=-1, stdout=-1, text=True) as process:
        assert process.stdout is not None and process.stdout.readline() == "held\n"
        yield
        process.kill()


@pytest.mark.slow(beside="test_an_unwritable_output_folder_is_reported_in_one_line")
def test_two_builds_in_one_folder_are_refused_until_the_first_is_gone(fast_bench, tmp_path, capsys):
    with another_build(tmp_path):
        assert fast_bench("--out", str(tmp_path)) == (2, [])
        assert capsys.readouterr().err == (
            f"Another build is at work in {tmp_path}; wait until it ends, or choose another folder "
            "with --out.\n"
        )
        assert fast_bench("verify", "--out", str(tmp_path))[1] == ["V1", "V3"]
    assert fast_bench("--out", str(tmp_path))[1] == PARTS


def test_work_precision_takes_one_problem_at_a_time_and_knows_their_names():
    assert len(set(problems())) == len(problems()) > len(problems(quick=True)) > 3
    with pytest.raises(ValueError, match="there is no problem 'ball' to compare on; known: "):
        work_precision(quick=True, problem="ball")


def test_an_unwritable_output_folder_is_reported_in_one_line(fast_bench, tmp_path, capsys):
    # refuses even root, as if the folder were another user's
    (tmp_path / LOCK_FILE).mkdir()
    assert fast_bench("--out", str(tmp_path)) == (2, [])
    errors = capsys.readouterr().err
    assert "--out expects a folder to write in; " in errors and len(errors.splitlines()) == 1


@pytest.mark.parametrize("command", ["build", "verify", "compare"])
def test_nothing_is_measured_for_a_folder_that_is_not_ours(
    fast_bench, tmp_path, monkeypatch, capsys, command
):
    def refused(dir):
        raise PermissionError(13, "Permission denied", str(dir))

    monkeypatch.setattr("tempfile.TemporaryFile", refused)
    assert fast_bench(command, "--out", str(tmp_path)) == (2, [])
    errors = capsys.readouterr().err
    assert "--out expects a folder to write in; " in errors and "Permission denied" in errors
