"""Figures: each of the catalogue draws and fits in any width; each contender has its own style."""

from __future__ import annotations

import itertools
import re
import warnings
from pathlib import Path

import matplotlib.style
import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st
from matplotlib.colors import to_rgb
from matplotlib.text import Text
from mpl_toolkits.mplot3d.art3d import Text3D

from benchmarks.claims import CLAIMS
from benchmarks.store.tables import table_of
from benchmarks.work_precision.dependable import dependable
from benchmarks.work_precision.problem import POSITION
from benchmarks.work_precision.problems import work_precision_problems
from galvi.charts import CHARTS
from reports.contents import SECTIONS
from reports.figures.catalogue.all import FIGURES
from reports.figures.drawing import comparison_figure
from reports.figures.headlines import HEADLINES
from reports.figures.picture import (
    NARROW_WIDTH,
    SMALL_STYLE,
    STYLE,
    WIDTHS,
    draw_canvas,
    picture,
    printed_figure,
)
from reports.figures.profiles import PROFILES
from reports.figures.style.decades import set_readable_ticks
from reports.figures.style.identities import OURS, TABLE, identity, legend_groups, legend_order
from reports.figures.style.layout import NoData, split, wrap
from reports.figures.work_precision import line_of
from reports.results.section import Figure
from reports.tables.profiles import profile_table
from tests.suite.reports.figure_frames import lay_out
from tests.suite.reports.small_reports import work_precision
from tests.suite.reports.study_frames import FRAMES

NAMES = [figure.name for figure in FIGURES]


@pytest.mark.slow_cases("fig-1-01")
@pytest.mark.parametrize("figure", FIGURES, ids=NAMES)
def test_a_figure_of_failed_runs_says_that_there_is_nothing_to_draw(figure, drawn_frames):
    failed = drawn_frames[figure.name].assign(value=np.nan, x=np.nan, y=np.nan)
    for table in (failed, table_of([])):
        with pytest.raises(NoData):
            lay_out(figure, table)


@pytest.mark.slow(beside="test_comparisons_draw_without_warnings")
def test_the_same_frame_gives_the_same_bytes(drawn_frames):
    first, second = (picture(FIGURES[0], drawn_frames[NAMES[0]]) for _ in range(2))
    assert (first.svg, first.png) == (second.svg, second.png)
    assert first.svg.startswith(b"<?xml") and first.png.startswith(b"\x89PNG")
    assert first.title.startswith(FIGURES[0].source)


def test_every_figure_of_the_claims_is_drawn_once_at_least():
    assert {source for claim in CLAIMS for source in claim.figures} == {f.source for f in FIGURES}
    assert {name for figure in FIGURES for name in figure.claims} <= {c.id for c in CLAIMS}
    assert len(set(NAMES)) == len(NAMES)


@pytest.mark.parametrize(
    "figure",
    [pytest.param(figure, id=figure.name) for figure in FIGURES if "rates" in figure.options],
)
def test_the_rate_beside_a_line_is_the_one_that_the_claim_states(figure, drawn_frames):
    table = drawn_frames[figure.name]
    verdicts_of = next(claim.check for claim in CLAIMS if claim.id == figure.claims[0])
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # the frame has the figure's rows alone
        stated = [row.measured for row in verdicts_of(table) if row.measured is not None]
    for rate in figure.options["rates"]:
        if figure.name == "fig-2-06" and rate.quantity == "one-step error":
            continue  # V3 states it
        assert rate.fit(table).rate in stated


def test_comparisons_draw_without_warnings():
    runs = work_precision(True, print)
    lay_out(comparison_figure("kepler e=0.6", runs), runs)
    with pytest.raises(NoData):
        lay_out(comparison_figure("kepler", runs), runs[runs["is_truth"]])


