"""The measurements of a comparison: errors and times of contenders, and the cost of a step."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import pandas as pd

from reports.results.cache import BuildCache, Study, not_run
from reports.results.options import Options
from reports.results.suite import Suite

COST_TITLE = "cost of a step"


@dataclass(frozen=True, eq=False)
class Comparison:
    """The tables of `benchmarks.work_precision.run` and `benchmarks.work_precision.cost`.

    A table is None if its measurement raised; `failures` has a sentence for each exception.
    """

    work_precision: pd.DataFrame | None
    cost: pd.DataFrame | None
    failures: tuple[str, ...] = ()


def measure_comparison(
    suite: Suite, options: Options, cache: BuildCache | None = None
) -> Comparison:
    """Measure every problem and the cost; exceptions are recorded in `failures`."""
    cache = cache or BuildCache()
    measures = {
        f"work-precision, {name}": partial(suite.work_precision, problem=name)
        for name in suite.problems(options.quick)
    } or {"work-precision": suite.work_precision}
    studies = [
        Study(title, "time", title, partial(measure, options.quick))
        for title, measure in measures.items()
    ]
    errors = cache.measure(
        [*studies, Study(COST_TITLE, "cost", COST_TITLE, partial(suite.cost, options.quick))]
    )
    tables = [cache.entries[title].table for title in measures if title not in errors]
    return Comparison(
        pd.concat(tables, ignore_index=True) if tables else None,
        None if COST_TITLE in errors else cache.entries[COST_TITLE].table,
        (*(not_run(title, error) for title, error in errors.items()), *suite.faults()),
    )
