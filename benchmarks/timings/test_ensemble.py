"""Ensembles: the speed-up by a second thread, in rounds interleaved with one thread's.

Long runs gain nearly a factor of two on two free cores; runs of a millisecond are mostly Python,
serialised by the GIL, and must not become slower. Members of an ensemble share instructions too.
"""

from __future__ import annotations

import functools
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
import pytest

import galvi
from benchmarks.statistics.timing import interleaved
from benchmarks.timings.annotate import annotate, timed_warm
from benchmarks.work_precision.galvi_methods import gauss_collocation

ROUNDS = 3
METHOD = gauss_collocation(8).method
CASES: dict[str, tuple[galvi.Problem, float, int, int]] = {
    "32 of the outer planets, 10,000 steps": (
        galvi.problems.outer_solar_system(),
        400.0,
        10_000,
        32,
    ),
    "16 of Kepler, 10,000 steps": (galvi.problems.kepler(0.6), 0.25, 10_000, 16),
    "16 with user's functions, 10,000 steps": (galvi.problems.henon_heiles(), 0.25, 10_000, 16),
    "1000 of Kepler, 20 steps": (galvi.problems.kepler(0.6), 0.25, 20, 1000),
}


@pytest.mark.parametrize("case", CASES)
def test_an_ensemble(benchmark: Any, case: str) -> None:
    problem, step, steps, members = CASES[case]
    shifts = 1e-6 * np.random.default_rng(1).standard_normal((members, *problem.q0.shape))
    starts = [problem.with_initial_state(problem.q0 * (1.0 + x), problem.v0) for x in shifts]

    def run(threads: int) -> tuple[galvi.Trajectory, ...]:
        return galvi.integrate_many(starts, METHOD, step, steps, save_every=steps, threads=threads)

    single_run = galvi.integrate(starts[-1], METHOD, step, steps, save_every=steps)
    one_thread, two_threads = interleaved(
        [functools.partial(run, n) for n in (1, 2)], ROUNDS, least_seconds=0.0
    )
    runs = timed_warm(benchmark, functools.partial(run, 2), 1)
    assert all(run.success for run in runs)
    assert np.array_equal(runs[-1].q, single_run.q)
    annotate(
        benchmark,
        problem=problem.name,
        error=None,
        counts={name: sum(run.counts[name] for run in runs) for name in runs[0].counts},
        status=runs[0].status,
        settings={"threads": "2", "step": step, "steps": steps},
        kind="ensemble",
        one_thread_over_two=one_thread.seconds / two_threads.seconds,
    )
    print(f"{case}: one thread over two {one_thread.seconds / two_threads.seconds:.2f}")


MEMBERS: dict[str, tuple[galvi.Problem, float, int, int]] = {
    "2000 members of Kepler, 100 steps": (galvi.problems.kepler(0.3), 0.25, 100, 2000),
    "1000 members of a free body, 100 steps": (galvi.problems.free_rigid_body(), 0.25, 100, 1000),
    "4000 grains, 200 steps": (galvi.problems.brownout(400e-6), 0.01, 200, 4000),
}


@pytest.mark.parametrize("case", MEMBERS)
def test_members_of_an_ensemble(benchmark: Any, case: str) -> None:
    problem, step, steps, members = MEMBERS[case]
    v = problem.v0 + 1e-3 * np.random.default_rng(1).standard_normal((members, *problem.v0.shape))

    def run(threads: int) -> galvi.Ensemble:
        with ThreadPoolExecutor(threads) as pool:
            return galvi.integrate_ensemble(
                problem, problem.q0, v, METHOD, step, steps, executor=pool
            )

    def run_singly() -> tuple[galvi.Trajectory, ...]:
        starts = [
            problem.with_initial_state(problem.q0, velocity) for velocity in v[: members // 50]
        ]
        return galvi.integrate_many(starts, METHOD, step, steps, save_every=steps, threads=1)

    calls = [run_singly, functools.partial(run, 1), functools.partial(run, 2)]
    single, one_thread, two_threads = interleaved(calls, ROUNDS, least_seconds=0.0)
    ensemble = timed_warm(benchmark, functools.partial(run, 2), 1)
    assert ensemble.success.all()
    annotate(
        benchmark,
        problem=problem.name,
        error=None,
        counts={"steps": steps * members, "iterations": int(ensemble.iterations.sum())},
        status=ensemble.status[0],
        settings={"threads": "2", "step": step, "steps": steps},
        kind="ensemble",
        one_thread_over_two=one_thread.seconds / two_threads.seconds,
        single_runs_over_lanes=50.0 * single.seconds / one_thread.seconds,
    )
    print(
        f"{case}: {1e6 * one_thread.seconds / members / steps:.2f} us a step, one thread over two "
        f"{one_thread.seconds / two_threads.seconds:.2f}, single runs over lanes "
        f"{50.0 * single.seconds / one_thread.seconds:.1f}"
    )
