"""Error against time to solution, both logarithmic: further left and lower is better."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import pandas as pd
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from benchmarks.work_precision.fronts import front
from reports.figures.style.chart_lines import chart_line
from reports.figures.style.contender_looks import contender_looks
from reports.figures.style.decades import decades, readable
from reports.figures.style.no_data import NoData
from reports.figures.style.palette import GUIDE
from reports.tables.matched_error import is_ours


def work_precision(
    axes: Axes, frame: pd.DataFrame, *, ylabel: str, contenders: Sequence[str]
) -> None:
    """One problem: the median time of each setting with its interval, one look per contender.

    Lines join a contender's Pareto front; hollow points are dominated runs. Failed runs have no
    point; the run that is the truth has a time only, a dotted line in its contender's colour.
    """
    measured = frame[(frame["error"] > 0) & (frame["seconds"] > 0)]
    if measured.empty:
        raise NoData("no contender has both an error and a time.")
    axes.set(xscale="log", yscale="log", xlabel="time to solution [s]", ylabel=ylabel)
    fronts, handles = front(measured), []
    looks = contender_looks(contenders, is_ours)
    for name, look in looks.items():
        runs = measured[measured["contender"] == name]
        if runs.empty:
            continue
        line = {"linestyle": dashes(name), "markersize": 5.5, **look}
        _intervals(axes, runs, look)
        axes.plot(runs["seconds"], runs["error"], **{**line, "linestyle": "none", "mfc": "white"})
        best = fronts[fronts["contender"] == name]
        axes.plot(best["seconds"], best["error"], **line)
        handles.append(Line2D([], [], label=name, **line))
    for _, truth in frame[(frame["status"] == "truth") & (frame["seconds"] > 0)].iterrows():
        color = looks.get(truth["contender"], {}).get("color", GUIDE)
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
    axes.legend(handles=handles, loc="upper left", bbox_to_anchor=(1.01, 1.0), borderaxespad=0.0)


def dashes(contender: str) -> Any:
    """The line of its chart for galvi; dashed for other codes."""
    return chart_line(contender) if is_ours(contender) else (0, (4, 2))


def _intervals(axes: Axes, runs: pd.DataFrame, look: Mapping[str, str]) -> None:
    """Error bars from the fastest to the slowest round."""
    axes.hlines(
        runs["error"],
        runs["seconds_low"].fillna(runs["seconds"]),
        runs["seconds_high"].fillna(runs["seconds"]),
        color=look["color"],
        linewidth=0.9,
        alpha=0.8,
    )
