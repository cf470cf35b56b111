"""Studies with sections of their own: shown, stored, resumed, and 'not run' where they were not."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from benchmarks.studies.round_off import COLUMNS
from reports.contents import SECTIONS
from reports.figures.style.layout import NoData
from reports.results.section import LongForm
from reports.studies.costs import scaling_table
from reports.studies.engines import engine_versions_table
from reports.studies.long_runs import free_body_drift_table, round_off_table
from reports.tables.number_format import TIMES
from reports.tables.study_table import readable_table
from tests.suite.reports.figure_frames import lay_out
from tests.suite.reports.small_reports import suite_of
from tests.suite.reports.study_frames import FRAMES, scaling, spins, versions, walks

STUDIES = [section for section in SECTIONS if section.name in FRAMES]
LONG = walks(1e6, commit="feedfacecafe", drift=1.0, runs=4)


@dataclass
class Run:
    """A part of a study that leaves a file, or raises."""

    folder: Path
    title: str
    broken: bool = False

    def is_complete(self):
        return (self.folder / self.title).exists()

    def run(self, report):
        if self.broken:
            raise ValueError("no more disk")
        report("half way")
        self.folder.mkdir(parents=True, exist_ok=True)
        (self.folder / self.title).touch()


@pytest.fixture
def suite_with():
    """The real studies, or the first few, with small frames.

    `long` is what is stored of the long Brouwer study, which is the first of them.
    """

    def make(long=(), count=None, runs=None, **fields):
        first, *later = [replace(study, measure=FRAMES[study.name]) for study in STUDIES[:count]]
        stored = pd.DataFrame(long, columns=list(COLUMNS))
        form = LongForm(runs or first.long_form.runs, lambda folder, report: stored)
        later = [replace(study, long_form=None) for study in later]
        return suite_of(sections=(replace(first, long_form=form, **fields), *later))

    return make


def page():
    return Path("out/results/studies.html").read_text(encoding="utf-8")


@pytest.mark.slow(beside="test_a_long_study_that_was_not_run_says_how_to")
def test_a_build_shows_the_studies_with_tables_and_pictures(suite_with, ask):
    assert ask("build", suite_with(walks(1e6, commit="feedfacecafe", drift=1.0))).status == 0
    for text in (*(study.title for study in STUDIES), "feedfacecafe", "2026-01-01", "drifts"):
        assert text in page()
    assert "make studies" not in page()
    for name in FRAMES:
        assert len(pd.read_csv(f"out/{name}.csv")) > 0
        assert Path(f"out/tables/{name}.md").stat().st_size > 0
    for name in ("brouwer", "scaling", "scaling-share"):
        assert Path(f"out/figures/{name}.svg").stat().st_size > 0
    commits = pd.read_csv("out/brouwer.csv")["commit"]
    assert set(commits) == {"0123456789ab+dirty", "feedfacecafe"}


@pytest.mark.usefixtures("undrawn")
def test_a_long_study_that_was_not_run_says_how_to(suite_with, ask):
    assert ask("build", suite_with(count=2)).status == 0
    assert "Short version: make studies runs the long one." in page()


@pytest.mark.slow(beside="test_a_run_that_raises_leaves_the_others")
@pytest.mark.usefixtures("undrawn")
@pytest.mark.parametrize("long", [(), LONG], ids=["nothing stored", "stored"])
@pytest.mark.parametrize("absent", ["", "Install the lamp."])
def test_a_study_that_raises_or_lacks_its_engine_is_named_and_its_stored_rows_are_shown(
    suite_with, ask, long, absent
):
    def broken(quick, report):
        raise OSError("the lamp went out")

    completed = ask("build", suite_with(long, count=2, measure=broken, absent=lambda: absent))
    reason = absent or "not run (OSError: the lamp went out)."
    assert completed.status == (not absent)
    assert f"Round-off: {'will not run. ' if absent else ''}{reason}" in completed.err
    assert (not absent) or completed.err.index(absent) < completed.err.index("[1/")
    assert ("at commit feedfacecafe" in page()) == ('id="brouwer"' in page()) == bool(long)
    assert absent in page() and (reason in page().partition("## Not run here")[2]) == (not long)


def test_studies_runs_what_is_not_there_yet(suite_with, ask):
    suite = suite_with(runs=lambda folder, report: [Run(folder, "one"), Run(folder, "two")])
    Run(Path("out/studies"), "one").run(print)
    completed = ask("studies", suite)
    assert completed.status == 0 and "Round-off: 1 of 2 runs are complete." in completed.out
    assert "[1/1] brouwer two: " in completed.err
    completed = ask("studies", suite)
    assert (completed.status, completed.err) == (0, "")


def test_a_run_that_raises_leaves_the_others(suite_with, ask):
    def runs(folder, report):
        return [Run(folder, "one", broken=True), Run(folder, "two")]

    completed = ask("studies", suite_with(runs=runs))
    assert completed.status == 1 and "one: not run (ValueError: no more disk)." in completed.err
    assert Path("out/studies/two").exists()


NUMBERS = ("measured", "error", "share", "seconds_per_orbit", "energy_error")


@pytest.mark.slow_cases("free-spin")
@pytest.mark.parametrize("study", STUDIES, ids=lambda study: study.name)
def test_the_figures_draw_and_say_when_there_is_nothing(study):
    table = FRAMES[study.name](True, print)
    failed = table.assign(**dict.fromkeys(NUMBERS, np.nan))
    for figure in study.figures:
        lay_out(figure, table)
        for unusable in (failed, table.head(0), pd.DataFrame()):
            with pytest.raises(NoData):
                lay_out(figure, unusable)


@pytest.mark.parametrize(("drift", "verdict"), [(0.0, "no drift seen"), (1.0, "drifts")])
def test_the_table_of_round_off_says_whether_it_drifts(drift, verdict):
    table = round_off_table(pd.DataFrame(walks(drift=drift), columns=list(COLUMNS)))[0]
    assert set(table["verdict"]) == {verdict} and set(table["runs"]) == {"16"}
    assert table["exponent"].str.contains("±").all()


def test_the_table_of_bodies_says_what_was_reached_and_how_far_from_galvi():
    frame, relative = scaling(True, print), "relative to galvi degree 8, Gauss 8"
    table = scaling_table(frame)[0]
    assert list(table["bodies"].drop_duplicates()) == ["3", "10", "100"]
    peer = table[table["contender"] == "REBOUND IAS15"]
    assert peer["time for an orbit"].iloc[0] == "not reached"
    assert peer[relative].iloc[1].startswith("100")
    assert set(table["share of the limit"]) == {"0.50", ""}
    of_100 = frame.query("bodies == 100")
    of_100 = of_100.assign(
        contender=of_100["contender"] + ", 10 heavy",
        seconds_per_orbit=0.3 * of_100["seconds_per_orbit"],
    )
    combined_table = scaling_table(pd.concat([frame, of_100]))[0]
    assert list(combined_table[relative])[-2:] == [f"1.0{TIMES}", f"100{TIMES}"]


def test_numbers_of_a_study_have_the_digits_that_they_need():
    numbers = pd.DataFrame({"n": [0.999, 1e-4, 200000.0, np.nan], "ok": True, "empty": ""})
    table, kinds = readable_table(numbers, {"n": "number", "ok": "well", "empty": "note"})
    assert list(table["number"]) == ["0.999", "1·10⁻⁴", "200000", ""] and "note" not in table
    assert set(table["well"]) == {"yes"} and kinds == {"number": "number"}


def test_versions_of_an_engine_are_told_by_their_orders():
    rows = versions(True, print)
    table = engine_versions_table(rows)[0]
    numbers = ("3.6.0", "3.10.0", "4.0.1", "9.9.9")
    assert list(table["engine"]) == [f"mujoco {name}" for name in numbers]
    assert list(table["order, ball"]) == ["2.00", "2.00", "4.00", ""]
    assert list(table["attitude error, free"])[:2] == ["1.56·10⁻⁵"] * 2
    assert list(table["status"]) == ["", "", "", "No such version."]
    later = pd.concat([rows, rows.assign(engine="mujoco 9.9.9")], ignore_index=True)
    assert "status" not in engine_versions_table(later)[0]
    assert len(engine_versions_table(pd.concat([rows, rows]))[0]) == len(table)


def test_long_spins_are_told_with_the_mark_that_they_came_to():
    table, kinds = free_body_drift_table(spins(True, print))
    lines = table.drop(columns="contender").rename(columns={"growth exponent (turns)": "growth"})
    steady, drifting, burst, absent = lines.to_dict("records")
    common = {"turns": "1000", "attitude": "1.0·10⁻⁹", "energy, relative": "\u22121.0·10⁻⁹"}
    assert steady["growth"] == "round-off"
    assert drifting.items() >= {**common, "growth": "1.0"}.items()
    assert burst.items() >= {"turns": "200", "status": "It burst.", "attitude": ""}.items()
    assert absent.items() >= {"status": "Install it.", "energy, relative": ""}.items()
    assert "commit" not in table and set(kinds) < set(table.columns)


def test_the_studies_have_names_of_their_own():
    names = [figure.name for study in STUDIES for figure in study.figures]
    assert len(set(names)) == len(names)
