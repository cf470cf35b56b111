"""Error against time to solution, both logarithmic: further left and lower is better."""

from __future__ import annotations

import pandas as pd
from matplotlib.axes import Axes

from benchmarks.work_precision.fronts import front
from reports.figures.style.decades import decades, readable
from reports.figures.style.identities import OURS, Identity, identity, in_order
from reports.figures.style.layout import legend
from reports.figures.style.legends import contender_legend
from reports.figures.style.no_data import NoData

MANY = 8  # methods of galvi, above which not all are drawn
FEWER = (
    "Of galvi's methods those that are fastest at some error, and of each other degree the fastest."
)


def work_precision(axes: Axes, frame: pd.DataFrame, *, ylabel: str) -> None:
    """One problem: the median time of each setting with its interval, one look per contender.

    Of many methods of galvi those that `shown` chooses. Lines join a contender's Pareto front;
    hollow points are dominated runs. Failed runs have no point; the run that is the truth has a
    time only, a dotted line in its contender's colour.
    """
    measured = frame[(frame["error"] > 0) & (frame["seconds"] > 0)]
    if measured.empty:
        raise NoData("no contender has both an error and a time.")
    axes.set(xscale="log", yscale="log", xlabel="time to solution [s]", ylabel=ylabel)
    names = shown(measured)
    measured = measured[measured["contender"].isin(names)]
    fronts = front(measured)
    for name in names:
        look, runs = identity(name), measured[measured["contender"] == name]
        style = {**look.style, "markersize": 4.5, "linewidth": 1.2}
        _intervals(axes, runs, look)
        axes.plot(runs["seconds"], runs["error"], **{**style, "linestyle": "none", "mfc": "white"})
        best = fronts[fronts["contender"] == name]
        axes.plot(best["seconds"], best["error"], **style)
    truths = {}
    for _, truth in frame[(frame["status"] == "truth") & (frame["seconds"] > 0)].iterrows():
        color = identity(truth["contender"]).color
        line = axes.axvline(truth["seconds"], color=color, linestyle=(0, (1, 2)), linewidth=0.9,
                            zorder=1)  # fmt: skip
        truths[f"truth: {truth['settings']}"] = line
    decades(axes.yaxis)
    readable(axes.xaxis)
    contender_legend(axes, names)
    legend(axes, truths.values(), truths)


def shown(measured: pd.DataFrame) -> list[str]:
    """The contenders to draw; of more than MANY methods of galvi those on their common front, and
    of each degree without one of them that with most points on the front of this degree."""
    names = in_order(measured["contender"])
    ours = [name for name in names if name.startswith(OURS)]
    if len(ours) <= MANY:
        return names
    runs = measured[measured["contender"].isin(ours)]
    chosen = set(_on_front(runs))
    degrees = {identity(name).color for name in chosen}
    for color, of_degree in runs.groupby(runs["contender"].map(lambda name: identity(name).color)):
        if color not in degrees:
            chosen.add(_on_front(of_degree).value_counts().index[0])
    return [name for name in names if name in chosen or name not in ours]


def _on_front(runs: pd.DataFrame) -> pd.Series:
    """The contenders of the runs that no other of these dominates, as often as they have one."""
    ordered = runs.sort_values(["seconds", "error"])
    best = ordered["error"].cummin().shift(fill_value=float("inf"))
    return ordered[ordered["error"] < best]["contender"]


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
