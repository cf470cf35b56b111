"""Errors of methods against their step and against their cost."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from benchmarks.statistics.orders import BOUND, ROUND_OFF
from reports.figures.style.decades import decades, readable
from reports.figures.style.identities import COLOURS, GUIDE, MARKERS
from reports.figures.style.layout import NoData, legend, panels, share_y_label
from reports.tables.number_format import concise, known

LINES = ("-", (0, (4, 2)), (0, (1, 1.4)))  # of each seven methods


def orders(axes: Axes, frame: pd.DataFrame, *, ylabel: str, unit: str = "unit of time") -> None:
    """Two panels with a common axis of errors: against the step, with the fitted slopes in the
    legend, and against the time of a run. Hollow points are not in the fit, or not resolved.

    frame  rows of `benchmarks.applications.convergence.table`
    """
    measured = frame[frame["error"] > 0.0]
    if measured.empty:
        raise NoData("no run has a finite error.")
    by_step, by_cost = panels(axes, 2, least=2.9)
    by_cost.sharey(by_step)
    share_y_label([by_step, by_cost], ylabel)
    by_step.set(xscale="log", yscale="log", xlabel=f"step size $h$ [{unit}]")
    by_cost.set(xscale="log", yscale="log", xlabel="time of a run [s]")
    entries: dict[str, Line2D] = {}
    for k, (method, rows) in enumerate(measured.groupby("method", sort=False)):
        style = {
            "color": COLOURS[k % len(COLOURS)], "marker": MARKERS[k % len(MARKERS)],
            "linestyle": LINES[k // len(COLOURS) % len(LINES)],
        }  # fmt: skip
        steps = rows[rows["h"].notna()].sort_values("h")
        _points(by_step, steps, "h", steps["fit"].astype(bool), style)
        _slope(by_step, steps, style)
        timed = rows[rows["seconds"] > 0.0].sort_values("error")
        _points(by_cost, timed, "seconds", ~timed["note"].isin((BOUND, ROUND_OFF)), style)
        name = str(method).replace("$", r"\$")
        if known(rows["fitted"].iloc[0]):
            name += f", order {concise(rows['fitted'].iloc[0], rows['fitted_se'].iloc[0])}"
        entries[name] = Line2D([], [], **style)
    hollow = Line2D([], [], color=GUIDE, marker="o", markerfacecolor="white", linestyle="none")
    entries["not in the fit, or not resolved"] = hollow
    for one in (by_step, by_cost):
        readable(one.xaxis)
    decades(by_step.yaxis)
    legend(by_step, entries.values(), entries)


def _points(
    axes: Axes, rows: pd.DataFrame, against: str, filled: pd.Series, style: Mapping[str, Any]
) -> None:
    """A thin line through all rows, and their points, hollow where they are not `filled`."""
    x, error = rows[against].to_numpy(float), rows["error"].to_numpy(float)
    axes.plot(x, error, **{**style, "marker": ""}, linewidth=0.7, alpha=0.6)
    full = filled.to_numpy(bool)
    for seen, face in ((full, style["color"]), (~full, "white")):
        axes.plot(x[seen], error[seen], **{**style, "linestyle": "none"}, markerfacecolor=face)


def _slope(axes: Axes, rows: pd.DataFrame, style: Mapping[str, Any]) -> None:
    """The fitted power of h, through the middle of the points of the fit."""
    used = rows[rows["fit"].astype(bool)]
    if used.empty or not known(used["fitted"].iloc[0]):
        return
    h, error, order = (used[name].to_numpy(float) for name in ("h", "error", "fitted"))
    middle = np.exp(np.mean(np.log(error) - order * np.log(h)))
    axes.plot(h, middle * h**order, **{**style, "marker": ""}, linewidth=1.6)
