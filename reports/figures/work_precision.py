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
from reports.figures.style.identities import OURS, identity, in_order
from reports.figures.style.layout import NoData, contender_legend, legend, split

TIME = "time to solution [s]"


def work_precision(axes: Axes, table: pd.DataFrame, *, ylabel: str) -> None:
    """One problem: the front of each code in error and time, of galvi one for each degree, with the
    intervals of times. Errors are those that count in tables too; bounds have a mark of their own.
    The run that is the truth has a time only, a dotted line in its colour."""
    axes.set(xscale="log", yscale="log", xlabel=TIME, ylabel=ylabel)
    fronts = front(table.assign(contender=table["contender"].map(line_of)))
    names = in_order(fronts["contender"])
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
    """The line that a contender's runs are on: of galvi's methods their degree's, whatever points
    and chart; the general kernel, frames and clocks have their own."""
    degree = re.match(r"galvi degree \d+", contender)
    return contender if degree is None or contender.endswith("general kernel") else degree[0]


def plot_front(axes: Axes, runs: pd.DataFrame, name: str, **line: Any) -> None:
    """The runs of a front in the look of a name: a line, bars from `seconds_low` to `seconds_high`,
    and an open mark with an arrow downwards at each error that is a bound alone."""
    style = identity(name).style
    axes.plot(runs["seconds"], runs["error"], **style, markersize=4.0, **line)
    low, high = (
        runs.get(end, runs["seconds"]).fillna(runs["seconds"])
        for end in ("seconds_low", "seconds_high")
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
    """A panel for each problem (name -> title), with a common axis of errors and one legend.

    Parameters
    ----------
    shown
        label -> how the names of its contenders begin; its line is the front of all their runs
    marked
        (contender, step, label): a circle on its line where that step would be
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
            at = at_step(runs[runs["problem"] == problem], contender, step)
            if at is not None:
                circle = {"color": identity(contender).color, "mfc": "none", "markersize": 9.0}
                legend(plane, plane.plot(at[1], at[0], "o", linestyle="none", **circle), [label])


def at_step(rows: pd.DataFrame, contender: str, step: float) -> tuple[float, float] | None:
    """(error, seconds) of a contender's run at a step; None without one."""
    runs = rows[(rows["contender"] == contender) & (rows["error"] > 0) & (rows["seconds"] > 0)]
    steps = pd.to_numeric(runs["settings"].str.extract(r"step=([\d.e-]+)")[0])
    at_it = runs.loc[np.isclose(steps, step, rtol=1e-4), ["error", "seconds"]]
    return None if at_it.empty else (float(at_it["error"].iloc[0]), float(at_it["seconds"].iloc[0]))
