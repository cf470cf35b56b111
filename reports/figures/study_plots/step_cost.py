"""Time per step of each method."""

from __future__ import annotations

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from benchmarks.work_precision.described import described
from reports.figures.style.identities import blue
from reports.figures.style.no_data import NoData
from reports.figures.style.palette import GUIDE
from reports.tables.number_format import readable


def step_cost(axes: Axes, frame: pd.DataFrame) -> None:
    """Microseconds per step as dots, each labelled with the iterations."""
    rows = frame[frame["seconds_per_step"] > 0]
    if rows.empty:
        raise NoData("no method has a time for a step.")
    places = -np.arange(len(rows), dtype=float)
    for place, (_, row) in zip(places, rows.iterrows(), strict=True):
        time = 1e6 * row["seconds_per_step"]
        axes.plot(time, place, "o", markersize=6, color=blue(8))
        axes.annotate(
            f"{readable(row['iterations_per_step'], 2)} iterations, {row['solver']}",
            (time, place),
            xytext=(8, 0),
            textcoords="offset points",
            va="center",
            fontsize=7.5,
            color=GUIDE,
        )
    names = [
        f"{described(row['problem']).title}: {row['method']}, h = {row['step']:.3g}"
        for _, row in rows.iterrows()
    ]
    axes.set_yticks(places, names)
    axes.set(xscale="log", xlabel="time for one step [µs]")
    axes.grid(axis="y", visible=False)
