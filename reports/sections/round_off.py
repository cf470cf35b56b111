"""The section on the growth of round-off in the energy of long runs: Brouwer's law."""

from __future__ import annotations

from functools import partial

import pandas as pd

from benchmarks.statistics.growth import Growth
from benchmarks.studies import round_off_long
from benchmarks.studies.round_off import FRAME, brouwer, growths
from reports.figures.study_plots.energy_growth import energy_growth
from reports.results.figure import Figure
from reports.results.section import LongForm, Section
from reports.tables.number_format import known, readable, with_uncertainty
from reports.tables.study_table import without_empty_status

NUMBERS = ("years", "runs", "RMS error", "exponent", "drift / its error")
GROWS, SIGMAS = 0.25, 3.0  # exponent, by standard errors, below that of a walk and of a drift


def round_off_table(frame: pd.DataFrame) -> tuple[pd.DataFrame, dict[str, str]]:
    """A line for each ensemble, and the CSS classes of the columns."""
    lines = [
        {
            "contender": ensemble["contender"],
            "setting": ensemble["settings"],
            "years": readable(ensemble["years"], 1),
            "runs": str(seen.runs),
            "RMS error": readable(seen.final),
            "exponent": with_uncertainty(seen.exponent, seen.uncertainty) or "not resolved",
            "drift / its error": readable(seen.sigmas, 2),
            "verdict": _drift_text(seen),
            "status": ensemble["status"],
            "commit": ensemble["commit"],
            "date": ensemble["date"],
        }
        for ensemble, seen in growths(frame)
    ]
    return without_empty_status(pd.DataFrame(lines)), dict.fromkeys(NUMBERS, "number")


def _drift_text(seen: Growth) -> str:
    if not known(seen.sigmas):
        return "not judged"
    if seen.drifts and seen.exponent + SIGMAS * seen.uncertainty < GROWS:
        return "alike in all runs, no growth"  # truncation error, not round-off
    return "drifts" if seen.drifts else "no drift seen"


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
    measure=partial(brouwer, longer=(FRAME,)),
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
    long_form=LongForm(round_off_long.parts, round_off_long.stored),
    open=True,
)
