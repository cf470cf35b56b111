"""[tool.galvi] in a project's pyproject.toml: defaults of the command, which the command line
overrides."""

from __future__ import annotations

import re
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import pandas as pd
import pytest

from reports.cli.commands import run
from reports.cli.project import TYPE_OF_KEY, read_table
from reports.results.options import OUT
from tests.suite.reports.small_reports import ROW, claim, suite_of

ROOT = Path(__file__).parents[3]
VALUES = {
    "contenders": '["mine:Leapfrog"]',
    "problems": '["mine:spring"]',
    "claims": '["V1", "V3"]',
    "require": '["rebound"]',
    "timeout": "20",
    "fail-under": "50",
    "slower": "20.0",
    "less-accurate": "5",
    "quick": "true",
    "out": '"results"',
}


@pytest.fixture
def project(tmp_path, monkeypatch):
    """A function that writes the table [tool.galvi] of a project in the current folder."""
    monkeypatch.chdir(tmp_path)

    def write(*keys, folder=tmp_path, **values):
        table = {key: VALUES[key] for key in keys} | values
        lines = ["[project]", 'name = "mine"', "[tool.galvi]"]
        lines += [f"{key} = {value}" for key, value in table.items()]
        (folder / "pyproject.toml").write_text("\n".join(lines))

    return write


@pytest.fixture
def suite(monkeypatch):
    """(a suite of three claims, of which the second fails, and of contenders'; the requests)."""
    requests = []

    @contextmanager
    def joined(suite, contenders, timeout):
        requests.append((list(contenders), timeout))
        contender_claims = [claim(f"A-{path.partition(':')[2].lower()}") for path in contenders]
        yield replace(suite, claims=(*suite.claims, *contender_claims))

    monkeypatch.setattr("reports.results.own_problems.with_contenders", joined)
    wrong = claim("V2", (replace(ROW, verdict="contradicted"),))
    suite = suite_of(claim("V1"), wrong, claim("V3"), engines=lambda: {"rebound": "It is absent."})
    return suite, requests


def checked_ids(folder=OUT):
    return list(pd.read_csv(Path(folder) / "claims.csv")["id"].unique())


TABLED = ("contenders", "timeout", "out")
MINE = ["mine:Leapfrog"]


@pytest.mark.parametrize(
    ("keys", "options", "status", "requests", "ids", "folder"),
    [
        (TABLED, "", 0, [(MINE, 20.0)], ["A-leapfrog"], "results"),
        (  # the command line wins
            TABLED,
            "--contender other:Verlet --timeout 7 --claims V1 --out here",
            0,
            [(["other:Verlet"], 7.0)],
            ["V1"],
            "here",
        ),
        (  # without contenders all claims are checked
            ("quick",),
            "--contender mine:Leapfrog",
            1,
            [(MINE, None)],
            ["V1", "V2", "V3", "A-leapfrog"],
            OUT,
        ),
        (
            ("quick",),
            "--contender mine:Leapfrog --claims contenders,V3",
            0,
            [(MINE, None)],
            ["V3", "A-leapfrog"],
            OUT,
        ),
        (("claims",), "", 0, [([], None)], ["V1", "V3"], OUT),
        (("claims", "require"), "", 1, [([], None)], ["V1", "V3"], OUT),
    ],
)
def test_verify_takes_what_the_table_says_where_the_command_line_does_not(
    project, suite, keys, options, status, requests, ids, folder
):
    project(*keys)
    assert run(lambda: suite[0], ["verify", *options.split()]) == status
    assert suite[1] == requests and checked_ids(folder) == ids
    assert OUT.exists() == (folder == OUT)


def test_the_share_that_is_enough_is_of_the_table(project, suite, capsys):
    project("fail-under")
    assert run(lambda: suite[0], ["verify"]) == 0
    sentence = "66.67 % of the checks came out as expected; --fail-under asks for 50 %."
    text = (OUT / "verify.md").read_text()
    assert (
        text.startswith("## verify: passed\n")
        and sentence in text
        and sentence in capsys.readouterr().out
    )
    assert run(lambda: suite[0], ["verify", "--fail-under", "70"]) == 1


