"""What the runs in a clock are made of: how steps are done, what they gave, and what the status
says of pairs of point masses."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from galvi.arrays import Array, read_only
from galvi.checkpoint import Checkpoint
from galvi.clocks.clock import Rate
from galvi.curves.curves import LocalChart
from galvi.problem import Problem

NO_COUNTS = read_only(np.zeros(4))


class Taken(NamedTuple):
    """n steps in a clock.

    q, p          (n, r), (n, d) after each step
    v             (n, d) velocities dq/dt, where momenta do not determine them; else None
    t             (n, 2) time and its low part after each step
    coefficients  (n, d, m) of the Galerkin curves in tau; (0, d, m) if they are not kept
    rates         (n, s) g at the stages
    counts        (4,) passes and others, as in galvi.run.run_arrays.COUNTED, of all steps
    energy        (n,) that of the start and the work of forces since then, as the clock integrates
                  it; None where it is that of the start
    """

    q: Array
    p: Array
    v: Array | None
    t: Array
    coefficients: Array
    rates: Array
    counts: Array
    energy: Array | None = None

    def rows(self, rows: Any) -> Taken:
        """Some of the steps, without their curves."""
        v, energy = (None if x is None else x[rows] for x in (self.v, self.energy))
        none = self.coefficients[:0]
        return Taken(
            self.q[rows], self.p[rows], v, self.t[rows], none, self.rates[rows], NO_COUNTS, energy
        )


def joined(parts: Sequence[Taken]) -> Taken:
    """Steps one after another."""
    arrays: Any = [None if x[0] is None else x for x in zip(*parts, strict=True)]
    q, p, v, t, coefficients, rates, _, energy = (x and np.concatenate(x) for x in arrays)
    counts = np.sum([part.counts for part in parts], axis=0)
    return Taken(q, p, v, t, coefficients, rates, counts, energy)


class Advanced(NamedTuple):
    """Up to n steps from a state: they, the state after them, and a code of kernels.nystrom.solve.

    With fewer steps and code SOLVED the next step would pass the time asked for. ``reason`` says
    why a step failed.
    """

    taken: Taken
    after: Checkpoint
    code: int
    reason: str = ""


# (state, h, n, time, keep) -> up to n steps of length h, none beyond a time unless that is None;
# ``keep`` their curves. The same bits in any portions; the state is not changed.
Advance = Callable[[Checkpoint, float, int, float | None, bool], Advanced]


@dataclass(frozen=True)
class Motion:
    """How a problem moves in a clock.

    advance  does steps
    at       (q, v, t) -> a state that moves with the energy of the problem's start
    rate     g of a flat configuration
    chart    of the Galerkin curves
    reason   why it is done so, for `galvi.Trajectory.engine_reason`
    remark   for the status of a run; "" for none
    each     (states, lengths (k,)) -> one step of its own length from each of k states: q, v
             (k, d), times and codes (k,); None: by ``advance``, one after another
    """

    advance: Advance
    at: Callable[[Array, Array, float], Checkpoint]
    rate: Rate
    chart: LocalChart
    reason: str
    remark: str = ""
    each: Callable[[list[Checkpoint], Array], tuple[Array, Array, Array, Any]] | None = None


COSTLY = 10.0  # times as many steps because of one pair, from which on it is named
PACED, SPARSELY = 32, 8  # states, of up to 1024, at which the pair is looked for: every 8th


def paces(problem: Problem, q: Array) -> tuple[Array, Array, Array]:
    """The pairs i, j of bodies, and G (m_i + m_j) / r^3 of them, (pairs, n), at flat q (n, r)."""
    system: Any = problem.system
    i, j, mass = _pairs(system)
    places = np.ascontiguousarray(q.reshape(-1, *problem.q0.shape).T)  # (dimension, bodies, n)
    gaps = places[:, i] - places[:, j]
    square = (gaps * gaps).sum(axis=0)
    with np.errstate(all="ignore"):
        return i, j, mass / (square * np.sqrt(square))


@lru_cache(maxsize=32)
def _pairs(system: Any) -> tuple[Any, Any, Array]:
    """The pairs i, j of bodies that attract, and G (m_i + m_j), (pairs, 1)."""
    i, j = np.triu_indices(system.masses.size, 1)
    mass = system.G * (system.masses[i] + system.masses[j])
    return i[mass > 0.0], j[mass > 0.0], read_only(mass[mass > 0.0, None])


def closest_pair(problem: Problem, q: Array) -> tuple[Any, Any]:
    """The names of the bodies that set the clock at q."""
    i, j, pace = paces(problem, q)
    pair, names = int(np.argmax(pace[:, 0])), problem.body_names()
    return names[i[pair]], names[j[pair]]


def costly_pair(problem: Problem, q: Array) -> str:
    """A sentence on the one pair because of which steps are ``COSTLY`` times as many, or none."""
    i, j, pace = paces(problem, q[:: max(SPARSELY, -(-len(q) // PACED))])
    if len(pace) < 2:
        return ""
    pair = int(np.bincount(np.argmax(pace, axis=0)).argmax())
    with np.errstate(all="ignore"):
        others = pace[:pair].sum(axis=0) + pace[pair + 1 :].sum(axis=0)
        shares = np.sort(others / (others + pace[pair]))
        times = 1.0 / np.sqrt(shares[len(shares) // 2])
    if not times > COSTLY:
        return ""
    names = problem.body_names()
    about = float(f"{times:.1g}")
    return (
        f"Bodies {names[i[pair]]} and {names[j[pair]]} set the steps of all: about {about:g} times "
        f"as many as the others need."
    )