def test_figures_show_the_errors_of_tables_and_mark_bounds():
    """TRACE's lucky run, and a run that is better than the truth can tell."""
    runs = [
        ("galvi degree 8, Gauss 8", "step=0.5", 1e-13, 2.0),
        ("galvi degree 8, Gauss 8", "step=1", 1e-5, 1.0),
        ("REBOUND TRACE", "step=1", 1e-9, 1.0),
        ("REBOUND TRACE", "step=0.5", 9e-2, 2.0),
    ]
    table = pd.DataFrame(runs, columns=["contender", "settings", "error", "seconds"])
    table = table.assign(
        problem="kepler e=0.6",
        quantity="position",
        is_truth=False,
        status="",
        reference="another engine",
    )
    exact = comparison_figure("kepler e=0.6", dependable(table.assign(truth_error=1e-16)))
    table = dependable(table.assign(truth_error=1e-10))
    figure = comparison_figure("kepler e=0.6", table)
    assert "An open mark with an arrow" in figure.caption and "An open" not in exact.caption
    lines = draw_canvas(figure, table).axes[0].get_lines()
    marked = [line for line in lines if line.get_markerfacecolor() == "white"]
    assert [list(line.get_ydata()) for line in marked if len(line.get_ydata())] == [[1e-9]]
    shown = [list(line.get_ydata()) for line in lines if line not in marked]
    assert [9e-2] in shown and [1e-5, 1e-9] in shown


def test_galvi_has_a_line_for_each_degree_and_what_is_another_method_keeps_its_own():
    names = [
        "galvi degree 8, Gauss 8, Cayley",
        "galvi degree 8, Gauss 9",
        "galvi clock, Gauss 8",
        "galvi degree 8, Gauss 8, general kernel",
        "MuJoCo RK4",
    ]
    assert list(map(line_of, names)) == ["galvi degree 8", "galvi degree 8", *names[2:]]


@pytest.mark.slow(beside="test_comparisons_draw_without_warnings")
def test_profiles_draw_what_is_solved_and_say_where_nothing_is():
    errors = {"galvi degree 8": 1e-9, "peer": 1e-5, "useless": 1e-2}
    rows = pd.DataFrame(
        [
            {
                "problem": f"p{k}",
                "contender": contender,
                "settings": "step=1",
                "error": error,
                "is_truth": False,
                "seconds": 20.0 - len(contender),
            }
            for k in range(6)
            for contender, error in errors.items()
        ]
    )
    for figure in PROFILES:
        lay_out(figure, rows)
        with pytest.raises(NoData, match="5 problems"):
            lay_out(figure, rows[rows["contender"] == "useless"])
    table = profile_table(rows).set_index(["error", "code"])
    assert table.loc[("10⁻⁴", "peer"), "fastest"] == "0 % (0 to 46)"
    assert table.loc[("10⁻⁸", "galvi"), "solved"] == "100 % (54 to 100)"
    assert table.loc[("10⁻⁸", "useless"), "galvi faster, tie, slower"] == "6, 0, 0"


@pytest.mark.slow_cases(but=["fig-3-02-page"])
@pytest.mark.parametrize("width", WIDTHS)
@pytest.mark.parametrize("name", ["fig-3-02", "fig-2-06"])
def test_a_figure_is_as_wide_as_asked_and_has_its_fonts(drawn_frames, name, width):
    figure = next(figure for figure in FIGURES if figure.name == name)
    pdf = printed_figure(figure, drawn_frames[name], "pdf", WIDTHS[width])
    box = re.search(rb"/MediaBox \[ ?0 0 ([\d.]+) ([\d.]+)", pdf)
    assert abs(float(box[1]) / 72.0 - WIDTHS[width]) < 0.05
    assert b"/FontFile2" in pdf and b"/Type3" not in pdf
    assert float(box[2]) < 72.0 * 8.0


@pytest.mark.slow(beside="test_a_figure_is_as_wide_as_asked_and_has_its_fonts")
def test_a_figure_is_exported_from_kept_rows(ask):
    ask("build")
    assert ask("export fig-2-03 --format svg --width column").status == 0
    assert Path("out/figures/fig-2-03-column.svg").read_bytes().startswith(b"<?xml")


# No figure has text on text, its legend on an axes, or anything beyond its edge, at any width.

ALL_WIDTHS = {"own": 0.0, "narrow": NARROW_WIDTH, **WIDTHS}
TOUCH = 1.0  # pixels by which the boxes of texts may overlap
STUDIED = {
    figure.name: (figure, FRAMES[section.name])
    for section in SECTIONS
    if section.name in FRAMES
    for figure in section.figures
}


def laid_out(figure, table, width):
    with matplotlib.style.context([STYLE, SMALL_STYLE if 0.0 < width < 3.6 else {}]):
        return draw_canvas(figure, table, width)


