"""How a problem moves in a clock: `Motion`, and `ClockSteps`, the steps done."""

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
        (n, r), (n, d) after each step
    v : array, shape (n, d)
        velocities dq/dt, where momenta do not determine them; else None
    t : array, shape (n, 2)
        time and its low part after each step
    coefficients : array, shape (n, d, m)
        of the Galerkin curves in tau; (0, d, m) if they are not kept
    rates : array, shape (n, s)
        g at the stages
    counts : array, shape (4,)
        of all steps, as in galvi.run.run_arrays.COUNTED
    number : array, shape (n,)
        of steps since the problem's start; a shortened step counts as its share
    energy : array, shape (n,)
        that of the start plus the work of forces since then, as the clock integrates it; None
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
        """Some of the steps, without their curves."""
        v, energy = (None if x is None else x[rows] for x in (self.v, self.energy))
        arrays = {name: getattr(self, name)[rows] for name in ("q", "p", "t", "rates", "number")}
        no_coefficients = self.coefficients[:0]
        return ClockSteps(
            **arrays, v=v, energy=energy, coefficients=no_coefficients, counts=NO_COUNTS
        )


def join_steps(parts: Sequence[ClockSteps]) -> ClockSteps:
    """Steps one after another."""
    arrays: Any = [None if x[0] is None else x for x in zip(*parts, strict=True)]
    steps = ClockSteps(*(x and np.concatenate(x) for x in arrays))
    return steps._replace(counts=np.sum([part.counts for part in parts], axis=0))


class Advanced(NamedTuple):
    """Up to n steps from a state, the state after them, and a code of galvi.kernels.nystrom.solve.

    Fewer steps with the code SOLVED: the next one would pass the requested time. ``reason`` says
    why a step failed.
    """

    steps: ClockSteps
    after: Checkpoint
    code: int
    reason: str = ""


# (state, h, n, time, keep) -> up to n steps of length h, none beyond ``time`` unless it is None,
# with their curves if ``keep``. Bit-identical in any portions; the state is not changed.
Advance = Callable[[Checkpoint, float, int, float | None, bool], Advanced]


@dataclass(frozen=True)
class Motion:
    """How a problem moves in a clock.

    Attributes
    ----------
    advance
        does steps
    at
        (q, v, t) -> a state with the energy of the problem's start
    rate
        g of a flat configuration
    chart
        of the Galerkin curves
    reason
        for `galvi.Trajectory.engine_reason`
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
