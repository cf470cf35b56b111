"""Times of the runs of a judgement: predicted before a run, and measured with their spread."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence

import numpy as np

from benchmarks.applications.judging.candidate import Candidate
from benchmarks.statistics.timing import once
from galvi import Problem, Trajectory
from galvi.arrays import Array

FEWEST_TIMINGS, ROUNDS = 5, 9  # timings of one run: a spread needs so many; no more are taken
TRIAL_SHARE = 0.05  # share of what may be spent that a look at a run takes before it is believed


def expected(run: Callable[[int], object], steps: int, enough: float) -> float:
    """The seconds of ``steps`` steps, from runs of n and of 2n: their difference has no set-up in
    it. n grows until steps outweigh set-up.

    Parameters
    ----------
    run
        (n): n steps
    enough
        seconds below which no better answer is needed than a bound from above
    """
    count = 2
    run(count)  # what compiles, and what a first call costs
    while True:
        once, twice = _pair(run, count)
        if _prevail(once, twice, enough):  # unless the machine was busy for a moment
            once, twice = map(min, (once, twice), _pair(run, count))
        bound = twice * max(1.0, steps / (2 * count))
        by_difference = twice + max(twice - once, 0.0) * max(0.0, steps / count - 2.0)
        if bound <= enough or _prevail(once, twice, enough) or 8 * count > steps:
            return min(bound, by_difference)
        count *= 4


def _prevail(once: float, twice: float, enough: float) -> bool:
    """Whether steps outweigh set-up in a run that is long enough to tell."""
    return twice - once > 0.5 * once and twice > TRIAL_SHARE * enough


def _pair(run: Callable[[int], object], count: int) -> tuple[float, float]:
    return _seconds(run, count), _seconds(run, 2 * count)


def _seconds(run: Callable[[int], object], count: int) -> float:
    begun = time.perf_counter()
    run(count)
    return time.perf_counter() - begun


def steps_of(candidate: Candidate, problem: Problem, span: float, samples: int, count: int) -> None:
    """The first ``count`` steps of a candidate, of which the last state alone is kept."""
    step = candidate.setting(span, samples)["step"]
    setting = {**candidate.options, "step": step, "save_every": count}
    candidate.contender.run(problem, count * step, setting)


def timed(
    candidate: Candidate,
    problem: Problem,
    span: float,
    samples: int,
) -> tuple[Trajectory, float, float]:
    """A run; the seconds of its engine: of galvi those of the whole call, of others without our
    conversion of their states; and those of all."""
    begun = time.perf_counter()
    run, seconds = once(lambda: candidate.run(problem, span, samples))
    return run, seconds, time.perf_counter() - begun


def race(
    candidates: Sequence[Candidate],
    walls: Sequence[float],
    problem: Problem,
    span: float,
    samples: int,
    limit: float,
) -> list[Array]:
    """The seconds of the candidates, run in turns so that all meet the same load: FEWEST_TIMINGS to
    ROUNDS timings of each, none of the slowest where ``limit`` seconds do not suffice. The first
    candidate has precedence.

    Parameters
    ----------
    walls
        seconds that a run of each takes, about
    """
    times: list[list[float]] = [[] for _ in candidates]
    by_time = sorted(range(len(walls)), key=lambda k: (k > 0, walls[k]))
    planned = np.cumsum(
        [FEWEST_TIMINGS * walls[k] for k in by_time if FEWEST_TIMINGS * walls[k] <= limit]
    )
    entered = [k for k in by_time if FEWEST_TIMINGS * walls[k] <= limit][
        : int(np.sum(planned <= limit))
    ]
    begun = time.perf_counter()
    for turn in range(ROUNDS if entered else 0):
        if turn >= FEWEST_TIMINGS and time.perf_counter() - begun > limit:
            break
        for k in entered:
            times[k].append(timed(candidates[k], problem, span, samples)[1])
    return [np.array(seconds) for seconds in times]


def quartiles(times: Array) -> tuple[float, float, float]:
    """The median, and the lower and the upper quartile."""
    low, middle, high = np.quantile(times, (0.25, 0.5, 0.75)).tolist()
    return middle, low, high
