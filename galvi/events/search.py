"""Finds the events of a run on its curves, and refines them by shortened steps.

Steps in which a traced function cannot be 0, by bounds of the coordinates, are left out. On the
others it is interpolated at Chebyshev points, at least four times as many as the method has stages,
and more until its last coefficients are small. Ends of steps are those of the steps themselves, to
which a linear term adjusts the interpolant: no root is lost or found twice where two curves meet.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from galvi.arrays import Array, read_only
from galvi.events.block import CHUNK, Block, Piece, pieces, sign_of
from galvi.events.bound_events import BoundEvent, BoundPairs, Function
from galvi.events.event import Distances, Event, several_events
from galvi.events.roots import roots
from galvi.events.shortened_steps import Shortened, shortened_steps
from galvi.input_checks import shown
from galvi.method import Galerkin
from galvi.outcome import Outcome
from galvi.problem import Problem
from galvi.run.states import RunStates
from galvi.trajectory import Trajectory

if TYPE_CHECKING:
    import pandas

MOST_EVENTS = 1_000_000  # events of a run
SECANTS = 6
ROOTS_TOGETHER = 1024  # roots that are refined at once
START = 1e-9  # of the first step, within which a root is one at t0
ROOT_TIME_ERROR = 4.0 * 2.0**-52  # of the time, at which a root's time is known


@dataclass(frozen=True, eq=False)
class Found:
    """Events in the order of their times; arrays (n,), and q, v (n, ...).

    Attributes
    ----------
    t
        times, of the order of the steps
    name
        names of the events
    step
        numbers of the steps in which they happen, from 1
    value
        what the event reports there, such as a distance
    index
        index of the event in the list of events
    q, v
        the state there, before an action
    unresolved
        number of steps in which a function was not resolved, so that roots may be missing
    status
        a sentence on what is not guaranteed; "" for nothing

    Examples
    --------
    >>> method = galvi.Galerkin(galvi.Polynomials(8), galvi.gauss(8))
    >>> run = galvi.integrate(galvi.problems.kepler(0.5), method, step=0.2, steps=60)
    >>> found = galvi.find_events(run, galvi.events.plane_crossing((0.0, 1.0)))
    >>> len(found), found.step, found["t"].round(6)
    (3, array([16, 32, 48]), array([3.141593, 6.283185, 9.424778]))
    """

    t: Array
    name: tuple[str, ...]
    step: Any
    value: Array
    index: Any
    q: Array
    v: Array
    unresolved: int = 0
    status: str = ""

    def __len__(self) -> int:
        return len(self.t)

    def __getitem__(self, key: str) -> Any:
        """The array of that name."""
        return getattr(self, key)

    def to_frame(self) -> pandas.DataFrame:
        """A tidy pandas.DataFrame: t, name, step, value and index."""
        import pandas

        columns = ("t", "name", "step", "value", "index")
        return pandas.DataFrame({name: getattr(self, name) for name in columns})

    def __repr__(self) -> str:
        return f"Found({len(self)} events)"


class Rows(NamedTuple):
    """n events in the order of their times: t, step, index and which of an event of many pairs it
    is (n,), q and v (n, ...), value (n,)."""

    t: Array
    step: Any
    index: Any
    part: Any
    q: Array
    v: Array
    value: Array

    def at(self, rows: Any) -> Rows:
        """The selected events."""
        return Rows(*(array[rows] for array in self))


def joined(parts: list[Rows]) -> Rows:
    """The rows of several tables as one."""
    return Rows(*(np.concatenate(arrays) for arrays in zip(*parts, strict=True)))


def find_events(run: Trajectory, events: Event | Any) -> Found:
    """The events of a run of `galvi.integrate`, on the curve of each of its steps.

    Parameters
    ----------
    run : galvi.Trajectory
        of `galvi.integrate`
    events
        one, or several: `galvi.Event`, or those of `galvi.events`

    Returns
    -------
    galvi.Found
        the events in the order of their times

    Raises
    ------
    ValueError
        For a run of a reference, for one with actions that kept no curves, for a function that is
        not finite, and for more than a million events.
    TypeError
        When events holds something else.

    Notes
    -----
    Every root of a function's interpolant on a step is found, also two within one step; a root at
    t0 is none. Times and states are those of the step's order: a root of the curve is refined by a
    shortened step from the last kept state. Steps after the last state that a failed run kept have
    no events. In a moving frame the curve is the frame's. ``terminal`` and ``action`` are for
    `galvi.integrate`: here nothing is ended or changed.

    Examples
    --------
    >>> method = galvi.Galerkin(galvi.Polynomials(6), galvi.gauss(6))
    >>> run = galvi.integrate(galvi.problems.harmonic_oscillator(), method, step=0.5, steps=20)
    >>> found = galvi.find_events(run, galvi.Event(lambda q, v, t: q[0], direction=1))
    >>> (found.t / 3.141592653589793).round(9)
    array([1.5])
    """
    several = several_events(events)
    if not isinstance(run, Trajectory) or run.step is None or run.checkpoint is None:
        raise ValueError(f"events are found on runs of galvi.integrate; received {shown(run)}.")
    search = Search(run.problem, run.method, several)
    beyond = search.over(pieces(run))
    if beyond is not None:
        raise ValueError(
            f"a run may have {MOST_EVENTS} events; received more, until t = {beyond:.10g}."
        )
    return search.collected()


class Search:
    """The events of one run, piece after piece."""

    def __init__(self, problem: Problem, method: Galerkin, events: tuple[Event, ...]) -> None:
        self.problem, self.method, self.events = problem, method, events
        self.bound_events = [
            (BoundPairs if isinstance(event.function, Distances) else BoundEvent)(event, problem, k)
            for k, event in enumerate(events)
        ]
        self.rows: list[Rows] = []
        self.unresolved = self.count = 0

    def over(self, run: Iterable[Piece]) -> float | None:
        """Search all pieces; returns the time after which the search stopped because there are too
        many events, or None."""
        for piece in run:
            self.on(piece)
            if self.count > MOST_EVENTS:
                return float(piece.times[-1])
        return None

    def on(self, piece: Piece) -> Rows:
        """Search a piece; returns its events, which are kept."""
        reaching, starts = (
            RunStates(piece.run),
            [np.zeros(_parts(event)) for event in self.bound_events],
        )
        parts = [self.none()]
        for first in range(0, len(piece.times) - 1, CHUNK):
            block = Block(piece, first, self.method)
            for event, start in zip(self.bound_events, starts, strict=True):
                if isinstance(event, BoundEvent):
                    parts.append(self._of(event, block, reaching, start))
                else:
                    parts += self._of_pairs(event, block, reaching, start)
            if self.count + sum(len(rows.t) for rows in parts) > MOST_EVENTS:
                break
        rows = joined(parts)
        self.count += len(rows.t)
        self.rows.append(rows.at(np.lexsort((rows.index, reaching.sign * rows.t))))
        return self.rows[-1]

    def _of_pairs(
        self, bound_event: BoundPairs, block: Block, reaching: RunStates, starts: Array
    ) -> list[Rows]:
        """As ``_of``, for the pairs whose bounds on the steps do not exclude a root."""
        parts, n = [], len(block.begin)
        signs: Any = [(np.arange(len(starts)), np.zeros((len(starts), n)))]
        if block.bounded:
            bounds = bound_event.bounds(*block.bounds(False))
            signs = ((rows, sign_of(low, high)) for rows, low, high in bounds)
        for rows, sure in signs:
            same = (sure == sure[:, :1]).all(axis=1) & (sure[:, 0] * starts[rows] >= 0.0)
            out = same & (sure[:, 0] != 0.0)
            starts[rows[out]] = sure[out, 0]
            for k in np.flatnonzero(~out).tolist():
                part, row = int(rows[k]), slice(rows[k], rows[k] + 1)
                events = self._of(bound_event.of_pair(part), block, reaching, starts[row], sure[k])
                parts.append(events._replace(part=np.full(len(events.t), part)))
        return parts

    def _of(
        self,
        bound_event: BoundEvent,
        block: Block,
        reaching: RunStates,
        start: Array,
        sure: Array | None = None,
    ) -> Rows:
        """The rows of one event in a block. ``start`` (1,), its value at the block's begin or 0, is
        set to that at the block's end; ``sure`` as for `Block.series`."""
        series, steps, joint, lost = block.series(bound_event.function, float(start[0]), sure)
        start[0] = joint[-1]
        self.unresolved += lost
        row, x, rises, slope = roots(series, joint[steps], joint[steps + 1])
        order = np.lexsort((x, row))
        order = order[
            (rises[order] == bound_event.event.direction) | (bound_event.event.direction == 0)
        ]
        if not order.size:
            return self.none()
        row, x, rises, slope = steps[row[order]], x[order], rises[order], slope[order]
        parts = [
            _refined(
                bound_event.function,
                reaching,
                block,
                *(array[k : k + ROOTS_TOGETHER] for array in (row, x, slope)),
            )
            for k in range(0, len(row), ROOTS_TOGETHER)
        ]
        t, q, v = (np.concatenate(x) for x in zip(*parts, strict=True))
        first_length = block.piece.times[1] - block.piece.times[0]
        good = (t - block.piece.after) / first_length > START  # not at t0, or found before
        good &= (t - block.piece.until) / first_length <= START
        distinct = np.flatnonzero(np.append(True, t[1:] != t[:-1]))  # others cannot be told apart
        good[np.setdiff1d(np.arange(len(t)), distinct[np.add.reduceat(rises, distinct) != 0])] = (
            False
        )
        if bound_event.condition is not None:
            good &= bound_event.condition.of(q, v, t) > 0.0
        number, index = (
            block.piece.first + block.first + row + 1,
            np.full(len(t), bound_event.number),
        )
        value = bound_event.reported.of(q, v, t)
        return Rows(t, number, index, np.zeros_like(index), q, v, value).at(good)

    def keep(self, n: int) -> None:
        """Keep the first n events of the last piece alone."""
        self.count -= len(self.rows[-1].t) - n
        self.rows[-1] = self.rows[-1].at(slice(n))

    def noted(self, outcome: Outcome) -> Outcome:
        """The outcome of the run, with a note on what is not guaranteed."""
        return replace(outcome, notes=(*outcome.notes, *filter(None, [self.status])))

    def none(self) -> Rows:
        """No events."""
        empty, shapes = (
            np.zeros(0, dtype=np.int64),
            (self.problem.q0.shape, self.problem.v0.shape),
        )
        q, v = (np.zeros((0, *shape)) for shape in shapes)
        return Rows(np.zeros(0), empty, empty, empty, q, v, np.zeros(0))

    def collected(self) -> Found:
        self.rows = [joined(self.rows or [self.none()])]
        t, step, index, part, q, v, value = self.rows[0]
        which = zip(index.tolist(), part.tolist(), strict=True)
        names = tuple(self.bound_events[k].name_of(pair) for k, pair in which)
        return Found(
            read_only(t),
            names,
            step,
            read_only(value),
            index,
            read_only(q),
            read_only(v),
            self.unresolved,
            self.status,
        )

    @property
    def status(self) -> str:
        """A sentence on functions that were sampled, and on steps that were not resolved; or ""."""
        sampled = [
            f"{event.name} ({why})"
            for event in self.bound_events
            if isinstance(event, BoundEvent) and (why := event.function.refusal)
        ]
        text = (
            f"Events sampled at {4 * self.method.stages} points of each step or more, since "
            f"their functions could not be traced: {', '.join(sampled)}."
        ) * bool(sampled)
        if self.unresolved:
            text += (
                f" In {self.unresolved} steps an event was too rough for the points: some may be "
                f"missing. Use a smaller step."
            )
        return text.strip()


