"""Plots of comparisons: error against time, the headlines, and the cost of a step."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd
from matplotlib import rcParams
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from benchmarks.work_precision.fronts import front
from benchmarks.work_precision.labels import label_of
from reports.figures.style.decades import decades, error_label, readable
from reports.figures.style.identities import OURS, Identity, blue, identity, in_order
from reports.figures.style.layout import (
    UNBROKEN,
    NoData,
    contender_legend,
    legend,
    share_y_label,
    wrapped,
)
from reports.figures.style.layout import panels as side_by_side

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


LEAST = 1e-14  # errors below it are the rounding of the truth


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

    marked  (contender, step, label): a circle on its line where that step would be
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
    runs = runs[runs["error"] >= LEAST]
    if runs.empty:
        return None
    look = identity(line.begins)
    ours = line.begins == OURS
    style = {**look.style, "color": blue(8), "linewidth": 2.4} if ours else look.style
    (drawn,) = axes.plot(runs["seconds"], runs["error"], markersize=4.0, **style)
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


LINE = 1.3  # distance of two lines of text, in font sizes
LETTER = 0.56  # width of a letter, likewise
MARGINS = 0.6  # inches above and below the rows


def step_cost(axes: Axes, frame: pd.DataFrame) -> None:
    """Microseconds per step as dots, each below its method."""
    rows = frame[frame["seconds_per_step"] > 0]
    if rows.empty:
        raise NoData("no method has a time for a step.")
    size = float(rcParams["xtick.labelsize"]) / 72.0
    letters = int((axes.figure.get_figwidth() - 0.3) / (LETTER * size))
    line, guides = 0.0, []  # counted downwards
    for _, row in rows.iterrows():
        name = f"{label_of(row['problem']).title}: {row['method']}, h ={UNBROKEN}{row['step']:.3g}"
        text = wrapped(name, letters)
        axes.text(0.01, -line, text, transform=axes.get_yaxis_transform(), va="top",
                  fontsize=72.0 * size)  # fmt: skip
        line += text.count("\n") + 1.2
        axes.plot(1e6 * row["seconds_per_step"], -line, "o", markersize=5, color=blue(8))
        guides.append(-line)
        line += 1.0
    axes.set(xscale="log", xlabel="time for one step [µs]", ylim=(-line, 0.3))
    axes.set_yticks(guides, [""] * len(guides))
    axes.tick_params(axis="y", length=0.0)
    axes.figure.set_figheight(LINE * size * line + MARGINS)
