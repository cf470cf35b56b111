"""Times of the runs of a judgement: predicted before a run, and measured with their spread."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence

import numpy as np

from benchmarks.applications.judging.candidate import Candidate
from benchmarks.statistics.timing import once
from galvi import Problem, Trajectory
from galvi.arrays import Array

FEWEST_TIMINGS, MOST_TIMINGS = 5, 9  # timings of one run: for a spread, and at most
TRIAL_FRACTION = 0.05  # of the seconds of interest: shorter trial runs predict nothing


def expected(run: Callable[[int], object], steps: int, enough: float) -> float:
    """Predict the seconds of ``steps`` steps from runs of n and of 2 n steps.

    The difference of the two contains no set-up. n grows until the steps outweigh the set-up.

    Parameters
    ----------
    run
        function of n that does n steps
    enough
        seconds below which an upper bound suffices
    """
    count = 2
    run(count)  # so that no timed run compiles
    while True:
        once, twice = _once_and_twice(run, count)
        if _steps_outweigh_setup(once, twice, enough):  # unless the machine was busy for a moment
            once, twice = map(min, (once, twice), _once_and_twice(run, count))
        bound = twice * max(1.0, steps / (2 * count))
        by_difference = twice + max(twice - once, 0.0) * max(0.0, steps / count - 2.0)
        if bound <= enough or _steps_outweigh_setup(once, twice, enough) or 8 * count > steps:
            return min(bound, by_difference)
        count *= 4


def _steps_outweigh_setup(once: float, twice: float, enough: float) -> bool:
    """Whether steps take longer than half a set-up in a run of TRIAL_FRACTION of `enough`."""
    return twice - once > 0.5 * once and twice > TRIAL_FRACTION * enough


def _once_and_twice(run: Callable[[int], object], count: int) -> tuple[float, float]:
    return _seconds(run, count), _seconds(run, 2 * count)


def _seconds(run: Callable[[int], object], count: int) -> float:
    start = time.perf_counter()
    run(count)
    return time.perf_counter() - start


def steps_of(candidate: Candidate, problem: Problem, span: float, samples: int, count: int) -> None:
    """Do the first ``count`` steps of a candidate and discard the run."""
    step = candidate.setting(span, samples)["step"]
    setting = {**candidate.options, "step": step, "save_every": count}
    candidate.contender.run(problem, count * step, setting)


def timed(
    candidate: Candidate,
    problem: Problem,
    span: float,
    samples: int,
) -> tuple[Trajectory, float, float]:
    """Run a candidate once.

    Returns the run, the seconds of its engine, without the conversion of states except for galvi,
    and the seconds of the whole call.
    """
    start = time.perf_counter()
    run, seconds = once(lambda: candidate.run(problem, span, samples))
    return run, seconds, time.perf_counter() - start


def race(
    candidates: Sequence[Candidate],
    walls: Sequence[float],
    problem: Problem,
    span: float,
    samples: int,
    limit: float,
) -> list[Array]:
    """Time the candidates in turns, so that all run under the same load.

    Returns FEWEST_TIMINGS to MOST_TIMINGS times in seconds for each; an empty array for the slowest
    candidates where ``limit`` seconds do not suffice. The first candidate is timed before others.

    Parameters
    ----------
    walls
        estimated seconds of a run of each
    """
    times: list[list[float]] = [[] for _ in candidates]
    by_time = sorted(range(len(walls)), key=lambda k: (k > 0, walls[k]))
    planned = np.cumsum(
        [FEWEST_TIMINGS * walls[k] for k in by_time if FEWEST_TIMINGS * walls[k] <= limit]
    )
    entered = [k for k in by_time if FEWEST_TIMINGS * walls[k] <= limit][
        : int(np.sum(planned <= limit))
    ]
    start = time.perf_counter()
    for timings in range(MOST_TIMINGS if entered else 0):
        if timings >= FEWEST_TIMINGS and time.perf_counter() - start > limit:
            break
        for k in entered:
            times[k].append(timed(candidates[k], problem, span, samples)[1])
    return [np.array(seconds) for seconds in times]


def quartiles(times: Array) -> tuple[float, float, float]:
    """The median, and the lower and the upper quartile."""
    low, middle, high = np.quantile(times, (0.25, 0.5, 0.75)).tolist()
    return middle, low, high
