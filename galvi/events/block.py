"""The steps of a run with their curves and states, kept or computed again, and on each step the
sign or an interpolant of a function."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import cache, cached_property, partial
from typing import Any, NamedTuple, cast

import numpy as np

from galvi.arrays import Array
from galvi.curves.clock_curves import ClockCurves, JoinedCurves
from galvi.curves.redone_curves import RedoneCurves
from galvi.events.bound_events import Function
from galvi.events.entries import Entry, later_entries
from galvi.events.roots import points_of, times_matrix
from galvi.events.step_polynomials import StepPolynomials, step_polynomials
from galvi.method import Galerkin
from galvi.run.integrate import prepared
from galvi.run.loop import unwatched
from galvi.run.request import RunRequest
from galvi.run.states import finite_states, saved_velocities
from galvi.trajectory import Trajectory

SAME_TIME = 1e-6  # of a step, by which times are those of its ends


class Piece(NamedTuple):
    """n steps of a run.

    Attributes
    ----------
    run
        has the states from which shortened steps are done
    curves
        row k of them is that of step k
    times : array, shape (n + 1,)
        at which the steps begin and end
    has_states
        whether the run has the states at these times
    first
        number of steps of the run before
    after, until
        times between which its events are the run's
    """

    run: Trajectory
    curves: Any
    times: Array
    has_states: bool
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
    if step == 0.0:  # time stands still, where bodies collide
        return Piece(run, curves, grid[:1], False, first, float(t[0]), last)
    grid = grid[(grid - last) / step < 1.0 - SAME_TIME]
    begin = float(t[0]) if after is None else after
    offsets = np.abs(t - grid) if len(t) == len(grid) else np.array([np.inf])
    if np.max(offsets / np.abs(np.diff(grid, append=2.0 * grid[-1] - grid[-2]))) < SAME_TIME:
        return Piece(run, curves, t, True, first, begin, np.copysign(np.inf, step))
    return Piece(run, curves, grid, False, first, begin, last)


def _grid(curves: Any) -> Array:
    return (
        curves.times
        if isinstance(curves, ClockCurves)
        else (curves.t0 + np.arange(len(curves.bases) + 1) * curves.step)
    )


def pieces(run: Trajectory) -> Iterator[Piece]:
    """The steps of a run, up to a failure; ValueError where it has no curves."""
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


def _redone(run: Trajectory, again: RedoneCurves) -> Iterator[Piece]:
    checkpoints, after = again.checkpoints, float(run.t[0])
    before: Trajectory | None = None
    for k, start in enumerate(checkpoints):
        begin = replace(start, save_every=1, curves=True)
        steps = checkpoints[k + 1].first - start.first if k + 1 < len(checkpoints) else None
        if again.method.clock is not None:
            arguments = run.problem, again.method, again.step, steps, begin, again.end, before
            before = prepared(RunRequest(*arguments))()
        else:
            left = checkpoints[0].first + again.steps_done - start.first if steps is None else steps
            if not left:
                continue
            before = unwatched(RunRequest(run.problem, again.method, again.step, left, begin))
        piece = piece_of(before, start.first - checkpoints[0].first, after)
        yield piece._replace(until=float(run.t[finite_states(run) - 1]))
        after = -float(np.copysign(np.inf, again.step))


CHUNK = 8192  # steps searched at once
SAMPLED = 512  # steps sampled at once
RESOLVED = 1e-9  # last coefficients of an interpolant, relative to its largest, that are small
POINT_DOUBLINGS = 3  # of the points of a step whose interpolant is not resolved
ZERO_BOUND = 1e-12  # of a bound, within which it is 0


class Block:
    """Up to CHUNK steps of a piece."""

    def __init__(self, piece: Piece, first: int, method: Galerkin) -> None:
        self.piece, self.first, self.method = piece, first, method
        times = piece.times[first : first + CHUNK + 1]
        self.begin, self.end = times[:-1], times[1:]

    @cached_property
    def polynomials(self) -> StepPolynomials | None:
        """The polynomials of the steps; None for curves that have none."""
        return step_polynomials(self.piece.curves, self.first, self.begin, self.end)

    @cached_property
    def rough(self) -> Any:
        """Whether a step has no polynomials (n,)."""
        none = np.ones(len(self.begin), dtype=bool)
        return none if self.polynomials is None else self.polynomials.unusable

    def times(self, steps: Any, x: Array) -> tuple[Array, Array]:
        """The times at places x (k,) in [-1, 1] of some steps (k,), and their slopes there."""
        half = 0.5 * (self.end - self.begin)[steps]
        t, slope = self.begin[steps] + (1.0 + x) * half, half
        smooth = np.flatnonzero(~self.rough[steps])
        if self.polynomials is not None and not self.polynomials.time_is_linear:
            some = self.polynomials.times(steps[smooth], 0.5 * (1.0 + x[smooth]))
            t[smooth], slope[smooth] = some[0], 0.5 * some[1]
        return t, slope

    def series(
        self, function: Function, start: float, sure: Array | None = None
    ) -> tuple[Array, Any, Array, int]:
        """Coefficients (k, points) of interpolants on the steps that may have a root, the numbers
        of these steps here (k,), values or signs (n + 1,) between steps, and how many are rough.

        Parameters
        ----------
        start
            the value, or the sign, at the end of the steps before; 0 where there are none
        sure
            the sign (n,) that the function keeps on each step, 0 where it may change; None: from
            bounds
        """
        if sure is None:
            has_bounds = self.bounded and not function.refusal
            sure = (
                sign_of(*function.bounds(*self._box)) if has_bounds else np.zeros(len(self.begin))
            )
        if self.bounded:
            sure[1:][sure[1:] * sure[:-1] < 0.0] = 0.0
            sure[0] = 0.0 if sure[0] * start < 0.0 else sure[0]
        steps = np.flatnonzero(sure == 0.0)
        if not steps.size:
            return np.zeros((0, 2)), steps, np.append(sure, sure[-1]), 0
        joint = self._joint(function, sure)
        steps = np.flatnonzero(sure == 0.0)
        interpolants = self._interpolants(function, steps)
        if joint is None:
            ends = np.stack([sure, sure], axis=1)
            ends[steps] = times_matrix(interpolants, _ends(interpolants.shape[1]))
            joint = np.append(start or ends[0, 0], ends[:, 1])
            outside = np.flatnonzero((sure[1:] != 0.0) & (sure[:-1] == 0.0)) + 1
            joint[outside] = sure[outside]
        else:
            off = np.stack([joint[steps], joint[steps + 1]], axis=1) - times_matrix(
                interpolants, _ends(interpolants.shape[1])
            )
            interpolants[:, :2] += off @ np.array([[0.5, -0.5], [0.5, 0.5]])
        return interpolants, steps, joint, int(np.sum(~is_resolved(interpolants)))

    def _joint(self, function: Function, sure: Array) -> Array | None:
        """The function at the ends of steps that are not sure, and its sign at the other ends; None
        without states. ``sure`` becomes 0 where the value at an end contradicts it."""
        run, times = self.piece.run, self.piece.times
        if not self.piece.has_states:
            return None
        joint, evaluated = np.append(sure, sure[-1]), np.zeros(len(sure) + 1, dtype=bool)
        while True:
            ends = np.append(sure == 0.0, False)
            ends[1:] |= sure == 0.0
            new = np.flatnonzero(ends & ~evaluated)
            if not new.size:
                return joint
            rows = self.first + new
            joint[new] = function.of(run.q[rows], saved_velocities(run, rows), times[rows])
            evaluated = ends
            for end, mask in ((joint[:-1], ends[:-1]), (joint[1:], ends[1:])):
                sure[mask & (end * sure <= 0.0)] = 0.0

    @property
    def bounded(self) -> bool:
        """Whether coordinates have bounds on each step."""
        return self.polynomials is not None and self.polynomials.is_polynomial

    @cached_property
    def bounds(self) -> Callable[[bool], tuple[Array, Array]]:
        """A cached function: False -> bounds (d, n) of the coordinates on each step, True -> of the
        velocities. It holds no reference to this block, which would outlive its search."""
        steps, points = cast(StepPolynomials, self.polynomials), 4 * self.method.stages
        return cache(lambda fast: steps.bounds(fast, points))

    @cached_property
    def _box(self) -> tuple[Any, Any, Entry]:
        """Entries that are bounds of each step: coordinates, velocities and the time."""
        bounds, d = self.bounds, cast(StepPolynomials, self.polynomials).coefficients.shape[1]

        def row(fast: bool, k: int) -> tuple[Array, Array]:
            low, high = bounds(fast)
            return low[k], high[k]

        q, v = (later_entries(partial(row, fast), d) for fast in (False, True))
        return q, v, Entry(np.minimum(self.begin, self.end), np.maximum(self.begin, self.end))

    def _interpolants(self, function: Function, steps: Any) -> Array:
        points = 4 * self.method.stages
        coefficients = self._sampled(function, steps, points)
        for _ in range(POINT_DOUBLINGS):
            rough = np.flatnonzero(~is_resolved(coefficients))
            if not rough.size:
                break
            points *= 2
            wider = np.zeros((len(steps), points))
            wider[:, : coefficients.shape[1]] = coefficients
            wider[rough] = self._sampled(function, steps[rough], points)
            coefficients = wider
        return coefficients

    def _sampled(self, function: Function, steps: Any, points: int) -> Array:
        """Coefficients (k, points) of the function's interpolants on some steps (k,)."""
        if len(steps) > SAMPLED:
            return np.concatenate(
                [
                    self._sampled(function, steps[k : k + SAMPLED], points)
                    for k in range(0, len(steps), SAMPLED)
                ]
            )
        matrix = points_of(points)[1]
        rough = self.rough[steps]
        if rough.any() and not rough.all():
            both = np.empty((len(steps), points))
            for some in (rough, ~rough):
                both[some] = self._sampled(function, steps[some], points)
            return both
        if rough.any():
            q, v, t = self._on_curves(steps, points)
            return times_matrix(
                function.at(q.transpose(1, 0, 2), v.transpose(1, 0, 2), t), matrix.T
            )
        places, velocities, t = cast(StepPolynomials, self.polynomials).at_points(steps, points)
        return times_matrix(function.at_later(places, velocities, t), matrix.T)

    def _on_curves(self, steps: Any, points: int) -> tuple[Array, Array, Array]:
        """q, v (k, d, points) and t (k, points), as the curves have them at Chebyshev points."""
        share, k = 0.5 * (1.0 + points_of(points)[0]), len(steps)
        begin = self.begin[steps]
        t = begin[:, None] + share * (self.end[steps] - begin)[:, None]
        q, v = (
            value(t.ravel()).reshape(k, points, -1).transpose(0, 2, 1)
            for value in (self.piece.curves.position, self.piece.curves.velocity)
        )
        return q, v, t


def sign_of(low: Array, high: Array) -> Array:
    """The sign that bounds of a function show on each step, ends included; 0 for none."""
    with np.errstate(invalid="ignore"):
        above = (low > 0.0) & (low > ZERO_BOUND * high)
        return 1.0 * above - 1.0 * ((high < 0.0) & (high < ZERO_BOUND * low))


def is_resolved(coefficients: Array) -> Any:
    sizes = np.abs(coefficients)
    return sizes[:, -3:].max(axis=1) <= RESOLVED * sizes.max(axis=1)


def _ends(n: int) -> Array:
    """The values (n, 2) of the first n polynomials at -1 and 1."""
    return np.stack([(-1.0) ** np.arange(n), np.ones(n)], axis=1)
