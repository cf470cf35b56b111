"""The table of targets and measured ratios, as text."""

from __future__ import annotations

import pandas as pd

from benchmarks.work_precision.fronts import NOT_REACHED
from benchmarks.work_precision.labels import label_of
from reports.tables.number_format import TIMES, is_finite, readable

GALVI_HEADING = "of galvi"
HEADINGS = (
    *("problem", "against", GALVI_HEADING, "error", "target", "measured", "verdict"),
    "fastest of each",
)
GALVI_ALONE = "by galvi alone"  # in place of a ratio, where no other code reaches the error
NUMBERS = ("error", "target", "measured")
TEXT = (
    "Time of another code relative to the fastest galvi method at the same error of the position "
    "or attitude, compared with targets set before any measurement. The fastest setting of each "
    "code counts, and of galvi those methods that the target names. Met: the ratio is reached, or "
    "the error where that is the target; missed: it is not, or galvi does not reach the error; not "
    "reached: the other code does not reach the error, so there is no ratio to judge."
)


def readable_targets(table: pd.DataFrame) -> tuple[pd.DataFrame, dict[str, str]]:
    """A line for each row of `benchmarks.work_precision.targets_met`, and the columns' CSS classes.

    There is a column of remarks if a row has one.
    """
    lines = [
        {
            "problem": label_of(row["problem"]).title,
            "against": row["against"],
            GALVI_HEADING: row["counted"],
            "error": readable(row["error"], 2),
            "target": _target(row["target"]),
            "measured": GALVI_ALONE
            if row["ratio"] == NOT_REACHED
            else _times(row["ratio"], 3) or str(row["verdict"]),
            "verdict": row["verdict"],
            "fastest of each": " / ".join(filter(None, (row["galvi"], row["contender"]))),
            "remark": " ".join(filter(None, (row["remark"], row["note"]))),
        }
        for _, row in table.iterrows()
    ]
    shown = pd.DataFrame(lines, columns=[*HEADINGS, "remark"])
    shown = shown if shown["remark"].any() else shown.drop(columns="remark")
    return shown, dict.fromkeys(NUMBERS, "number")


def summary(table: pd.DataFrame) -> str:
    """Sentences with the number of targets of each verdict, and their sources."""
    counts = ", ".join(f"{n} {name}" for name, n in table["verdict"].value_counts().items())
    sources = table["source"].drop_duplicates()
    name = "Sources" if len(sources) > 1 else "Source"
    return f"{len(table)} targets: {counts}. {name}: {'; '.join(sources)}."


def _target(ratio: float) -> str:
    """The target as text; "reached" if it is an error to reach, without a ratio."""
    if not is_finite(ratio):
        return "reached"
    digits = 2 if float(f"{ratio:.2g}") == ratio else 3
    return f"at least {_times(ratio, digits)}"


def _times(ratio: float | str, digits: int) -> str:
    """A ratio as text, e.g. 18 ×; texts are unchanged; "" if it is unknown."""
    if isinstance(ratio, str):
        return ratio
    return f"{readable(ratio, digits)}{TIMES}" if is_finite(ratio) else ""
