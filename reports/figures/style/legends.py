"""Legends of contenders: at most eight entries."""

from __future__ import annotations

from collections.abc import Iterable

from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from reports.figures.style.identities import grouped, identity
from reports.figures.style.layout import legend

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
