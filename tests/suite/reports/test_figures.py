"""Every figure of the catalogue draws, from good frames and from bad ones."""

import warnings

import numpy as np
import pandas as pd
import pytest

from benchmarks.claims import CLAIMS
from benchmarks.store.frames import frame
from benchmarks.work_precision.dependable import dependable
from reports.figures.catalogue.all import FIGURES
from reports.figures.drawing import comparison_figure
from reports.figures.picture import drawn, picture
from reports.figures.profiles import PROFILES
from reports.figures.style.layout import NoData
from reports.figures.work_precision import line_of
from reports.tables.profiles import profile_table
from tests.suite.reports.figure_frames import lay_out

NAMES = [figure.name for figure in FIGURES]


@pytest.mark.slow_cases("fig-1-01")
@pytest.mark.parametrize("figure", FIGURES, ids=NAMES)
def test_a_figure_of_failed_runs_says_that_there_is_nothing_to_draw(figure, drawn_frames):
    failed = drawn_frames[figure.name].assign(value=np.nan, x=np.nan, y=np.nan)
    for table in (failed, frame([])):
        with pytest.raises(NoData):
            lay_out(figure, table)


@pytest.mark.slow(beside="test_comparisons_draw_without_warnings")
def test_the_same_frame_gives_the_same_bytes(drawn_frames):
    first, again = (picture(FIGURES[0], drawn_frames[NAMES[0]]) for _ in range(2))
    assert (first.svg, first.png) == (again.svg, again.png)
    assert first.svg.startswith(b"<?xml") and first.png.startswith(b"\x89PNG")
    assert first.title.startswith(FIGURES[0].source)


def test_every_figure_of_the_claims_is_drawn_once_at_least():
    assert {source for claim in CLAIMS for source in claim.figures} == {f.source for f in FIGURES}
    drawn = {"H fig. 1.1", "H fig. 1.2", *(f"H fig. 2.{k}" for k in range(3, 16))}
    drawn |= {*(f"H fig. 3.{k}" for k in range(1, 10)), "H 3.6.1", "H thm. 3.3.3", "H thm. 3.3.4"}
    drawn |= {"M fig. 3", "M fig. 1 left", "M fig. 1 right", "M sec. 5"}
    drawn |= {"H thm. 2.3.6", "H thm. 2.3.7"}
    assert drawn <= {figure.source for figure in FIGURES}
    assert {name for figure in FIGURES for name in figure.claims} <= {c.id for c in CLAIMS}
    assert len(set(NAMES)) == len(NAMES)


@pytest.mark.parametrize(
    "figure",
    [pytest.param(figure, id=figure.name) for figure in FIGURES if "rates" in figure.options],
)
def test_the_rate_beside_a_line_is_the_one_that_the_claim_states(figure, drawn_frames):
    table = drawn_frames[figure.name]
    judge = next(claim.judge for claim in CLAIMS if claim.id == figure.claims[0])
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # the frame has the figure's rows alone
        stated = [row.measured for row in judge(table) if row.measured is not None]
    for rate in figure.options["rates"]:
        if figure.name == "fig-2-06" and rate.quantity == "one-step error":
            continue  # V3 states it
        assert rate.fit(table).rate in stated


def test_comparisons_draw_without_warnings(make_suite):
    suite = make_suite()
    runs = suite.work_precision(True, print)
    lay_out(comparison_figure("kepler e=0.6", runs), runs)
    with pytest.raises(NoData):
        lay_out(comparison_figure("kepler", runs), runs[runs["is_truth"]])


def test_figures_show_the_errors_of_tables_and_mark_bounds():
    """TRACE's lucky run, and a run that is better than the truth can tell."""
    runs = [("galvi degree 8, Gauss 8", "step=0.5", 1e-13, 2.0),
            ("galvi degree 8, Gauss 8", "step=1", 1e-5, 1.0),
            ("REBOUND TRACE", "step=1", 1e-9, 1.0),
            ("REBOUND TRACE", "step=0.5", 9e-2, 2.0)]  # fmt: skip
    table = pd.DataFrame(runs, columns=["contender", "settings", "error", "seconds"])
    table = table.assign(problem="kepler e=0.6", quantity="position", is_truth=False, status="",
                         reference="another engine")  # fmt: skip
    exact = comparison_figure("kepler e=0.6", dependable(table.assign(truth_error=1e-16)))
    table = dependable(table.assign(truth_error=1e-10))
    figure = comparison_figure("kepler e=0.6", table)
    assert "An open mark with an arrow" in figure.caption and "An open" not in exact.caption
    lines = drawn(figure, table).axes[0].get_lines()
    marked = [line for line in lines if line.get_markerfacecolor() == "white"]
    assert [list(line.get_ydata()) for line in marked if len(line.get_ydata())] == [[1e-9]]
    shown = [list(line.get_ydata()) for line in lines if line not in marked]
    assert [9e-2] in shown and [1e-5, 1e-9] in shown


def test_galvi_has_a_line_for_each_degree_and_what_is_another_method_keeps_its_own():
    names = ["galvi degree 8, Gauss 8, Cayley", "galvi degree 8, Gauss 9", "galvi clock, Gauss 8",
             "galvi degree 8, Gauss 8, general kernel", "MuJoCo RK4"]  # fmt: skip
    assert list(map(line_of, names)) == ["galvi degree 8", "galvi degree 8", *names[2:]]


@pytest.mark.slow(beside="test_comparisons_draw_without_warnings")
def test_profiles_draw_what_is_solved_and_say_where_nothing_is():
    errors = {"galvi degree 8": 1e-9, "peer": 1e-5, "useless": 1e-2}
    rows = pd.DataFrame(
        [{"problem": f"p{k}", "contender": who, "settings": "step=1", "error": error,
          "is_truth": False, "seconds": 20.0 - len(who)}
         for k in range(6) for who, error in errors.items()]
    )  # fmt: skip
    for figure in PROFILES:
        lay_out(figure, rows)
        with pytest.raises(NoData, match="5 problems"):
            lay_out(figure, rows[rows["contender"] == "useless"])
    table = profile_table(rows).set_index(["error", "code"])
    assert table.loc[("10⁻⁴", "peer"), "fastest"] == "0 % (0 to 46)"
    assert table.loc[("10⁻⁸", "galvi"), "solved"] == "100 % (54 to 100)"
    assert table.loc[("10⁻⁸", "useless"), "galvi faster, tie, slower"] == "6, 0, 0"
