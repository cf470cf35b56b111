"""The sections on errors that grow in long runs: round-off in energies, and a free body's drift."""

from __future__ import annotations

from functools import partial

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from benchmarks.statistics.drift import Growth, rms
from benchmarks.studies import free_body_drift, round_off
from reports.figures.plots.lines import DOTS, LONG_DASH, SMALLEST_DRAWN
from reports.figures.style.decades import set_decade_ticks
from reports.figures.style.identities import CHART_LEGEND, GUIDE, identity, legend_order
from reports.figures.style.layout import (
    NoData,
    contender_legend,
    mark_rounding,
    split,
)
from reports.results.section import Figure, LongForm, Section
from reports.tables.number_format import capital, is_finite, readable, with_uncertainty
from reports.tables.study_table import readable_table


def energy_growth(axes: Axes, table: pd.DataFrame) -> None:
    """Draw the RMS of each ensemble with its single runs, a guide that grows as t^(1/2), and the
    error of rounding one state to float64.

    Of several ensembles of a contender and duration, the newest is drawn. Raises NoData if no
    ensemble is complete.
    """
    ensembles = round_off.ensembles(table) if len(table) else ()
    newest = {
        (about["contender"], about["years"]): (about, t, errors)
        for about, t, errors in sorted(ensembles, key=lambda ensemble: ensemble[0]["date"])
    }
    resolved = [
        (about, t, errors) for about, t, errors in newest.values() if (rms(errors) > 0).any()
    ]
    if not resolved:
        raise NoData("no ensemble of runs is complete.")
    names = legend_order(about["contender"] for about, _, _ in resolved)
    for about, t, errors in sorted(
        resolved, key=lambda ensemble: names.index(ensemble[0]["contender"])
    ):
        look, label = identity(about["contender"]), f"{about['contender']}\n{about['settings']}"
        axes.plot(t, np.abs(errors).T, color=look.color, linewidth=0.4, alpha=0.13)
        axes.plot(t, rms(errors), markersize=3.5, zorder=3, label=label, **look.style)
    times, sizes = (
        np.concatenate(parts)
        for parts in zip(*((t, rms(errors)) for _, t, errors in resolved), strict=True)
    )
    time_range = np.array([times.min(), times.max()])
    guide_factor = 0.5 * np.nanmin(sizes / np.sqrt(times))  # through the lowest first point
    guide = {"color": GUIDE, "linewidth": 1.0}
    axes.plot(
        time_range,
        guide_factor * np.sqrt(time_range),
        linestyle=LONG_DASH,
        label="$t^{1/2}$",
        **guide,
    )
    floor = round_off.reading_floor(table)
    if floor > 0.0:
        axes.axhline(floor, linestyle=DOTS, label="rounding of one state", **guide)
    top = max(np.nanmax(np.abs(errors)) for _, _, errors in resolved)
    axes.set(
        xscale="log",
        yscale="log",
        ylim=(0.2 * np.nanmin(sizes), 2.0 * top),
        xlabel="time [years]",
        ylabel="relative energy error, RMS [1]",
    )
    set_decade_ticks(axes.xaxis)
    set_decade_ticks(axes.yaxis)


# Smaller exponents are no growth: that of a random walk is 1/2, that of a drift 1:
MAX_STATIONARY_EXPONENT = 0.25
STANDARD_ERRORS = 3.0  # standard errors by which an exponent must be smaller
ROUND_OFF_COLUMNS = {
    "contender": "contender",
    "settings": "setting",
    "years": "years",
    "runs": "runs",
    "final": "RMS error",
    "exponent": "exponent",
    "sigmas": "drift / its error",
    "verdict": "verdict",
    "status": "status",
    "commit": "commit",
    "date": "date",
}
ROUND_OFF_FORMATS = {
    "years": partial(readable, digits=1),
    "final": readable,
    "exponent": readable,
    "sigmas": partial(readable, digits=2),
}


