"""What `verify` prints: a table of every row, and what they add up to."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from rich.console import Console
from rich.table import Table
from rich.text import Text

from reports.build.summary import Summary
from reports.results.changes import Change
from reports.results.engines import Engines
from reports.tables.number_format import plain

STYLES = {"holds": "green", "exceeds": "cyan", "contradicted": "yellow", "not run": "dim"}
MOST = 20  # changes that are printed
WIDTH = 120  # where output is not a terminal
SHORTENED: Mapping[str, Any] = {"max_width": 28, "no_wrap": True, "overflow": "ellipsis"}


def show(seen: Summary, console: Console | None = None) -> None:
    """Print the rows; those that differ from what was expected, or were not run, say why."""
    console = console or Console()
    if not console.is_terminal:
        console.width = WIDTH
    table = Table(box=None, pad_edge=False, header_style="bold")
    for heading in ("claim", "quantity", "bound", "measured", "verdict", "expected"):
        table.add_column(
            heading,
            justify="right" if heading == "measured" else "left",
            **(SHORTENED if heading == "bound" else {}),
        )
    for row in seen.rows:
        differs = row.verdict != row.expected
        table.add_row(
            row.id,
            Text(row.quantity),
            Text(row.bound),
            plain(row.measured) or "-",
            Text(row.verdict, style="bold red" if differs else STYLES.get(row.verdict, "")),
            Text(row.expected, style="bold red" if differs else ""),
        )
    console.print(table)
    for row in seen.rows:
        if row.verdict == "not run" and row.reason:
            console.print(Text(f"{row.id} {row.quantity} was not run: {row.reason}"))
    console.print(Text(str(seen)))


def show_changes(changed: Sequence[Change], console: Console | None = None) -> None:
    """Print what is different from the rows before, the first of it when it is much."""
    if not changed:
        return
    console = console or Console()
    if not console.is_terminal:
        console.width = WIDTH
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
    """Print a sentence for each engine that is absent."""
    for sentence in engines.sentences():
        print(sentence)
