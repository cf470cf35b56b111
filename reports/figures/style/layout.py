"""Panels, a legend outside of them, and titles that fit, in matplotlib's constrained layout."""

from __future__ import annotations

import math
import re
import textwrap
from collections.abc import Iterable, Iterator
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.legend_handler import HandlerTuple
from matplotlib.lines import Line2D
from matplotlib.text import Text
from matplotlib.transforms import Bbox

from reports.figures.style.decades import choose_ticks
from reports.figures.style.identities import GUIDE, identity, legend_groups
from reports.tables.number_format import readable


class NoData(Exception):
    """A figure cannot be drawn, for want of finite numbers or of width; the message says why."""


MIN_ASPECT, MAX_ASPECT = 0.62, 0.8  # height of a panel over its width where the figure is narrow
PAD = 0.06  # inches around the axes
WIDE_INCHES = 5.0  # inches; in wider figures a legend may stand on the right
MAX_LEGEND_FRACTION = 0.26  # largest part of the width that such a legend takes
MIN_PANEL_WIDTH = 2.7  # inches of width that such a legend leaves, at least, to each panel
LABEL_INCHES = (0.85, 0.6)  # inches of a panel's width and height that labels take
MAX_LEGEND_COLUMNS = 4  # largest number of columns of a legend
HANDLE_INCHES = 0.8  # inches beside the text of a legend's entry
MAX_MARKERS = 6  # largest number of markers in an entry for several names
BELOW, RIGHT = "outside lower center", "outside right upper"
UNBROKEN = "\u00a0"


class Canvas(Figure):
    """A figure whose height follows from its width.

    Parameters
    ----------
    natural
        width and height in inches at which the figure looks best
    width
        width in inches

    Attributes
    ----------
    entries
        label -> handle of the legend's entries besides those of the axes
    """

    def __init__(self, natural: tuple[float, float], width: float) -> None:
        self.natural = natural
        self.entries: dict[str, Any] = {}
        super().__init__(figsize=(width, _height(natural, width)), layout="compressed")
        FigureCanvasAgg(self)
        self.get_layout_engine().set(w_pad=PAD, h_pad=PAD, wspace=0.04, hspace=0.06)


def _height(natural: tuple[float, float], width: float) -> float:
    """The height in inches of a panel `width` inches wide.

    The ratio of height and width is the natural one; in narrower panels it is clipped to MIN_ASPECT
    and MAX_ASPECT.
    """
    ratio = natural[1] / natural[0]
    return width * (ratio if width >= natural[0] else min(max(ratio, MIN_ASPECT), MAX_ASPECT))


def split(
    axes: Axes,
    count: int,
    *,
    ylabel: str = "",
    min_width: float = 2.6,
    columns: int = 0,
    **keywords: Any,
) -> list[Axes]:
    """Replace an axes by `count` panels.

    Parameters
    ----------
    ylabel
        label of the first panel of each row
    min_width
        inches; the panels stand side by side if each is as wide as this, else in several rows
    columns
        number of columns at any width; 0 to choose it by `min_width`
    keywords
        arguments of `Figure.add_subplot`
    """
    canvas = axes.get_figure(root=True)
    natural_width, natural_height = canvas.natural
    figure_width = canvas.get_figwidth()
    rows = math.ceil(count / (columns or max(1, min(count, int(figure_width / min_width)))))
    side_by_side = columns or math.ceil(count / rows)
    panel_height = _height((natural_width / count, natural_height), figure_width / side_by_side)
    canvas.set_figheight(
        max(natural_height, canvas.get_figheight()) if columns else rows * panel_height
    )
    axes.remove()
    grid = canvas.add_gridspec(rows, side_by_side)
    panels = [canvas.add_subplot(grid[k], **keywords) for k in range(count)]
    for first in panels[::side_by_side]:
        first.set_ylabel(ylabel)
    return panels


def legend(axes: Axes, handles: Iterable[Any], labels: Iterable[str]) -> None:
    """Add entries to the figure's legend, in addition to those of labelled lines."""
    axes.get_figure(root=True).entries.update(zip(labels, handles, strict=True))