def round_off_table(table: pd.DataFrame) -> tuple[pd.DataFrame, dict[str, str]]:
    """A line for each ensemble, and the CSS classes of the columns."""
    lines = [
        ensemble
        | {
            "runs": growth.runs,
            "final": growth.final,
            "exponent": with_uncertainty(growth.exponent, growth.uncertainty) or "not resolved",
            "sigmas": growth.sigmas,
            "verdict": drift_text(growth),
        }
        for ensemble, growth in round_off.growths(table)
    ]
    return readable_table(pd.DataFrame(lines), ROUND_OFF_COLUMNS, ROUND_OFF_FORMATS)


def drift_text(growth: Growth) -> str:
    """A few words on whether the energy drifts."""
    if not is_finite(growth.sigmas):
        return "not judged"
    if (
        growth.drifts
        and growth.exponent + STANDARD_ERRORS * growth.uncertainty < MAX_STATIONARY_EXPONENT
    ):
        return "alike in all runs, no growth"  # truncation error, not round-off
    return "drifts" if growth.drifts else "no drift seen"


ROUND_OFF = Section(
    name="brouwer",
    title="Round-off",
    text="The outer solar system from 32 starts that differ by 1e-12. "
    "Unbiased rounding moves the energy at random: its RMS over the runs grows as t^(1/2), and its "
    "mean does not drift. Exponents are fitted over the later two decades of time, with the "
    "bootstrap standard error over the runs; a drift is a mean that the scatter of the runs would "
    "give less than once in 10000 times. Energies are computed with 32 digits, galvi's including "
    "the low parts of its state, which it keeps; REBOUND returns rounded states, and times at "
    "which that rounding hides its error are left out of its fit. The Kepler frame also "
    "returns rounded states; its runs are ten times as long.",
    measure=partial(round_off.brouwer, longer=(round_off.FRAME,)),
    figures=(
        Figure(
            name="brouwer",
            title="Energy error of long runs",
            draw=energy_growth,
            caption="RMS over the runs; faint, the size of each run's error. Blue: galvi.",
            size=(6.0, 4.4),
        ),
    ),
    table=round_off_table,
    long_form=LongForm(round_off.parts, round_off.stored),
    open=True,
)


ERROR_TITLES = {
    "energy_error": "energy, relative",
    "momentum_error": "angular momentum in space, relative",
}


def errors_over_turns(axes: Axes, table: pd.DataFrame, *, problem: str) -> None:
    """Draw the largest error since the previous mark over the number of turns, both logarithmic.

    Of several runs of a contender, the longest is drawn, and of equally long ones the newest; a
    failed run ends with a cross. Raises NoData if no run has an error.
    """
    rows = table[table["problem"] == problem] if len(table) else table
    measured = rows[rows["energy_error"].notna()] if len(rows) else rows
    if measured.empty:
        raise NoData("no body turned.")
    names = legend_order(measured["contender"])
    panels = split(axes, len(ERROR_TITLES), ylabel="largest error since the last mark [1]")
    for panel, (column, title) in zip(panels, ERROR_TITLES.items(), strict=True):
        panel.set(xscale="log", yscale="log", xlabel="turns", title=title)
        for name in names:
            run, look = _longest_run(rows[rows["contender"] == name]), identity(name)
            reached = run[run[column].notna()]
            size = np.maximum(np.abs(reached[column]), SMALLEST_DRAWN)
            panel.plot(reached["turn"], size, markersize=4.0, **look.style)
            if 0 < len(reached) < len(run):
                panel.plot(reached["turn"].iloc[-1], size.iloc[-1], "x", ms=11.0, color=look.color)
        set_decade_ticks(panel.xaxis)
        set_decade_ticks(panel.yaxis)
        mark_rounding(panel)
    contender_legend(panel, names)


def _longest_run(rows: pd.DataFrame) -> pd.DataFrame:
    """The rows of the longest run of a contender, of equally long ones the newest."""
    longest = rows[rows["turns"] == rows["turns"].max()]
    return longest[longest["date"] == longest["date"].max()].sort_values("turn")


