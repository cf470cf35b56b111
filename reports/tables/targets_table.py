"""The targets and what was measured, as text."""

from __future__ import annotations

import pandas as pd

from reports.tables.number_format import TIMES, capital, known, readable

HEADINGS = ("problem", "against", "error", "target", "measured", "verdict", "fastest of each")
REMARK = "remark"
NUMBERS = ("error", "target", "measured")
TEXT = (
    "Time of another code over that of the fastest galvi method at the same error of the position, "
    "or of the attitude, against the aims that were set before anything was measured. The fastest "
    "setting of a code counts, and a target is missed too when galvi does not reach the error."
)
QUICK = "These are the quick setting's runs, which are shorter than those that the targets are for."


def readable_targets(frame: pd.DataFrame) -> tuple[pd.DataFrame, dict[str, str]]:
    """A line for each row of `benchmarks.work_precision.targets_met`, and how to set the columns.

    The column of remarks is there when a row has one.
    """
    lines = [
        {
            "problem": capital(row["problem"]),
            "against": row["against"],
            "error": readable(row["error"], 2),
            "target": _target(row["target"]),
            "measured": _times(row["ratio"], 3) or str(row["verdict"]),
            "verdict": row["verdict"],
            "fastest of each": " / ".join(filter(None, (row["galvi"], row["contender"]))),
        }
        for _, row in frame.iterrows()
    ]
    shown = pd.DataFrame(lines, columns=list(HEADINGS))
    if (frame["remark"] != "").any():
        shown[REMARK] = list(frame["remark"])
    return shown, dict.fromkeys(NUMBERS, "number")


def summary(frame: pd.DataFrame) -> str:
    """How many are met, in one sentence, and whose numbers these targets are."""
    counts = ", ".join(f"{n} {name}" for name, n in frame["verdict"].value_counts().items())
    asked = list(frame["source"].drop_duplicates())
    return f"{len(frame)} targets: {counts}. {_sources(asked)}"


def _sources(asked: list[str]) -> str:
    return f"Source{'s' if len(asked) > 1 else ''}: {'; '.join(asked)}."


def _target(ratio: float) -> str:
    """Without a ratio, the error is to be reached."""
    return f"at least {_times(ratio)}" if known(ratio) else "reached"


def _times(ratio: float | str, digits: int = 2) -> str:
    """18×; a text as it is; nothing for what is not known."""
    if isinstance(ratio, str):
        return ratio
    return f"{readable(ratio, digits)}{TIMES}" if known(ratio) else ""
