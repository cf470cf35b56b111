"""Legends of contenders: at most eight entries, beside the axes or below them."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from matplotlib.axes import Axes
from matplotlib.legend_handler import HandlerTuple
from matplotlib.lines import Line2D

from reports.figures.style.identities import grouped, identity

NARROW = 4.2  # inches, below which a legend is under its axes
SHOWN = 6  # markers of an entry that stands for several names
ALONE, LONGEST = 2.6, 6.0  # length of handles in font sizes, of one line and of several


def contender_legend(axes: Axes, names: Iterable[str], **more: Any) -> None:
    """The legend of these contenders, outside the axes."""
    outside(axes, *contender_handles(names), **more)


def contender_handles(names: Iterable[str]) -> tuple[list[tuple[Line2D, ...]], list[str]]:
    """(handles, labels) of `grouped`; an entry of several names shows some of their markers, of
    galvi's one for each degree."""
    handles, labels = [], []
    for label, members in grouped(names):
        looks = [identity(name).style for name in members]
        styles = list({(s["color"], s["marker"]): s for s in reversed(looks)}.values())[::-1]
        stride = max(1, (len(styles) - 1) // (SHOWN - 1)) if len(styles) > SHOWN else 1
        shown = styles[::stride][:SHOWN]
        handles.append(tuple(Line2D([], [], markersize=5.0, **style) for style in shown))
        labels.append(label)
    return handles, labels


def outside(axes: Axes, handles: list[Any], labels: list[str], **more: Any) -> None:
    """A legend right of the axes; below them where the figure is narrow."""
    narrow = axes.figure.get_figwidth() < NARROW
    place = (
        {"loc": "upper center", "bbox_to_anchor": (0.45, -0.22), "ncols": 1}
        if narrow
        else {"loc": "upper left", "bbox_to_anchor": (1.01, 1.0)}
    )
    most = max((len(h) if isinstance(h, tuple) else 1 for h in handles), default=1)
    length = min(1.7 * most, LONGEST) if most > 1 else ALONE
    axes.legend(
        handles, labels, borderaxespad=0.0, handlelength=length,
        handler_map={tuple: HandlerTuple(ndivide=None, pad=0.3)}, **{**place, **more},
    )  # fmt: skip
