"""Labels beside the ends of lines instead of a legend, moved apart where they overlap."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib import rcParams
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from reports.figures.style.legends import NARROW, outside
from reports.figures.style.palette import darker

LONG = 20  # letters of a label that does not fit beside a narrow figure
LINE = 1.6  # distance of two lines of text, in font sizes


@dataclass(frozen=True)
class Label:
    """The end (x, y) of a line in data coordinates, its text and colour."""

    x: float
    y: float
    text: str
    color: str


def label_ends(
    axes: Axes, labels: Sequence[Label], size: float | None = None, gap: float = 6.0
) -> None:
    """Write each label right of its point; call when the limits of the axes are final.

    size  of the letters in points; None for that of legends

    In a narrow figure long labels are a legend below instead.
    """
    narrow = axes.figure.get_figwidth() < NARROW
    if narrow and max((len(label.text) for label in labels), default=0) > LONG:
        lines = [Line2D([], [], color=label.color) for label in labels]
        outside(axes, lines, [label.text.replace("\n", " ") for label in labels])
        return
    size = size or float(rcParams["legend.fontsize"])
    axes.figure.draw_without_rendering()
    scale = 72.0 / axes.figure.dpi
    ends = axes.transData.transform([(label.x, label.y) for label in labels]) * scale
    low, high = axes.get_window_extent().intervaly * scale
    heights = [LINE * size * (1 + label.text.count("\n")) for label in labels]
    order = np.argsort(ends[:, 1])
    places = spread([float(ends[k, 1]) for k in order], [heights[k] for k in order], low, high)
    for k, place in zip(order, places, strict=True):
        label = labels[k]
        axes.annotate(
            label.text,
            (label.x, label.y),
            xytext=(gap, place - ends[k, 1]),
            textcoords="offset points",
            color=darker(label.color),
            fontsize=size,
            va="center",
            annotation_clip=False,
        )


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
