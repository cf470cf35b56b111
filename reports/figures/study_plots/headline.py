"""Some contenders on two problems: the fastest time for each error."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from benchmarks.work_precision.fronts import front
from reports.figures.style.decades import decades, error_label, readable
from reports.figures.style.identities import OURS, blue, identity
from reports.figures.style.layout import legend, share_y_label
from reports.figures.style.layout import panels as side_by_side
from reports.figures.style.no_data import NoData

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
    """An open circle, by its label, between the two measured steps around this one."""
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
    """(error, seconds) of a contender at a step, between measured ones by their logarithms.

    None where its runs do not reach on both sides of the step.
    """
    runs = rows[(rows["contender"] == contender) & (rows["error"] > 0) & (rows["seconds"] > 0)]
    steps = pd.to_numeric(runs["settings"].str.extract(r"step=([\d.e-]+)")[0]).to_numpy(float)
    order = np.argsort(steps)
    if not steps.size or not steps.min() <= step <= steps.max():
        return None
    error, seconds = (
        float(
            np.exp(
                np.interp(
                    np.log(step), np.log(steps[order]), np.log(runs[name].to_numpy(float)[order])
                )
            )
        )
        for name in ("error", "seconds")
    )
    return error, seconds