def _parts(event: BoundEvent | BoundPairs) -> int:
    return 1 if isinstance(event, BoundEvent) else len(event.pairs)


def _refined(
    function: Function, reaching: RunStates, block: Block, steps: Any, x: Array, slope: Array
) -> tuple[Array, Array, Array]:
    """Times (n,), q and v of roots, from those of the curves at x (n,) in [-1, 1] of steps, and the
    slopes by x there."""
    problem, n, lost = block.piece.run.problem, len(x), np.arange(len(x))
    states = np.full(n, np.nan), np.empty((n, *problem.q0.shape)), np.empty((n, *problem.v0.shape))
    for reach in (shortened_steps, partial(_each_reached, reaching)):
        some = steps[lost], x[lost]
        if lost.size and (shortened := reach(block, *some)) is not None:
            parts = _secants(function, shortened, block, *some, slope[lost])
            for array, part in zip(states, parts, strict=True):
                array[lost] = part
            lost = np.flatnonzero(~np.isfinite(states[0]))
    return states


def _each_reached(reaching: RunStates, block: Block, steps: Any, x: Array) -> Shortened:
    """As `shortened_steps`, at times within the run, from the last kept states."""
    run = reaching.run
    first, last = sorted((float(run.t[0]), reaching.last))
    begin, end = block.begin[steps], block.end[steps]
    low = np.maximum(np.minimum(begin, end), first)
    high = np.minimum(np.maximum(begin, end), last)
    stages = np.zeros((len(x), run.problem.v0.size, run.method.stages))

    def after(t: Array, rows: Any) -> tuple[Array, Array, Array]:
        guess = stages[rows]
        q, _, v = reaching(t, guess)
        stages[rows] = guess
        return q, v, t

    t = np.minimum(np.maximum(block.times(steps, x)[0], low), high)
    return Shortened(after, low, high, t, np.ones_like(x))


