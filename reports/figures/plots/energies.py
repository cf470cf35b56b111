"""Quantities against time: energies, histories, departures."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.ticker import FixedLocator

from benchmarks.store.frames import pick
from galvi.arrays import Array
from reports.figures.style.decades import decades, powers, readable
from reports.figures.style.identities import BAND, COLOURS, GUIDE, line_color
from reports.figures.style.layout import Label, NoData, label_ends, legend, mark_rounding, panels

LINEAR = 1e-3  # smaller changes are drawn linearly, larger ones logarithmically
TICKS = (-1e-2, -1e-3, 0.0, 1e-3, 1e-2, 1e-1)


def energies(
    axes: Axes,
    frame: pd.DataFrame,
    *,
    quantity: str,
    labels: Mapping[str, str],
    unit: float,
    xlabel: str = "time [years]",
    ylabel: str = "relative change of energy",
) -> None:
    """A line for each study in `labels`, labelled at its end; a cross where one ends early.

    unit  unit of the time axis, in the frame's unit of time
    """
    ends = []
    axes.axhspan(-LINEAR, LINEAR, color=BAND, zorder=0)
    for k, (study, text) in enumerate(labels.items()):
        rows = pick(frame, study=study, quantity=quantity).sort_values("t")
        t, change = rows["t"].to_numpy(float) / unit, rows["value"].to_numpy(float)
        seen = (t > 0.0) & np.isfinite(change)
        if not np.any(seen):
            raise NoData(f"{study}: no step has a finite {quantity}.")
        t, change, color = t[seen], change[seen], line_color(study, k)
        axes.plot(t, change, color=color, linewidth=1.0)
        ends.append(Label(t[-1], change[-1], text, color))
    last = max(end.x for end in ends)
    for end in ends:
        if end.x < last:
            axes.plot(end.x, end.y, "X", color=end.color, markersize=7)
    axes.set(xscale="log", xlabel=xlabel, ylabel=ylabel)
    axes.set_yscale("symlog", linthresh=LINEAR, linscale=0.8)
    axes.yaxis.set_major_locator(FixedLocator(TICKS))
    powers(axes.yaxis)
    axes.set_ylim(TICKS[0], TICKS[-1])
    readable(axes.xaxis)
    label_ends(axes, ends)


TIME = "time $t$ [unit of time; the period is $2\\pi$]"
MANY = 300  # above this many, points are not joined


def history(
    axes: Axes,
    frame: pd.DataFrame,
    *,
    quantity: str,
    ylabel: str,
    xlabel: str = TIME,
    rounding: bool = False,
) -> None:
    """Values at step ends, over a band that spans the values of the first half.

    An error that grows with time leaves the band in the second half.

    rounding  in units of the machine epsilon, with guides in place of the band that grow as the
              square root of the time and as the time, to the mean of the last tenth
    """
    rows = pick(frame, study="history", quantity=quantity).sort_values("t")
    rows = rows[rows["value"].notna()]
    if rows.empty:
        raise NoData(f"no step has a finite {quantity}.")
    t, value = rows["t"].to_numpy(float), rows["value"].to_numpy(float)
    if rounding:
        value = value / np.finfo(float).eps
        _growths(axes, t, float(np.mean(value[-max(1, len(t) // 10) :])))
    else:
        first = value[t <= 0.5 * (t[0] + t[-1])]
        axes.axhspan(
            first.min(), first.max(), color=BAND, zorder=0, label="range over the first half"
        )
    many = len(t) > MANY
    axes.plot(
        t,
        value,
        marker=".",
        markersize=2.0 if many else 4.0,
        linestyle="none" if many else "-",
        linewidth=0.6,
        color=COLOURS[0],
        rasterized=many,
    )
    axes.set(xlabel=xlabel, ylabel=ylabel)
    axes.ticklabel_format(axis="x", style="plain")
    axes.margins(x=0.01, y=0.15)
    legend(axes)


def _growths(axes: Axes, t: Array, end: float) -> None:
    """Guides that grow to this value like the root of the time, as of errors of rounding that are
    independent, and like the time, as of biased ones."""
    share = (t - t[0]) / (t[-1] - t[0])
    for power, dash, text in ((0.5, (0, (5, 3)), "square root of the time"),
                              (1.0, (0, (1, 1.5)), "the time")):  # fmt: skip
        axes.plot(t, end * share**power, color=GUIDE, linestyle=dash, linewidth=1.2, label=text)


SMALLEST = 1e-17  # drawn in place of 0


def departures(
    axes: Axes,
    frame: pd.DataFrame,
    *,
    quantities: Sequence[str],
    labels: Mapping[str, str],
    xlabel: str = "time $t$",
) -> None:
    """A line for each study in `labels`, labelled at its end, in a panel for each quantity; both
    axes logarithmic, times from the second sample on."""
    for one, quantity in zip(panels(axes, len(quantities), least=3.0), quantities, strict=True):
        one.set(xscale="log", yscale="log", xlabel=xlabel, title=quantity)
        ends = []
        for k, (study, text) in enumerate(labels.items()):
            rows = pick(frame, study=study, quantity=quantity).sort_values("t")
            t, away = rows["t"].to_numpy(float), rows["value"].to_numpy(float)
            seen = (t > 0.0) & np.isfinite(away)
            if not np.any(seen):
                raise NoData(f"{study}: no step has a finite {quantity}.")
            t, away, color = t[seen], np.maximum(away[seen], SMALLEST), line_color(study, k)
            one.plot(t, away, color=color, linewidth=1.0)
            ends.append(Label(t[-1], away[-1], text, color))
        decades(one.xaxis)
        decades(one.yaxis)
        mark_rounding(one)
        label_ends(one, ends)
