"""A benchmark over the commits: normalised time, counts and error, with changes marked."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from reports.figures.style.decades import set_readable_ticks
from reports.figures.style.identities import COLOURS, GUIDE
from reports.figures.style.layout import split

MAX_COMMITS = 12  # largest number of commits that are named on the axis


def track_record(axes: Axes, table: pd.DataFrame, *, panels: Sequence[Any]) -> None:
    """Draw stacked panels over the same benchmark runs.

    Parameters
    ----------
    table
        a row for each run, with its commit
    panels
        (label, values, changes, logarithmic) of each panel; a dashed line precedes each run whose
        index is in `changes`
    """
    commits = [commit[:8] for commit in table["commit"]]
    stride = -(-len(commits) // MAX_COMMITS)
    named_runs = range(0, len(commits), stride)
    stacked = split(axes, len(panels), columns=1)
    for row, (panel, (label, values, changes, logarithmic)) in enumerate(
        zip(stacked, panels, strict=True)
    ):
        panel.plot(values, marker="o", markersize=3.5, linewidth=0.8, color=COLOURS[row])
        for change in changes:
            panel.axvline(change - 0.5, color=GUIDE, linestyle=(0, (4, 3)), linewidth=1.0)
        finite = values[np.isfinite(values)]
        if logarithmic and finite.size and finite.min() > 0.0:
            panel.set_yscale("log")
            set_readable_ticks(panel.yaxis)
        elif finite.size and finite.min() >= 0.0:
            panel.set_ylim(0.0, 1.25 * finite.max() or 1.0)
        if not logarithmic:  # errors may be tiny, some of them 0
            panel.ticklabel_format(axis="y", style="plain", useOffset=False)
        panel.set_ylabel(label, fontsize=8)
        panel.set(xlim=(-0.5, len(commits) - 0.5), xticks=named_runs, xticklabels=[])
    panel.set_xticks(named_runs, commits[::stride], rotation=40, ha="right")
