"""Finds the events of a run on its curves, and refines them by shortened steps.

On each step a function is interpolated at Chebyshev points, in at least four times as many as the
method has stages, and in more until its last coefficients are small. Ends of steps are those of the
steps themselves, to which a linear term adjusts the interpolant: no root is lost or found twice
where two curves meet. Roots of the interpolant are isolated by bounds: an interval is without one
where |f| at its middle exceeds the bound of |f'| times its half, and has at most one where the same
holds of |f'| and the bound of |f''|; others are halved.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.polynomial import chebyshev

from galvi import input_checks
from galvi.arrays import Array, read_only
from galvi.curves.clock_curves import ClockCurves
from galvi.events.event import Event, Values
from galvi.input_checks import shown
from galvi.run.states import states_between
from galvi.trajectory import Trajectory

if TYPE_CHECKING:
    import pandas

CHUNK = 2048  # steps searched at once
RESOLVED = 1e-9  # last coefficients of an interpolant, relative to its largest, that are small
DOUBLINGS = 3  # of the points of a step whose interpolant is not resolved
HALVINGS = 40
MOST = 1_000_000  # events of a run
SECANTS = 6
START = 1e-9  # of the first step, within which a root is one at t0
FINE = 4.0 * 2.0**-52  # of the time, at which a root's time is known


@dataclass(frozen=True, eq=False)
class Found:
    """Events in the order of their times; arrays (n,), and q, v (n, ...).

    t          times, of the order of the steps
    name       names of the events
    step       numbers of the steps in which they happen, from 1
    value      what the event reports there, such as a distance
    index      place of the event in the list that was asked for
    q, v       the state there
    unresolved number of steps in which a function was not resolved, so that roots may be missing
    """

    t: Array
    name: tuple[str, ...]
    step: Any
    value: Array
    index: Any
    q: Array
    v: Array
    unresolved: int = 0

    def __len__(self) -> int:
        return len(self.t)

    def __getitem__(self, key: str) -> Any:
        """The array of that name."""
        return getattr(self, key)

    def to_frame(self) -> pandas.DataFrame:
        """A tidy pandas frame: t, name, step, value and index."""
        import pandas

        columns = ("t", "name", "step", "value", "index")
        return pandas.DataFrame({name: getattr(self, name) for name in columns})

    def __repr__(self) -> str:
        return f"Found({len(self)} events)"


def find_events(run: Trajectory, events: Event | Sequence[Event]) -> Found:
    """The events of a run of `galvi.integrate`, on the curve of each of its steps.

    events  one, or several: `galvi.Event`, or those of `galvi.events`

    Every root of a function's interpolant on a step is found, also two within one step; a root at
    t0 is none. Times and states are those of the step's order: a root of the curve is refined by a
    shortened step from the last kept state. Steps after the last state that a failed run kept have
    no events. In a moving frame the curve is the frame's.

    Raises ValueError for a run of a reference, for one in a clock that kept no curves, and for more
    than a million events; TypeError for something that is no event.
    """
    several = (events,) if isinstance(events, Event) else input_checks.several(events)
    for one in several:
        if not isinstance(one, Event):
            raise TypeError(
                f"events must be galvi.Event values, such as galvi.events.apsis(1, 0); received "
                f"{shown(one)}."
            )
    times = _grid(run)
    rows: list[tuple[float, int, int]] = []
    unresolved = 0
    values = [one.values(run.problem) for one in several]
    for number, (event, (function, _, condition)) in enumerate(zip(several, values, strict=True)):
        close: set[float] = set()
        joint = np.zeros(0)
        for first, begin, end, coefficients, lost in _interpolants(run, times, function):
            unresolved += lost
            start = _at(coefficients[:1], np.array([-1.0])) if first == 0 else joint[-1:]
            joint = np.append(start, coefficients.sum(axis=1))  # the same for steps that meet
            for step, x, rises in _roots(coefficients, joint):
                if event.direction and (rises > 0) != (event.direction > 0):
                    continue
                t = begin[step] + 0.5 * (1.0 + x) * (end[step] - begin[step])
                t, q, v = _refined(run, function, t, begin[step], end[step])
                since = abs((t[0] - times[0]) / (times[1] - times[0]))
                if since <= START or t[0] in close:  # at t0, or found in the step before
                    continue
                if condition is None or condition(q, v, t)[0] > 0.0:
                    rows.append((float(t[0]), number, first + step + 1))
                    close = {float(t[0])}
            if len(rows) > MOST:
                raise ValueError(f"a run may have {MOST} events; received more, of {event.name!r}.")
    sign = 1.0 if run.step is not None and run.step > 0.0 else -1.0
    rows.sort(key=lambda row: (sign * row[0], row[1]))
    t = np.array([row[0] for row in rows])
    index: Any = np.array([row[1] for row in rows], dtype=np.int64)
    q, _p, v = states_between(run, t) if len(t) else (run.q[:0], run.p[:0], run.v[:0])
    value = np.full(len(t), np.nan)
    for k, (_, reported, _c) in enumerate(values):
        own = np.flatnonzero(index == k)
        if own.size:
            value[own] = reported(q[own], v[own], t[own])
    names = tuple(several[k].name for k in index)
    numbers = np.array([row[2] for row in rows], dtype=np.int64)
    return Found(read_only(t), names, numbers, read_only(value), index, q, v, unresolved)


def _grid(run: Trajectory) -> Array:
    """The times at which the steps of a run begin and end, up to a failure."""
    if not isinstance(run, Trajectory) or run.step is None or (run.curves or run.again) is None:
        raise ValueError(f"events are found on runs of galvi.integrate; received {shown(run)}.")
    if run.tau is None:
        finite = np.isfinite(run.q.reshape(len(run.t), -1)).all(axis=1)
        last = float(run.t[finite][-1])
        steps = round((last - run.t[0]) / run.step)
        return np.append(run.t[0] + np.arange(steps) * run.step, last)
    if not isinstance(run.curves, ClockCurves):
        raise ValueError(
            "events of a run in a clock are found on its curves; this one kept none. Integrate "
            "with save_every=1, or curves=True."
        )
    return np.append(run.t[:1], run.curves.times[1:])  # one that was resumed begins within a step


def _interpolants(
    run: Trajectory, times: Array, function: Values
) -> Iterator[tuple[int, Array, Array, Array, int]]:
    """Chunks of steps: the first one's number, where they begin and end, the coefficients of the
    interpolants (n, points), and how many are not resolved."""
    every = len(run.t) == len(times) and bool(np.all(np.isfinite(run.q)))
    for first in range(0, len(times) - 1, CHUNK):
        begin, end = times[first : first + CHUNK + 1][:-1], times[first + 1 : first + CHUNK + 1]
        points, n = 4 * run.method.stages, len(begin)
        coefficients = _coefficients(run, begin, end, points, function)
        for _ in range(DOUBLINGS):
            rough = np.flatnonzero(~_is_resolved(coefficients))
            if not rough.size:
                break
            points *= 2
            wider = np.zeros((n, points))
            wider[:, : coefficients.shape[1]] = coefficients
            wider[rough] = _coefficients(run, begin[rough], end[rough], points, function)
            coefficients = wider
        if every:
            states = slice(first, first + n + 1)
            exact = function(run.q[states], run.v[states], times[states])
            signs = (-1.0) ** np.arange(coefficients.shape[1])
            off = exact[:-1] - coefficients @ signs, exact[1:] - coefficients.sum(axis=1)
            coefficients[:, 0] += 0.5 * (off[0] + off[1])
            coefficients[:, 1] += 0.5 * (off[1] - off[0])
        if not np.all(np.isfinite(coefficients)):
            raise ValueError(
                "an event must be a finite number along the run; received one that is not."
            )
        yield first, begin, end, coefficients, int(np.sum(~_is_resolved(coefficients)))


def _coefficients(
    run: Trajectory, begin: Array, end: Array, points: int, function: Values
) -> Array:
    x, matrix = _points(points)
    t = (begin[:, None] + 0.5 * (1.0 + x) * (end - begin)[:, None]).ravel()
    found: Array = function(run(t), run.velocity(t), t).reshape(len(begin), points) @ matrix.T
    return found


@lru_cache(maxsize=16)
def _points(n: int) -> tuple[Array, Array]:
    """Chebyshev points in (-1, 1), and the matrix from values there to coefficients."""
    angle = np.pi * (np.arange(n) + 0.5) / n
    matrix = 2.0 / n * np.cos(np.arange(n)[:, None] * angle)
    matrix[0] *= 0.5
    return np.cos(angle), matrix


def _is_resolved(coefficients: Array) -> Any:
    sizes = np.abs(coefficients)
    return sizes[:, -3:].max(axis=1) <= RESOLVED * sizes.max(axis=1)


def _roots(coefficients: Array, joint: Array) -> list[tuple[int, float, int]]:
    """Row, place in (-1, 1] and direction of each root of n series with a change of sign.

    joint  (n + 1,) values between one series and the next
    """
    slopes = chebyshev.chebder(coefficients, axis=1)
    bends = chebyshev.chebder(slopes, axis=1) if slopes.shape[1] > 1 else 0.0 * slopes
    bounds = np.abs(slopes).sum(axis=1), np.abs(bends).sum(axis=1)
    rows, left = np.arange(len(coefficients)), np.full(len(coefficients), -1.0)
    found: list[tuple[int, float, int]] = []
    half = 1.0
    for _ in range(HALVINGS):
        middle = left + half
        f, slope = _at(coefficients[rows], middle), _at(slopes[rows], middle)
        maybe = np.abs(f) <= half * bounds[0][rows]
        single = maybe & (np.abs(slope) > half * bounds[1][rows])
        for k in np.flatnonzero(single).tolist():
            row, low, high = int(rows[k]), float(left[k]), float(left[k] + 2.0 * half)
            ends = chebyshev.chebval(np.array([low, high]), coefficients[row])
            ends[0] = joint[row] if low == -1.0 else ends[0]
            ends[1] = joint[row + 1] if high == 1.0 else ends[1]
            root = _root(coefficients[row], low, high, ends)
            if root is not None:
                found.append((int(rows[k]), root, 1 if slope[k] > 0.0 else -1))
        more = maybe & ~single
        rows, left = rows[more], left[more]
        if not rows.size:
            break
        half *= 0.5
        rows, left = np.repeat(rows, 2), (left[:, None] + np.array([0.0, 2.0 * half])).ravel()
    for k in range(len(rows)):  # roots too near each other to tell: a change of sign or none
        ends = _at(coefficients[rows[[k, k]]], np.array([left[k], left[k] + 2.0 * half]))
        if ends[0] * ends[1] < 0.0:
            found.append((int(rows[k]), float(left[k] + half), int(np.sign(ends[1]))))
    return found


def _at(coefficients: Any, x: Any) -> Array:
    found: Array = np.einsum("kn,kn->k", chebyshev.chebvander(x, coefficients.shape[1] - 1),
                             coefficients)  # fmt: skip
    return found


def _root(series: Array, low: float, high: float, ends: Array) -> float | None:
    """The root in (low, high] of a series that is monotone there, with values at its ends; None
    without one."""
    if ends[1] == 0.0:
        return high
    if ends[0] * ends[1] >= 0.0:
        return None
    for _ in range(60):
        middle = 0.5 * (low + high)
        value = chebyshev.chebval(middle, series)
        if value * ends[0] > 0.0:
            low = middle
        else:
            high = middle
        if high - low <= 1e-14:
            break
    return 0.5 * (low + high)


def _refined(
    run: Trajectory, function: Values, t: float, begin: float, end: float
) -> tuple[Array, Array, Array]:
    """Time (1,), q and v (1, ...) of a root by secants, from one of the curve, within its step."""
    low, high = min(begin, end), max(begin, end)
    times = [t, t + 1e-6 * (end - begin) if t < high else t - 1e-6 * (end - begin)]
    known = []
    for one in times:
        where = np.array([min(max(one, low), high)])
        q, _, v = states_between(run, where)
        known.append((float(where[0]), float(function(q, v, where)[0]), q, v))
    best = min(known, key=lambda one: abs(one[1]))
    for _ in range(SECANTS):
        (a, fa, *_), (b, fb, *_) = known[-2:]
        if fb == fa or fb == 0.0:
            break
        new = min(max(b - fb * (b - a) / (fb - fa), low), high)
        if abs(new - b) <= FINE * max(abs(new), abs(end - begin)):
            break
        where = np.array([new])
        q, _, v = states_between(run, where)
        known.append((new, float(function(q, v, where)[0]), q, v))
        best = min(best, known[-1], key=lambda one: abs(one[1]))
    return np.array([best[0]]), best[2], best[3]
