"""No figure has text on text, its legend on an axes, or anything beyond its edge, at any width."""

from __future__ import annotations

import itertools
from collections.abc import Iterator

import matplotlib.style
import numpy as np
import pandas as pd
import pytest
from matplotlib.text import Text
from matplotlib.transforms import Bbox
from mpl_toolkits.mplot3d.art3d import Text3D

from benchmarks.work_precision.problem import POSITION
from reports.contents import SECTIONS
from reports.figures.catalogue.all import FIGURES
from reports.figures.drawing import comparison_figure
from reports.figures.headlines import HEADLINES
from reports.figures.picture import NARROW, SMALL, STYLE, WIDTHS, drawn
from reports.figures.style.decades import readable
from reports.figures.style.layout import Canvas, split, wrapped
from reports.figures.track_record import track_record
from reports.results.section import Figure
from tests.suite.reports.study_frames import FRAMES

ALL = {"own": 0.0, "narrow": NARROW, **WIDTHS}
TOUCH = 1.0  # pixels, by which the boxes of letters may overlap
STUDIED = {
    figure.name: (figure, FRAMES[section.name])
    for section in SECTIONS
    if section.name in FRAMES
    for figure in section.figures
}


def laid_out(figure: Figure, frame: pd.DataFrame, width: float) -> Canvas:
    with matplotlib.style.context([STYLE, SMALL if 0.0 < width < 3.6 else {}]):
        return drawn(figure, frame, width)


def faults(canvas: Canvas) -> Iterator[str]:
    """What is wrong with a layout."""
    edge = canvas.bbox
    texts = [(one, one.get_window_extent()) for one in seen_texts(canvas)]
    for one, box in texts:
        if not (box.x0 > edge.x0 - TOUCH and box.x1 < edge.x1 + TOUCH
                and box.y0 > edge.y0 - TOUCH and box.y1 < edge.y1 + TOUCH):  # fmt: skip
            yield f"{one.get_text()!r} is beyond the edge"
    for (one, a), (other, b) in itertools.combinations(texts, 2):
        if one.get_rotation() % 90.0 == 0.0 and overlap(a, b):
            yield f"{one.get_text()!r} is on {other.get_text()!r}"
    for one in canvas.legends:
        box = one.get_window_extent()
        for axes in canvas.axes:
            if overlap(box, axes.get_window_extent()):
                yield "the legend is on axes"
    drawn_in = canvas.get_tightbbox()  # inches
    wide, high = canvas.get_size_inches()
    if (min(drawn_in.x0, drawn_in.y0) < -0.02
            or drawn_in.x1 > wide + 0.02 or drawn_in.y1 > high + 0.02):  # fmt: skip
        yield "something is beyond the edge"
    for axes in canvas.axes:
        box = axes.get_window_extent()
        if box.width < 0.3 * canvas.dpi or box.height < 0.2 * canvas.dpi:
            yield f"axes of {box.width:.0f} by {box.height:.0f} pixels"


def seen_texts(canvas: Canvas) -> Iterator[Text]:
    """Those that are drawn: labels of ticks only within the range of their axis."""
    ticks: set[int] = set()
    for axes in canvas.axes:
        for axis in (axes.xaxis, axes.yaxis):
            low, high = sorted(axis.get_view_interval())
            for tick in (*axis.majorTicks, *axis.minorTicks):
                hidden = tick.get_loc() < low or tick.get_loc() > high or not axes.axison
                ticks |= {id(tick.label1), id(tick.label2)} if hidden else set()
    for one in canvas.findobj(Text):
        if isinstance(one, Text3D):  # is placed when it is drawn
            continue
        if one.get_visible() and one.get_text().strip() and id(one) not in ticks:
            yield one


def overlap(a: Bbox, b: Bbox) -> bool:
    return (min(a.x1, b.x1) - max(a.x0, b.x0) > TOUCH
            and min(a.y1, b.y1) - max(a.y0, b.y0) > TOUCH)  # fmt: skip


