"""Plots of comparisons: error against time, and the headlines."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from benchmarks.work_precision.fronts import front
from reports.figures.style.decades import error_label
from reports.figures.style.identities import OURS, identity, legend_order
from reports.figures.style.layout import NoData, contender_legend, legend, split

TIME = "time to solution [s]"


def work_precision(axes: Axes, table: pd.DataFrame, *, ylabel: str) -> None:
    """Draw the fronts of error and time on one problem: one for each code, for galvi one for each
    degree, with the intervals of the times.

    Errors are those of the tables; bounds have a mark of their own. The run that is the truth has
    no error, and is a vertical dotted line at its time.
    """
    axes.set(xscale="log", yscale="log", xlabel=TIME, ylabel=ylabel)
    fronts = front(table.assign(contender=table["contender"].map(line_of)))
    names = legend_order(fronts["contender"])
    for name in names:
        plot_front(axes, fronts[fronts["contender"] == name], name, linewidth=1.2)
    contender_legend(axes, names)
    for _, truth in table[table["is_truth"] & (table["seconds"] > 0)].iterrows():
        color = identity(truth["contender"]).color
        line = axes.axvline(
            truth["seconds"], color=color, linestyle=(0, (1, 2)), linewidth=0.9, zorder=1
        )
        legend(axes, [line], [f"truth: {truth['settings']}"])


def line_of(contender: str) -> str:
    """The name of the line on which a contender's runs are drawn.

    galvi's methods of one degree share a line, whatever their points and chart, but for the general
    kernel; every other contender has its own.
    """
    degree = re.match(r"galvi degree \d+", contender)
    return contender if degree is None or contender.endswith("general kernel") else degree[0]


def plot_front(axes: Axes, runs: pd.DataFrame, name: str, **line: Any) -> None:
    """Draw the runs of a front in the identity of a name: a line, bars from `seconds_low` to
    `seconds_high`, and an open mark with a downward arrow at each error that is a bound."""
    style = identity(name).style
    axes.plot(runs["seconds"], runs["error"], **style, markersize=4.0, **line)
    low, high = (
        runs.get(column, runs["seconds"]).fillna(runs["seconds"])
        for column in ("seconds_low", "seconds_high")
    )
    axes.hlines(runs["error"], low, high, color=style["color"], linewidth=0.9, alpha=0.8)
    bounds = runs[runs["error_is_bound"]]
    axes.errorbar(
        bounds["seconds"],
        bounds["error"],
        yerr=0.7 * bounds["error"],
        uplims=True,
        fmt="o",
        color=style["color"],
        mfc="white",
        markersize=5.0,
        elinewidth=1.0,
        zorder=4,
    )


def headline(
    axes: Axes,
    table: pd.DataFrame,
    *,
    panels: Mapping[str, str],
    shown: Mapping[str, str],
    marked: tuple[str, float, str] | None = None,
) -> None:
    """Draw a panel for each problem (name -> title), with a common axis of errors and one legend.

    Raises NoData if none of the problems was compared.

    Parameters
    ----------
    shown
        label of a line -> beginning of the names of the contenders whose common front it shows
    marked
        (contender, step, label) of a run that is marked by a circle, where it was made
    """
    runs = table[table["problem"].isin(panels)]
    lines = [
        runs[runs["contender"].str.startswith(begins)].assign(contender=label)
        for label, begins in shown.items()
    ]
    fronts = front(pd.concat(lines, ignore_index=True))
    if fronts.empty:
        raise NoData("its problems were not compared.")
    problems = [problem for problem in panels if problem in set(fronts["problem"])]
    ylabel = error_label(problems[0], fronts["quantity"].iloc[0])
    planes = split(axes, len(problems), ylabel=ylabel, xscale="log", yscale="log", xlabel=TIME)
    for plane in planes[1:]:
        plane.sharey(planes[0])
    for plane, problem in zip(planes, problems, strict=True):
        plane.set_title(panels[problem])
        for label in fronts["contender"].unique():
            best = fronts[(fronts["problem"] == problem) & (fronts["contender"] == label)]
            width = 2.4 if shown[label] == OURS else 1.4
            plot_front(plane, best, shown[label], label=label, linewidth=width)
        if marked is not None:
            contender, step, label = marked
            error_and_seconds = at_step(runs[runs["problem"] == problem], contender, step)
            if error_and_seconds is not None:
                circle = {"color": identity(contender).color, "mfc": "none", "markersize": 9.0}
                legend(
                    plane,
                    plane.plot(
                        error_and_seconds[1], error_and_seconds[0], "o", linestyle="none", **circle
                    ),
                    [label],
                )


def at_step(rows: pd.DataFrame, contender: str, step: float) -> tuple[float, float] | None:
    """(error, seconds) of a contender's run at a step; None if there is no such run."""
    runs = rows[(rows["contender"] == contender) & (rows["error"] > 0) & (rows["seconds"] > 0)]
    steps = pd.to_numeric(runs["settings"].str.extract(r"step=([\d.e-]+)")[0])
    matching_runs = runs.loc[np.isclose(steps, step, rtol=1e-4), ["error", "seconds"]]
    return (
        None
        if matching_runs.empty
        else (float(matching_runs["error"].iloc[0]), float(matching_runs["seconds"].iloc[0]))
    )
