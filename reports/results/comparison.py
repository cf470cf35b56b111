"""`compare`: time contenders against each other and measure the rest; write CSV and tables."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import pandas as pd

from benchmarks.work_precision.targets_met import targets_met
from reports.cli.options import Order
from reports.results.atomic import write
from reports.results.cache import Parts
from reports.results.origins import note_origin
from reports.results.progress import Studies
from reports.results.suite import Measure, Suite, Table
from reports.tables.fastest_per_error import choices
from reports.tables.matched_error import matched, smallest
from reports.tables.targets_table import readable_targets, show_targets
from reports.tables.writing import as_csv, write_table

COST = "cost of a step"


@dataclass(frozen=True, eq=False)
class Compared:
    """Frames of `benchmarks.work_precision.run` and `benchmarks.work_precision.cost`; None where
    one raised.

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


def duels(suite: Suite, quick: bool) -> dict[str, Measure]:
    """The comparisons by their titles: one for each problem, where the suite tells them apart."""
    apart = {
        f"work-precision, {name}": partial(suite.work_precision, problem=name)
        for name in suite.problems(quick)
    }
    return apart or {"work-precision": suite.work_precision}


def titles(suite: Suite, quick: bool) -> tuple[str, ...]:
    """Of everything that `compare` measures."""
    return (*duels(suite, quick), COST, *(table.title for table in suite.tables))


def compare(suite: Suite, order: Order, parts: Parts | None = None) -> Compared:
    """Measure, write, and print the targets; one that raises leaves the others, and is named.

    parts  of a build; None keeps none
    """
    failures: list[str] = []
    parts = parts or Parts()
    with Studies(len(titles(suite, order.quick))) as studies:

        def run(name: str, title: str, measure: Measure) -> pd.DataFrame | None:
            return _measure(studies, name, title, measure, order, failures, parts)

        raced = [
            rows
            for title, measure in duels(suite, order.quick).items()
            if (rows := run("time", title, measure)) is not None
        ]
        frame = pd.concat(raced, ignore_index=True) if raced else None
        cost = run("cost", COST, suite.cost)
        others = [(table, run("table", table.title, table.measure)) for table in suite.tables]
    failures += dict.fromkeys((*parts.faults_taken(), *suite.faults()))
    found = tuple((table, rows) for table, rows in others if rows is not None)
    runs = pd.DataFrame() if frame is None else frame
    ratios = matched(runs) if len(runs) else runs
    chosen = choices(runs) if len(runs) else runs
    ends = smallest(runs) if len(runs) else runs
    aims = targets_met(runs, suite.targets) if len(runs) else runs
    named = [(table.name, rows) for table, rows in found]
    inside = {"work_precision": tuple(duels(suite, order.quick)), "cost": (COST,)}
    inside |= {table.name: (table.title,) for table, _ in found}
    for name, table in (("work_precision", frame), ("cost", cost), *named):
        if table is not None:
            write(order.out / f"{name}.csv", as_csv(table))
            told = {**suite.provenance(order.command), **parts.measured(inside[name])}
            note_origin(order.out, f"{name}.csv", told, order.quick)
    at_errors = (("ratios", ratios), ("choices", chosen), ("smallest", ends))
    for name, table in (*at_errors, ("cost", cost), *named):
        if table is not None and len(table):
            write_table(order.out / "tables", name, table)
    if len(aims):
        write_table(order.out / "tables", "targets", aims, readable_targets(aims)[0])
    show_targets(aims, order.quick)
    return Compared(frame, cost, ratios, chosen, ends, aims, tuple(failures), found)


def _measure(
    studies: Studies,
    name: str,
    title: str,
    measure: Measure,
    order: Order,
    failures: list[str],
    parts: Parts,
) -> pd.DataFrame | None:
    try:
        with studies(name, title) as report:
            return parts.part(title, lambda: measure(order.quick, report)).frame
    except Exception as error:
        failures.append(f"{title}: not run ({type(error).__name__}: {error}).")
        return None
