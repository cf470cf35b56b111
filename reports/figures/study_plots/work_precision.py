"""Error against time to solution, both logarithmic: further left and lower is better."""

from __future__ import annotations

import pandas as pd
from matplotlib.axes import Axes

from benchmarks.work_precision.fronts import front
from reports.figures.style.decades import decades, readable
from reports.figures.style.identities import Identity, identity, in_order
from reports.figures.style.legends import contender_legend
from reports.figures.style.no_data import NoData


def work_precision(axes: Axes, frame: pd.DataFrame, *, ylabel: str) -> None:
    """One problem: the median time of each setting with its interval, one look per contender.

    Lines join a contender's Pareto front; hollow points are dominated runs. Failed runs have no
    point; the run that is the truth has a time only, a dotted line in its contender's colour.
    """
    measured = frame[(frame["error"] > 0) & (frame["seconds"] > 0)]
    if measured.empty:
        raise NoData("no contender has both an error and a time.")
    axes.set(xscale="log", yscale="log", xlabel="time to solution [s]", ylabel=ylabel)
    fronts, names = front(measured), in_order(measured["contender"])
    for name in names:
        look, runs = identity(name), measured[measured["contender"] == name]
        style = {**look.style, "markersize": 4.5, "linewidth": 1.2}
        _intervals(axes, runs, look)
        axes.plot(runs["seconds"], runs["error"], **{**style, "linestyle": "none", "mfc": "white"})
        best = fronts[fronts["contender"] == name]
        axes.plot(best["seconds"], best["error"], **style)
    for _, truth in frame[(frame["status"] == "truth") & (frame["seconds"] > 0)].iterrows():
        color = identity(truth["contender"]).color
        axes.axvline(truth["seconds"], color=color, linestyle=(0, (1, 2)), linewidth=0.9, zorder=1)
        axes.annotate(
            f"truth: {truth['settings']}",
            (truth["seconds"], 0.02),
            xycoords=("data", "axes fraction"),
            xytext=(-2, 0),
            textcoords="offset points",
            rotation=90,
            ha="right",
            va="bottom",
            fontsize=7,
            color=color,
        )
    decades(axes.yaxis)
    readable(axes.xaxis)
    contender_legend(axes, names)


def _intervals(axes: Axes, runs: pd.DataFrame, look: Identity) -> None:
    """Error bars from the fastest to the slowest round."""
    axes.hlines(
        runs["error"],
        runs["seconds_low"].fillna(runs["seconds"]),
        runs["seconds_high"].fillna(runs["seconds"]),
        color=look.color,
        linewidth=0.9,
        alpha=0.8,
    )
