"""Finds the events of a run on its curves, and refines them by shortened steps.

Steps on which bounds of the coordinates prove that a function of entries is not 0 are left out. On
the others it is interpolated at Chebyshev points, four times as many as the method has stages, and
more until its last coefficients are small. A linear term adjusts the interpolant to the function at
the saved states, so that no root is lost or found twice where two curves meet.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from galvi.arrays import Array, read_only
from galvi.events.block import STEPS_AT_ONCE, Block, Piece, pieces, sign_of
from galvi.events.bound_events import BoundEvent, BoundPairs, Function
from galvi.events.event import Distances, Event, as_events
from galvi.events.roots import roots
from galvi.events.shortened_steps import ShortenedSteps, shortened_steps
from galvi.input_checks import shown
from galvi.method import Galerkin
from galvi.outcome import Outcome
from galvi.problem import Problem
from galvi.run.states import RunStates
from galvi.trajectory import Trajectory

if TYPE_CHECKING:
    import pandas

MAX_EVENTS = 1_000_000  # largest number of events of a run
SECANTS = 6  # largest number of secant steps that refine a root
ROOTS_TOGETHER = 1024  # roots that are refined at once
START_FRACTION = 1e-9  # of the first step: a root that is not later is one at t0
ROOT_TIME_ERROR = 4.0 * 2.0**-52  # share of the time, or of the step, to which a root is refined


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
        reported values, such as distances
    index
        indices of the events in the given list of events
    q, v
        configurations and velocities, before an action
    unresolved
        number of interpolants on a step that were not resolved, so that roots may be missing
    status
        sentences on sampled functions and unresolved steps; "" without these

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
    """n events: t, step, index and part (n,), which is the index of the pair in an event of many
    pairs and else 0; q and v (n, ...), value (n,)."""

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


def join_rows(parts: list[Rows]) -> Rows:
    """The rows of several tables as one."""
    return Rows(*(np.concatenate(arrays) for arrays in zip(*parts, strict=True)))


def find_events(run: Trajectory, events: Event | Any) -> Found:
    """The events of a run of `galvi.integrate`, on the curve of each of its steps.

    Parameters
    ----------
    run : galvi.Trajectory
        a run of `galvi.integrate`
    events
        one `galvi.Event` or several, such as those of `galvi.events`

    Returns
    -------
    galvi.Found
        The events in the order of their times.

    Raises
    ------
    ValueError
        For a run of a reference, for one with actions that kept no curves, for a function that is
        not finite, and for more than a million events.
    TypeError
        For values in ``events`` that are no `galvi.Event`.

    Notes
    -----
    Every root at which a function's interpolant on a step changes its sign is found, also two
    within one step; a root at t0 does not count. Times and states have the order of the steps: a
    root on the curve is refined by shortened steps from the last saved state. Steps after the last
    finite state of a failed run have no events. In a moving frame the curve is the frame's.
    ``terminal`` and ``action`` have no effect here; they are for `galvi.integrate`.

    Examples
    --------
    >>> method = galvi.Galerkin(galvi.Polynomials(6), galvi.gauss(6))
    >>> run = galvi.integrate(galvi.problems.harmonic_oscillator(), method, step=0.5, steps=20)
    >>> found = galvi.find_events(run, galvi.Event(lambda q, v, t: q[0], direction=1))
    >>> (found.t / 3.141592653589793).round(9)
    array([1.5])
    """
    event_tuple = as_events(events)
    if not isinstance(run, Trajectory) or run.step is None or run.checkpoint is None:
        raise ValueError(f"events are found on runs of galvi.integrate; received {shown(run)}.")
    search = Search(run.problem, run.method, event_tuple)
    last_searched = search.search_pieces(pieces(run))
    if last_searched is not None:
        raise ValueError(
            f"a run may have at most {MAX_EVENTS} events; received more, up to "
            f"t = {last_searched:.10g}. Search a shorter run, or for fewer events."
        )
    return search.to_found()


class Search:
    """The search for the events of one run, piece after piece.

    Attributes
    ----------
    rows
        events of the pieces that were searched
    count
        their number
    unresolved
        see `Found`
    """

    def __init__(self, problem: Problem, method: Galerkin, events: tuple[Event, ...]) -> None:
        self.problem, self.method, self.events = problem, method, events
        self.bound_events = [
            (BoundPairs if isinstance(event.function, Distances) else BoundEvent)(event, problem, k)
            for k, event in enumerate(events)
        ]
        self.rows: list[Rows] = []
        self.unresolved = self.count = 0

    def search_pieces(self, run: Iterable[Piece]) -> float | None:
        """Search all pieces; returns None, or the end of the piece after which the search stopped
        since there are more than MAX_EVENTS events."""
        for piece in run:
            self.search_piece(piece)
            if self.count > MAX_EVENTS:
                return float(piece.times[-1])
        return None

    def search_piece(self, piece: Piece) -> Rows:
        """Search a piece, and add its events to ``rows``; returns them."""
        run_states, starts = (
            RunStates(piece.run),
            [np.zeros(_parts(event)) for event in self.bound_events],
        )
        parts = [self.no_rows()]
        for first in range(0, len(piece.times) - 1, STEPS_AT_ONCE):
            block = Block(piece, first, self.method)
            for event, start in zip(self.bound_events, starts, strict=True):
                if isinstance(event, BoundEvent):
                    parts.append(self._search_block(event, block, run_states, start))
                else:
                    parts += self._search_pairs(event, block, run_states, start)
            if self.count + sum(len(rows.t) for rows in parts) > MAX_EVENTS:
                break
        rows = join_rows(parts)
        self.count += len(rows.t)
        self.rows.append(rows.at(np.lexsort((rows.index, run_states.sign * rows.t))))
        return self.rows[-1]

    def _search_pairs(
        self, bound_event: BoundPairs, block: Block, run_states: RunStates, starts: Array
    ) -> list[Rows]:
        """As ``_search_block``, for each pair whose bounds on the steps do not exclude a root."""
        parts, n = [], len(block.begin)
        signs: Any = [(np.arange(len(starts)), np.zeros((len(starts), n)))]
        if block.has_bounds:
            bounds = bound_event.bounds(*block.bounds(False))
            signs = ((rows, sign_of(low, high)) for rows, low, high in bounds)
        for rows, sure in signs:
            keeps_sign = (sure == sure[:, :1]).all(axis=1) & (sure[:, 0] * starts[rows] >= 0.0)
            has_no_root = keeps_sign & (sure[:, 0] != 0.0)
            starts[rows[has_no_root]] = sure[has_no_root, 0]
            for k in np.flatnonzero(~has_no_root).tolist():
                part, row = int(rows[k]), slice(rows[k], rows[k] + 1)
                events = self._search_block(
                    bound_event.of_pair(part), block, run_states, starts[row], sure[k]
                )
                parts.append(events._replace(part=np.full(len(events.t), part)))
        return parts

    def _search_block(
        self,
        bound_event: BoundEvent,
        block: Block,
        run_states: RunStates,
        start: Array,
        sure: Array | None = None,
    ) -> Rows:
        """The rows of one event in a block. ``start`` (1,), the value or sign at the start of the
        block, or 0, is changed in place to that at its end; ``sure`` as for `Block.series`."""
        series, steps, joint, unresolved = block.series(bound_event.function, float(start[0]), sure)
        start[0] = joint[-1]
        self.unresolved += unresolved
        row, x, rises, slope = roots(series, joint[steps], joint[steps + 1])
        order = np.lexsort((x, row))
        order = order[
            (rises[order] == bound_event.event.direction) | (bound_event.event.direction == 0)
        ]
        if not order.size:
            return self.no_rows()
        row, x, rises, slope = steps[row[order]], x[order], rises[order], slope[order]
        parts = [
            _refine(
                bound_event.function,
                run_states,
                block,
                *(array[k : k + ROOTS_TOGETHER] for array in (row, x, slope)),
            )
            for k in range(0, len(row), ROOTS_TOGETHER)
        ]
        t, q, v = (np.concatenate(x) for x in zip(*parts, strict=True))
        first_length = block.piece.times[1] - block.piece.times[0]
        is_event = (
            t - block.piece.after
        ) / first_length > START_FRACTION  # not at t0, or found before
        is_event &= (t - block.piece.until) / first_length <= START_FRACTION
        distinct = np.flatnonzero(np.append(True, t[1:] != t[:-1]))  # others cannot be told apart
        is_event[
            np.setdiff1d(np.arange(len(t)), distinct[np.add.reduceat(rises, distinct) != 0])
        ] = False
        if bound_event.condition is not None:
            is_event &= bound_event.condition.of(q, v, t) > 0.0
        number, index = (
            block.piece.first + block.first + row + 1,
            np.full(len(t), bound_event.number),
        )
        value = bound_event.reported.of(q, v, t)
        return Rows(t, number, index, np.zeros_like(index), q, v, value).at(is_event)

    def keep_first(self, n: int) -> None:
        """Drop the events of the last piece after its first n."""
        self.count -= len(self.rows[-1].t) - n
        self.rows[-1] = self.rows[-1].at(slice(n))

    def with_status(self, outcome: Outcome) -> Outcome:
        """The outcome with the search's status as a note."""
        return replace(outcome, notes=(*outcome.notes, *filter(None, [self.status])))

    def no_rows(self) -> Rows:
        """Rows of no events."""
        empty, shapes = (
            np.zeros(0, dtype=np.int64),
            (self.problem.q0.shape, self.problem.v0.shape),
        )
        q, v = (np.zeros((0, *shape)) for shape in shapes)
        return Rows(np.zeros(0), empty, empty, empty, q, v, np.zeros(0))

    def to_found(self) -> Found:
        self.rows = [join_rows(self.rows or [self.no_rows()])]
        t, step, index, part, q, v, value = self.rows[0]
        event_and_pair = zip(index.tolist(), part.tolist(), strict=True)
        names = tuple(self.bound_events[k].name_of(pair) for k, pair in event_and_pair)
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
        """Sentences on functions that were sampled and on steps that were not resolved; "" without
        these."""
        sampled_events = [
            f"{event.name} ({why})"
            for event in self.bound_events
            if isinstance(event, BoundEvent) and (why := event.function.refusal)
        ]
        text = (
            f"Events sampled at {4 * self.method.stages} points of each step or more, since "
            f"their functions could not be traced: {', '.join(sampled_events)}."
        ) * bool(sampled_events)
        if self.unresolved:
            text += (
                f" In {self.unresolved} steps an event was too rough for the points: some may be "
                f"missing. Use a smaller step."
            )
        return text.strip()


