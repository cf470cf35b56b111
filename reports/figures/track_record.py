"""A benchmark over the commits: normalised time, counts and error, with changes marked."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from reports.figures.style.decades import readable
from reports.figures.style.identities import COLOURS, GUIDE
from reports.figures.style.layout import NoData
from reports.figures.style.layout import panels as side_by_side

COMMITS = 12  # more are not all named


def track_record(axes: Axes, frame: pd.DataFrame, *, panels: Sequence[Any]) -> None:
    """Stacked panels over the same benchmark runs, in order.

    panels  (label, values, changes, logarithmic)
    """
    commits = list(frame["commit"])
    if not commits or not panels:
        raise NoData("it has no benchmark run.")
    places = np.arange(len(commits))
    stacked = side_by_side(axes, len(panels), columns=1)
    for row, (one, (label, values, changes, logarithmic)) in enumerate(
        zip(stacked, panels, strict=True)
    ):
        one.plot(places, values, marker="o", markersize=3.5, linewidth=0.8,
                 color=COLOURS[row % len(COLOURS)])  # fmt: skip
        for change in changes:
            one.axvline(change - 0.5, color=GUIDE, linestyle=(0, (4, 3)), linewidth=1.0)
        known = values[np.isfinite(values)]
        if logarithmic and known.size and known.min() > 0.0:
            one.set_yscale("log")
            readable(one.yaxis)
        elif known.size and known.min() >= 0.0:
            one.set_ylim(0.0, 1.25 * known.max() or 1.0)
        if one.get_yscale() == "linear" and not logarithmic:  # errors may be tiny, some of them 0
            one.ticklabel_format(axis="y", style="plain", useOffset=False)
        one.set_ylabel(label, fontsize=8)
        one.set_xlim(-0.5, len(commits) - 0.5)
        one.tick_params(labelsize=8)
        last = row == len(panels) - 1
        stride = max(1, -(-len(commits) // COMMITS))
        named = [commit[:8] for commit in commits[::stride]] if last else []
        one.set_xticks(places[::stride], named, rotation=40, ha="right") if last else (
            one.set_xticks(places[::stride], [])
        )