def _secants(
    function: Function, shortened: Shortened, block: Block, steps: Any, x: Array, slope: Array
) -> tuple[Array, Array, Array]:
    """As `_refined`, each root within its step; NaN where a state could not be reached."""
    problem, n = block.piece.run.problem, len(x)
    after, low, high, u, pace = shortened
    slope = slope * pace / block.times(steps, x)[1]
    root_times, size = np.full(n, np.nan), np.full(n, np.inf)
    q, v = np.empty((n, *problem.q0.shape)), np.empty((n, *problem.v0.shape))
    fine = ROOT_TIME_ERROR * np.abs(block.end - block.begin)[steps]
    u, active = u.copy(), np.arange(n)
    before, values = u.copy(), u.copy()
    for k in range(SECANTS):
        now, steep = u[active], slope[active]
        places, rates, t = after(now, active)
        good = np.isfinite(places.reshape(len(now), -1)).all(axis=1)
        if not good.all():
            root_times[active[~good]] = np.nan
            active, now, steep = active[good], now[good], steep[good]
            places, rates, t = places[good], rates[good], t[good]
            if not active.size:
                break
        value = function.of(places, rates, t)
        better = np.abs(value) < size[active]
        at = active[better]
        root_times[at], q[at], v[at] = t[better], places[better], rates[better]
        size[at] = np.abs(value[better])
        with np.errstate(all="ignore"):
            if k:
                moved = now - before[active]
                steep = np.where(moved == 0.0, steep, (value - values[active]) / moved)
            before[active], values[active], slope[active] = now, value, steep
            new = np.minimum(np.maximum(now - value / steep, low[active]), high[active])
        time_tolerance = np.maximum(ROOT_TIME_ERROR * np.abs(t), fine[active]) / np.abs(
            pace[active]
        )
        u[active] = new
        active = active[(value != 0.0) & (steep != 0.0) & (np.abs(new - now) > time_tolerance)]
        if not active.size:
            break
    return root_times, q, v
