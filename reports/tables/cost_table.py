"""What steps cost, as text for the page."""

from __future__ import annotations

import pandas as pd

from reports.tables.number_format import readable, seconds

HEADINGS = {
    "problem": "problem",
    "method": "method",
    "order": "order",
    "step": "step",
    "solver": "solver",
    "iterations_per_step": "iterations a step",
    "forces_per_step": "forces a step",
    "seconds_per_step": "time a step",
    "status": "status",
}
NUMBERS = ("order", "step", "iterations a step", "forces a step", "time a step")


def readable_cost(frame: pd.DataFrame) -> tuple[pd.DataFrame, dict[str, str]]:
    """The columns that people ask for, as text, and how to set them; empty columns are left out."""
    shown = frame.reindex(columns=[name for name in HEADINGS if name in frame]).copy()
    for name in shown:
        write = seconds if name == "seconds_per_step" else _text
        shown[name] = [write(value) for value in frame[name]]
    shown = shown.loc[:, [bool((shown[name] != "").any()) for name in shown]]
    return shown.rename(columns=HEADINGS), dict.fromkeys(NUMBERS, "number")


def _text(value: object) -> str:
    if isinstance(value, str):
        return value
    number = float(value)
    return f"{number:.0f}" if number.is_integer() else readable(number)
