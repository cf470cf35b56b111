"""How the energy errors of the Brouwer study grow, as text for the page."""

from __future__ import annotations

import pandas as pd

from benchmarks.statistics.growth import Growth
from benchmarks.studies.round_off import growths
from reports.tables.number_format import known, readable, with_uncertainty

NUMBERS = ("years", "runs", "RMS error", "exponent", "drift / its error")
GROWS, SIGMAS = 0.25, 3.0  # exponent, by standard errors, below that of a walk and of a drift


def brouwer_table(frame: pd.DataFrame) -> tuple[pd.DataFrame, dict[str, str]]:
    """A line for each ensemble, and how to set the columns."""
    lines = [
        {
            "contender": told["contender"],
            "setting": told["settings"],
            "years": readable(told["years"], 1),
            "runs": str(seen.runs),
            "RMS error": readable(seen.final),
            "exponent": with_uncertainty(seen.exponent, seen.uncertainty) or "not resolved",
            "drift / its error": readable(seen.sigmas, 2),
            "verdict": _verdict(seen),
            "status": told["status"],
            "commit": told["commit"],
            "date": told["date"],
        }
        for told, seen in growths(frame)
    ]
    table = pd.DataFrame(lines)
    if not any(line["status"] for line in lines):
        table = table.drop(columns="status", errors="ignore")
    return table, dict.fromkeys(NUMBERS, "number")


def _verdict(seen: Growth) -> str:
    if not known(seen.sigmas):
        return "not judged"
    if seen.drifts and seen.exponent + SIGMAS * seen.uncertainty < GROWS:
        return "alike in all runs, no growth"  # an error of the method's, not of rounding
    return "drifts" if seen.drifts else "no drift seen"