def test_without_a_command_the_report_is_built_with_these(project, suite, monkeypatch):
    project("contenders", "require", "timeout", "quick")
    options = []
    monkeypatch.setattr(
        "reports.build.build.build", lambda suite, *arguments: options.append(arguments[0])
    )
    assert run(lambda: suite[0], []) == run(lambda: suite[0], ["build"]) == 2  # no report came
    assert suite[1] == [(MINE, 20.0)] * 2
    for build_options in options:
        assert (
            build_options.quick
            and build_options.require == ("rebound",)
            and len(build_options.claims) == 4
        )


def test_track_compares_these_contenders_where_a_revision_is_named_else_shows_the_history(
    project, suite, monkeypatch
):
    comparisons = []

    def track(out, provenance, against, only, quick, isolate, contenders, timeout, thresholds):
        slower, less_accurate = thresholds.slower, thresholds.less_accurate
        comparisons.append(
            (against, contenders, timeout, round(slower, 6), round(less_accurate, 6))
        )
        return 0

    monkeypatch.setattr("reports.cli.track.track_command", track)
    monkeypatch.setattr("reports.cli.assess._show_history", lambda suite, options: 0)
    project(*VALUES)
    assert run(lambda: suite[0], ["track"]) == 0 and comparisons == []  # the history
    assert run(lambda: suite[0], ["track", "--against", "v1", "--slower", "30"]) == 0
    project("contenders")
    assert run(lambda: suite[0], ["track"]) == 0
    assert run(lambda: suite[0], ["track", "--contender", "mine:Leapfrog"]) == 2
    assert comparisons == [("v1", ["mine:Leapfrog"], 20.0, 0.3, 0.05)]


def test_the_table_of_the_repository_counts_in_its_folders(project, suite, tmp_path, monkeypatch):
    project("claims", "out")
    (tmp_path / ".git").mkdir()
    below = tmp_path / "a" / "b"
    below.mkdir(parents=True)
    monkeypatch.chdir(below)
    assert run(lambda: suite[0], ["verify"]) == 0
    assert checked_ids(str(tmp_path / "results")) == ["V1", "V3"]
    project("out", folder=below, claims='["V1"]')
    assert run(lambda: suite[0], ["verify"]) == 0
    assert checked_ids("results") == ["V1"]


def test_results_of_compare_and_judge_lie_below_the_folder_of_the_table(project, suite):
    project("out")
    arguments = ["compare", "--only", "none"]
    assert run(lambda: suite[0], arguments) == 2  # no such problem
    assert run(lambda: suite[0], ["judge", "nothing.bin"]) == 2
    assert [path.name for path in Path("results").iterdir()] == ["judge"]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("[tool.galvi]\ncontender = ['a:B']", "has no key 'contender'; did you mean 'contenders'?"),
        ("[tool.galvi]\ncontenders = 'a:B'", "contenders expects a list of one or more texts"),
        ("[tool.galvi]\nclaims = []", "claims expects a list of one or more texts; received []."),
        ("[tool.galvi]\ntimeout = true", "timeout expects a number; received True."),
        ("[tool.galvi]\nquick = 1", "quick expects true or false; received 1."),
        ("[tool]\ngalvi = 3", "expects a table; received 3."),
        ("[tool.galvi\n", "pyproject.toml cannot be read: "),
        ("\udcff", "pyproject.toml cannot be read: "),
        *(
            (f"[tool.galvi]\n{key} = {value}", f"[tool.galvi]: invalid value for '--{key}': Input ")
            for key, value in (("timeout", -1), ("timeout", "inf"), ("fail-under", 101))
        ),
    ],
)
def test_a_table_that_is_wrong_is_refused_in_a_sentence(project, suite, capsys, text, message):
    Path("pyproject.toml").write_text(text, errors="surrogateescape")
    assert run(lambda: suite[0], ["verify"]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert message in line
    assert run(lambda: suite[0], ["--help"]) == run(lambda: suite[0], ["--version"]) == 0


def test_every_key_has_a_value_here_and_stands_on_the_page(tmp_path):
    assert set(VALUES) == set(TYPE_OF_KEY)
    page = (ROOT / "docs" / "suite.md").read_text()
    (table,) = re.findall(r"^```toml\n(\[tool\.galvi\]\n.*?)^```$", page, re.M | re.S)
    (tmp_path / "pyproject.toml").write_text(re.sub("^# ", "", table, flags=re.M))
    assert set(read_table(tmp_path / "pyproject.toml")) == set(TYPE_OF_KEY)
