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
    """The agreement of a source with the truth, up to where the source stops.

    Attributes
    ----------
    source
        the source that is compared with the truth
    t : array, shape (times,)
        compared times
    distances : array, shape (times,)
        largest distance of a part of the model between the two
    stopped
        reason why the source did not reach the end; "" where it did
    """

    source: Source
    t: Array
    distances: Array
    stopped: str = ""

    @property
    def largest(self) -> float:
        """The largest distance at any compared time."""
        return float(np.max(self.distances))


def in_pieces(
    source: Source, problem: Problem, ends: Array, limit: float = math.inf
) -> tuple[Trajectory, str]:
    """Run to each of the times `ends` in turn, each run starting from the end of the one before.

    So no state is interpolated between steps. Returns the states at the start and at the times that
    were reached without a failure and within ``limit`` seconds, and the reason why it ended early,
    or "".
    """
    t, q, v, stopped = [problem.t0], [problem.q0], [problem.v0], ""
    piece, start = problem, math.inf  # the first piece may compile
    for end in ends.tolist():
        if time.perf_counter() - start > limit:
            stopped = "it was given up as slow"
            break
        run = source.run(piece, end - piece.t0, 1)
        if not run.success:
            stopped = "its run fails"
            break
        start = min(start, time.perf_counter())
        t, q, v = [*t, end], [*q, run.q[-1]], [*v, run.v[-1]]
        piece = Problem(problem.system, run.q[-1], run.v[-1], end)
    positions, velocities, times = np.stack(q), np.stack(v), np.array(t)
    momenta = momentum_at(problem.system, positions, velocities, times)
    return Trajectory(problem, times, positions, momenta, velocities=velocities), stopped


def agreements(
    truth: Trajectory,
    sources: Iterable[Source],
    errors: Errors,
    pieces: int,
    report: Callable[[str], None],
    limit: float = math.inf,
) -> list[Agreement]:
    """The agreement of the truth with each source, at the ends of ``pieces`` equal parts of its
    time.

    Parameters
    ----------
    limit
        seconds after which no further piece of a source is run
    """
    problem = truth.problem
    rows = np.unique(np.linspace(0, len(truth.t) - 1, pieces + 1).round().astype(int))
    truth_at_ends = states_of(truth, rows)
    compared = []
    for source in sources:
        report(f"truth: {source.label}")
        run, stopped = in_pieces(source, problem, truth_at_ends.t[1:], limit)
        reached = len(run.t)  # fewer where it stopped
        reached_truth = states_of(truth_at_ends, slice(reached))
        distances = errors(run, reached_truth).reshape(reached, -1).max(axis=1)
        compared.append(Agreement(source, reached_truth.t, distances, stopped))
    return compared


def states_of(run: Trajectory, rows: Any) -> Trajectory:
    """A run with the states in `rows` (an index or slice) only."""
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
    """A time with enough digits to resolve 1e-5 of the run, however far its times are from 0."""
    duration = abs(float(truth.t[-1] - truth.t[0]))
    size = max(abs(float(truth.t[0])), abs(float(truth.t[-1])))
    return f"{t:.{max(6, math.ceil(math.log10(size / duration)) + 5 if size else 0)}g}"