@pytest.mark.slow_cases(but=["fig-2-12"])
@pytest.mark.parametrize("figure", FIGURES, ids=[figure.name for figure in FIGURES])
def test_a_figure_of_a_claim_fits_in_any_width(figure, drawn_frames):
    for name, width in ALL.items():
        canvas = laid_out(figure, drawn_frames[figure.name], width)
        assert not list(faults(canvas)), name
        assert canvas.get_figwidth() == (width or figure.size[0])


@pytest.mark.slow_cases(but=["taxonomy"])
@pytest.mark.parametrize("name", STUDIED)
def test_a_figure_of_a_study_fits_in_any_width(name):
    figure, measure = STUDIED[name]
    frame = measure(True, print)
    for which, width in ALL.items():
        if not 0.0 < width < figure.least:
            assert not list(faults(laid_out(figure, frame, width))), which


def compared(headline: Figure) -> pd.DataFrame:
    """Three runs of each of its contenders on its problems."""
    rows = [
        {"problem": problem, "contender": name, "quantity": POSITION, "settings": "step=1",
         "error": 10.0 ** -(3 + 4 * k), "seconds": 10.0 ** (k - 3 + 0.1 * place), "is_truth": False}
        for problem in headline.options["panels"]
        for place, name in enumerate(headline.options["shown"].values())
        for k in range(3)
    ]  # fmt: skip
    return pd.DataFrame(rows)


@pytest.mark.slow(beside="test_a_figure_of_a_claim_fits_in_any_width")
def test_comparisons_fit_in_any_width(make_suite):
    suite = make_suite()
    history = pd.DataFrame({"commit": [f"{k:040x}" for k in range(30)]})
    values = np.linspace(1.0, 1.6, 30)
    panels_of = [
        (name, values * size, [11], name == "error")
        for name, size in (("time", 1.0), ("iterations", 1e4), ("error", 1e-12))
    ]
    tracked = Figure("t", "t", track_record, options={"panels": panels_of}, size=(6.0, 4.85))
    runs = suite.work_precision(True, print)
    for width in ALL.values():
        for figure, frame in ((comparison_figure("kepler e=0.6", runs), runs),
                              (tracked, history),
                              *((one, compared(one)) for one in HEADLINES)):  # fmt: skip
            assert not list(faults(laid_out(figure, frame, width)))


def decades_of_time(axes, frame, *, span):
    for panel in split(axes, 2):
        panel.plot([3e-4, 3e-4 * 10.0**span], [1.0, 2.0])
        panel.set(xscale="log", ylabel="error")
        readable(panel.xaxis)


@pytest.mark.parametrize("span", [0.4, 1.3, 2.4, 2.9, 6.0])
def test_ticks_of_a_logarithmic_axis_do_not_touch(span):
    figure = Figure("f", "f", decades_of_time, options={"span": span}, size=(9.0, 3.9))
    for width in ALL.values():
        assert not list(faults(laid_out(figure, pd.DataFrame(), width)))


def careless(axes, frame):
    left, right = split(axes, 2, columns=2)
    for panel in (left, right):
        panel.plot([0.0, 1.0])
    left.text(0.1, 0.5, "a text", in_layout=False)
    left.text(0.2, 0.5, "on a text", in_layout=False)
    right.text(0.5, 0.5, "a long text that does not end within its panel", in_layout=False)


def test_text_on_text_and_beyond_the_edge_is_seen():
    canvas = laid_out(Figure("f", "f", careless), pd.DataFrame(), 6.3)
    found = list(faults(canvas))
    assert any("is on" in one for one in found) and any("beyond" in one for one in found)


def test_lines_break_between_words_and_not_within_mathematics():
    assert wrapped("the error of $R - R_0$ at the end", 14) == "the error of\n$R - R_0$ at\nthe end"
