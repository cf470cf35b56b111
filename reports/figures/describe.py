"""A figure in words, from what was drawn: the alternative text of its picture."""

from __future__ import annotations

import re

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure as Canvas

MOST = 8  # entries of the legend that are listed
SIGNS = {
    r"\pi": "pi", r"\infty": "infinity", r"\leq": "<=", r"\geq": ">=", r"\times": "x",
    r"\cdot": "*", r"\,": "", r"\mu": "mu", r"\pm": "±",
}  # fmt: skip


def describe(canvas: Canvas) -> str:
    """Sentences on axes, ranges and legend of every panel; no mathematics."""
    panels = [sentence for axes in canvas.axes if (sentence := _panel(axes))]
    entries = [plain(text.get_text()) for drawn in canvas.legends for text in drawn.get_texts()]
    more = f"; and {len(entries) - MOST} more" if len(entries) > MOST else ""
    return " ".join([
        *([f"{len(canvas.axes)} panels."] if len(canvas.axes) > 1 else []),
        *panels,
        *([f"Legend: {'; '.join(entries[:MOST])}{more}."] if entries else []),
    ])  # fmt: skip


def plain(text: str) -> str:
    """TeX mathematics and line breaks as plain text."""
    for sign, word in SIGNS.items():
        text = text.replace(sign, word)
    text = re.sub(r"\\(?:text|mathrm)?|[${}]", "", text)
    return " ".join(text.split())


def _panel(axes: Axes) -> str:
    title = plain(axes.get_title(loc="left") or axes.get_title())
    if hasattr(axes, "get_zlim"):
        what = "in three dimensions" if title else ""
    else:
        what = " against ".join(filter(None, (_axis(axes, "y"), _axis(axes, "x"))))
    sentence = ": ".join(filter(None, (title, what)))
    return f"{sentence}." if sentence else ""


def _axis(axes: Axes, name: str) -> str:
    """Its label with the range of the data, as far as there are numbers; guides across the axes are
    none."""
    label = plain(getattr(axes, f"get_{name}label")())
    lines = [line for line in axes.lines if line.get_transform() == axes.transData]
    data = np.concatenate([[], *(np.asarray(line.get_data()["xy".index(name)], float)
                                 for line in lines)])  # fmt: skip
    shown = np.isfinite(data) & ((data > 0.0) | (getattr(axes, f"get_{name}scale")() != "log"))
    if not label or not shown.any():
        return label
    return f"{label} from {data[shown].min():.2g} to {data[shown].max():.2g}"
