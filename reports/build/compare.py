"""`compare`: time the contenders against each other; write the measurements and their tables."""

from __future__ import annotations

from benchmarks.store.atomic import write
from benchmarks.store.cells import as_csv
from reports.build.terminal import show_ratios, show_targets
from reports.results.cache import BuildCache
from reports.results.comparison import Comparison, measure_comparison
from reports.results.options import Options
from reports.results.origins import note_origin
from reports.results.suite import Suite
from reports.tables.comparison_tables import comparison_tables, write_comparison
from reports.tables.writing import write_table


def compare(suite: Suite, options: Options, cache: BuildCache | None = None) -> Comparison:
    """Measure the comparisons, write them, and print the targets.

    Ratios are printed instead in the quick setting, whose runs are shorter than those that the
    targets are for, and for a suite without targets.

    Parameters
    ----------
    cache
        the build's result cache; None stores nothing
    """
    measured = measure_comparison(suite, options, cache)
    origin = suite.provenance(options.command)
    for name, table in (("work_precision", measured.work_precision), ("cost", measured.cost)):
        if table is not None:
            write(options.out / f"{name}.csv", as_csv(table))
            note_origin(options.out, f"{name}.csv", origin, options.quick)
    targets = () if options.quick else suite.targets
    tables = comparison_tables(measured.work_precision, targets)
    write_comparison(options.out / "tables", tables, origin)
    if measured.cost is not None and len(measured.cost):
        write_table(options.out / "tables", "cost", measured.cost, origin=origin)
    show_targets(tables.targets)
    if not targets:
        show_ratios(tables.ratios, tables.smallest)
    return measured
