"""`compare`: time contenders against each other and measure the rest; write CSV and tables."""

from __future__ import annotations

from dataclasses import dataclass

import pandas as pd

from benchmarks.targets_met import targets_met
from reports.atomic import write
from reports.choices import choices
from reports.matched import matched, smallest
from reports.order import Order
from reports.origins import note_origin
from reports.progress import Studies
from reports.suite import Measure, Suite, Table
from reports.tables import as_csv, write_table
from reports.targets_table import readable_targets, show_targets


@dataclass(frozen=True, eq=False)
class Compared:
    """Frames of `benchmarks.work_precision` and `benchmarks.cost`; None where one raised.

    ratios, choices  times at matched errors; the fastest run for each error
    smallest         the same at the smallest error of each contender
    targets          what the suite aims at, beside what was measured
    failures         a sentence for each that raised
    tables           the suite's further studies with their frames, those that did not raise
    """

    work_precision: pd.DataFrame | None
    cost: pd.DataFrame | None
    ratios: pd.DataFrame
    choices: pd.DataFrame
    smallest: pd.DataFrame
    targets: pd.DataFrame
    failures: tuple[str, ...]
    tables: tuple[tuple[Table, pd.DataFrame], ...] = ()


def compare(suite: Suite, order: Order) -> Compared:
    """Measure, write, and print the targets; one that raises leaves the other, and is named."""
    failures: list[str] = []
    with Studies(2 + len(suite.tables)) as studies:
        frame = _measure(studies, "time", "work-precision", suite.work_precision, order, failures)
        cost = _measure(studies, "cost", "cost of a step", suite.cost, order, failures)
        others = [
            (table, _measure(studies, "table", table.title, table.measure, order, failures))
            for table in suite.tables
        ]
    failures += dict.fromkeys(suite.faults())
    found = tuple((table, rows) for table, rows in others if rows is not None)
    runs = pd.DataFrame() if frame is None else frame
    ratios = matched(runs) if len(runs) else runs
    chosen = choices(runs) if len(runs) else runs
    ends = smallest(runs) if len(runs) else runs
    aims = targets_met(runs, suite.targets) if len(runs) else runs
    named = [(table.name, rows) for table, rows in found]
    for name, table in (("work_precision", frame), ("cost", cost), *named):
        if table is not None:
            write(order.out / f"{name}.csv", as_csv(table))
            note_origin(order.out, f"{name}.csv", suite.provenance(order.command), order.quick)
    at_errors = (("ratios", ratios), ("choices", chosen), ("smallest", ends))
    for name, table in (*at_errors, ("cost", cost), *named):
        if table is not None and len(table):
            write_table(order.out / "tables", name, table)
    if len(aims):
        write_table(order.out / "tables", "targets", aims, readable_targets(aims)[0])
    show_targets(aims, order.quick)
    return Compared(frame, cost, ratios, chosen, ends, aims, tuple(failures), found)


def _measure(
    studies: Studies, name: str, title: str, measure: Measure, order: Order, failures: list[str]
) -> pd.DataFrame | None:
    try:
        with studies(name, title) as report:
            return measure(order.quick, report)
    except Exception as error:
        failures.append(f"{title}: not run ({type(error).__name__}: {error}).")
        return None
