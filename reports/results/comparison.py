"""Time the contenders against each other, and measure the cost of a step."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import pandas as pd

from reports.results.cache import BuildCache
from reports.results.options import Options
from reports.results.progress import Studies
from reports.results.section import Measure
from reports.results.suite import Suite

COST = "cost of a step"


@dataclass(frozen=True, eq=False)
class Comparison:
    """Frames of `benchmarks.work_precision.run` and `benchmarks.work_precision.cost`; None where
    one raised, with a sentence in `failures`.
    """

    work_precision: pd.DataFrame | None
    cost: pd.DataFrame | None
    failures: tuple[str, ...] = ()


def measure_comparison(
    suite: Suite, options: Options, cache: BuildCache | None = None
) -> Comparison:
    """Measure every problem and the cost; exceptions are recorded in `failures`."""
    cache, failures = cache or BuildCache(), []
    races = _races(suite, options.quick)

    def measured(name: str, title: str, measure: Measure) -> pd.DataFrame | None:
        try:
            with studies(name, title) as report:
                return cache.result(title, lambda: measure(options.quick, report)).frame
        except Exception as error:
            failures.append(f"{title}: not run ({type(error).__name__}: {error}).")
            return None

    with Studies(len(races) + 1) as studies:
        found = [measured("time", title, measure) for title, measure in races.items()]
        cost = measured("cost", COST, suite.cost)
    frames = [frame for frame in found if frame is not None]
    runs = pd.concat(frames, ignore_index=True) if frames else None
    return Comparison(runs, cost, (*failures, *suite.faults()))


def _races(suite: Suite, quick: bool) -> dict[str, Measure]:
    """The measurements by title: one per problem, where the suite lists its problems."""
    apart = {
        f"work-precision, {name}": partial(suite.work_precision, problem=name)
        for name in suite.problems(quick)
    }
    return apart or {"work-precision": suite.work_precision}
