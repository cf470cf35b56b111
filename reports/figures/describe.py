"""The alternative text of a picture, from the artists of its figure."""

from __future__ import annotations

import math
import re

from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.figure import Figure as Canvas

MAX_LEGEND_ENTRIES = 8  # entries of the legend that are listed
SIGNS = {
    r"\pi": "pi",
    r"\infty": "infinity",
    r"\leq": "<=",
    r"\geq": ">=",
    r"\times": "x",
    r"\cdot": "*",
    r"\,": "",
    r"\mu": "mu",
    r"\pm": "±",
}


def describe(canvas: Canvas) -> str:
    """Sentences on the axes, ranges and titles of all panels, and on the legend, in plain text."""
    panels = [sentence for axes in canvas.axes if (sentence := _panel(axes))]
    entries = [plain(text.get_text()) for drawn in canvas.legends for text in drawn.get_texts()]
    omitted = (
        f"; and {len(entries) - MAX_LEGEND_ENTRIES} more"
        if len(entries) > MAX_LEGEND_ENTRIES
        else ""
    )
    return " ".join(
        [
            *([f"{len(canvas.axes)} panels."] if len(canvas.axes) > 1 else []),
            *panels,
            *([f"Legend: {'; '.join(entries[:MAX_LEGEND_ENTRIES])}{omitted}."] if entries else []),
        ]
    )


def plain(text: str) -> str:
    """The text with TeX mathematics in plain characters and on one line."""
    for sign, word in SIGNS.items():
        text = text.replace(sign, word)
    text = re.sub(r"\\(?:text|mathrm)?|[${}]", "", text)
    return " ".join(text.split())


def _panel(axes: Axes) -> str:
    title = plain(axes.get_title(loc="left") or axes.get_title())
    if hasattr(axes, "get_zlim"):
        coordinates = "in three dimensions" if title else ""
    else:
        coordinates = " against ".join(filter(None, map(_axis, (axes.yaxis, axes.xaxis))))
    sentence = ": ".join(filter(None, (title, coordinates)))
    return f"{sentence}." if sentence else ""


def _axis(axis: Axis) -> str:
    """The label of an axis with the range of its data, if that is finite; "" without a label."""
    label = plain(axis.get_label_text())
    low, high = axis.get_data_interval()
    low = axis.get_minpos() if axis.get_scale() == "log" else low
    return f"{label} from {low:.2g} to {high:.2g}" if label and math.isfinite(high - low) else label
