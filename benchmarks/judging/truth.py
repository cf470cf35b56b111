"""The truth of a judgement, from two sources that are not galvi, and their agreement."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from benchmarks.judging.candidate import Source
from galvi import Problem, Trajectory
from galvi.arrays import Array
from galvi.systems.velocities import momentum_at

Errors = Callable[[Trajectory, Trajectory], Array]


@dataclass(frozen=True, eq=False)
class Agreement:
    """The largest distance of a part of the model between two sources, until one of them stops.

    source  the other one
    t       (times,)
    apart   (times,)
    """

    source: Source
    t: Array
    apart: Array

    @property
    def largest(self) -> float:
        """Over all times."""
        return float(np.max(self.apart))


def in_pieces(source: Source, problem: Problem, duration: float, pieces: int) -> Trajectory:
    """A run whose states are the ends of runs, not interpolated between steps; it ends with the
    last one that is a success."""
    t, q, v = [problem.t0], [problem.q0], [problem.v0]
    here = problem
    for k in range(pieces):
        end = problem.t0 + duration * ((k + 1) / pieces)
        run = source.run(here, end - here.t0, 1)
        if not run.success:
            break
        t, q, v = [*t, end], [*q, run.q[-1]], [*v, run.v[-1]]
        here = Problem(problem.system, run.q[-1], run.v[-1], end)
    places, speeds = np.stack(q), np.stack(v)
    times = np.array(t)
    momenta = momentum_at(problem.system, places, speeds, times)
    return Trajectory(problem, times, places, momenta, velocities=speeds)


def agreements(
    truth: Trajectory, others: Sequence[Source], errors: Errors, pieces: int,
    report: Callable[[str], None],
) -> list[Agreement]:  # fmt: skip
    """Of the truth with each other source, at ``pieces`` times among its states."""
    problem, every = truth.problem, (len(truth.t) - 1) // pieces
    rows = np.arange(0, every * pieces + 1, every)
    thinned = Trajectory(problem, truth.t[rows], truth.q[rows], truth.p[rows],
                         velocities=truth.v[rows])  # fmt: skip
    found = []
    for source in others:
        report(f"truth: {source.label}")
        run = in_pieces(source, problem, float(thinned.t[-1] - problem.t0), pieces)
        reached = len(run.t)  # fewer where it stopped
        if reached == 1:
            continue
        until = replace(thinned, t=thinned.t[:reached], q=thinned.q[:reached],
                        p=thinned.p[:reached], velocities=thinned.v[:reached])  # fmt: skip
        apart = errors(run, until).reshape(reached, -1).max(axis=1)
        found.append(Agreement(source, until.t, apart))
    return found
