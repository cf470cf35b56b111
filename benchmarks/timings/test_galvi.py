"""Time steps and trajectories of galvi on every problem, and runs long enough to show rounding."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

import pytest

from benchmarks.timings.annotate import TIMER, annotate, timed
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
    description = described(timed(benchmark, prepared(asdict(case))))
    try:
        error = error_of(description["ends"], true_ends(case))
    except Unknown:
        error = None
    assert description["success"], description["status"]
    settings = {k: v for k, v in asdict(case).items() if k not in ("name", "kind", "quick")}
    annotate(
        benchmark,
        problem=case.problem,
        error=error,
        counts=description["counts"],
        status=description["status"],
        settings=settings,
        kind=case.kind,
        error_tolerance=case.error_tolerance,
        rounding=case.rounding,
    )
