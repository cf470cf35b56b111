"""Errors and resonances over h omega, and the exchange of energy between stiff springs."""

from __future__ import annotations

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from benchmarks.studies.moving_frames.stiff_springs import (
    CHANGE,
    ERROR,
    EXCHANGE,
    LARGEST,
    RESONANCE,
)
from reports.figures.style.decades import decades
from reports.figures.style.identities import GUIDE, identity, in_order
from reports.figures.style.layout import legend, panels
from reports.figures.style.no_data import NoData


def errors_and_resonances(axes: Axes, frame: pd.DataFrame) -> None:
    """Errors at the end, and the largest change of the stiff energy, over h omega / pi."""
    rows = frame[frame["study"] == RESONANCE]
    if rows.empty:
        raise NoData("no steps were measured.")
    looks = {name: identity(name).style for name in in_order(rows["contender"])}
    for one, quantity in zip(panels(axes, 2), (ERROR, CHANGE), strict=True):
        for name, look in looks.items():
            runs = rows[(rows["contender"] == name) & (rows["quantity"] == quantity)]
            runs = runs.sort_values("x")
            one.plot(runs["x"] / np.pi, runs["value"], label=name, **{**look, "markersize": 3.0})
        for k in range(1, int(LARGEST / np.pi) + 1):
            one.axvline(k, color=GUIDE, linewidth=0.6, linestyle=(0, (1, 3)))
        one.set(yscale="log", xlabel=r"$h\omega / \pi$", title=quantity)
        decades(one.yaxis)
    legend(one)


def energy_exchange(axes: Axes, frame: pd.DataFrame) -> None:
    """The energies of the stiff springs and their sum over time."""
    rows = frame[(frame["study"] == EXCHANGE) & (frame["quantity"] != ERROR)]
    if rows.empty:
        raise NoData("the exchange was not measured.")
    table = rows.pivot(index="x", columns="quantity", values="value")
    for name in table:
        axes.plot(table.index, table[name], linewidth=0.8, label=f"${name}$")
    axes.plot(table.index, table.sum(axis=1), linewidth=0.8, color=GUIDE, label="sum")
    axes.set(xlabel="t", ylabel="energy [problem's unit]")
    legend(axes)