def _parts(event: BoundEvent | BoundPairs) -> int:
    return 1 if isinstance(event, BoundEvent) else len(event.pairs)


def _refine(
    function: Function, run_states: RunStates, block: Block, steps: Any, x: Array, slope: Array
) -> tuple[Array, Array, Array]:
    """Times (n,), q and v of roots, refined from the roots x (n,) in [-1, 1] on the curves of
    steps; ``slope`` (n,) is the derivative by x there."""
    problem, n, remaining = block.piece.run.problem, len(x), np.arange(len(x))
    states = np.full(n, np.nan), np.empty((n, *problem.q0.shape)), np.empty((n, *problem.v0.shape))
    for reach in (shortened_steps, partial(_steps_within_run, run_states)):
        remaining_roots = steps[remaining], x[remaining]
        if remaining.size and (shortened := reach(block, *remaining_roots)) is not None:
            parts = _refine_by_secants(
                function, shortened, block, *remaining_roots, slope[remaining]
            )
            for array, part in zip(states, parts, strict=True):
                array[remaining] = part
            remaining = np.flatnonzero(~np.isfinite(states[0]))
    return states


def _steps_within_run(run_states: RunStates, block: Block, steps: Any, x: Array) -> ShortenedSteps:
    """As `shortened_steps`, at times within the run, from the last saved states, one by one."""
    run = run_states.run
    first, last = sorted((float(run.t[0]), run_states.last))
    begin, end = block.begin[steps], block.end[steps]
    low = np.maximum(np.minimum(begin, end), first)
    high = np.minimum(np.maximum(begin, end), last)
    stages = np.zeros((len(x), run.problem.v0.size, run.method.stages))

    def after(t: Array, rows: Any) -> tuple[Array, Array, Array]:
        guess = stages[rows]
        q, _, v = run_states(t, guess)
        stages[rows] = guess
        return q, v, t

    t = np.minimum(np.maximum(block.times(steps, x)[0], low), high)
    return ShortenedSteps(after, low, high, t, np.ones_like(x))


