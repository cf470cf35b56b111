"""Time Burrau's problem in galvi's clock, and by IAS15 beside it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest

import galvi
from benchmarks.timings.annotate import TIMER, annotate, timed
from benchmarks.work_precision.galvi_methods import in_clock
from benchmarks.work_precision.problems.encounters import clock_label
from references import Contender
from references.rebound.ias15 import DEFAULT, IAS15
from references.stored.encounters import ENCOUNTERS
from references.stored.planets import STORED_TRUTH

RUNS: dict[str, tuple[Contender, Mapping[str, Any]]] = {
    clock_label(8): (in_clock(8, galvi.DynamicalTime()), {"step": 0.4}),
    IAS15.name: (IAS15, {"samples": 1, **DEFAULT}),
}


@pytest.mark.quick
@pytest.mark.benchmark(timer=TIMER)
@pytest.mark.parametrize("name", RUNS)
def test_burrau_s_problem(benchmark: Any, name: str) -> None:
    (make, duration), (contender, setting) = ENCOUNTERS["burrau"], RUNS[name]
    problem = make()
    if contender.missing:
        pytest.skip(contender.missing)
    run = timed(benchmark, lambda: contender.run(problem, duration, setting))
    assert run.success, run.status
    end = STORED_TRUTH.run(problem, duration, {"samples": 1}).q[-1]
    annotate(
        benchmark,
        problem=problem.name,
        error=float(np.max(np.abs(run.q[-1] - end))),
        counts=run.counts,
        status=run.status,
        settings={"contender": name, "duration": duration, **setting, "truth": STORED_TRUTH.name},
        kind="reference",
    )
