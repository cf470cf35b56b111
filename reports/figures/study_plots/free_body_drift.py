"""Energy and momentum errors of long rotations, one panel each."""

from __future__ import annotations

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from reports.figures.study_plots.work_precision import dashes
from reports.figures.style.contender_looks import contender_looks
from reports.figures.style.decades import decades
from reports.figures.style.no_data import NoData
from reports.tables.matched_error import is_ours

PANELS = {
    "energy_error": "energy, relative",
    "momentum_error": "angular momentum in space, relative",
}
SMALLEST = 1e-17  # drawn in place of 0


def errors_over_turns(axes: Axes, frame: pd.DataFrame, *, problem: str) -> None:
    """The largest error since the previous mark against the number of turns, both logarithmic.

    Of several runs of a contender the longest is drawn, the newest of those; a failed run ends with
    a cross.
    """
    rows = frame[frame["problem"] == problem] if len(frame) else frame
    known = rows[rows["energy_error"].notna()] if len(rows) else rows
    if known.empty:
        raise NoData("no body turned.")
    shown = pd.concat([_run(part) for _, part in rows.groupby("contender", sort=False)])
    looks = contender_looks(list(known["contender"]), is_ours)
    grid = axes.get_subplotspec().subgridspec(1, len(PANELS), wspace=0.3)
    axes.set_axis_off()
    for column, (name, title) in enumerate(PANELS.items()):
        one = axes.figure.add_subplot(grid[column])
        one.set(xscale="log", yscale="log", xlabel="turns", title=title)
        for contender, look in looks.items():
            run = shown[shown["contender"] == contender]
            good = run[run[name].notna()]
            size = np.maximum(np.abs(good[name]), SMALLEST)
            one.plot(good["turn"], size, linestyle=dashes(contender), markersize=4.0, **look)
            if len(good) and len(good) < len(run):
                one.plot(good["turn"].iloc[-1], size.iloc[-1], "x", ms=11.0, color=look["color"])
        decades(one.xaxis)
        decades(one.yaxis)
    handles = [
        Line2D([], [], label=name, linestyle=dashes(name), markersize=5.0, **look)
        for name, look in looks.items()
    ]
    one.legend(handles=handles, loc="upper left", bbox_to_anchor=(1.03, 1.0), borderaxespad=0.0)


def _run(rows: pd.DataFrame) -> pd.DataFrame:
    """The longest run of a contender, the newest of those."""
    longest = rows[rows["turns"] == rows["turns"].max()]
    return longest[longest["date"] == longest["date"].max()].sort_values("turn")
