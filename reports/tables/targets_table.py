"""The targets and what was measured, as text for the page and the terminal."""

from __future__ import annotations

from collections.abc import Mapping

import pandas as pd
from rich.console import Console
from rich.table import Table
from rich.text import Text

from benchmarks.work_precision.targets_met import MET, MISSED
from reports.results.terminal import WIDTH
from reports.tables.number_format import TIMES, capital, known, readable

HEADINGS = ("problem", "against", "error", "target", "measured", "verdict", "fastest of each")
PRINTED = HEADINGS[:-1]  # what a terminal is wide enough for
REMARK = "remark"
NUMBERS = ("error", "target", "measured")
STYLES: Mapping[str, str] = {MET: "green", MISSED: "bold red"}
TEXT = (
    "Time of a peer over that of the fastest galvi method at the same error of the position, or "
    "of the attitude, against what was aimed at before anything was measured. The fastest setting "
    "of a peer counts, and a target is missed too when galvi does not reach the error."
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


def show_targets(frame: pd.DataFrame, quick: bool, console: Console | None = None) -> None:
    """Print them, and what is to be remarked; nothing when there are none."""
    if frame.empty:
        return
    console = console or Console()
    if not console.is_terminal:
        console.width = WIDTH
    shown, numbers = readable_targets(frame)
    table = Table(box=None, pad_edge=False, header_style="bold")
    for heading in PRINTED:
        table.add_column(heading, justify="right" if heading in numbers else "left")
    for _, line in shown.iterrows():
        style = STYLES.get(line["verdict"], "dim")
        table.add_row(*(Text(line[name], style if name == "verdict" else "") for name in PRINTED))
    console.print(table)
    for _, row in frame[frame["remark"] != ""].iterrows():
        console.print(Text(f"{row['problem']}, {row['against']}, own error: {row['remark']}"))
    console.print(Text(summary(frame) + (f" {QUICK}" if quick else "")))


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
