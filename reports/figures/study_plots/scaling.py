"""Cost against the number of bodies, and the share of the machine's limit that is used."""

from __future__ import annotations

from typing import Any

import pandas as pd
from matplotlib.axes import Axes

from benchmarks.studies.scaling import FEW_HEAVY
from reports.figures.style.decades import decades, round_numbers
from reports.figures.style.identities import GUIDE, identity, in_order
from reports.figures.style.layout import legend
from reports.figures.style.no_data import NoData


def seconds_per_orbit(axes: Axes, frame: pd.DataFrame) -> None:
    """Time per orbit of each contender's representative run against the number of bodies."""
    rows = _chosen(frame, "seconds_per_orbit")
    for name in in_order(frame["contender"]):
        look = identity(name)
        runs = rows[rows["contender"] == name]
        if runs.empty:
            continue
        axes.vlines(
            runs["bodies"], 1e3 * runs["seconds_low"], 1e3 * runs["seconds_high"],
            color=look.color, linewidth=0.9,
        )  # fmt: skip
        axes.plot(runs["bodies"], 1e3 * runs["seconds_per_orbit"], label=name, **_style(name))
    axes.set(
        xscale="log", yscale="log", xlabel="number of bodies",
        ylabel="time for an orbit of the innermost planet [ms]",
    )  # fmt: skip
    round_numbers(axes.xaxis)
    decades(axes.yaxis)
    legend(axes)


def share_of_limit(axes: Axes, frame: pd.DataFrame) -> None:
    """Pairs per second relative to the limit set by the divide and square-root units."""
    rows = _chosen(frame, "share")
    for name in in_order(rows["contender"]):
        runs = rows[rows["contender"] == name]
        axes.plot(runs["bodies"], runs["share"], label=name, **_style(name))
    limit = rows["limit_pairs_per_second"].max()
    axes.axhline(
        1.0, color=GUIDE, linestyle=(0, (5, 3)), linewidth=1.0,
        label=f"divisions and square roots alone: {limit / 1e9:.2f} billion pairs per second",
    )  # fmt: skip
    axes.set(
        xscale="log", xlabel="number of bodies", ylabel="share of the limit [1]", ylim=(0.0, 1.08)
    )
    round_numbers(axes.xaxis)
    legend(axes)


def _style(name: str) -> dict[str, Any]:
    """The look of a contender; hollow where few bodies are heavy."""
    return identity(name).style | ({"mfc": "white"} if name.endswith(FEW_HEAVY) else {})


def _chosen(frame: pd.DataFrame, column: str) -> pd.DataFrame:
    rows = frame[(frame["matched"] == True) & (frame[column] > 0)] if len(frame) else frame  # noqa: E712
    if rows.empty:
        raise NoData("no run reaches the error of the comparison.")
    return rows.sort_values("bodies")
