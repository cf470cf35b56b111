"""What every timing carries beside its time: error, counts, status, settings, versions."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from benchmarks.provenance import commit, versions
from galvi import Trajectory
from galvi.arrays import Array


def timed_run(
    benchmark: Any, call: Callable[[], Trajectory], end: Array, settings: Mapping[str, Any]
) -> Trajectory:
    """Time a run that is warm, and note what it reached.

    end       the truth at the run's last time, in the configuration's shape
    settings  what another person needs to repeat it
    """
    call()
    run = benchmark(call)
    error = float(np.max(np.abs(run.q[-1] - end))) if run.success else None
    benchmark.extra_info.update(
        error=error,
        counts=dict(run.counts),
        status=run.status,
        settings={key: str(value) for key, value in settings.items()},
        problem=run.problem.name,
        versions=versions(),
        commit=commit(),
    )
    return run
