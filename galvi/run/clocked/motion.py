"""`Motion`, the steps of a problem in a clock, and `ClockSteps`, the records of such steps."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from galvi.arrays import Array, read_only
from galvi.checkpoint import Checkpoint
from galvi.clocks.clock import Rate
from galvi.curves.curves import LocalChart

NO_COUNTS = read_only(np.zeros(4))


class ClockSteps(NamedTuple):
    """n steps in a clock.

    Attributes
    ----------
    q, p
        configurations (n, r) and momenta (n, d) after each step
    v : array, shape (n, d)
        velocities dq/dt, where momenta do not determine them; else None
    t : array, shape (n, 2)
        time and its low part after each step
    coefficients : array, shape (n, d, m)
        coefficients of the Galerkin curves in tau; (0, d, m) if these are not kept
    rates : array, shape (n, s)
        g at the stages
    counts : array, shape (4,)
        counts of all steps together, see galvi.run.run_arrays.COUNT_NAMES
    number : array, shape (n,)
        numbers of completed steps since the problem's start; a shortened step adds a fraction
    energy : array, shape (n,)
        the energy at the start plus the work of forces since then, as the clock integrates it; None
        where it is constant
    """

    q: Array
    p: Array
    v: Array | None
    t: Array
    coefficients: Array
    rates: Array
    counts: Array
    number: Array
    energy: Array | None = None

    def rows(self, rows: Any) -> ClockSteps:
        """The steps at these rows, without curves and counts."""
        v, energy = (None if x is None else x[rows] for x in (self.v, self.energy))
        arrays = {name: getattr(self, name)[rows] for name in ("q", "p", "t", "rates", "number")}
        no_coefficients = self.coefficients[:0]
        return ClockSteps(
            **arrays, v=v, energy=energy, coefficients=no_coefficients, counts=NO_COUNTS
        )


def join_steps(parts: Sequence[ClockSteps]) -> ClockSteps:
    """The steps of several records as one."""
    arrays: Any = [None if x[0] is None else x for x in zip(*parts, strict=True)]
    steps = ClockSteps(*(x and np.concatenate(x) for x in arrays))
    return steps._replace(counts=np.sum([part.counts for part in parts], axis=0))


class Advanced(NamedTuple):
    """The steps of a call of `Advance`, the state after them, and a code of
    galvi.kernels.nystrom.solve.

    Fewer steps than requested with the code SOLVED mean that the next one would pass the requested
    time. ``reason`` says why a step failed.
    """

    steps: ClockSteps
    after: Checkpoint
    code: int
    reason: str = ""


# (state, h, n, time, keep) -> up to n steps of length h in tau, none beyond ``time`` unless it is
# None, with their curves if ``keep``. Steps are bit-identical however many a call does; the given
# state is not changed.
Advance = Callable[[Checkpoint, float, int, float | None, bool], Advanced]


@dataclass(frozen=True)
class Motion:
    """The steps of a problem in a clock.

    Attributes
    ----------
    advance
        see `Advance`
    at
        (q, v, t) -> a state; its energy is that of the problem's start, or its own where forces do
        work or depend on the time
    rate
        g of a flat configuration
    chart
        chart of the Galerkin curves
    reason
        text for `galvi.Trajectory.engine_reason`
    single_steps
        (states, lengths (k,)) -> one step of its own length from each of k states: q, v (k, d),
        times and codes (k,); None: by ``advance``, one after another
    """

    advance: Advance
    at: Callable[[Array, Array, float], Checkpoint]
    rate: Rate
    chart: LocalChart
    reason: str
    single_steps: Callable[[list[Checkpoint], Array], tuple[Array, Array, Array, Any]] | None = None
