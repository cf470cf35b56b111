"""Energy and momentum errors of long rotations, one panel each."""

from __future__ import annotations

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from reports.figures.style.decades import decades
from reports.figures.style.identities import identity, in_order
from reports.figures.style.layout import panels, share_y_label
from reports.figures.style.legends import contender_legend
from reports.figures.style.no_data import NoData

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
    names = in_order(known["contender"])
    places = panels(axes, len(PANELS))
    share_y_label(places, "largest error since the last mark [1]")
    for one, (name, title) in zip(places, PANELS.items(), strict=True):
        one.set(xscale="log", yscale="log", xlabel="turns", title=title)
        for contender in names:
            look = identity(contender)
            run = shown[shown["contender"] == contender]
            good = run[run[name].notna()]
            size = np.maximum(np.abs(good[name]), SMALLEST)
            one.plot(good["turn"], size, markersize=4.0, **look.style)
            if len(good) and len(good) < len(run):
                one.plot(good["turn"].iloc[-1], size.iloc[-1], "x", ms=11.0, color=look.color)
        decades(one.xaxis)
        decades(one.yaxis)
    contender_legend(one, names)


def _run(rows: pd.DataFrame) -> pd.DataFrame:
    """The longest run of a contender, the newest of those."""
    longest = rows[rows["turns"] == rows["turns"].max()]
    return longest[longest["date"] == longest["date"].max()].sort_values("turn")
