"""Studies with sections of their own: shown, stored, resumed, and 'not run' where they were not."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from benchmarks.brouwer import COLUMNS
from benchmarks.scaling import COLUMNS as SCALING
from benchmarks.walkers import KEPT
from reports.brouwer_table import brouwer_table
from reports.commands import run
from reports.figures.figure import picture
from reports.figures.nothing import NothingToDraw
from reports.own_sections import NUMBER_OF_BODIES, ROUND_OFF, STUDIES
from reports.scaling_table import scaling_table


def walks(
    years: float = 1e4, commit: str = "", drift: float = 0.0, runs: int = 16
) -> list[dict[str, object]]:
    """Random walks of two contenders, one of which hands out rounded states."""
    rng = np.random.default_rng(1)
    rows = []
    for who, low in (("galvi degree 8, Gauss 8", 1e-18), ("REBOUND IAS15", 0.0)):
        for k in range(runs):
            path = np.cumsum(1e-16 * (rng.standard_normal(100) + drift))
            rows += [
                {
                    "contender": who, "settings": "as usual", "years": years, "member": k,
                    "sample": n, "t": years * n / 100, "error": path[n - 1],
                    "error_of_rounded": path[n - 1] + low, "status": "", "commit": commit,
                    "date": "2026-01-01" if commit else "",
                }
                for n in KEPT
            ]  # fmt: skip
    return rows


def brouwer(quick: bool, report: Callable[[str], None]) -> pd.DataFrame:
    return pd.DataFrame(walks(), columns=list(COLUMNS))


def scaling(quick: bool, report: Callable[[str], None]) -> pd.DataFrame:
    """galvi and a peer that does not reach the error with three bodies; one is not installed."""
    blank = dict.fromkeys(SCALING, np.nan)
    rows = [
        {**blank, "contender": who, "settings": "P/6", "bodies": bodies, "orbits": 30,
         "seconds_per_orbit": time * bodies, "seconds_low": 0.9 * time * bodies,
         "seconds_high": 1.1 * time * bodies, "error": 1e-9,
         "matched": time < 1e-4 or bodies > 3, "pairs_per_second": 1e9,
         "limit_pairs_per_second": 2e9, "share": 0.5 if who.startswith("galvi") else np.nan,
         "status": ""}
        for bodies in (3, 10, 100)
        for who, time in (("galvi degree 8, Gauss 8", 1e-5), ("REBOUND IAS15", 1e-3))
    ]  # fmt: skip
    absent = {**blank, "contender": "Other", "bodies": 3, "matched": False, "status": "Install it."}
    return pd.DataFrame([*rows, absent], columns=list(SCALING))


FRAMES = {"brouwer": brouwer, "scaling": scaling}


@dataclass
class Part:
    """A run that leaves a file, or raises."""

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
    """The real studies with small frames; `long` is what is stored of the long Brouwer study."""

    def make(long: list[dict[str, object]] = [], **fields: object):  # noqa: B006
        studies = [replace(one, measure=FRAMES[one.name]) for one in STUDIES]
        stored = pd.DataFrame(long, columns=list(COLUMNS))
        first = {"stored": lambda folder, report: stored, **fields}
        return make_suite(studies=(replace(studies[0], **first), studies[1]))

    return make


def test_a_build_shows_both_studies_with_tables_and_pictures(suite_with, tmp_path):
    long = walks(1e6, commit="feedfacecafe", drift=1.0)
    assert run(lambda: suite_with(long), ["build", "--out", str(tmp_path)]) == 0
    page = (tmp_path / "index.html").read_text(encoding="utf-8")
    for text in ("Round-off", "Number of bodies", "feedfacecafe", "2026-01-01", "drifts"):
        assert text in page
    assert "make studies" not in page
    for name in ("brouwer", "scaling"):
        assert len(pd.read_csv(tmp_path / f"{name}.csv")) > 0
        assert (tmp_path / "tables" / f"{name}.md").stat().st_size > 0
    for name in ("brouwer", "scaling", "scaling-share"):
        assert (tmp_path / "figures" / f"{name}.svg").stat().st_size > 0
    rows = pd.read_csv(tmp_path / "brouwer.csv")
    assert set(rows["commit"]) == {"0123456789ab+dirty", "feedfacecafe"}


def test_a_long_study_that_was_not_run_says_how_to(suite_with, tmp_path):
    assert run(suite_with, ["build", "--out", str(tmp_path)]) == 0
    page = (tmp_path / "index.html").read_text(encoding="utf-8")
    assert "Its long form was not run: make studies." in page


def test_a_study_that_raises_is_named_and_its_stored_rows_are_shown(suite_with, tmp_path, capsys):
    def broken(quick, report):
        raise OSError("the lamp went out")

    for long, shown in (([], False), (walks(1e6, "feedfacecafe", runs=4), True)):
        suite = suite_with(long, measure=broken)
        assert run(lambda suite=suite: suite, ["build", "--out", str(tmp_path)]) == 1
        assert "Round-off: not run (OSError: the lamp went out)." in capsys.readouterr().err
        page = (tmp_path / "index.html").read_text(encoding="utf-8")
        section = page[page.index('<h2 id="brouwer">') : page.index('<h2 id="scaling">')]
        assert ("feedfacecafe" in section) is shown
        assert ('<p class="note">not run</p>' in section) is not shown


def test_studies_runs_what_is_not_there_yet(suite_with, tmp_path, capsys):
    def parts(folder, report):
        return [Part(folder, "one"), Part(folder, "two")]

    (tmp_path / "studies").mkdir()
    (tmp_path / "studies" / "one").touch()
    suite = suite_with(parts=parts)
    assert run(lambda: suite, ["studies", "--out", str(tmp_path)]) == 0
    printed = capsys.readouterr()
    assert "Round-off: 1 of 2 runs are there." in printed.out
    assert "[1/1] brouwer two: " in printed.err
    assert run(lambda: suite, ["studies", "--out", str(tmp_path)]) == 0
    assert capsys.readouterr().err == ""


def test_a_part_that_raises_leaves_the_others(suite_with, tmp_path, capsys):
    def parts(folder, report):
        return [Part(folder, "one", broken=True), Part(folder, "two")]

    assert run(lambda: suite_with(parts=parts), ["studies", "--out", str(tmp_path)]) == 1
    assert "one: not run (ValueError: no more disk)." in capsys.readouterr().err
    assert (tmp_path / "studies" / "two").exists()


@pytest.mark.parametrize("study", STUDIES, ids=lambda study: study.name)
def test_the_figures_draw_and_say_when_there_is_nothing(study):
    frame = FRAMES[study.name](True, print)
    for figure in study.figures:
        drawn = picture(figure, frame)
        assert (drawn.svg, drawn.png) == (picture(figure, frame).svg, picture(figure, frame).png)
        failed = frame.assign(**{name: np.nan for name in ("error", "share", "seconds_per_orbit")})
        for nothing in (failed, frame.head(0), pd.DataFrame()):
            with pytest.raises(NothingToDraw):
                picture(figure, nothing)


def test_the_tables_say_what_was_found():
    walk = brouwer_table(pd.DataFrame(walks(), columns=list(COLUMNS)))[0]
    drift = brouwer_table(pd.DataFrame(walks(drift=1.0), columns=list(COLUMNS)))[0]
    assert set(walk["verdict"]) == {"no drift seen"} and set(drift["verdict"]) == {"drifts"}
    assert walk["exponent"].str.contains("±").all() and set(walk["runs"]) == {"16"}
    table = scaling_table(scaling(True, print))[0]
    assert list(table["bodies"]) == ["3", "10", "100"]
    assert table["REBOUND IAS15"].iloc[0] == "not reached"
    assert table["REBOUND IAS15"].iloc[1].startswith("100")
    assert set(table["share of the limit"]) == {"0.50"}


def test_the_studies_have_names_of_their_own():
    assert ROUND_OFF.parts is not None and NUMBER_OF_BODIES.parts is None
    names = [figure.name for study in STUDIES for figure in study.figures]
    assert len(set(names)) == len(names)
