"""The cost of a step, as text for the page."""

from __future__ import annotations

import pandas as pd

from benchmarks.work_precision.cost import COLUMNS
from benchmarks.work_precision.labels import label_of
from reports.tables.number_format import readable, seconds


def readable_cost(frame: pd.DataFrame) -> tuple[pd.DataFrame, dict[str, str]]:
    """The columns with a heading, as text, and their CSS classes; empty columns are omitted."""
    columns = [one for one in COLUMNS if one.heading and one.name in frame]
    shown = frame.assign(problem=[label_of(name).title for name in frame["problem"]])
    texts = {one: [WRITERS[one.kind](value) for value in shown[one.name]] for one in columns}
    filled = {one.heading: text for one, text in texts.items() if any(text)}
    numbers = [one.heading for one in columns if one.kind != "text"]
    return pd.DataFrame(filled), dict.fromkeys(numbers, "number")


def _number(value: object) -> str:
    number = float(value)
    return f"{number:.0f}" if number.is_integer() else readable(number)


WRITERS = {"text": str, "number": _number, "seconds": seconds}
