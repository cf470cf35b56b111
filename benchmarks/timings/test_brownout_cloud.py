"""The cloud of a brownout: 2000 grains of a size in one thread, with contacts."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
import pytest

from benchmarks.applications.brownout.cloud import CONSTANT_DRAG, END_TIME, REYNOLDS_DRAG, Cloud
from benchmarks.timings.annotate import annotate, timed
from benchmarks.work_precision.galvi_methods import gauss_collocation
from references.textbook.grain_flights import landings

METHOD = gauss_collocation(2).method
STEPS, GRAINS, TRACKED = 200, 2000, 50


@pytest.mark.parametrize("diameter", [10e-6, 100e-6, 400e-6])
@pytest.mark.parametrize("drag", [CONSTANT_DRAG, REYNOLDS_DRAG])
def test_a_cloud(benchmark: Any, drag: str, diameter: float) -> None:
    cloud = Cloud(diameter, drag, np.arange(GRAINS))
    run = timed(benchmark, partial(cloud.flights, METHOD, STEPS, threads=1))
    tracked_cloud = Cloud(diameter, drag, np.arange(TRACKED))
    truth = landings(tracked_cloud.problem, *tracked_cloud.starts(), END_TIME)
    failed = int(np.sum(~run.success))
    annotate(
        benchmark,
        problem=f"{cloud.problem.name}, {GRAINS} grains",
        error=float(np.median(np.linalg.norm(run.q[:TRACKED] - truth.q, axis=1))),
        counts={
            "steps": run.steps.sum(),
            "iterations": run.passes.sum(),
            "contacts": run.contacts.sum(),
        },
        status=f"{failed} grains failed." if failed else "",
        settings={"step": END_TIME / STEPS, "threads": 1, "degree": 2},
        kind="ensemble",
    )
