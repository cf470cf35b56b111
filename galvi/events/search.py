"""Finds the events of a run on its curves, and refines them by shortened steps.

A function that could be traced is bounded on each step, by bounds of the coordinates' Chebyshev
series where these are polynomials: steps in which it cannot be 0 are left out. On the others it is
interpolated at Chebyshev points, at least four times as many as the method has stages, and more
until its last coefficients are small. Ends of steps are those of the steps themselves, to which a
linear term adjusts the interpolant: no root is lost or found twice where two curves meet. Roots of
the interpolant are isolated by bounds: an interval is without one where |f| at its middle exceeds
the bound of |f'| times its half, and has at most one where the same holds of |f'| and the bound of
|f''|; others are halved.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from galvi.arrays import Array, read_only
from galvi.events.asked import Asked
from galvi.events.block import CHUNK, Block
from galvi.events.event import Event, several_events
from galvi.events.pieces import Piece, pieces
from galvi.events.roots import roots
from galvi.input_checks import shown
from galvi.method import Galerkin
from galvi.problem import Problem
from galvi.run.states import Reaching
from galvi.trajectory import Trajectory

if TYPE_CHECKING:
    import pandas

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
    q, v       the state there, before an action
    unresolved number of steps in which a function was not resolved, so that roots may be missing
    status     a sentence on what is not guaranteed; "" for nothing
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
        """A tidy pandas frame: t, name, step, value and index."""
        import pandas

        columns = ("t", "name", "step", "value", "index")
        return pandas.DataFrame({name: getattr(self, name) for name in columns})

    def __repr__(self) -> str:
        return f"Found({len(self)} events)"


class Rows(NamedTuple):
    """n events in the order of their times: t, step, index (n,), q and v (n, ...), value (n,)."""

    t: Array
    step: Any
    index: Any
    q: Array
    v: Array
    value: Array

    def first(self, n: int) -> Rows:
        """The first n."""
        return Rows(*(array[:n] for array in self))


def find_events(run: Trajectory, events: Event | Any) -> Found:
    """The events of a run of `galvi.integrate`, on the curve of each of its steps.

    events  one, or several: `galvi.Event`, or those of `galvi.events`

    Every root of a function's interpolant on a step is found, also two within one step; a root at
    t0 is none. Times and states are those of the step's order: a root of the curve is refined by a
    shortened step from the last kept state. Steps after the last state that a failed run kept have
    no events. In a moving frame the curve is the frame's. ``terminal`` and ``action`` are for
    `galvi.integrate`: here nothing is ended or changed.

    Raises ValueError for a run of a reference, for one with actions that kept no curves, for a
    function that is not finite, and for more than a million events; TypeError for something that is
    no event.
    """
    several = several_events(events)
    if not isinstance(run, Trajectory) or run.step is None or run.checkpoint is None:
        raise ValueError(f"events are found on runs of galvi.integrate; received {shown(run)}.")
    search = Search(run.problem, run.method, several)
    for piece in pieces(run):
        search.on(piece)
        if search.count > MOST:
            raise ValueError(
                f"a run may have {MOST} events; received more, until t = {piece.times[-1]:.10g}."
            )
    return search.found()


class Search:
    """The events of one run, piece after piece."""

    def __init__(self, problem: Problem, method: Galerkin, events: tuple[Event, ...]) -> None:
        self.problem, self.method, self.events = problem, method, events
        self.asked = [Asked(event, problem, k) for k, event in enumerate(events)]
        self.rows: list[Rows] = []
        self.unresolved = 0

    @property
    def count(self) -> int:
        """How many were found."""
        return sum(len(rows.t) for rows in self.rows)

    def on(self, piece: Piece) -> Rows:
        """The events of a piece, which are kept."""
        found: list[tuple[Any, ...]] = []
        reaching, starts = Reaching(piece.run), [0.0] * len(self.asked)
        for first in range(0, len(piece.times) - 1, CHUNK):
            block = Block(piece, first, self.method)
            for asked in self.asked:
                found += self._of(asked, block, reaching, starts)
        sign = 1.0 if piece.times[-1] >= piece.times[0] else -1.0
        found.sort(key=lambda row: (sign * row[0], row[2]))
        rows = self._rows(found)
        self.rows.append(rows)
        return rows

    def _of(
        self, asked: Asked, block: Block, reaching: Reaching, starts: list[float]
    ) -> list[tuple[Any, ...]]:
        """Those of one event in a block; ``starts`` has its values at the block's begin, if any."""
        series, steps, joint, lost = block.series(asked, starts[asked.number])
        starts[asked.number] = float(joint[-1])
        self.unresolved += lost
        found: list[tuple[Any, ...]] = []
        close: set[float] = set()
        times, after = block.piece.times, block.piece.after
        whole = times[1] - times[0]
        for row, x, rises, slope in roots(series, joint[steps], joint[steps + 1]):
            if asked.event.direction and rises != asked.event.direction:
                continue
            begin, end = block.begin[steps[row]], block.end[steps[row]]
            half = 0.5 * (end - begin)
            t, q, v = _refined(asked, reaching, begin + (1.0 + x) * half, begin, end, slope / half)
            if (t - after) / whole <= START or t in close:  # at t0, or found in the step before
                continue
            if (t - block.piece.until) / whole > START:
                continue
            if asked.condition is not None:
                held = asked.of(asked.condition, q[None], v[None], np.array([t]))
                if not held[0] > 0.0:
                    continue
            number = block.piece.first + block.first + int(steps[row]) + 1
            found.append((t, number, asked.number, q, v))
            close = {t}
        return found

    def _rows(self, found: list[tuple[Any, ...]]) -> Rows:
        n, problem = len(found), self.problem
        t, step, index, q, v = zip(*found, strict=True) if found else ((), (), (), (), ())
        rows = Rows(
            np.array(t), np.array(step, dtype=np.int64), np.array(index, dtype=np.int64),
            np.array(q).reshape(n, *problem.q0.shape), np.array(v).reshape(n, *problem.v0.shape),
            np.full(n, np.nan),
        )  # fmt: skip
        for asked in self.asked:
            own = np.flatnonzero(rows.index == asked.number)
            if own.size:
                states = rows.q[own], rows.v[own], rows.t[own]
                rows.value[own] = asked.of(asked.reported, *states)
        return rows

    def found(self) -> Found:
        """All of them."""
        parts = self.rows or [self._rows([])]
        t, step, index, q, v, value = (np.concatenate(x) for x in zip(*parts, strict=True))
        names = tuple(self.events[k].name for k in index.tolist())
        return Found(
            read_only(t), names, step, read_only(value), index, read_only(q), read_only(v),
            self.unresolved, self.status,
        )  # fmt: skip

    @property
    def status(self) -> str:
        """A sentence on functions that were sampled; "" for none."""
        said = [f"{one.name} ({one.refusal})" for one in self.asked if one.refusal]
        text = ""
        if said:
            text = (
                f"Events sampled at {4 * self.method.stages} points of each step, since their "
                f"functions could not be traced: {', '.join(said)}."
            )
        if self.unresolved:
            text += (
                f" In {self.unresolved} steps an event was too rough for the points: some may be "
                f"missing. Use a smaller step."
            )
        return text.strip()


def _refined(
    asked: Asked, reaching: Reaching, t: float, begin: float, end: float, slope: float
) -> tuple[float, Array, Array]:
    """Time, q and v of a root by secants, from one of the curve and the slope there, within its
    step."""
    within = sorted((begin, end))
    run = sorted((float(reaching.run.t[0]), reaching.last))
    low, high = max(within[0], run[0]), min(within[1], run[1])
    known: list[tuple[float, float, Array, Array]] = []
    t = min(max(t, low), high)
    for _ in range(SECANTS):
        q, _, v = reaching(t)
        value = float(asked.many(q.reshape(-1, 1), v.reshape(-1, 1), np.array([t]))[0])
        known.append((t, value, q, v))
        if len(known) > 1 and known[-1][0] != known[-2][0]:
            slope = (known[-1][1] - known[-2][1]) / (known[-1][0] - known[-2][0])
        if value == 0.0 or slope == 0.0:
            break
        new = min(max(t - value / slope, low), high)
        if abs(new - t) <= FINE * max(abs(new), abs(end - begin)):
            break
        t = new
    best = min(known, key=lambda one: abs(one[1]))
    return best[0], best[2], best[3]
