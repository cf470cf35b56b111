"""How the energy errors of the Brouwer study grow, as text for the page."""

from __future__ import annotations

import pandas as pd

from benchmarks.brouwer import growths
from benchmarks.growth import Growth
from reports.numerals import known, readable, with_uncertainty

NUMBERS = ("years", "runs", "RMS error at the end", "exponent", "drift in its standard errors")


def brouwer_table(frame: pd.DataFrame) -> tuple[pd.DataFrame, dict[str, str]]:
    """A line for each ensemble, and how to set the columns."""
    lines = [
        {
            "contender": told["contender"],
            "setting": told["settings"],
            "years": readable(told["years"], 1),
            "runs": str(seen.runs),
            "RMS error at the end": readable(seen.final),
            "exponent": with_uncertainty(seen.exponent, seen.uncertainty) or "not resolved",
            "drift in its standard errors": readable(seen.sigmas, 2),
            "verdict": _verdict(seen),
            "commit": told["commit"],
            "date": told["date"],
        }
        for told, seen in growths(frame)
    ]
    return pd.DataFrame(lines), dict.fromkeys(NUMBERS, "number")


def _verdict(seen: Growth) -> str:
    if not known(seen.sigmas):
        return "not judged"
    return "drifts" if seen.drifts else "no drift seen"
