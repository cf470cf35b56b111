"""Studies with sections of their own: shown, stored, resumed, and 'not run' where they were not."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from benchmarks.studies.round_off import COLUMNS
from reports.cli.commands import run
from reports.contents import SECTIONS
from reports.figures.style.layout import NoData
from reports.results.section import LongForm
from reports.studies.costs import NUMBER_OF_BODIES, scaling_table
from reports.studies.engines import engine_versions_table
from reports.studies.long_runs import ROUND_OFF, free_body_drift_table, round_off_table
from reports.tables.number_format import TIMES
from reports.tables.study_table import readable_table
from tests.suite.reports.figure_frames import lay_out
from tests.suite.reports.study_frames import FRAMES, scaling, spins, versions, walks

STUDIES = [section for section in SECTIONS if section.name in FRAMES]


@dataclass
class Run:
    """One that leaves a file, or raises."""

    folder: Path
    title: str
    broken: bool = False

    def done(self) -> bool:
        return (self.folder / self.title).exists()

    def run(self, report: Callable[[str], None]) -> None:
        if self.broken:
            raise ValueError("no more disk")
        report("half way")
        self.folder.mkdir(parents=True, exist_ok=True)
        (self.folder / self.title).touch()


@pytest.fixture
def suite_with(make_suite):
    """The real studies, or the first few, with small frames.

    `long` is what is stored of the long Brouwer study, which is the first of them.
    """

    def make(long: list[dict[str, object]] = [], few: int | None = None, runs=None, **fields):  # noqa: B006
        first, *rest = [replace(one, measure=FRAMES[one.name]) for one in STUDIES[:few]]
        stored = pd.DataFrame(long, columns=list(COLUMNS))
        form = LongForm(runs or first.long_form.runs, lambda folder, report: stored)
        rest = [replace(one, long_form=None) for one in rest]
        return make_suite(sections=(replace(first, long_form=form, **fields), *rest))

    return make


@pytest.mark.slow(beside="test_a_long_study_that_was_not_run_says_how_to")
def test_a_build_shows_the_studies_with_tables_and_pictures(suite_with, tmp_path):
    long = walks(1e6, commit="feedfacecafe", drift=1.0)
    assert run(lambda: suite_with(long), ["build", "--out", str(tmp_path)]) == 0
    page = (tmp_path / "results" / "studies.html").read_text(encoding="utf-8")
    for text in (*(study.title for study in STUDIES), "feedfacecafe", "2026-01-01", "drifts"):
        assert text in page
    assert "make studies" not in page
    for name in FRAMES:
        assert len(pd.read_csv(tmp_path / f"{name}.csv")) > 0
        assert (tmp_path / "tables" / f"{name}.md").stat().st_size > 0
    for name in ("brouwer", "scaling", "scaling-share"):
        assert (tmp_path / "figures" / f"{name}.svg").stat().st_size > 0
    rows = pd.read_csv(tmp_path / "brouwer.csv")
    assert set(rows["commit"]) == {"0123456789ab+dirty", "feedfacecafe"}


@pytest.mark.usefixtures("undrawn")
def test_a_long_study_that_was_not_run_says_how_to(suite_with, tmp_path):
    assert run(lambda: suite_with(few=2), ["build", "--out", str(tmp_path)]) == 0
    page = (tmp_path / "results" / "studies.html").read_text(encoding="utf-8")
    assert "Short version: make studies runs the long one." in page


@pytest.mark.slow(beside="test_a_run_that_raises_leaves_the_others")
@pytest.mark.usefixtures("undrawn")
def test_a_study_that_raises_is_named_and_its_stored_rows_are_shown(suite_with, tmp_path, capsys):
    def broken(quick, report):
        raise OSError("the lamp went out")

    for long, shown in (([], False), (walks(1e6, "feedfacecafe", runs=4), True)):
        suite = suite_with(long, few=2, measure=broken)
        assert run(lambda suite=suite: suite, ["build", "--out", str(tmp_path)]) == 1
        assert "Round-off: not run (OSError: the lamp went out)." in capsys.readouterr().err
        page = (tmp_path / "results" / "studies.html").read_text(encoding="utf-8")
        assert ("at commit feedfacecafe" in page) is shown
        assert ('id="brouwer"' in page) is shown
        left_out = page.partition("## Not run here")[2]
        assert ("Round-off: not run (OSError: the lamp went out)." in left_out) is not shown


@pytest.mark.slow(beside="test_a_long_study_that_was_not_run_says_how_to")
@pytest.mark.usefixtures("undrawn")
def test_a_study_without_its_engine_is_named_and_no_failure(suite_with, tmp_path, capsys):
    def broken(quick, report):
        raise AssertionError("it was run without its engine")

    for long, shown in (([], False), (walks(1e6, "feedfacecafe", runs=4), True)):
        suite = suite_with(long, few=2, measure=broken, absent=lambda: "Install the lamp.")
        assert run(lambda suite=suite: suite, ["build", "--out", str(tmp_path)]) == 0
        said = capsys.readouterr().err
        assert said.index("Round-off: will not run. Install the lamp.") < said.index("[1/")
        page = (tmp_path / "results" / "studies.html").read_text(encoding="utf-8")
        assert "Install the lamp." in page
        assert ("at commit feedfacecafe" in page) is shown


def test_studies_runs_what_is_not_there_yet(suite_with, tmp_path, capsys):
    def runs(folder, report):
        return [Run(folder, "one"), Run(folder, "two")]

    (tmp_path / "studies").mkdir()
    (tmp_path / "studies" / "one").touch()
    suite = suite_with(runs=runs)
    assert run(lambda: suite, ["studies", "--out", str(tmp_path)]) == 0
    printed = capsys.readouterr()
    assert "Round-off: 1 of 2 runs are there." in printed.out
    assert "[1/1] brouwer two: " in printed.err
    assert run(lambda: suite, ["studies", "--out", str(tmp_path)]) == 0
    assert capsys.readouterr().err == ""


def test_a_run_that_raises_leaves_the_others(suite_with, tmp_path, capsys):
    def runs(folder, report):
        return [Run(folder, "one", broken=True), Run(folder, "two")]

    assert run(lambda: suite_with(runs=runs), ["studies", "--out", str(tmp_path)]) == 1
    assert "one: not run (ValueError: no more disk)." in capsys.readouterr().err
    assert (tmp_path / "studies" / "two").exists()


NUMBERS = (
    "measured",
    "error",
    "share",
    "seconds_per_orbit",
    "energy_error",
)


@pytest.mark.slow_cases("free-spin")
@pytest.mark.parametrize("study", STUDIES, ids=lambda study: study.name)
def test_the_figures_draw_and_say_when_there_is_nothing(study):
    frame = FRAMES[study.name](True, print)
    for figure in study.figures:
        lay_out(figure, frame)
        failed = frame.assign(**{name: np.nan for name in NUMBERS})
        for nothing in (failed, frame.head(0), pd.DataFrame()):
            with pytest.raises(NoData):
                lay_out(figure, nothing)


def test_the_tables_say_what_was_found():
    walk = round_off_table(pd.DataFrame(walks(), columns=list(COLUMNS)))[0]
    drift = round_off_table(pd.DataFrame(walks(drift=1.0), columns=list(COLUMNS)))[0]
    assert set(walk["verdict"]) == {"no drift seen"} and set(drift["verdict"]) == {"drifts"}
    assert walk["exponent"].str.contains("±").all() and set(walk["runs"]) == {"16"}
    table = scaling_table(scaling(True, print))[0]
    assert list(table["bodies"].drop_duplicates()) == ["3", "10", "100"]
    peer = table[table["contender"] == "REBOUND IAS15"]
    assert peer["time for an orbit"].iloc[0] == "not reached"
    assert peer["relative to galvi degree 8, Gauss 8"].iloc[1].startswith("100")
    assert set(table["share of the limit"]) == {"0.50", ""}
    few = scaling(True, print).query("bodies == 100")
    few = few.assign(
        contender=few["contender"] + ", 10 heavy", seconds_per_orbit=0.3 * few["seconds_per_orbit"]
    )
    both = scaling_table(pd.concat([scaling(True, print), few]))[0]
    assert list(both["relative to galvi degree 8, Gauss 8"])[-2:] == [f"1.0{TIMES}", f"100{TIMES}"]


def test_numbers_of_a_study_have_the_digits_that_they_need():
    frame = pd.DataFrame({"n": [0.999, 0.9643123, 1e-4, 200000.0, np.nan], "ok": True})
    table, kinds = readable_table(frame, {"n": "number", "ok": "well"})
    assert list(table["number"]) == ["0.999", "0.964", "1·10⁻⁴", "200000", ""]
    assert set(table["well"]) == {"yes"} and kinds == {"number": "number"}


def test_versions_of_an_engine_are_told_by_their_orders():
    frame = versions(True, print)
    table = engine_versions_table(frame)[0]
    assert list(table["engine"]) == [
        f"mujoco {name}" for name in ("3.6.0", "3.10.0", "4.0.1", "9.9.9")
    ]
    assert list(table["order, ball"]) == ["2.00", "2.00", "4.00", ""]
    assert list(table["attitude error, free"])[:2] == ["1.56·10⁻⁵"] * 2
    assert list(table["status"]) == ["", "", "", "No such version."]
    later = pd.concat([frame, frame.assign(engine="mujoco 9.9.9")], ignore_index=True)
    assert "status" not in engine_versions_table(later)[0]
    assert len(engine_versions_table(pd.concat([frame, frame]))[0]) == len(table)


def test_long_spins_are_told_with_the_mark_that_they_came_to():
    table, kinds = free_body_drift_table(spins(True, print))
    lines = table.set_index("contender")
    ours, drifting, burst, absent = (lines.iloc[k] for k in range(4))
    growth = "growth exponent (turns)"
    assert ours[growth] == "round-off" and drifting[growth] == "1.0"
    assert (drifting["turns"], drifting["attitude"]) == ("1000", "1.0·10⁻⁹")
    assert drifting["energy, relative"] == "\u22121.0·10⁻⁹"
    assert (burst["turns"], burst["status"], burst["attitude"]) == ("200", "It burst.", "")
    assert absent["status"] == "Install it." and absent["energy, relative"] == ""
    assert "commit" not in table and set(kinds) < set(table.columns)


def test_the_studies_have_names_of_their_own():
    assert ROUND_OFF.long_form is not None and NUMBER_OF_BODIES.long_form is None
    names = [figure.name for study in STUDIES for figure in study.figures]
    assert len(set(names)) == len(names)
