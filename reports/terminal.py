"""What `verify` prints: a table of every row, and what they add up to."""

from __future__ import annotations

from rich.console import Console
from rich.table import Table
from rich.text import Text

from reports.numerals import plain
from reports.summary import Summary

STYLES = {"holds": "green", "exceeds": "cyan", "contradicted": "yellow", "not run": "dim"}
WIDTH = 120  # where output is not a terminal


def show(seen: Summary, console: Console | None = None) -> None:
    """Print the rows; those that differ from what was expected, or were not run, say why."""
    console = console or Console()
    if not console.is_terminal:
        console.width = WIDTH
    table = Table(box=None, pad_edge=False, header_style="bold")
    for heading in ("claim", "quantity", "measured", "verdict", "expected"):
        table.add_column(heading, justify="right" if heading == "measured" else "left")
    for row in seen.rows:
        differs = row.verdict != row.expected
        table.add_row(
            row.id,
            Text(row.quantity),
            plain(row.measured) or "-",
            Text(row.verdict, style="bold red" if differs else STYLES.get(row.verdict, "")),
            Text(row.expected, style="bold red" if differs else ""),
        )
    console.print(table)
    for row in seen.rows:
        if row.verdict == "not run" and row.reason:
            console.print(Text(f"{row.id} {row.quantity} was not run: {row.reason}"))
    console.print(Text(str(seen)))
