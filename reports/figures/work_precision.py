"""Plots of comparisons: error against time, and the headlines."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from benchmarks.work_precision.fronts import front
from reports.figures.style.decades import decades, error_label, readable
from reports.figures.style.identities import OURS, blue, identity, in_order
from reports.figures.style.layout import (
    NoData,
    contender_legend,
    legend,
    share_y_label,
)
from reports.figures.style.layout import panels as side_by_side


def work_precision(axes: Axes, frame: pd.DataFrame, *, ylabel: str) -> None:
    """One problem: the front of each code in error and time, of galvi one for each degree, with the
    intervals of times. Errors are those that count in tables too; bounds have a mark of their own.
    The run that is the truth has a time only, a dotted line in its colour."""
    measured = frame[(frame["error"] > 0) & (frame["seconds"] > 0)]
    if measured.empty:
        raise NoData("no contender has both an error and a time.")
    axes.set(xscale="log", yscale="log", xlabel="time to solution [s]", ylabel=ylabel)
    fronts = front(measured.assign(contender=measured["contender"].map(line_of)))
    names = in_order(fronts["contender"])
    for name in names:
        look, best = identity(name), fronts[fronts["contender"] == name]
        axes.plot(best["seconds"], best["error"], **{**look.style, "markersize": 4.0, "lw": 1.2})
        intervals(axes, best, look.color)
        bounds(axes, best, look.color)
    truths = {}
    for _, truth in frame[frame["is_truth"] & (frame["seconds"] > 0)].iterrows():
        color = identity(truth["contender"]).color
        line = axes.axvline(truth["seconds"], color=color, linestyle=(0, (1, 2)), linewidth=0.9,
                            zorder=1)  # fmt: skip
        truths[f"truth: {truth['settings']}"] = line
    decades(axes.yaxis)
    readable(axes.xaxis)
    contender_legend(axes, names)
    legend(axes, truths.values(), truths)


def line_of(contender: str) -> str:
    """The line that a contender's runs are on: of galvi's methods their degree's, whatever points
    and chart; the general kernel, frames and clocks have their own."""
    found = re.match(r"galvi degree \d+", contender)
    return contender if found is None or contender.endswith("general kernel") else found[0]


def intervals(axes: Axes, runs: pd.DataFrame, color: str) -> None:
    """Bars at the times of these runs, from `seconds_low` to `seconds_high`."""
    low, high = (
        runs.get(name, runs["seconds"]).fillna(runs["seconds"])
        for name in ("seconds_low", "seconds_high")
    )
    axes.hlines(runs["error"], low, high, color=color, linewidth=0.9, alpha=0.8)


def bounds(axes: Axes, runs: pd.DataFrame, color: str) -> None:
    """An open marker with an arrow downwards at each run whose error is a bound alone."""
    below = runs[runs["error_is_bound"]]
    axes.errorbar(
        below["seconds"], below["error"], yerr=0.7 * below["error"], uplims=True, fmt="o",
        color=color, mfc="white", markersize=5.0, elinewidth=1.0, zorder=4,
    )  # fmt: skip


@dataclass(frozen=True)
class Shown:
    """A line: its label, and how the names of its contenders begin."""

    label: str
    begins: str

    def runs(self, frame: pd.DataFrame) -> pd.DataFrame:
        """The fastest run for each error among its contenders, by falling error."""
        mine = frame[frame["contender"].str.startswith(self.begins)]
        return front(mine.assign(contender=self.label)).sort_values("error", ascending=False)


def headline(
    axes: Axes, frame: pd.DataFrame, *, panels: Mapping[str, str], shown: Sequence[Shown],
    marked: tuple[str, float, str] | None = None,
) -> None:  # fmt: skip
    """A panel for each problem (name -> title), with a common axis of errors and one legend.

    Parameters
    ----------
    marked
        (contender, step, label): a circle on its line where that step would be
    """
    known = [name for name in panels if (frame["problem"] == name).any()]
    if not known:
        raise NoData("its problems were not compared.")
    drawn: dict[str, Line2D] = {}
    places = side_by_side(axes, len(known))
    quantity = frame.loc[frame["problem"] == known[0], "quantity"].iloc[0]
    share_y_label(places, error_label(known[0], quantity))
    for one in places[1:]:
        one.sharey(places[0])
    for one, name in zip(places, known, strict=True):
        rows = frame[frame["problem"] == name]
        one.set(xscale="log", yscale="log", xlabel="time to solution [s]")
        one.set_title(panels[name])
        lines = {line.label: found for line in shown if (found := _line(one, rows, line))}
        if not lines:
            raise NoData(f"{name}: no contender has both an error and a time.")
        if marked is not None:
            lines |= _mark(one, rows, *marked)
        decades(one.yaxis)
        readable(one.xaxis)
        drawn = lines | drawn
    labels = [line.label for line in shown] + ([marked[2]] if marked else [])
    names = [name for name in labels if name in drawn]
    legend(one, [drawn[name] for name in names], names)


def _line(axes: Axes, rows: pd.DataFrame, line: Shown) -> Line2D | None:
    runs = line.runs(rows)
    if runs.empty:
        return None
    look = identity(line.begins)
    ours = line.begins == OURS
    style = {**look.style, "color": blue(8), "linewidth": 2.4} if ours else look.style
    (drawn,) = axes.plot(runs["seconds"], runs["error"], markersize=4.0, **style)
    intervals(axes, runs, style["color"])
    bounds(axes, runs, style["color"])
    return drawn


def _mark(
    axes: Axes, rows: pd.DataFrame, contender: str, step: float, label: str
) -> dict[str, Line2D]:
    """An open circle, by its label, round the run at this step."""
    found = at_step(rows, contender, step)
    if found is None:
        return {}
    error, seconds = found
    color = identity(contender).color
    (drawn,) = axes.plot(
        seconds, error, "o", markersize=9.0, mfc="none", color=color, linestyle="none"
    )
    return {label: drawn}


def at_step(rows: pd.DataFrame, contender: str, step: float) -> tuple[float, float] | None:
    """(error, seconds) of a contender's run at a step; None without one."""
    runs = rows[(rows["contender"] == contender) & (rows["error"] > 0) & (rows["seconds"] > 0)]
    steps = pd.to_numeric(runs["settings"].str.extract(r"step=([\d.e-]+)")[0])
    found = runs[np.isclose(steps, step, rtol=1e-4)]
    if found.empty:
        return None
    return float(found["error"].iloc[0]), float(found["seconds"].iloc[0])
