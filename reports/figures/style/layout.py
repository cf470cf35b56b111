"""Axes, legends and their places."""

from __future__ import annotations

import itertools
import math
import re
import textwrap
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib import rcParams
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.legend import Legend
from matplotlib.legend_handler import HandlerTuple
from matplotlib.lines import Line2D
from matplotlib.text import Annotation, Text

from reports.figures.style.decades import fewer
from reports.figures.style.identities import GUIDE, darker, grouped, identity
from reports.tables.number_format import readable


class NoData(Exception):
    """The frame has no finite number for what a figure shows; the message says which."""


SHOWN = 6  # markers of an entry that stands for several names


def contender_legend(axes: Axes, names: Iterable[str]) -> None:
    """Entries of `grouped`; one of several names shows some of their markers, of galvi's one for
    each degree."""
    handles, labels = [], []
    for label, members in grouped(names):
        looks = [identity(name).style for name in members]
        styles = list({(s["color"], s["marker"]): s for s in reversed(looks)}.values())[::-1]
        stride = max(1, (len(styles) - 1) // (SHOWN - 1)) if len(styles) > SHOWN else 1
        shown = styles[::stride][:SHOWN]
        handles.append(tuple(Line2D([], [], markersize=5.0, **style) for style in shown))
        labels.append(label)
    legend(axes, handles, labels)


# The layout of every figure, at any width: panels in rows, one legend, labels that do not touch.
#
# Drawing functions ask for `panels`, and leave what belongs in the legend to `legend` and
# `label_ends`; `finish` puts it in place. The space between is that of a constrained layout.

LEAST, MOST = 0.62, 0.8  # height of a panel over its width where the figure is narrow
PAD = 0.06  # inches around the axes and between panels
WIDE, BESIDE = 5.0, 0.27  # inches from which a legend may take this part of the width
AT_ENDS = 0.3  # of the width of a panel, that labels at the ends of lines may take
NEAR = 0.7  # of that width, from which on a line ends at the right
LINE = 1.35  # distance of two lines of text, in font sizes
GAP = 6.0  # points from the axes to a label
APART = 4.0  # pixels, at least, between the labels of ticks
ATTEMPTS = 6  # to have fewer ticks, and shorter lines
SHRINK = 0.9  # of the number of letters in a line, in each attempt to make it fit
UNBROKEN = "\u00a0"


@dataclass(frozen=True)
class Label:
    """The end (x, y) of a line in data coordinates; its text, colour and marker."""

    x: float
    y: float
    text: str
    color: str
    marker: str = ""


class Canvas(Figure):
    """A figure that keeps what `finish` puts in place.

    natural  its width and height in inches where width is not limited
    columns  number of panels side by side
    entries  label -> handle of its legend
    ends     of each panel, the labels at the ends of its lines
    """

    def __init__(self, natural: tuple[float, float], width: float) -> None:
        self.natural, self.columns = natural, 1
        self.entries: dict[str, Any] = {}
        self.ends: list[tuple[Axes, list[Annotation], Sequence[Label]]] = []
        super().__init__(figsize=(width, _height(natural, width)), layout="constrained")
        FigureCanvasAgg(self)
        spaces = {name: PAD for name in ("w_pad", "h_pad")} | {"wspace": 0.04, "hspace": 0.06}
        self.get_layout_engine().set(**spaces)  # type: ignore[union-attr, call-arg]


def panels(
    axes: Axes, count: int, *, least: float = 2.6, columns: int = 0, **keywords: Any
) -> list[Axes]:
    """`count` axes in place of these: side by side as far as each is `least` inches wide, else in
    rows; in so many columns at any width where these are given.

    keywords  of `Figure.add_subplot`
    """
    canvas = axes.get_figure(root=True)
    wide, high = canvas.natural
    across = canvas.get_figwidth()
    rows = math.ceil(count / (columns or max(1, min(count, int(across / least)))))
    canvas.columns = columns or math.ceil(count / rows)
    each = _height((wide / count, high), across / canvas.columns)
    canvas.set_figheight(max(high, canvas.get_figheight()) if columns else rows * each)
    places = axes.get_subplotspec()
    axes.remove()
    grid = places.subgridspec(rows, canvas.columns)  # type: ignore[union-attr]
    return [canvas.add_subplot(grid[k], **keywords) for k in range(count)]


def share_y_label(places: Sequence[Axes], label: str) -> None:
    """The label of a vertical axis that panels have in common, at the first of each row."""
    columns = places[0].get_figure(root=True).columns
    for one in places[::columns]:
        one.set_ylabel(label)


def legend(
    axes: Axes, handles: Iterable[Any] | None = None, labels: Iterable[str] | None = None
) -> None:
    """Entries of the figure's legend, which is outside all axes; those of the axes by default."""
    if handles is None or labels is None:
        handles, labels = axes.get_legend_handles_labels()
    axes.get_figure(root=True).entries.update(zip(labels, handles, strict=True))


def mark_rounding(axes: Axes) -> None:
    """A line at the machine epsilon, below which errors are rounding, and its entry."""
    line = axes.axhline(np.finfo(float).eps, color=GUIDE, linestyle=(0, (1, 2)), linewidth=1.0)
    legend(axes, [line], [f"machine epsilon, {readable(np.finfo(float).eps, 2)}"])


def label_ends(axes: Axes, labels: Sequence[Label]) -> None:
    """Write each label right of the axes, beside the end of its line; in the legend where they are
    too long for that, or a line ends elsewhere. Call when the limits of the axes are final."""
    notes = [
        axes.annotate(
            label.text, (1.0, label.y), xycoords=("axes fraction", "data"), xytext=(GAP, 0.0),
            textcoords="offset points", color=darker(label.color), va="center",
            fontsize=rcParams["legend.fontsize"], annotation_clip=False,
        )
        for label in labels
    ]  # fmt: skip
    axes.get_figure(root=True).ends.append((axes, notes, labels))


def finish(canvas: Canvas) -> None:
    """Put legend and labels in place, break lines that are too long, and keep the layout."""
    _long_ends_to_the_legend(canvas)
    if canvas.entries:
        _legend(canvas)
    canvas.draw_without_rendering()
    for _ in range(ATTEMPTS):  # a label in two lines leaves less room for a title
        if not any([_fitted(canvas, axes) for axes in canvas.axes]):
            break
        canvas.draw_without_rendering()
    for axes, notes, labels in canvas.ends:
        _apart(axes, notes, labels)
    canvas.draw_without_rendering()
    canvas.set_layout_engine("none")


def spread(
    wanted: Sequence[float], heights: Sequence[float], low: float, high: float
) -> list[float]:
    """Centres near the wanted ones (ascending) such that the boxes do not overlap.

    Boxes move up from below, then down from `high`; `low` is ignored when there is no room.
    """
    places: list[float] = []
    for centre, height in zip(wanted, heights, strict=True):
        floor = places[-1] + 0.5 * (heights[len(places) - 1] + height) if places else low
        places.append(max(centre, floor))
    ceiling = high
    for k in reversed(range(len(places))):
        places[k] = min(places[k], ceiling if k == len(places) - 1 else ceiling - 0.5 * heights[k])
        ceiling = places[k] - 0.5 * heights[k]
    return places


def wrapped(text: str, letters: int) -> str:
    """The text in lines of at most so many letters, without a break within mathematics."""
    whole = re.sub(r"\$[^$]*\$", lambda found: found[0].replace(" ", UNBROKEN), text)
    whole = re.sub(r" (?=\[[^]]{1,12}\]|\$[^$]{1,3}\$$)", UNBROKEN, whole)  # units and symbols
    lines = textwrap.wrap(whole.replace("\n", " "), max(letters, 8), break_long_words=False)
    return "\n".join(lines).replace(UNBROKEN, " ")


def _height(natural: tuple[float, float], width: float) -> float:
    """Of a panel so wide: in proportion, but not too flat or tall where it is made narrower."""
    ratio = natural[1] / natural[0]
    return width * (ratio if width >= natural[0] else min(max(ratio, LEAST), MOST))


def _long_ends_to_the_legend(canvas: Canvas) -> None:
    """Labels at the ends of lines, in all panels, become entries where they cannot stand there."""
    room = AT_ENDS * canvas.get_figwidth() / canvas.columns
    notes = [note for _, some, _ in canvas.ends for note in some]
    fits = max((_inches(note, canvas)[0] for note in notes), default=0.0) <= room
    if fits and all(_at_the_right(axes, one) for axes, _, labels in canvas.ends for one in labels):
        return
    for note in notes:
        note.remove()
    lines = {
        one.text.replace("\n", " "): Line2D([], [], color=one.color, marker=one.marker)
        for _, _, labels in canvas.ends
        for one in labels
    }
    canvas.entries = lines | canvas.entries
    canvas.ends.clear()


def _at_the_right(axes: Axes, label: Label) -> bool:
    """Whether a line ends near the right edge of its axes."""
    place = axes.transData.transform((label.x, label.y))
    return float(axes.transAxes.inverted().transform(place)[0]) > NEAR


def _legend(canvas: Canvas) -> None:
    """Right of the axes where it is slim, else below them in as many columns as fit."""
    across = canvas.get_figwidth() - 4.0 * PAD
    found = _drawn_legend(canvas, "outside right upper", 1)
    if across > WIDE and not canvas.ends and _inches(found, canvas)[0] <= BESIDE * across:
        return
    found.remove()
    letters = max(len(text) for text in canvas.entries)
    columns = min(4, len(canvas.entries))
    found = _drawn_legend(canvas, "outside lower center", columns)
    while _inches(found, canvas)[0] > across and (columns > 1 or letters > 20):
        found.remove()
        if columns > 1:
            columns -= 1
        else:
            letters = int(SHRINK * letters)
        found = _drawn_legend(canvas, "outside lower center", columns, letters)
    canvas.set_figheight(canvas.get_figheight() + _inches(found, canvas)[1])


def _drawn_legend(canvas: Canvas, place: str, columns: int, letters: int = 10_000) -> Legend:
    handles = list(canvas.entries.values())
    labels = [text if "\n" in text else wrapped(text, letters) for text in canvas.entries]
    most = max(len(one) if isinstance(one, tuple) else 1 for one in handles)
    return canvas.legend(
        handles, labels, loc=place, ncols=columns, borderaxespad=0.2,
        handlelength=2.6 if most == 1 else min(1.7 * most, 6.0),
        handler_map={tuple: HandlerTuple(ndivide=None, pad=0.3)},
    )  # fmt: skip


def _inches(artist: Any, canvas: Canvas) -> tuple[float, float]:
    """Width and height."""
    box = artist.get_window_extent(canvas.canvas.get_renderer())  # type: ignore[attr-defined]
    return box.width / canvas.dpi, box.height / canvas.dpi


def _fitted(canvas: Canvas, axes: Axes) -> bool:
    """Break title and labels that are longer than their side of the axes; whether one was."""
    box = axes.get_window_extent()
    changed = False
    for text, room, side in (
        (axes.xaxis.label, box.width, "width"),
        (axes.yaxis.label, box.height, "height"),
        (axes.title, box.width, "width"),
        (axes._left_title, box.width, "width"),  # type: ignore[attr-defined]
    ):
        changed |= _broken(canvas, text, room, side)
    for axis, side in ((axes.xaxis, "width"), (axes.yaxis, "height")):
        changed |= _thinned(canvas, axis, side)
    return changed


def _broken(canvas: Canvas, text: Text, room: float, side: str) -> bool:
    words = text.get_text()
    letters, changed = len(words), False
    while letters > 12 and getattr(text.get_window_extent(), side) > room:
        letters, changed = int(SHRINK * letters), True
        text.set_text(wrapped(words, letters))
    return changed


def _thinned(canvas: Canvas, axis: Axis, side: str) -> bool:
    """Fewer ticks where their labels touch."""
    end = {"width": ("x0", "x1"), "height": ("y0", "y1")}[side]
    changed = False
    for _ in range(ATTEMPTS):
        boxes = [one.get_window_extent() for one in axis.get_ticklabels() if one.get_text()]
        edges = sorted((getattr(box, end[0]), getattr(box, end[1])) for box in boxes)
        touch = any(b[0] < a[1] + APART for a, b in itertools.pairwise(edges))
        if not touch or axis.get_ticklabels()[0].get_rotation() or not fewer(axis):
            break
        changed = True
    return changed


def _apart(axes: Axes, notes: Sequence[Annotation], labels: Sequence[Label]) -> None:
    """Move labels at the ends of lines apart, within the height of the axes."""
    scale = 72.0 / axes.figure.dpi
    ends = axes.transData.transform([(1.0, label.y) for label in labels]) * scale
    low, high = axes.get_window_extent().intervaly * scale
    size = float(rcParams["legend.fontsize"])
    heights = [LINE * size * (1 + label.text.count("\n")) for label in labels]
    order = np.argsort(ends[:, 1], kind="stable")
    places = spread([float(ends[k, 1]) for k in order], [heights[k] for k in order], low, high)
    for k, place in zip(order, places, strict=True):
        notes[k].set_position((GAP, place - ends[k, 1]))
