"""Steps and trajectories of galvi on every problem, and runs long enough to show rounding."""

from __future__ import annotations

from typing import Any

import pytest

from benchmarks.timings.annotate import TIMER, noted, timed
from benchmarks.timings.case import Case
from benchmarks.timings.catalogue import CASES
from benchmarks.timings.truth import Unknown, error_of, true_ends
from benchmarks.timings.worker import described, prepared

MARKED = [
    pytest.param(case, id=case.name, marks=[pytest.mark.quick] if case.quick else [])
    for case in CASES
]


@pytest.mark.benchmark(timer=TIMER)
@pytest.mark.parametrize("case", MARKED)
def test_a_run_of_galvi(benchmark: Any, case: Case) -> None:
    told = described(timed(benchmark, prepared(case.as_data())))
    try:
        error = error_of(told["ends"], true_ends(case))
    except Unknown:
        error = None
    assert told["success"], told["status"]
    settings = {k: v for k, v in case.as_data().items() if k not in ("name", "kind", "quick")}
    noted(
        benchmark,
        problem=case.problem,
        error=error,
        counts=told["counts"],
        status=told["status"],
        settings=settings,
        kind=case.kind,
        error_tolerance=case.error_tolerance,
        rounding=case.rounding,
    )