FREE_BODY_COLUMNS = {
    "problem": "body",
    "contender": "contender",
    "engine": "engine",
    "step": "step",
    "turn": "turns",
    "energy_error": "energy, relative",
    "growth": "growth exponent (turns)",
    "momentum_error": "angular momentum",
    "attitude_error": "attitude",
    "status": "status",
    "commit": "commit",
    "date": "date",
}
ERROR_COLUMNS = ("energy_error", "momentum_error", "attitude_error")
FREE_BODY_FORMATS = dict.fromkeys((*ERROR_COLUMNS, "growth"), partial(readable, digits=2))
RUN_KEYS = ["problem", "contender", "engine", "step", "turns", "commit"]
MIN_MARKS = 4  # marks needed to fit a growth
RANDOM_WALK_ERROR = 1e-13  # smaller energy errors may be one random walk, which has no exponent


def free_body_drift_table(observations: pd.DataFrame) -> tuple[pd.DataFrame, dict[str, str]]:
    """A line for each run, and the CSS classes of the columns.

    Errors are those of the last mark that the run reached, whose turns are in the line. The
    exponent x of an energy error that grows as turns^x is fitted over the later half of the marks.
    """
    runs = observations.groupby(RUN_KEYS, sort=False, dropna=False)
    table = pd.DataFrame([_run_line(rows.sort_values("turn")) for _, rows in runs])
    is_one_engine = (table.groupby("contender")["engine"].nunique() == 1).all()
    return readable_table(
        table.drop(columns="engine") if is_one_engine else table,
        FREE_BODY_COLUMNS,
        FREE_BODY_FORMATS,
    )


def _run_line(run: pd.DataFrame) -> dict[str, object]:
    """The line of a run: its last mark, the errors at the last mark that it reached, and their
    growth."""
    line = run.iloc[-1].to_dict() | {"problem": capital(run["problem"].iloc[0])}
    reached = run[run["energy_error"].notna()]
    if reached.empty:
        return line | {"turn": line["turns"]}
    errors = reached.iloc[-1][["turn", *ERROR_COLUMNS]].to_dict()
    return line | errors | {"growth": _growth(reached)}


def _growth(run: pd.DataFrame) -> float | str:
    """The log-log slope of the energy error over the later half of the marks.

    "" for fewer than MIN_MARKS such marks, and "round-off" if no error there exceeds
    RANDOM_WALK_ERROR.
    """
    later = run.iloc[len(run) // 2 :]
    size = np.abs(later["energy_error"].to_numpy(float))
    if len(later) < MIN_MARKS:
        return ""
    if not np.max(size) > RANDOM_WALK_ERROR:
        return "round-off"
    return float(np.polyfit(np.log(later["turn"]), np.log(size), 1)[0])


FREE_BODY_DRIFT = Section(
    name="free-spin",
    title="Energy and angular momentum in long rotations",
    text="H's free body over many turns, a "
    "turn being one rotation at the initial angular speed; MuJoCo in steps of 0.01. Also the free "
    "box of MuJoCo's own tests: 500 steps of 0.01 from the angular velocity (1, 2, 3). MuJoCo's "
    "implicitfast and discrete integrate rotation differently on ball and free joints; on free "
    "joints they are damped, as implicit is. Energy errors are E / E0 - 1 with their sign, "
    "momentum errors the length of the change in space; both are the largest since the previous "
    "mark (turns 1, 2, 5, 10 and so on). Attitudes are compared with the closed form at the end.",
    measure=free_body_drift.free_spin,
    figures=(
        Figure(
            name="free-spin",
            title="Free rigid body: energy and angular momentum over many turns",
            draw=errors_over_turns,
            options={"problem": "free rigid body"},
            caption=f"Blue: galvi; {CHART_LEGEND}; dashed: other codes, "
            "MuJoCo on a free joint, where implicit, implicitfast and discrete lie on one another. "
            "A cross: the run failed after it.",
            size=(9.6, 4.2),
        ),
    ),
    table=free_body_drift_table,
    long_form=LongForm(free_body_drift.parts, free_body_drift.stored),
    open=True,
)
