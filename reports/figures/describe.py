"""A figure in words, from what was drawn: the alternative text of its picture."""

from __future__ import annotations

import re
from collections.abc import Iterator

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure as Canvas

MOST = 8  # texts that are listed of one kind
SIGNS = {
    r"\pi": "pi", r"\infty": "infinity", r"\leq": "<=", r"\geq": ">=", r"\times": "x",
    r"\cdot": "*", r"\,": "", r"\mu": "mu", r"\pm": "±",
}  # fmt: skip


def describe(canvas: Canvas) -> str:
    """Sentences on axes, ranges, lines and labels of every panel with data; no mathematics."""
    panels = [one for one in canvas.axes if (one.axison and one.has_data()) or _curves(one)]
    said = [sentence for panel in panels if (sentence := _panel(panel))]
    texts = list(dict.fromkeys(text for one in (canvas, *canvas.axes) for text in _texts(one)))
    said += [f"Legend: {_listed(texts)}."] if texts else []
    many = f"{len(panels)} panels. " if len(panels) > 1 else ""
    return many + " ".join(said)


def plain(text: str) -> str:
    """TeX mathematics and line breaks as plain text."""
    for sign, word in SIGNS.items():
        text = text.replace(sign, word)
    text = re.sub(r"\\(?:text|mathrm)?", "", text).replace("$", "")
    return " ".join(re.sub(r"\{([^{}]*)\}", r"\1", text).replace("{", "").replace("}", "").split())


def _panel(axes: Axes) -> str:
    title = plain(axes.get_title(loc="left") or axes.get_title())
    if hasattr(axes, "get_zlim"):
        return f"{title}: in three dimensions." if title else ""
    x, y = (_axis(axes, name) for name in "xy")
    if not (x or y):
        return f"{title}." if title else ""
    return f"{f'{title}: ' if title else ''}{' against '.join(filter(None, (y, x)))}."


def _axis(axes: Axes, name: str) -> str:
    """Its label with the range of the data, as far as there are numbers."""
    label = plain(getattr(axes, f"get_{name}label")())
    ends = np.concatenate([*_numbers(axes, name), []])
    logarithmic = getattr(axes, f"get_{name}scale")() == "log"
    ends = ends[np.isfinite(ends) & ((ends > 0.0) | (not logarithmic))]
    if not label or not ends.size:
        return label
    return f"{label} from {ends.min():.2g} to {ends.max():.2g}"


def _numbers(axes: Axes, name: str) -> Iterator[np.ndarray]:
    for line in _curves(axes):
        data = line.get_xdata() if name == "x" else line.get_ydata()
        yield np.asarray(data, dtype=float).ravel()


def _curves(axes: Axes) -> list:
    """Lines in the coordinates of the data; guides across the axes are not."""
    return [one for one in axes.get_lines() if one.get_transform() == axes.transData]


def _texts(part: Canvas | Axes) -> Iterator[str]:
    """Entries of legends, and labels at lines."""
    legends = part.legends if isinstance(part, Canvas) else [part.get_legend()]
    for one in legends:
        yield from (plain(text.get_text()) for text in (one.get_texts() if one else ()))
    for text in part.texts:
        words = plain(text.get_text())
        if re.search(r"[A-Za-z]{2}|=", words):
            yield words


def _listed(texts: list[str]) -> str:
    rest = len(texts) - MOST
    return "; ".join(texts[:MOST]) + (f"; and {rest} more" if rest > 0 else "")
