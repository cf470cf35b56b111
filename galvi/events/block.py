"""The steps of a run with their curves and states, kept or computed again, and the sign or an
interpolant of a function on each step."""

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
from galvi.events.entries import Entry, lazy_entries
from galvi.events.roots import points_of, times_matrix
from galvi.events.step_polynomials import StepPolynomials, step_polynomials
from galvi.method import Galerkin
from galvi.run.integrate import prepare_run
from galvi.run.loop import unwatched
from galvi.run.request import RunRequest
from galvi.run.states import finite_states, saved_velocities
from galvi.trajectory import Trajectory

TIME_TOLERANCE = 1e-6  # share of a step, up to which a time counts as that of a step's end
STEPS_AT_ONCE = 8192  # steps searched at once
SAMPLED_AT_ONCE = 512  # steps sampled at once
RESOLVED_COEFFICIENT = 1e-9  # an interpolant's last coefficients at most, over the largest one
POINT_DOUBLINGS = 3  # largest number of doublings of the points of an unresolved interpolant
ZERO_BOUND = 1e-12  # share of the other bound, up to which a bound counts as 0


class Piece(NamedTuple):
    """n steps of a run.

    Attributes
    ----------
    run
        a run whose saved states shortened steps start from
    curves
        the curves of the steps, in their order
    times : array, shape (n + 1,)
        times at which the steps begin and end
    has_states
        whether the run has saved states at these times
    first
        number of steps of the whole run before this piece
    after, until
        times between which roots count as events of the whole run
    """

    run: Trajectory
    curves: Any
    times: Array
    has_states: bool
    first: int = 0
    after: float = -np.inf
    until: float = np.inf


def piece_of(run: Trajectory, first: int = 0, after: float | None = None) -> Piece:
    """All steps of a run that kept its curves, up to a failure.

    Parameters
    ----------
    first, after
        see `Piece`; None: the time of the first state
    """
    finite_count = finite_states(run)
    curves: Any = run.curves
    grid = _grid(curves)
    saved_times, last_time = run.t[:finite_count], float(run.t[finite_count - 1])
    step = grid[1] - grid[0]
    if step == 0.0:  # time stands still, where bodies collide
        return Piece(run, curves, grid[:1], False, first, float(saved_times[0]), last_time)
    grid = grid[(grid - last_time) / step < 1.0 - TIME_TOLERANCE]
    begin = float(saved_times[0]) if after is None else after
    offsets = np.abs(saved_times - grid) if len(saved_times) == len(grid) else np.array([np.inf])
    if np.max(offsets / np.abs(np.diff(grid, append=2.0 * grid[-1] - grid[-2]))) < TIME_TOLERANCE:
        return Piece(run, curves, saved_times, True, first, begin, np.copysign(np.inf, step))
    return Piece(run, curves, grid, False, first, begin, last_time)


def _grid(curves: Any) -> Array:
    return (
        curves.times
        if isinstance(curves, ClockCurves)
        else (curves.t0 + np.arange(len(curves.bases) + 1) * curves.step)
    )


def pieces(run: Trajectory) -> Iterator[Piece]:
    """The steps of a run, up to a failure; ValueError where it has no curves, and none that can be
    computed again."""
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
        yield from _redone_pieces(run, run.again)
    else:
        raise ValueError(
            "events are found on curves, and this run with actions kept none. Integrate with "
            "save_every=1, or curves=True, or read run.events."
        )


def _redone_pieces(run: Trajectory, again: RedoneCurves) -> Iterator[Piece]:
    checkpoints, after = again.checkpoints, float(run.t[0])
    run_of_piece: Trajectory | None = None
    for k, start in enumerate(checkpoints):
        begin = replace(start, save_every=1, curves=True)
        steps = checkpoints[k + 1].first - start.first if k + 1 < len(checkpoints) else None
        if again.method.clock is not None:
            arguments = run.problem, again.method, again.step, steps, begin, again.end, run_of_piece
            run_of_piece = prepare_run(RunRequest(*arguments))()
        else:
            steps_left = (
                checkpoints[0].first + again.steps_done - start.first if steps is None else steps
            )
            if not steps_left:
                continue
            run_of_piece = unwatched(
                RunRequest(run.problem, again.method, again.step, steps_left, begin)
            )
        piece = piece_of(run_of_piece, start.first - checkpoints[0].first, after)
        yield piece._replace(until=float(run.t[finite_states(run) - 1]))
        after = -float(np.copysign(np.inf, again.step))