def contender_legend(axes: Axes, names: Iterable[str]) -> None:
    """Add the entries of `grouped` to the legend; an entry for several names shows up to
    MAX_MARKERS of their markers."""
    for label, members in legend_groups(names):
        looks = [identity(name).style for name in reversed(members)]
        styles = list({(look["color"], look["marker"]): look for look in looks}.values())[::-1]
        shown_styles = styles[:: -(-len(styles) // MAX_MARKERS)]
        legend(
            axes,
            [tuple(Line2D([], [], markersize=5.0, **style) for style in shown_styles)],
            [label],
        )


def mark_rounding(axes: Axes) -> None:
    """Draw a labelled line at the machine epsilon, below which errors are rounding errors."""
    epsilon = float(np.finfo(float).eps)
    axes.axhline(
        epsilon,
        color=GUIDE,
        linestyle=(0, (1, 2)),
        linewidth=1.0,
        label=f"machine epsilon, {readable(epsilon, 2)}",
    )


def finish(canvas: Canvas) -> None:
    """Choose the ticks of logarithmic axes, draw the legend, break titles and labels that are too
    long, and fix the layout. Raises NoData if a panel has no finite data."""
    for axes in canvas.axes:
        if not np.isfinite(axes.dataLim.get_points()).all():
            raise NoData("no run has a finite number of what it shows.")
        choose_ticks(axes)
    across, figure_height = canvas.get_size_inches()
    beside, below = _draw_legend(canvas)
    across -= beside
    for axes in canvas.axes:
        grid = axes.get_subplotspec().get_gridspec()
        label_inches = LABEL_INCHES if axes.axison else (0.0, 0.0)
        width, height = (
            across / grid.ncols - label_inches[0],
            figure_height / grid.nrows - label_inches[1],
        )
        for text in (axes._left_title, axes.xaxis.label):  # type: ignore[attr-defined]
            _break_lines(text, width, "width")
        _break_lines(axes.yaxis.label, height, "height")
    for _ in range(2):  # axes in three dimensions take two to settle
        canvas.draw_without_rendering()
    if any(axes.get_aspect() != "auto" for axes in canvas.axes):  # no higher than they are
        box = Bbox.union([axes.get_tightbbox() for axes in canvas.axes])
        canvas.set_figheight(box.height / canvas.dpi + below + 2.0 * PAD)
        canvas.draw_without_rendering()
    canvas.set_layout_engine("none")


def _entries(canvas: Canvas) -> dict[str, Any]:
    """Label -> handle of the labelled lines, followed by the entries that `legend` added."""
    labelled = {
        label: handle
        for axes in canvas.axes
        for handle, label in zip(*axes.get_legend_handles_labels(), strict=True)
        if label not in canvas.entries
    }
    return labelled | canvas.entries


def _legend_layouts(count: int, across: float) -> Iterator[tuple[str, int]]:
    """(location, columns) for a legend of `count` entries, in the order in which they are tried:
    below the axes in one row, right of them, below them in as few rows as fit."""
    balanced = (math.ceil(count / rows) for rows in range(1, count + 1))
    below = [(BELOW, columns) for columns in balanced if columns <= MAX_LEGEND_COLUMNS]
    yield from below[:1] if count <= MAX_LEGEND_COLUMNS else ()
    yield from [(RIGHT, 1)] if across > WIDE_INCHES else ()
    yield from below


def _draw_legend(canvas: Canvas) -> tuple[float, float]:
    """Draw the legend; returns its width beside and its height below the axes, in inches."""
    entries = _entries(canvas)
    if not entries:
        return 0.0, 0.0
    across, high = canvas.get_size_inches()
    markers = max(len(handle) if isinstance(handle, tuple) else 1 for handle in entries.values())
    columns_of_panels = max(axes.get_subplotspec().get_gridspec().ncols for axes in canvas.axes)
    for loc, columns in _legend_layouts(len(entries), across):
        figure_legend = canvas.legend(
            list(entries.values()),
            list(entries),
            ncols=columns,
            borderaxespad=0.2,
            loc=loc,
            handlelength=2.6 if markers == 1 else min(1.7 * markers, 6.0),
            handler_map={tuple: HandlerTuple(ndivide=None, pad=0.3)},
        )
        if columns == 1 and loc == BELOW:
            for text in figure_legend.get_texts():
                _break_lines(text, across - HANDLE_INCHES, "width")
        box = figure_legend.get_window_extent()
        width, height = box.width / canvas.dpi, box.height / canvas.dpi
        fits = (
            width < MAX_LEGEND_FRACTION * across
            and (across - width) / columns_of_panels > MIN_PANEL_WIDTH
        )
        if loc == RIGHT and fits and height < high:
            return width, 0.0
        if loc == BELOW and (columns == 1 or width < across - 4.0 * PAD):
            break
        figure_legend.remove()
    canvas.set_figheight(high + height)
    return 0.0, height


def _break_lines(text: Text, limit: float, side: str) -> None:
    """Break a text into lines that fit in `limit` inches."""
    length = getattr(text.get_window_extent(), side) / text.get_figure(root=True).dpi
    if length > limit:
        text.set_text(wrap(text.get_text(), int(0.95 * len(text.get_text()) * limit / length)))


def wrap(text: str, letters: int) -> str:
    """The text in lines of at most `letters` characters (8, if that is less), as far as its words
    allow; there is no break within mathematics, nor before a unit or a symbol."""
    text = re.sub(r"\$[^$]*\$", lambda formula: formula[0].replace(" ", UNBROKEN), text)
    joined = re.sub(r" (?=\[[^]]{1,12}\]|\$[^$]{1,3}\$$)", UNBROKEN, text)
    return textwrap.fill(joined, max(letters, 8), break_long_words=False).replace(UNBROKEN, " ")
