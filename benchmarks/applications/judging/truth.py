"""The truth of a judgement, from two sources that are not galvi, and their agreement."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np

from benchmarks.applications.judging.candidate import Source
from galvi import Problem, Trajectory
from galvi.arrays import Array
from galvi.systems.lagrangian import momentum_at

Errors = Callable[[Trajectory, Trajectory], Array]


@dataclass(frozen=True, eq=False)
class Agreement:
    """The largest distance of a part of the model between two sources, until one of them stops.

    Attributes
    ----------
    source
        that is compared with the truth
    t : array, shape (times,)
    distances : array, shape (times,)
    stopped
        why it did not reach the end, in words; "" where it did
    """

    source: Source
    t: Array
    distances: Array
    stopped: str = ""

    @property
    def largest(self) -> float:
        """Over all times."""
        return float(np.max(self.distances))


def in_pieces(
    source: Source, problem: Problem, ends: Array, limit: float = math.inf
) -> tuple[Trajectory, str]:
    """A run whose states, at the start and at these times, are the ends of runs, not interpolated
    between steps; it ends with the last one that is a success, or after ``limit`` seconds. And why
    it ended early, or ""."""
    t, q, v, stopped = [problem.t0], [problem.q0], [problem.v0], ""
    piece, begun = problem, math.inf  # the first piece may compile
    for end in ends.tolist():
        if time.perf_counter() - begun > limit:
            stopped = "it was given up as slow"
            break
        run = source.run(piece, end - piece.t0, 1)
        if not run.success:
            stopped = "its run fails"
            break
        begun = min(begun, time.perf_counter())
        t, q, v = [*t, end], [*q, run.q[-1]], [*v, run.v[-1]]
        piece = Problem(problem.system, run.q[-1], run.v[-1], end)
    places, speeds, times = np.stack(q), np.stack(v), np.array(t)
    momenta = momentum_at(problem.system, places, speeds, times)
    return Trajectory(problem, times, places, momenta, velocities=speeds), stopped


def agreements(
    truth: Trajectory,
    sources: Iterable[Source],
    errors: Errors,
    pieces: int,
    report: Callable[[str], None],
    limit: float = math.inf,
) -> list[Agreement]:
    """The agreement of the truth with each source, at the ends of ``pieces`` of its time.

    Parameters
    ----------
    limit
        seconds after which a source is not taken any further
    """
    problem = truth.problem
    rows = np.unique(np.linspace(0, len(truth.t) - 1, pieces + 1).round().astype(int))
    few = states_of(truth, rows)
    compared = []
    for source in sources:
        report(f"truth: {source.label}")
        run, stopped = in_pieces(source, problem, few.t[1:], limit)
        reached = len(run.t)  # fewer where it stopped
        until = states_of(few, slice(reached))
        distances = errors(run, until).reshape(reached, -1).max(axis=1)
        compared.append(Agreement(source, until.t, distances, stopped))
    return compared


def states_of(run: Trajectory, rows: Any) -> Trajectory:
    """These states of a run."""
    return Trajectory(
        run.problem,
        run.t[rows],
        run.q[rows],
        run.p[rows],
        velocities=run.v[rows],
        method=run.method,
    )


def thinned(run: Trajectory, stride: int) -> Trajectory:
    """The first state of a run, and every `stride`-th one after it."""
    return states_of(run, slice(None, None, stride))


def time_text(truth: Trajectory, t: float) -> str:
    """A time with the digits that tell apart a hundred-thousandth of the run, also at an epoch."""
    duration = abs(float(truth.t[-1] - truth.t[0]))
    size = max(abs(float(truth.t[0])), abs(float(truth.t[-1])))
    return f"{t:.{max(6, math.ceil(math.log10(size / duration)) + 5 if size else 0)}g}"
