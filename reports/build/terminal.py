"""Terminal output: rows of claims with a summary, changes, missing engines, targets."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import pandas as pd
from rich.console import Console
from rich.table import Table
from rich.text import Text

from benchmarks.checks.bounds import (
    ATTAINED,
    CONTRADICTED,
    EXCEEDS,
    HOLDS,
    NOT_REPRODUCED,
    NOT_RUN,
)
from benchmarks.work_precision.targets_met import MET, MISSED
from reports.build.changes import Change
from reports.figures.headlines import HEADLINES
from reports.results.own_problems import Engines
from reports.results.summary import Summary
from reports.tables.comparison_tables import readable_ratios
from reports.tables.number_format import plain
from reports.tables.targets_table import HEADINGS, readable_targets, summary

STYLES = {
    ATTAINED: "green", HOLDS: "green", EXCEEDS: "cyan", NOT_REPRODUCED: "magenta",
    CONTRADICTED: "yellow", NOT_RUN: "dim",
}  # fmt: skip
TARGET_STYLES: Mapping[str, str] = {MET: "green", MISSED: "bold red"}
PRINTED = HEADINGS[:-1]  # columns of the targets table that fit in a terminal
MOST = 20  # changes printed
FEW = 6  # problems whose times are all printed
WIDTH = 120  # columns when output is not a terminal
SHORTENED: Mapping[str, Any] = {"max_width": 28, "no_wrap": True, "overflow": "ellipsis"}


def show(seen: Summary) -> None:
    """Print the rows, with the reasons of unexpected verdicts and of rows that were not run."""
    console = _console()
    table = Table(box=None, pad_edge=False, header_style="bold")
    for heading in ("claim", "source", "quantity", "bound", "measured", "verdict"):
        table.add_column(
            heading,
            justify="right" if heading == "measured" else "left",
            **(SHORTENED if heading == "bound" else {}),
        )
    for row in seen.rows:
        differs = row.verdict != row.expected
        expected = f", expected {row.expected}" if differs else ""
        style = "bold red" if differs else STYLES.get(row.verdict, "")
        table.add_row(
            row.id,
            Text(row.source),
            Text(row.quantity),
            Text(row.bound),
            plain(row.measured) or "-",
            Text(f"{row.verdict}{expected}", style=style),
        )
    console.print(table)
    for row in seen.rows:
        if row.verdict == NOT_RUN and row.reason:
            console.print(Text(f"{row.id} {row.quantity} was not run: {row.reason}"))
    console.print(Text(str(seen)))


def show_changes(changed: Sequence[Change]) -> None:
    """Print the changes since the earlier rows, at most MOST of them."""
    if not changed:
        return
    console = _console()
    table = Table(
        box=None, pad_edge=False, header_style="bold", title="Changed since the rows before"
    )
    for heading in ("claim", "quantity", "what", "before", "now"):
        table.add_column(heading)
    for one in changed[:MOST]:
        table.add_row(*map(Text, (one.id, one.quantity, one.what, one.before, one.now)))
    console.print(table)
    if len(changed) > MOST:
        console.print(Text(f"and {len(changed) - MOST} more, in verify.md."))


def show_engines(engines: Engines) -> None:
    """Print a sentence for each missing engine."""
    for sentence in engines.sentences():
        print(sentence)


def show_ratios(ratios: pd.DataFrame, ends: pd.DataFrame) -> None:
    """Print a table of times at matched error for each problem; of more than FEW problems those of
    the headlines alone."""
    console = _console()
    problems = list(ratios["problem"].unique()) if len(ratios) else []
    if len(problems) > FEW:
        problems = [name for one in HEADLINES for name in one.options["panels"] if name in problems]
        console.print("Other problems are in tables/ratios.md and on the page.")
    for problem in problems:
        lines = readable_ratios(ratios, ends, problem)
        title = f"{problem}: times at matched error over those of galvi's fastest"
        table = Table(
            box=None, pad_edge=False, header_style="bold", title=title, title_justify="left"
        )
        for heading in lines:
            left = heading == "contender"
            table.add_column(str(heading), justify="left" if left else "right", no_wrap=left)
        for name, *cells in lines.to_numpy():
            table.add_row(Text(name), *(Text(cell.partition(" (")[0]) for cell in cells))
        console.print(table)


def show_targets(frame: pd.DataFrame) -> None:
    """Print the targets with their remarks; nothing when there are none."""
    if frame.empty:
        return
    console = _console()
    shown, numbers = readable_targets(frame)
    table = Table(box=None, pad_edge=False, header_style="bold")
    for heading in PRINTED:
        table.add_column(heading, justify="right" if heading in numbers else "left")
    for _, line in shown.iterrows():
        style = TARGET_STYLES.get(line["verdict"], "dim")
        table.add_row(*(Text(line[name], style if name == "verdict" else "") for name in PRINTED))
    console.print(table)
    for _, row in frame[frame["remark"] != ""].iterrows():
        console.print(Text(f"{row['problem']}, {row['against']}, own error: {row['remark']}"))
    console.print(Text(summary(frame)))


def _console() -> Console:
    """The terminal, or lines of WIDTH columns in a file."""
    console = Console()
    if not console.is_terminal:
        console.width = WIDTH
    return console
