"""Import, cold start and memory of a fresh process, kept beside the times of runs."""

from __future__ import annotations

import os
from typing import Any

import pytest

from benchmarks.studies.start_up import STARTS, STEPS, own_folder, started
from benchmarks.timings.annotate import TIMER, annotate, timed_warm

POINT_MASSES = STARTS[1]


@pytest.mark.benchmark(timer=TIMER)
@pytest.mark.quick
def test_a_fresh_process(benchmark: Any) -> None:
    """The time is that of starting a warm process; the other numbers are in its `start_up`."""
    with own_folder() as folder:
        cold = started(POINT_MASSES, folder, cache=os.fspath(folder / "cache"))
        warm = [timed_warm(benchmark, lambda: started(POINT_MASSES, folder, (STEPS,)), 1)]
    annotate(
        benchmark,
        problem=POINT_MASSES.label,
        error=None,
        counts={},
        status="Completed.",
        settings={"steps": STEPS},
        kind="start-up",
        start_up={
            "import [s]": warm[0].imported,
            "cold start [s]": cold.processor,
            "memory [MiB]": warm[0].peaks[0],
        },
    )
