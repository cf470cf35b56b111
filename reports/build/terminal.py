"""Print rows of claims with a summary, changes, times at matched errors, and targets."""

from __future__ import annotations

import os
from collections.abc import Collection, Sequence
from textwrap import shorten

import numpy as np
import pandas as pd
import typer
from tabulate import tabulate

from benchmarks.checks.bounds import NOT_RUN
from benchmarks.store.foreign_texts import visible
from benchmarks.work_precision.targets_met import MISSED
from reports.figures.headlines import HEADLINES
from reports.results.summary import Summary
from reports.tables.claims_table import claims_frame
from reports.tables.comparison_tables import readable_ratios
from reports.tables.number_format import plain
from reports.tables.targets_table import HEADINGS, readable_targets, summary

TARGET_COLUMNS = HEADINGS[:-1]  # columns of the targets table that fit in a terminal
MAX_CHANGES = 20  # changes printed
MAX_PROBLEMS = 6  # problems whose times are all printed
MAX_COLUMN_WIDTHS = {"quantity": 60}  # columns in which longer texts are wrapped
MAX_BOUND_LENGTH = 28  # characters of a bound, longer ones are shortened
CLAIM_COLUMNS = ["claim", "source", "quantity", "bound", "measured", "verdict"]
NUMBER_COLUMNS = ("measured", "error", "target")  # aligned to the right


def show(summary: Summary) -> None:
    """Print the rows, with the reasons of unexpected verdicts and of rows that were not run."""
    table = claims_frame(summary.rows)
    differing = table["verdict"] != table["expected"]
    table["verdict"] += np.where(differing, ", expected " + table["expected"], "")
    table["bound"] = [shorten(text, MAX_BOUND_LENGTH, placeholder="...") for text in table["bound"]]
    table["measured"] = [plain(number) or "-" for number in table["measured"]]
    _show_table(table.rename(columns={"id": "claim"})[CLAIM_COLUMNS], np.flatnonzero(differing))
    for row in summary.rows:
        if row.verdict == NOT_RUN and row.reason:
            print(visible(f"{row.id} {row.quantity} was not run: {row.reason}"))
    print(summary)


def show_changes(changes: pd.DataFrame) -> None:
    """Print the changes since the earlier rows, at most MAX_CHANGES of them."""
    if changes.empty:
        return
    print("Changed since the rows before")
    _show_table(changes.head(MAX_CHANGES))
    if len(changes) > MAX_CHANGES:
        print(f"and {len(changes) - MAX_CHANGES} more, in verify.md.")


def show_ratios(ratios: pd.DataFrame, smallest: pd.DataFrame) -> None:
    """Print a table of times at matched errors for each problem.

    For more than MAX_PROBLEMS problems, only those that the headlines show are printed.
    """
    problems = list(ratios["problem"].unique()) if len(ratios) else []
    if len(problems) > MAX_PROBLEMS:
        problems = [
            name
            for headline in HEADLINES
            for name in headline.options["panels"]
            if name in problems
        ]
        print("Other problems are in tables/ratios.md and on the page.")
    for problem in problems:
        times = readable_ratios(ratios, smallest, problem)
        print(f"{problem}: times at matched error over those of galvi's fastest")
        _show_table(times.map(lambda cell: cell.partition(" (")[0]))


def show_targets(targets: pd.DataFrame) -> None:
    """Print the targets with their remarks; nothing when there are none."""
    if targets.empty:
        return
    table = readable_targets(targets)[0][[*TARGET_COLUMNS]]
    _show_table(table, [k for k, verdict in enumerate(table["verdict"]) if verdict == MISSED])
    for _, row in targets[targets["remark"] != ""].iterrows():
        print(visible(f"{row['problem']}, {row['against']}, own error: {row['remark']}"))
    print(summary(targets))


def _show_table(table: pd.DataFrame, red_lines: Collection[int] = ()) -> None:
    """Print a table of texts.

    Parameters
    ----------
    red
        indices of the lines whose last cell is red on a terminal with colours
    """
    lines: list[Sequence[str]] = table.map(visible).to_numpy().tolist()
    for k in red_lines:
        lines[k] = [*lines[k][:-1], typer.style(lines[k][-1], fg="red", bold=True)]
    text = tabulate(
        lines,
        [*table],
        tablefmt="plain",
        disable_numparse=True,
        colalign=["right" if name in NUMBER_COLUMNS else "left" for name in table]
        if lines
        else None,
        maxcolwidths=[MAX_COLUMN_WIDTHS.get(name) for name in table],
    )
    typer.echo(text, color=False if os.environ.get("NO_COLOR") else None)
