"""Tables made from the times of contenders: ratios, the fastest per error, targets."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import pandas as pd

from benchmarks.work_precision.dependable import dependable
from benchmarks.work_precision.targets import Target
from benchmarks.work_precision.targets_met import targets_met
from reports.tables.fastest_per_error import fastest_per_error
from reports.tables.matched_error import matched, smallest
from reports.tables.targets_table import readable_targets
from reports.tables.writing import write_table


@dataclass(frozen=True, eq=False)
class ComparisonTables:
    """Empty frames where nothing was compared.

    ratios    times at matched errors
    fastest   the fastest code for each error, and its run
    smallest  times at the smallest error of each contender
    targets   targets with the measured ratios
    """

    ratios: pd.DataFrame
    fastest: pd.DataFrame
    smallest: pd.DataFrame
    targets: pd.DataFrame


def comparison_tables(runs: pd.DataFrame | None, targets: Sequence[Target]) -> ComparisonTables:
    """The tables of the rows of `benchmarks.work_precision.run`; `runs` is None if that raised."""
    if runs is None or runs.empty:
        return ComparisonTables(*(pd.DataFrame() for _ in range(4)))
    runs = dependable(runs)
    return ComparisonTables(
        matched(runs), fastest_per_error(runs), smallest(runs), targets_met(runs, targets)
    )


def write_comparison(
    folder: Path, tables: ComparisonTables, origin: Mapping[str, str] | None = None
) -> None:
    """Write the non-empty tables, each as CSV, Markdown and LaTeX."""
    named = (("ratios", tables.ratios), ("choices", tables.fastest), ("smallest", tables.smallest))
    for name, table in named:
        if len(table):
            write_table(folder, name, table, origin=origin)
    if len(tables.targets):
        shown = readable_targets(tables.targets)[0]
        write_table(folder, "targets", tables.targets, shown, origin)
