"""The targets as people read them: in the terminal, in the tables and on the page."""

from __future__ import annotations

import io

import pandas as pd
import pytest
from rich.console import Console

from benchmarks.work_precision.targets import ORBITS, TARGETS, TURNS, Target
from benchmarks.work_precision.targets_met import targets_met
from reports.build.terminal import show_targets
from reports.cli.commands import run
from reports.contents import load
from reports.tables.comparison_tables import (
    ERRORS,
    OF_ATTITUDES,
    SMALLEST,
    matched,
    readable_ratios,
    smallest,
)
from reports.tables.number_format import TIMES
from reports.tables.targets_table import ALONE, QUICK, readable_targets, summary

KEPLER = "kepler e=0.6"
PLANTED = (
    Target(KEPLER, ("SciPy DOP853",), 1e-4, 5.0),  # a peer that is faster: missed
    Target(KEPLER, ("SciPy DOP853",), 1e-8, 5.0),  # a peer that does not get there
    Target(KEPLER, ("SciPy DOP853",), None, None),  # its own error, which galvi reaches
    Target(KEPLER, ("Leapfrog",), 1e-4, 5.0),  # failed
    Target(KEPLER, ("Taylor",), 1e-4, 5.0),  # the truth: nothing to compare with
)


@pytest.fixture
def met(make_suite) -> pd.DataFrame:
    return targets_met(make_suite().work_precision(True, print), PLANTED)


def test_each_verdict_stands_beside_what_was_measured(met):
    text, kinds = readable_targets(met)
    assert list(text["verdict"]) == ["missed", "not reached", "met", "not run", "not run"]
    assert list(text["measured"])[1:] == [
        ALONE, f"0.159{TIMES}", "not run", "not run",
    ]  # fmt: skip
    assert list(text["target"])[1:3] == [f"at least 5.0{TIMES}", "reached"]
    assert set(kinds) <= set(text.columns) and "remark" not in text
    noted = readable_targets(met.assign(remark="A bound.", note="It changed.", target=1.25))[0]
    alone = readable_targets(met.assign(ratio="not reached", verdict="met"))[0]
    assert set(alone["measured"]) == {ALONE}
    assert set(noted["remark"]) == {"A bound. It changed."}
    assert set(noted["target"]) == {f"at least 1.25{TIMES}"}
    assert summary(met).startswith("5 targets: 2 not run, 1 missed, 1 not reached, 1 met. Source:")
    assert summary(met.assign(source=["a", "b", "b", "a", "a"])).endswith("Sources: a; b.")


def test_the_terminal_shows_them_and_nothing_when_there_are_none(met):
    console = Console(width=120, record=True, file=io.StringIO())
    show_targets(met.assign(remark=["", "", "A bound.", "", ""]), True, console)
    printed = console.export_text()
    assert printed.count("missed") == 2 and printed.count("not reached") == 2
    assert "SciPy DOP853, own error: A bound." in printed
    assert QUICK.split(",")[0] in " ".join(printed.split())
    empty = Console(width=120, record=True, file=io.StringIO())
    show_targets(met.head(0), False, empty)
    assert empty.export_text() == ""


def test_one_command_prints_and_writes_them(make_suite, tmp_path, capsys):
    suite = make_suite(targets=PLANTED)
    assert run(lambda: suite, ["compare", "--out", str(tmp_path)]) == 0
    printed = capsys.readouterr().out
    assert "5 targets: 2 not run, 1 missed, 1 not reached, 1 met." in printed
    assert QUICK[:30] not in printed
    table = pd.read_csv(tmp_path / "tables" / "targets.csv")
    assert list(table["verdict"]) == ["missed", "not reached", "met", "not run", "not run"]
    assert len(pd.read_csv(tmp_path / "tables" / "smallest.csv")) == 3


@pytest.mark.usefixtures("undrawn")
def test_the_page_has_a_section_of_them_when_there_are_any(make_suite, tmp_path):
    suite = make_suite(targets=PLANTED)
    run(lambda: suite, ["build", "--quick", "--out", str(tmp_path)])
    page = (tmp_path / "comparisons.html").read_text(encoding="utf-8")
    place = page[page.index('<h2 id="targets">Targets</h2>') : page.index('<h2 id="cost">')]
    assert "<td>missed</td>" in place and '<td class="absent">not run</td>' in place
    assert '<a href="#targets">' in page and "shorter than those" in place
    assert "1.0·10⁻⁵" in place
    run(make_suite, ["build", "--quick", "--out", str(tmp_path)])
    assert "targets" not in (tmp_path / "comparisons.html").read_text(encoding="utf-8")


def test_each_contender_s_own_smallest_error_is_the_last_column(make_suite):
    runs = make_suite().work_precision(True, print)
    table = readable_ratios(matched(runs), smallest(runs), KEPLER).set_index("contender")
    assert table.columns[-1] == SMALLEST
    assert table.loc["SciPy DOP853", SMALLEST].startswith("1.0·10⁻⁵: 0.16")
    assert table.loc["galvi, best", SMALLEST].startswith("1.0·10⁻⁹: 20.0")
    assert table.loc["Taylor", SMALLEST] == ""
    ends = smallest(runs.assign(truth_error=2e-6))
    bound = readable_ratios(matched(runs), ends, KEPLER).set_index("contender")[SMALLEST]
    assert bound["SciPy DOP853"].startswith("≤ 1.0·10⁻⁵: ")
    assert table.loc["Taylor", "10⁻⁶"].startswith("reference: ")
    assert "reference" not in "".join(table.drop(index="Taylor").to_numpy().ravel())


def test_the_report_has_a_column_for_every_error_of_the_targets():
    assert load().targets == TARGETS
    for source, columns in ((ORBITS, ERRORS), (TURNS, OF_ATTITUDES)):
        asked = {target.error for target in TARGETS if target.source == source}
        assert len(asked) > 1 and asked - {None} <= set(columns)
    assert {1e-4, 1e-6, 1e-8, 1e-10} <= set(ERRORS)
