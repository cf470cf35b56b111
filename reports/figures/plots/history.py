"""A quantity against time, with the range of its first half, to show drift."""

from __future__ import annotations

import pandas as pd
from matplotlib.axes import Axes

from benchmarks.store.frames import pick
from reports.figures.style.layout import legend
from reports.figures.style.no_data import NoData
from reports.figures.style.palette import BAND, COLOURS

TIME = "time $t$ [unit of time; the period is $2\\pi$]"
MANY = 300  # above this many, points are not joined


def history(
    axes: Axes, frame: pd.DataFrame, *, quantity: str, ylabel: str, xlabel: str = TIME
) -> None:
    """Values at step ends, over a band that spans the values of the first half.

    An error that grows with time leaves the band in the second half.
    """
    rows = pick(frame, study="history", quantity=quantity).sort_values("t")
    rows = rows[rows["value"].notna()]
    if rows.empty:
        raise NoData(f"no step has a finite {quantity}.")
    t, value = rows["t"].to_numpy(float), rows["value"].to_numpy(float)
    first = value[t <= 0.5 * (t[0] + t[-1])]
    axes.axhspan(first.min(), first.max(), color=BAND, zorder=0, label="range over the first half")
    many = len(t) > MANY
    axes.plot(
        t,
        value,
        marker=".",
        markersize=2.0 if many else 4.0,
        linestyle="none" if many else "-",
        linewidth=0.6,
        color=COLOURS[0],
        rasterized=many,
    )
    axes.set(xlabel=xlabel, ylabel=ylabel)
    axes.ticklabel_format(axis="x", style="plain")
    axes.margins(x=0.01, y=0.15)
    legend(axes)