def _refine_by_secants(
    function: Function, shortened: ShortenedSteps, block: Block, steps: Any, x: Array, slope: Array
) -> tuple[Array, Array, Array]:
    """As `_refine`, by secant steps within the limits of u; times are NaN where a state could not
    be reached."""
    problem, n = block.piece.run.problem, len(x)
    after, low, high, u, pace = shortened
    slope = slope * pace / block.times(steps, x)[1]
    root_times, size = np.full(n, np.nan), np.full(n, np.inf)
    q, v = np.empty((n, *problem.q0.shape)), np.empty((n, *problem.v0.shape))
    least_tolerance = ROOT_TIME_ERROR * np.abs(block.end - block.begin)[steps]
    u, active = u.copy(), np.arange(n)
    u_before, values_before = u.copy(), u.copy()
    for k in range(SECANTS):
        u_now, slope_now = u[active], slope[active]
        positions, velocities, t = after(u_now, active)
        is_finite = np.isfinite(positions.reshape(len(u_now), -1)).all(axis=1)
        if not is_finite.all():
            root_times[active[~is_finite]] = np.nan
            active, u_now, slope_now = active[is_finite], u_now[is_finite], slope_now[is_finite]
            positions, velocities, t = positions[is_finite], velocities[is_finite], t[is_finite]
            if not active.size:
                break
        value = function.of(positions, velocities, t)
        is_better = np.abs(value) < size[active]
        improved = active[is_better]
        root_times[improved], q[improved], v[improved] = (
            t[is_better],
            positions[is_better],
            velocities[is_better],
        )
        size[improved] = np.abs(value[is_better])
        with np.errstate(all="ignore"):
            if k:
                u_change = u_now - u_before[active]
                slope_now = np.where(
                    u_change == 0.0, slope_now, (value - values_before[active]) / u_change
                )
            u_before[active], values_before[active], slope[active] = u_now, value, slope_now
            u_new = np.minimum(np.maximum(u_now - value / slope_now, low[active]), high[active])
        time_tolerance = np.maximum(ROOT_TIME_ERROR * np.abs(t), least_tolerance[active]) / np.abs(
            pace[active]
        )
        u[active] = u_new
        active = active[
            (value != 0.0) & (slope_now != 0.0) & (np.abs(u_new - u_now) > time_tolerance)
        ]
        if not active.size:
            break
    return root_times, q, v