def faults(canvas):
    """One sentence on each fault of a layout."""
    edge = canvas.bbox
    texts = [(text, text.get_window_extent()) for text in drawn_texts(canvas)]
    for text, box in texts:
        if not (
            box.x0 > edge.x0 - TOUCH
            and box.x1 < edge.x1 + TOUCH
            and box.y0 > edge.y0 - TOUCH
            and box.y1 < edge.y1 + TOUCH
        ):
            yield f"{text.get_text()!r} is beyond the edge"
    for (left, a), (right, b) in itertools.combinations(texts, 2):
        if left.get_rotation() % 90.0 == 0.0 and overlap(a, b):
            yield f"{left.get_text()!r} is on {right.get_text()!r}"
    for legend in canvas.legends:
        box = legend.get_window_extent()
        for axes in canvas.axes:
            if overlap(box, axes.get_window_extent()):
                yield "the legend is on axes"
    for axes in canvas.axes:
        box = axes.get_window_extent()
        if box.width < 0.3 * canvas.dpi or box.height < 0.2 * canvas.dpi:
            yield f"axes of {box.width:.0f} by {box.height:.0f} pixels"


def drawn_texts(canvas):
    """The texts that are drawn; labels of ticks only within the range of their axis."""
    ticks: set[int] = set()
    for axes in canvas.axes:
        for axis in (axes.xaxis, axes.yaxis):
            low, high = sorted(axis.get_view_interval())
            for tick in (*axis.majorTicks, *axis.minorTicks):
                hidden = tick.get_loc() < low or tick.get_loc() > high or not axes.axison
                ticks |= {id(tick.label1), id(tick.label2)} if hidden else set()
    for text in canvas.findobj(Text):
        if isinstance(text, Text3D):  # is placed when it is drawn
            continue
        if text.get_visible() and text.get_text().strip() and id(text) not in ticks:
            yield text


def overlap(a, b):
    return min(a.x1, b.x1) - max(a.x0, b.x0) > TOUCH and min(a.y1, b.y1) - max(a.y0, b.y0) > TOUCH


@pytest.mark.slow_cases(but=["fig-2-12"])
@pytest.mark.parametrize("figure", FIGURES, ids=[figure.name for figure in FIGURES])
def test_a_figure_of_a_claim_fits_in_any_width(figure, drawn_frames):
    for name, width in ALL_WIDTHS.items():
        canvas = laid_out(figure, drawn_frames[figure.name], width)
        assert not list(faults(canvas)), name
        assert canvas.get_figwidth() == (width or figure.size[0])


@pytest.mark.slow_cases(but=["taxonomy"])
@pytest.mark.parametrize("name", STUDIED)
def test_a_figure_of_a_study_fits_in_any_width(name):
    figure, measure = STUDIED[name]
    table = measure(True, print)
    for name_of_width, width in ALL_WIDTHS.items():
        if not 0.0 < width < figure.min_width:
            assert not list(faults(laid_out(figure, table, width))), name_of_width


@pytest.mark.slow(beside="test_a_figure_of_a_claim_fits_in_any_width")
def test_comparisons_fit_in_any_width():
    rows = [
        {
            "problem": problem,
            "contender": name,
            "quantity": POSITION,
            "settings": "step=1",
            "error": 10.0 ** -(3 + 4 * k),
            "seconds": 10.0 ** (k - 3 + 0.1 * rank),
            "is_truth": False,
        }
        for headline in HEADLINES
        for problem in headline.options["panels"]
        for rank, name in enumerate(headline.options["shown"].values())
        for k in range(3)
    ]
    runs = work_precision(True, print)
    shown = [(comparison_figure("kepler e=0.6", runs), runs)]
    shown += [(headline, pd.DataFrame(rows).assign(error_is_bound=False)) for headline in HEADLINES]
    for width, (figure, table) in itertools.product(ALL_WIDTHS.values(), shown):
        assert not list(faults(laid_out(figure, table, width)))


def decades_of_time(axes, table, *, span):
    for panel in split(axes, 2):
        panel.plot([3e-4, 3e-4 * 10.0**span], [1.0, 2.0])
        panel.set(xscale="log", ylabel="error")
        set_readable_ticks(panel.xaxis)


@pytest.mark.parametrize("span", [0.4, 2.4, 6.0])
def test_ticks_of_a_logarithmic_axis_do_not_touch(span):
    figure = Figure("f", "f", decades_of_time, options={"span": span}, size=(9.0, 3.9))
    for width in ALL_WIDTHS.values():
        assert not list(faults(laid_out(figure, pd.DataFrame(), width)))


