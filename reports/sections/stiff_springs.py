"""The section on stiff springs in steps beyond their period."""

from __future__ import annotations

import pandas as pd

from benchmarks.studies.moving_frames import stiff_springs
from benchmarks.studies.moving_frames.stiff_springs import CHANGE, ERROR, EXCHANGE, RESONANCE
from reports.figures.study_plots.stiff_springs import energy_exchange, errors_and_resonances
from reports.results.figure import Figure
from reports.results.section import Section
from reports.tables.number_format import readable

STEPS = (1.0, 3.0, 6.0, 12.0)  # of h omega, the nearest measured
ERRORS = (1e-2, 1e-3, 3e-4, 1e-4)  # to be reached in the fewest evaluations


def stiff_spring_table(frame: pd.DataFrame) -> tuple[pd.DataFrame, dict[str, str]]:
    """Lines at a few steps and of the fewest evaluations, then of the exchange and the long run."""
    steps, lines = frame[frame["study"] == RESONANCE], []
    for (name, quantity), rows in steps.groupby(["contender", "quantity"], sort=False):
        for wanted in STEPS:
            row = rows.iloc[(rows["x"] - wanted).abs().to_numpy().argmin()]
            lines.append(_line(str(name), f"h omega = {row['x']:.2f}", str(quantity), row))
    for name, rows in steps[steps["quantity"] == ERROR].groupby("contender", sort=False):
        for error in ERRORS:
            good = rows[rows["value"] <= error]
            if not good.empty:
                row = good.loc[good["evaluations"].idxmin()]
                where = f"fewest evaluations to {error:g}, h omega = {row['x']:.2f}"
                lines.append(_line(str(name), where, ERROR, row))
    rest = frame[(frame["study"] != RESONANCE) & frame["quantity"].isin(_judged())]
    for _, row in rest.iterrows():
        words = "exchange" if row["study"] == EXCHANGE else "largest in a tenth, up to"
        lines.append(_line(row["contender"], f"{words} t = {row['x']:g}", row["quantity"], row))
    return pd.DataFrame(lines), dict.fromkeys(("value", "evaluations"), "number")


def _judged() -> tuple[str, ...]:
    return ERROR, CHANGE, stiff_springs.TOTAL


def _line(name: str, where: str, quantity: str, row: pd.Series) -> dict[str, str]:
    bound = " (bound)" if row["status"] == stiff_springs.BOUND else ""
    return {
        "contender": name, "where": where, "quantity": quantity,
        "value": readable(row["value"]) + bound, "evaluations": readable(row["evaluations"]),
    }  # fmt: skip


STIFF_SPRINGS = Section(
    name="stiff-springs",
    title="Stiff springs in steps beyond their period",
    text=stiff_springs.EXPLANATION,
    measure=stiff_springs.stiff_spring_study,
    table=stiff_spring_table,
    figures=(
        Figure(
            name="stiff-springs",
            title="Errors and resonances of long steps",
            draw=errors_and_resonances,
            caption="Dotted: whole multiples of pi. A run that ends early has no point.",
            size=(9.6, 3.6),
        ),
        Figure(
            name="energy-exchange",
            title="Energies of the stiff springs",
            draw=energy_exchange,
            caption="Harmonic frame, 8 stages, h omega = 4.",
            size=(7.0, 3.2),
        ),
    ),
)
