"""Signed change of energy by several methods, over decades of size and of time."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.ticker import FixedLocator

from benchmarks.store.frames import pick
from reports.figures.style.decades import powers, readable
from reports.figures.style.identities import line_color
from reports.figures.style.layout import Label, label_ends
from reports.figures.style.no_data import NoData
from reports.figures.style.palette import BAND

LINEAR = 1e-3  # smaller changes are drawn linearly, larger ones logarithmically
TICKS = (-1e-2, -1e-3, 0.0, 1e-3, 1e-2, 1e-1)


def energies(
    axes: Axes,
    frame: pd.DataFrame,
    *,
    quantity: str,
    labels: Mapping[str, str],
    unit: float,
    xlabel: str = "time [years]",
    ylabel: str = "relative change of energy",
) -> None:
    """A line for each study in `labels`, labelled at its end; a cross where one ends early.

    unit  unit of the time axis, in the frame's unit of time
    """
    ends = []
    axes.axhspan(-LINEAR, LINEAR, color=BAND, zorder=0)
    for k, (study, text) in enumerate(labels.items()):
        rows = pick(frame, study=study, quantity=quantity).sort_values("t")
        t, change = rows["t"].to_numpy(float) / unit, rows["value"].to_numpy(float)
        seen = (t > 0.0) & np.isfinite(change)
        if not np.any(seen):
            raise NoData(f"{study}: no step has a finite {quantity}.")
        t, change, color = t[seen], change[seen], line_color(study, k)
        axes.plot(t, change, color=color, linewidth=1.0)
        ends.append((t[-1], Label(change[-1], text, color)))
    last = max(t for t, _ in ends)
    for t, end in ends:
        if t < last:
            axes.plot(t, end.y, "X", color=end.color, markersize=7)
    axes.set(xscale="log", xlabel=xlabel, ylabel=ylabel)
    axes.set_yscale("symlog", linthresh=LINEAR, linscale=0.8)
    axes.yaxis.set_major_locator(FixedLocator(TICKS))
    powers(axes.yaxis)
    axes.set_ylim(TICKS[0], TICKS[-1])
    readable(axes.xaxis)
    label_ends(axes, [end for _, end in ends])