def careless(axes, table):
    left, right = split(axes, 2, columns=2)
    for panel in (left, right):
        panel.plot([0.0, 1.0])
    left.text(0.1, 0.5, "a text", in_layout=False)
    left.text(0.2, 0.5, "on a text", in_layout=False)
    right.text(0.5, 0.5, "a long text that does not end within its panel", in_layout=False)


def test_text_on_text_and_beyond_the_edge_is_seen():
    canvas = laid_out(Figure("f", "f", careless), pd.DataFrame(), 6.3)
    layout_faults = list(faults(canvas))
    assert any("is on" in fault for fault in layout_faults) and any(
        "beyond" in fault for fault in layout_faults
    )


def test_lines_break_between_words_and_not_within_mathematics():
    assert wrap("the error of $R - R_0$ at the end", 14) == "the error of\n$R - R_0$ at\nthe end"


# Each contender has one style in all figures, and legends stay readable.

COLOR_DISTANCE = 10.0  # in CIELAB, between two families in a figure with different markers
LONGEST_LEGEND = 10  # entries; the families of the rigid bodies
SAME_MARKER_DISTANCE = 20.0  # in CIELAB, between two families with the same marker; 23 measured


def lab(color):
    """CIELAB coordinates under D65."""
    rgb = np.array(to_rgb(color))
    linear = np.where(rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4)
    xyz = (
        np.array([[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]])
        @ linear
        / [0.9505, 1.0, 1.089]
    )
    f = np.where(xyz > 216 / 24389, np.cbrt(xyz), (24389 / 27 * xyz + 16) / 116)
    return np.array([116 * f[1] - 16, 500 * (f[0] - f[1]), 200 * (f[1] - f[2])])


PROBLEMS = {
    case.problem.name: [label for label, _, _ in case.participants]
    for case in work_precision_problems(False)
}
CONTENDERS = legend_order(name for names in PROBLEMS.values() for name in names)


@pytest.mark.parametrize("problem", PROBLEMS)
def test_no_two_of_a_comparison_look_alike_and_the_legend_is_short(problem):
    looks = {name: identity(name) for name in PROBLEMS[problem]}
    assert len(legend_groups(looks)) <= LONGEST_LEGEND
    styles = {(look.color, look.marker, str(look.dash)) for look in looks.values()}
    variants = {n for n in looks if n.startswith(OURS)}  # the same degree, with more points
    families = {identity(name).family for name in looks if name not in variants}
    assert len(styles) >= len(families) + (1 if variants else 0)
    look_of_family = {look.family: look for name, look in looks.items() if name not in variants}
    for a, b in itertools.combinations(look_of_family.values(), 2):
        least_distance = SAME_MARKER_DISTANCE if a.marker == b.marker else COLOR_DISTANCE
        assert np.linalg.norm(lab(a.color) - lab(b.color)) > least_distance, (a.family, b.family)


def test_every_known_code_has_a_row_of_its_own():
    for name in CONTENDERS:
        assert name.startswith(OURS) or identity(name).family in TABLE, name


def test_galvi_darkens_with_the_degree_and_charts_differ_by_their_lines():
    lightness = [lab(identity(f"galvi degree {s}, Gauss {s}").color)[0] for s in (2, 4, 8, 12, 16)]
    assert np.all(np.diff(lightness) < 0.0)
    dashes = {str(identity(f"galvi degree 8, Gauss 8, {chart.name}").dash) for chart in CHARTS}
    assert len(dashes) == len(CHARTS)
    assert identity("galvi degree 8, Gauss 8, Cayley").color == identity("galvi degree 8").color


@given(st.lists(st.sampled_from(CONTENDERS), min_size=1, unique=True))
def test_whoever_takes_part_is_in_one_entry_of_the_legend(names):
    entries = legend_groups(names)
    assert len({label for label, _ in entries}) == len(entries)
    assert sorted(name for _, members in entries for name in members) == sorted(names)


def test_an_unknown_integrator_has_a_look_that_stays():
    look = identity("my leapfrog")
    assert look == identity("my leapfrog") and look.family == "my leapfrog"
    assert legend_order(["my leapfrog", "heyoka", "galvi degree 8, Gauss 8"])[-1] == "my leapfrog"


def test_families_that_share_a_colour_would_be_found():
    a = b = identity("heyoka")
    assert not np.linalg.norm(lab(a.color) - lab(b.color)) > COLOR_DISTANCE
