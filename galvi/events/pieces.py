"""The steps of a run with their curves and states, for a search: kept, or done again."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from galvi.arrays import Array
from galvi.curves.clock_curves import ClockCurves, RedoneClockCurves
from galvi.curves.curves import RedoneCurves
from galvi.curves.joined import JoinedCurves
from galvi.run.clocked.run import run_in_clock
from galvi.run.engine_choice import engine_for
from galvi.run.loop import run_steps
from galvi.run.plan import Run
from galvi.run.states import finite_states
from galvi.trajectory import Trajectory

NEAR = 1e-6  # of a step, by which times are those of its ends


class Piece(NamedTuple):
    """n steps of a run.

    run           has the states from which shortened steps are done
    curves        row k of them is that of step k
    times         (n + 1,) at which the steps begin and end
    known         whether the states of the run are those at these times
    first         number of steps of the run before
    after, until  times between which its events are the run's
    """

    run: Trajectory
    curves: Any
    times: Array
    known: bool
    first: int = 0
    after: float = -np.inf
    until: float = np.inf


def piece_of(run: Trajectory, first: int = 0, after: float | None = None) -> Piece:
    """All steps of a run that kept its curves, up to a failure."""
    good = finite_states(run)
    curves: Any = run.curves
    grid = _grid(curves)
    t, last = run.t[:good], float(run.t[good - 1])
    step = grid[1] - grid[0]
    grid = grid[(grid - last) / step < 1.0 - NEAR]
    begin = float(t[0]) if after is None else after
    far = np.abs(t - grid) if len(t) == len(grid) else np.array([np.inf])
    if np.max(far / np.abs(np.diff(grid, append=2.0 * grid[-1] - grid[-2]))) < NEAR:
        return Piece(run, curves, t, True, first, begin, np.copysign(np.inf, step))
    return Piece(run, curves, grid, False, first, begin, last)


def _grid(curves: Any) -> Array:
    return curves.times if isinstance(curves, ClockCurves) else (
        curves.t0 + np.arange(len(curves.bases) + 1) * curves.step
    )  # fmt: skip


def pieces(run: Trajectory) -> Iterator[Piece]:
    """The steps of a run, up to a failure; ValueError where its curves are not to be had."""
    curves: Any = run.curves
    if isinstance(curves, JoinedCurves):
        first = 0
        for part, begin, end in zip(curves.parts, curves.times, curves.times[1:], strict=False):
            grid = _grid(part)
            yield Piece(run, part, grid, False, first, float(begin), float(end))
            first += len(grid) - 1
    elif curves is not None:
        yield piece_of(run)
    elif run.again is not None:
        yield from _redone(run, run.again)
    else:
        raise ValueError(
            "events are found on curves, and this run with actions kept none. Integrate with "
            "save_every=1, or curves=True, or read run.events."
        )


def _redone(run: Trajectory, again: RedoneCurves | RedoneClockCurves) -> Iterator[Piece]:
    known, after = again.known, float(run.t[0])
    before: Trajectory | None = None
    for k, start in enumerate(known):
        begin = replace(start, save_every=1, curves=True)
        steps = known[k + 1].first - start.first if k + 1 < len(known) else None
        if isinstance(again, RedoneClockCurves):
            given = run.problem, again.method, again.step, begin, steps, again.end
            before = run_in_clock(*given, first=before)
        else:
            left = known[0].first + again.done - start.first if steps is None else steps
            if not left:
                continue
            part = Run(run.problem, again.method, again.step, left, begin)
            before = run_steps(engine_for(run.problem, again.method), part, watched=False)
        found = piece_of(before, start.first - known[0].first, after)
        yield found._replace(until=float(run.t[finite_states(run) - 1]))
        after = -float(np.copysign(np.inf, again.step))
