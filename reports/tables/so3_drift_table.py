"""What a million steps leave of rotations and momenta, as text for the page."""

from __future__ import annotations

import pandas as pd

from benchmarks.statistics.growth import Growth
from benchmarks.studies.so3_drift import QUANTITIES, growths
from reports.tables.number_format import known, readable, with_uncertainty

SIGMAS = 3.0
NUMBERS = ("steps", "runs", "largest", "RMS at the end", "exponent")


def turning_table(frame: pd.DataFrame) -> tuple[pd.DataFrame, dict[str, str]]:
    """A line for each ensemble and quantity, and how to set the columns."""
    lines = [
        {
            "contender": told["contender"],
            "setting": told["settings"],
            "quantity": QUANTITIES[name],
            "steps": readable(float(told["steps"]), 1),
            "runs": str(seen.runs),
            "largest": readable(largest),
            "RMS at the end": readable(seen.final),
            "exponent": with_uncertainty(seen.exponent, seen.uncertainty) or "not resolved",
            "verdict": verdict(seen),
            "status": told["status"],
            "commit": told["commit"],
            "date": told["date"],
        }
        for told, name, seen, largest in growths(frame)
    ]
    table = pd.DataFrame(lines)
    if not any(line["status"] for line in lines):
        table = table.drop(columns="status", errors="ignore")
    return table, dict.fromkeys(NUMBERS, "number")


def verdict(seen: Growth) -> str:
    """Whether the exponent is at most one half, by three standard errors."""
    if not (known(seen.exponent) and known(seen.uncertainty)):
        return "not judged"
    slow = seen.exponent - SIGMAS * seen.uncertainty <= 0.5
    return "at most the square root" if slow else "faster than the square root"