class Block:
    """At most STEPS_AT_ONCE steps of a piece.

    Attributes
    ----------
    first
        index of its first step in the piece
    begin, end : array, shape (n,)
        times at which the steps begin and end
    """

    def __init__(self, piece: Piece, first: int, method: Galerkin) -> None:
        self.piece, self.first, self.method = piece, first, method
        times = piece.times[first : first + STEPS_AT_ONCE + 1]
        self.begin, self.end = times[:-1], times[1:]

    @cached_property
    def polynomials(self) -> StepPolynomials | None:
        """The polynomials of the steps; None for curves that have none."""
        return step_polynomials(self.piece.curves, self.first, self.begin, self.end)

    @cached_property
    def lacks_polynomials(self) -> Any:
        """Whether each step lacks polynomials, (n,)."""
        all_steps = np.ones(len(self.begin), dtype=bool)
        return all_steps if self.polynomials is None else self.polynomials.unusable

    def times(self, steps: Any, x: Array) -> tuple[Array, Array]:
        """The times (k,) at x (k,) in [-1, 1] of the steps ``steps`` (k,), and dt/dx there."""
        half = 0.5 * (self.end - self.begin)[steps]
        t, slope = self.begin[steps] + (1.0 + x) * half, half
        smooth = np.flatnonzero(~self.lacks_polynomials[steps])
        if self.polynomials is not None and not self.polynomials.time_is_linear:
            interpolated = self.polynomials.times(steps[smooth], 0.5 * (1.0 + x[smooth]))
            t[smooth], slope[smooth] = interpolated[0], 0.5 * interpolated[1]
        return t, slope

    def series(
        self, function: Function, start: float, sure: Array | None = None
    ) -> tuple[Array, Any, Array, int]:
        """Coefficients (k, points) of interpolants on the steps that may have a root, the indices
        of these steps in the block (k,), values or signs (n + 1,) at the ends of all steps, and the
        number of interpolants that are not resolved.

        Parameters
        ----------
        start
            the value, or the sign, at the end of the block before; 0 for the first block
        sure
            the sign (n,) that the function keeps on each step, 0 where it may change; changed in
            place. None: it is taken from bounds
        """
        if sure is None:
            use_bounds = self.has_bounds and not function.refusal
            sure = (
                sign_of(*function.bounds(*self._entries_of_bounds))
                if use_bounds
                else np.zeros(len(self.begin))
            )
        if self.has_bounds:
            sure[1:][sure[1:] * sure[:-1] < 0.0] = 0.0
            sure[0] = 0.0 if sure[0] * start < 0.0 else sure[0]
        steps = np.flatnonzero(sure == 0.0)
        if not steps.size:
            return np.zeros((0, 2)), steps, np.append(sure, sure[-1]), 0
        end_values = self._values_at_ends(function, sure)
        steps = np.flatnonzero(sure == 0.0)
        interpolants = self._interpolate(function, steps)
        if end_values is None:
            ends = np.stack([sure, sure], axis=1)
            ends[steps] = times_matrix(interpolants, _ends(interpolants.shape[1]))
            end_values = np.append(start or ends[0, 0], ends[:, 1])
            outer_ends = np.flatnonzero((sure[1:] != 0.0) & (sure[:-1] == 0.0)) + 1
            end_values[outer_ends] = sure[outer_ends]
        else:
            end_errors = np.stack(
                [end_values[steps], end_values[steps + 1]], axis=1
            ) - times_matrix(interpolants, _ends(interpolants.shape[1]))
            interpolants[:, :2] += end_errors @ np.array([[0.5, -0.5], [0.5, 0.5]])
        return interpolants, steps, end_values, int(np.sum(~is_resolved(interpolants)))

    def _values_at_ends(self, function: Function, sure: Array) -> Array | None:
        """The function's values at the ends of steps on which its sign may change, and its sign at
        the other ends, (n + 1,); None without saved states. ``sure`` becomes 0 in place where the
        value at an end contradicts it."""
        run, times = self.piece.run, self.piece.times
        if not self.piece.has_states:
            return None
        end_values, evaluated = np.append(sure, sure[-1]), np.zeros(len(sure) + 1, dtype=bool)
        while True:
            ends = np.append(sure == 0.0, False)
            ends[1:] |= sure == 0.0
            new_ends = np.flatnonzero(ends & ~evaluated)
            if not new_ends.size:
                return end_values
            rows = self.first + new_ends
            end_values[new_ends] = function.of(
                run.q[rows], saved_velocities(run, rows), times[rows]
            )
            evaluated = ends
            for end, mask in ((end_values[:-1], ends[:-1]), (end_values[1:], ends[1:])):
                sure[mask & (end * sure <= 0.0)] = 0.0

    @property
    def has_bounds(self) -> bool:
        """Whether coordinates and velocities have bounds on each step."""
        return self.polynomials is not None and self.polynomials.is_polynomial

    @cached_property
    def bounds(self) -> Callable[[bool], tuple[Array, Array]]:
        """A cached function: False -> bounds (d, n) of the coordinates on each step, True -> those
        of the velocities. It holds no reference to this block, which would outlive its search."""
        steps, points = cast(StepPolynomials, self.polynomials), 4 * self.method.stages
        return cache(lambda fast: steps.bounds(fast, points))

    @cached_property
    def _entries_of_bounds(self) -> tuple[Any, Any, Entry]:
        """Coordinates, velocities and the time as entries with their bounds on each step."""
        bounds, d = self.bounds, cast(StepPolynomials, self.polynomials).coefficients.shape[1]

        def row(fast: bool, k: int) -> tuple[Array, Array]:
            low, high = bounds(fast)
            return low[k], high[k]

        q, v = (lazy_entries(partial(row, fast), d) for fast in (False, True))
        return q, v, Entry(np.minimum(self.begin, self.end), np.maximum(self.begin, self.end))

    def _interpolate(self, function: Function, steps: Any) -> Array:
        points = 4 * self.method.stages
        coefficients = self._sample(function, steps, points)
        for _ in range(POINT_DOUBLINGS):
            unresolved = np.flatnonzero(~is_resolved(coefficients))
            if not unresolved.size:
                break
            points *= 2
            padded = np.zeros((len(steps), points))
            padded[:, : coefficients.shape[1]] = coefficients
            padded[unresolved] = self._sample(function, steps[unresolved], points)
            coefficients = padded
        return coefficients

    def _sample(self, function: Function, steps: Any, points: int) -> Array:
        """Coefficients (k, points) of the function's interpolants on the steps ``steps`` (k,)."""
        if len(steps) > SAMPLED_AT_ONCE:
            return np.concatenate(
                [
                    self._sample(function, steps[k : k + SAMPLED_AT_ONCE], points)
                    for k in range(0, len(steps), SAMPLED_AT_ONCE)
                ]
            )
        matrix = points_of(points)[1]
        lacks_polynomials = self.lacks_polynomials[steps]
        if lacks_polynomials.any() and not lacks_polynomials.all():
            coefficients = np.empty((len(steps), points))
            for same_kind in (lacks_polynomials, ~lacks_polynomials):
                coefficients[same_kind] = self._sample(function, steps[same_kind], points)
            return coefficients
        if lacks_polynomials.any():
            q, v, t = self._on_curves(steps, points)
            return times_matrix(
                function.at(q.transpose(1, 0, 2), v.transpose(1, 0, 2), t), matrix.T
            )
        positions, velocities, t = cast(StepPolynomials, self.polynomials).at_points(steps, points)
        return times_matrix(function.at_later(positions, velocities, t), matrix.T)

    def _on_curves(self, steps: Any, points: int) -> tuple[Array, Array, Array]:
        """q and v (k, d, points) of the curves, and t (k, points), at Chebyshev points."""
        fractions, k = 0.5 * (1.0 + points_of(points)[0]), len(steps)
        begin = self.begin[steps]
        t = begin[:, None] + fractions * (self.end[steps] - begin)[:, None]
        q, v = (
            value(t.ravel()).reshape(k, points, -1).transpose(0, 2, 1)
            for value in (self.piece.curves.position, self.piece.curves.velocity)
        )
        return q, v, t


def sign_of(low: Array, high: Array) -> Array:
    """The sign (...) that bounds of a function prove on each step, ends included; 0 where they
    prove none."""
    with np.errstate(invalid="ignore"):
        above = (low > 0.0) & (low > ZERO_BOUND * high)
        return 1.0 * above - 1.0 * ((high < 0.0) & (high < ZERO_BOUND * low))


def is_resolved(coefficients: Array) -> Any:
    sizes = np.abs(coefficients)
    return sizes[:, -3:].max(axis=1) <= RESOLVED_COEFFICIENT * sizes.max(axis=1)


def _ends(n: int) -> Array:
    """The values (n, 2) of the first n polynomials at -1 and 1."""
    return np.stack([(-1.0) ** np.arange(n), np.ones(n)], axis=1)
