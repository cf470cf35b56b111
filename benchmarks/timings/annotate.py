"""Time a call in processor time, and store settings, counts and error with the time.

docs/why.md says why processor time is used.
"""

from __future__ import annotations

import math
import statistics
import time
from collections.abc import Callable, Mapping
from typing import Any

from benchmarks.statistics import calibration
from benchmarks.store.provenance import commit, versions

TIMER = time.process_time
ROUND_SECONDS = 0.01  # least seconds of a round
BENCHMARK_SECONDS = 0.5  # seconds per benchmark, without first calls
ROUNDS, FEWEST_ROUNDS = 9, 3


def timed(benchmark: Any, call: Callable[[], Any]) -> Any:
    """Time a call after two first ones, and store the seconds of the first, which compiles.

    Returns the value of the call.
    """
    start = time.perf_counter()
    call()
    first = time.perf_counter() - start
    start = time.perf_counter()  # under `ulimit -t` processor time stands still for milliseconds
    call()
    seconds = max(time.perf_counter() - start, 1e-6)
    repeats = max(1, math.ceil(ROUND_SECONDS / seconds))
    rounds = min(ROUNDS, max(FEWEST_ROUNDS, int(BENCHMARK_SECONDS / (repeats * seconds))))
    returned = timed_warm(benchmark, call, rounds, repeats)
    benchmark.extra_info.update(first_call=first)
    return returned


def timed_warm(benchmark: Any, call: Callable[[], Any], rounds: int, repeats: int = 1) -> Any:
    """Time a warm call, with the yardstick before and after; returns the value of the call."""
    before = calibration.yardstick(3)
    returned = benchmark.pedantic(call, rounds=rounds, iterations=repeats)
    seconds = statistics.median(before + calibration.yardstick(3))
    benchmark.extra_info.update(yardstick={"name": calibration.NAME, "seconds": seconds})
    return returned


def annotate(
    benchmark: Any,
    *,
    problem: str,
    error: float | None,
    counts: Mapping[str, int],
    status: str,
    settings: Mapping[str, Any],
    **columns: Any,
) -> None:
    """Add problem, error, counts, status and settings to the benchmark's row.

    Parameters
    ----------
    error
        against the truth; None if unknown
    settings
        everything needed to reproduce the run
    """
    benchmark.extra_info.update(
        problem=problem,
        error=error if error is not None and math.isfinite(error) else None,
        counts={name: int(count) for name, count in counts.items()},
        status=status,
        settings={key: str(value) for key, value in settings.items()},
        versions=versions(),
        commit=commit(),
        **columns,
    )
