"""Lines of studies: errors and energies against time, step, cost or angle."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from benchmarks.applications.brownout.step_errors import SAMPLING, STEP_ERROR, WORK, sampling_error
from benchmarks.store.tables import pick
from galvi.arrays import Array
from reports.figures.style.decades import power_of_ten
from reports.figures.style.identities import BAND, COLOURS, GUIDE, MARKERS, line_color
from reports.figures.style.layout import NoData, mark_rounding, split

TIME, STEP = "t", "step"  # columns for the horizontal axis, which may also show a quantity
SMALLEST_DRAWN = 1e-17  # drawn in place of an error of 0
LONG_DASH, DOTS = (0, (5, 3)), (0, (1, 1.5))


def curve(
    table: pd.DataFrame, study: str, quantity: str, against: str = TIME
) -> tuple[Array, Array]:
    """The finite pairs (x, y) of a study, sorted by time and number of steps, as two arrays.

    Parameters
    ----------
    quantity
        whose values are y
    against
        a column for x, or a quantity, whose values are matched by the number of steps
    """
    rows = pick(table, study=study, quantity=quantity).sort_values(["t", "steps"])
    if against not in rows:
        abscissae = pick(table, study=study, quantity=against).set_index("steps")["value"]
        rows[against] = abscissae.reindex(rows["steps"]).to_numpy()
    x, y = rows[[against, "value"]].to_numpy(float).T
    finite = np.isfinite(x) & np.isfinite(y)
    return x[finite], y[finite]


def lines(
    axes: Axes,
    table: pd.DataFrame,
    *,
    quantity: str,
    labels: Mapping[str, str],
    xlabel: str,
    ylabel: str = "",
    against: str = TIME,
    between: tuple[str, ...] = (),
    xscale: str = "log",
    floor: float = 0.0,
    unit: float = 1.0,
    signed: bool = False,
) -> None:
    """Draw the absolute value of a quantity, a line for each study in `labels` (study -> text).

    A line over time ends with a cross if one of its rows has a status.

    Parameters
    ----------
    against
        TIME, STEP, which falls to the right, or a quantity of the same runs
    between
        two such quantities, between which horizontal bars are drawn; () for no bars
    floor
        drawn in place of smaller values
    unit
        of the horizontal axis, in units of the table
    signed
        whether to draw the sign, too; the caller then sets the scale of the vertical axis
    """
    axes.set(xscale=xscale, yscale="linear" if signed else "log", xlabel=xlabel, ylabel=ylabel)
    for k, (study, label) in enumerate(labels.items()):
        x, y = curve(table, study, quantity, against)
        x, y = x / unit, y if signed else np.maximum(np.abs(y), floor)
        shown = (signed | (y > 0.0)) & ((x > 0.0) | (xscale != "log"))
        color = line_color(study, k)
        marker = "" if against == TIME else MARKERS[k]
        if not shown.any():
            continue
        axes.plot(x[shown], y[shown], color=color, marker=marker, linewidth=1.0, label=label)
        if between:
            (low, errors), (high, _) = (
                curve(table, study, quantity, bar_quantity) for bar_quantity in between
            )
            axes.hlines(errors, low, high, color=color, linewidth=0.9, alpha=0.8)
        if against == TIME and any(pick(table, study=study, quantity=quantity)["status"] != ""):
            axes.plot(x[-1], y[-1], "X", color=color, markersize=7)
    if against == STEP:
        axes.invert_xaxis()


LINEAR_BELOW = 1e-3  # relative changes below this are drawn linearly, larger ones logarithmically
ENERGY_TICKS = (-1e-2, -1e-3, 0.0, 1e-3, 1e-2, 1e-1)


def energies(
    axes: Axes, table: pd.DataFrame, *, quantity: str, labels: Mapping[str, str], unit: float
) -> None:
    """Draw the signed change of a quantity over time for each study in `labels` (study -> text); a
    cross marks the end of a run with a status.

    Parameters
    ----------
    unit
        a year, in the table's unit of time
    """
    lines(
        axes,
        table,
        quantity=quantity,
        labels=labels,
        xlabel="time [years]",
        ylabel="relative change of energy",
        unit=unit,
        signed=True,
    )
    axes.axhspan(-LINEAR_BELOW, LINEAR_BELOW, color=BAND, zorder=0)
    axes.set_yscale("symlog", linthresh=LINEAR_BELOW, linscale=0.8)
    axes.set_yticks(ENERGY_TICKS, [power_of_ten(tick) if tick else "0" for tick in ENERGY_TICKS])
    axes.set_ylim(ENERGY_TICKS[0], ENERGY_TICKS[-1])


TIME_IN_PERIODS = "time $t$ [unit of time; the period is $2\\pi$]"
MAX_JOINED = 300  # above this many, points are not joined


def history(
    axes: Axes,
    table: pd.DataFrame,
    *,
    quantity: str,
    ylabel: str,
    xlabel: str = TIME_IN_PERIODS,
    rounding: bool = False,
) -> None:
    """Draw values at step ends over a band that spans the values of the first half.

    An error that grows with time leaves the band in the second half. Raises NoData if no value is
    finite.

    Parameters
    ----------
    rounding
        whether to draw in units of the machine epsilon, with two guides in place of the band: they
        grow as the square root of the time and as the time, up to the mean of the last tenth
    """
    t, value = curve(table, "history", quantity)
    if not t.size:
        raise NoData(f"no step has a finite {quantity}.")
    if rounding:
        value = value / np.finfo(float).eps
        final_level, time_fraction = (
            np.mean(value[-max(1, len(t) // 10) :]),
            (t - t[0]) / (t[-1] - t[0]),
        )
        guides = (0.5, "square root of the time", LONG_DASH), (1.0, "the time", DOTS)
        for power, label, dash in guides:
            axes.plot(
                t,
                final_level * time_fraction**power,
                color=GUIDE,
                linewidth=1.2,
                linestyle=dash,
                label=label,
            )
    else:
        first_half = value[t <= 0.5 * (t[0] + t[-1])]
        axes.axhspan(
            first_half.min(),
            first_half.max(),
            color=BAND,
            zorder=0,
            label="range over the first half",
        )
    style = (
        {"markersize": 2.0, "linestyle": "none", "rasterized": True} if len(t) > MAX_JOINED else {}
    )
    axes.plot(t, value, **{"marker": ".", "linewidth": 0.6, "color": COLOURS[0], **style})
    axes.set(xlabel=xlabel, ylabel=ylabel)
    axes.ticklabel_format(axis="x", style="plain")
    axes.margins(x=0.01, y=0.15)


def departures(
    axes: Axes, table: pd.DataFrame, *, quantities: Sequence[str], labels: Mapping[str, str]
) -> None:
    """Draw a panel for each quantity, both axes logarithmic, so that t = 0 is not shown."""
    for panel, quantity in zip(
        split(axes, len(quantities), min_width=3.0), quantities, strict=True
    ):
        lines(
            panel, table, quantity=quantity, labels=labels, xlabel="time $t$", floor=SMALLEST_DRAWN
        )
        panel.set_title(quantity)
        mark_rounding(panel)


def jumps(
    axes: Axes,
    table: pd.DataFrame,
    *,
    quantity: str,
    runs: Mapping[str, str],
    steps: Mapping[str, tuple[str, str]],
    turn: str,
    change: str,
    limit: tuple[float, str],
) -> None:
    """Draw |quantity| of each study in `runs` in the first panel, and in the second, for each study
    in `steps`, `change` against `turn` at the same times.

    Raises NoData for a study in `steps` without both quantities.

    Parameters
    ----------
    runs
        study -> text
    steps
        study -> (text, colour)
    turn, change
        quantities: rotation angle of a step in radians, and what changed in the step
    limit
        an angle in radians to mark, and its label
    """
    left, right = split(axes, 2, min_width=3.0)
    lines(
        left,
        table,
        quantity=quantity,
        labels=runs,
        xlabel="time $t$",
        ylabel=f"relative {quantity}",
        xscale="linear",
        floor=SMALLEST_DRAWN,
    )
    for k, (study, (text, color)) in enumerate(steps.items()):
        rows = pick(table, study=study)
        by_time = rows.pivot_table(index=["label", "t"], columns="quantity", values="value")
        if not {turn, change} <= set(by_time):
            raise NoData(f"{study}: no step was done.")
        right.plot(
            by_time[turn],
            np.maximum(by_time[change], SMALLEST_DRAWN),
            color=color,
            marker=MARKERS[k],
            markersize=3.5,
            linestyle="none",
            label=text,
        )
    right.axvline(limit[0], color=GUIDE, linestyle=LONG_DASH, linewidth=1.1, label=limit[1])
    right.set(yscale="log", xlabel="rotation angle of the step [rad]", ylabel=change)
    right.set_xlim(left=0.0)


def limits(
    axes: Axes, table: pd.DataFrame, *, quantity: str, charts: Mapping[str, tuple[float, str]]
) -> None:
    """Draw the error against the rotation angle for each chart; failed runs are crosses above the
    axes.

    Parameters
    ----------
    charts
        study -> (limit in radians, label of the limit)
    """
    axes.set(
        xlabel="rotation angle of one step [rad]",
        ylabel="error of the attitude [1]",
        yscale="log",
        ylim=(SMALLEST_DRAWN, 10.0),
    )
    for k, study in enumerate(charts):
        rows = pick(table, study=study, quantity=quantity).sort_values("step")
        turn, error = rows["step"].to_numpy(float), rows["value"].to_numpy(float)
        has_failed = ~np.isfinite(error)
        axes.plot(
            turn,
            np.maximum(error, SMALLEST_DRAWN),
            color=COLOURS[k],
            marker=MARKERS[k],
            linewidth=0.8,
            label=study,
        )
        axes.plot(
            turn[has_failed],
            np.full(has_failed.sum(), 1.03 + 0.035 * k),
            "x",
            color=COLOURS[k],
            ms=3.5,
            transform=axes.get_xaxis_transform(),
            clip_on=False,
        )
    axes.plot([], [], "x", color=GUIDE, label="failed")
    for (limit, text), dash in zip(dict.fromkeys(charts.values()), (LONG_DASH, DOTS), strict=False):
        axes.axvline(limit, color=GUIDE, linestyle=dash, linewidth=1.1, label=text)


GRAIN_COUNTS = {1e4: "error of 10,000 grains", 1e6: "error of a million grains"}


def sampling(axes: Axes, table: pd.DataFrame, *, quantity: str, degrees: Mapping[int, str]) -> None:
    """Draw errors due to the step over evaluations of the wind for each grain, a line for each
    degree.

    Runs without an error are left out. An error below its standard error is drawn as an upper
    limit, an arrow at the sum of both. Horizontal lines show the sampling errors of GRAIN_COUNTS.

    Parameters
    ----------
    degrees
        degree -> label
    """
    axes.set(
        xscale="log",
        yscale="log",
        xlabel="evaluations of the wind for a grain",
        ylabel=f"error of the {quantity}",
    )
    cloud_rows = table[table["study"].isin((quantity, WORK))]
    runs = cloud_rows.pivot_table("value", ["n", "steps"], "quantity")
    runs = runs.reindex(columns=[WORK, STEP_ERROR, f"{SAMPLING} of it"]).dropna()
    for k, (degree, label) in enumerate(degrees.items()):
        solved = runs[runs.index.get_level_values("n") == degree + 1]
        work, error, spread = np.abs(solved.to_numpy(float).T)
        is_limit = error < spread
        upper_limits = (error + spread)[is_limit]
        style = {"color": COLOURS[k], "marker": MARKERS[k]}
        if len(solved):
            axes.errorbar(
                work[~is_limit],
                error[~is_limit],
                yerr=spread[~is_limit],
                label=label,
                linewidth=1.0,
                **style,
            )
            axes.errorbar(
                work[is_limit],
                upper_limits,
                yerr=0.4 * upper_limits,
                uplims=True,
                mfc="white",
                linestyle="none",
                **style,
            )
    for (grains, text), dash in zip(GRAIN_COUNTS.items(), (LONG_DASH, DOTS), strict=True):
        level = sampling_error(table, quantity, grains)
        if level > 0.0:
            axes.axhline(level, color=GUIDE, linestyle=dash, linewidth=1.0, label=text)
