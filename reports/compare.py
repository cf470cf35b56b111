"""`compare`: time contenders against each other and measure the rest; write CSV and tables."""

from __future__ import annotations

from dataclasses import dataclass

import pandas as pd

from reports.atomic import write
from reports.choices import choices
from reports.matched import TARGETS, matched
from reports.order import Order
from reports.origins import note_origin
from reports.progress import Studies
from reports.suite import Measure, Suite, Table
from reports.tables import as_csv, write_table


@dataclass(frozen=True, eq=False)
class Compared:
    """Frames of `benchmarks.work_precision` and `benchmarks.cost`; None where one raised.

    ratios, choices  times at matched errors; the fastest run for each error
    failures         a sentence for each that raised
    tables           the suite's further studies with their frames, those that did not raise
    """

    work_precision: pd.DataFrame | None
    cost: pd.DataFrame | None
    ratios: pd.DataFrame
    choices: pd.DataFrame
    failures: tuple[str, ...]
    tables: tuple[tuple[Table, pd.DataFrame], ...] = ()


def compare(suite: Suite, order: Order) -> Compared:
    """Measure and write; one that raises leaves the other, and is named."""
    failures: list[str] = []
    with Studies(2 + len(suite.tables)) as studies:
        frame = _measure(studies, "time", "work-precision", suite.work_precision, order, failures)
        cost = _measure(studies, "cost", "cost of a step", suite.cost, order, failures)
        others = [
            (table, _measure(studies, "table", table.title, table.measure, order, failures))
            for table in suite.tables
        ]
    found = tuple((table, rows) for table, rows in others if rows is not None)
    runs = pd.DataFrame() if frame is None else frame
    ratios = matched(runs) if len(runs) else runs
    chosen = choices(runs, TARGETS) if len(runs) else runs
    named = [(table.name, rows) for table, rows in found]
    for name, table in (("work_precision", frame), ("cost", cost), *named):
        if table is not None:
            write(order.out / f"{name}.csv", as_csv(table))
            note_origin(order.out, f"{name}.csv", suite.provenance(order.command), order.quick)
    for name, table in (("ratios", ratios), ("choices", chosen), ("cost", cost), *named):
        if table is not None and len(table):
            write_table(order.out / "tables", name, table)
    return Compared(frame, cost, ratios, chosen, tuple(failures), found)


def _measure(
    studies: Studies, name: str, title: str, measure: Measure, order: Order, failures: list[str]
) -> pd.DataFrame | None:
    try:
        with studies(name, title) as report:
            return measure(order.quick, report)
    except Exception as error:
        failures.append(f"{title}: not run ({type(error).__name__}: {error}).")
        return None
