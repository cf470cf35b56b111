"""The section on stiff springs in steps beyond their period."""

from __future__ import annotations

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from benchmarks.studies.moving_frames import stiff_springs
from benchmarks.studies.moving_frames.stiff_springs import (
    BOUND,
    CHANGE,
    ERROR,
    EXCHANGE,
    LARGEST,
    LONG,
    RESONANCE,
    TOTAL,
    TREND,
    TREND_ERROR,
    TRUTH,
)
from reports.figures.style.decades import decades
from reports.figures.style.identities import GUIDE, identity, in_order
from reports.figures.style.layout import NoData, legend, panels
from reports.results.section import Figure, Section
from reports.tables.number_format import readable, with_uncertainty


def errors_and_resonances(axes: Axes, frame: pd.DataFrame) -> None:
    """Errors at the end, and the largest change of the stiff energy, over h omega / pi."""
    rows = frame[frame["study"] == RESONANCE]
    if rows.empty:
        raise NoData("no steps were measured.")
    looks = {name: identity(name).style for name in in_order(rows["contender"])}
    for one, quantity in zip(panels(axes, 2), (ERROR, CHANGE), strict=True):
        for name, look in looks.items():
            runs = rows[(rows["contender"] == name) & (rows["quantity"] == quantity)]
            runs = runs.sort_values("x")
            one.plot(runs["x"] / np.pi, runs["value"], label=name, **{**look, "markersize": 3.0})
        for k in range(1, int(LARGEST / np.pi) + 1):
            one.axvline(k, color=GUIDE, linewidth=0.6, linestyle=(0, (1, 3)))
        one.set(yscale="log", xlabel=r"$h\omega / \pi$", title=quantity)
        decades(one.yaxis)
    legend(one)


def energy_exchange(axes: Axes, frame: pd.DataFrame) -> None:
    """The energies of the stiff springs and their sum over time."""
    rows = frame[(frame["study"] == EXCHANGE) & (frame["quantity"] != ERROR)]
    if rows.empty:
        raise NoData("the exchange was not measured.")
    table = rows.pivot(index="x", columns="quantity", values="value")
    for name in table:
        axes.plot(table.index, table[name], linewidth=0.8, label=f"${name}$")
    axes.plot(table.index, table.sum(axis=1), linewidth=0.8, color=GUIDE, label="sum")
    axes.set(xlabel="time $t$ [problem's unit]", ylabel="energy [problem's unit]")
    legend(axes)


STEPS = (1.0, 3.0, 6.0, 12.0)  # of hω, the nearest measured
ERRORS = (1e-2, 1e-3, 3e-4, 1e-4)  # to be reached in the fewest evaluations
SIGMAS = 5.0  # standard errors of a trend that is a drift


def stiff_spring_table(frame: pd.DataFrame) -> tuple[pd.DataFrame, dict[str, str]]:
    """A line for each contender and quantity: its values at a few steps, and the fewest evaluations
    to an error; and the CSS classes of the columns."""
    steps, lines = frame[frame["study"] == RESONANCE], []
    common = steps[steps["quantity"] == CHANGE]["x"]
    shown = [common.loc[(common - wanted).abs().idxmin()] for wanted in STEPS]
    for (name, quantity), rows in steps.groupby(["contender", "quantity"], sort=False):
        line = {"contender": str(name), "largest": str(quantity)}
        line |= {f"hω = {x:.2f}": _value(rows[rows["x"] == x]) for x in shown}
        for error in ERRORS:
            good = rows[rows["value"] <= error]
            line[f"evaluations to {readable(error, 1)}"] = (
                readable(good["evaluations"].min()) if quantity == ERROR else ""
            )
        lines.append(line)
    table = pd.DataFrame(lines)
    return table, dict.fromkeys(list(table)[2:], "number")


def _value(rows: pd.DataFrame) -> str:
    bound = " (bound)" if (rows["status"] == BOUND).any() else ""
    return "".join(readable(value) for value in rows["value"]) + bound


def long_run(frame: pd.DataFrame) -> str:
    """Sentences on the exchange and on the long run."""
    values = frame[frame["study"].isin([EXCHANGE, LONG])].groupby("quantity")["value"].agg(list)
    said = []
    if ERROR in values:
        said.append(f"The exchanged energies are within {readable(max(values[ERROR]))} of DOP853's "
                    f"at t = {TRUTH:g}.")  # fmt: skip
    if TREND in values:
        (trend,), (error,) = values[TREND], values[TREND_ERROR]
        drifts = abs(trend) > SIGMAS * error
        said.append(
            "Over the long run the sum of the stiff energies departs by "
            f"{readable(max(values[CHANGE]))} at most; the trend of its mean is "
            f"{with_uncertainty(trend, error)}: {'it drifts' if drifts else 'no drift seen'}. "
            f"The total energy changes by {readable(max(values[TOTAL]))} at most."
        )
    return " ".join(said)


STIFF_SPRINGS = Section(
    name="stiff-springs",
    title="Stiff springs in steps beyond their period",
    text=stiff_springs.EXPLANATION,
    measure=stiff_springs.stiff_spring_study,
    table=stiff_spring_table,
    summary=long_run,
    figures=(
        Figure(
            name="stiff-springs",
            title="Errors and resonances of long steps",
            draw=errors_and_resonances,
            caption="Dotted: integer multiples of π. A run that ends early has no point.",
            size=(9.6, 3.6),
        ),
        Figure(
            name="energy-exchange",
            title="Energies of the stiff springs",
            draw=energy_exchange,
            caption="Harmonic frame, 8 stages, hω = 4; the energies of the three stiff springs.",
            size=(7.0, 3.2),
        ),
    ),
)
