"""The interface of moving frames: an integrable flow as a chart."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from galvi.arrays import Array
from galvi.problem import Problem

GAUSS_CLOCK = (0.0, -1.0, 0.0)  # `Motion.clock` for Gauss nodes in time


@dataclass(frozen=True, eq=False)
class Motion:
    """The arguments of galvi.lanes.frames.collocation for a frame on a problem and one step size.

    Attributes
    ----------
    functions : array, shape (3,)
        addresses of RATES, DRIFT and LEAVE (galvi.lanes.frames.collocation)
    alive
        the functions, which must exist as long as these addresses are used
    numbers : array, shape (c,)
        their constants
    work
        number of rows of scratch that they need
    guesses
        number of rows that they keep between passes; a pass at other nodes can interpolate them
    sizes : array, shape (2 n,)
        sizes of the positions and velocities in the frame, to which changes are relative
    clock
        (3,) revolutions of a reference orbit in a step, its eccentricity, and its mean anomaly at
        the start over 2 pi; `GAUSS_CLOCK` for Gauss nodes in time
    stretch
        alpha of arcsin(alpha y) / arcsin(alpha), the stretched position of a node y in [-1, 1]
    """

    functions: Any
    alive: Any
    numbers: Array
    work: int
    guesses: int
    sizes: Array
    clock: tuple[float, float, float] = GAUSS_CLOCK
    stretch: float = 0.0


class Frame(Hashable, Protocol):
    """A system H = A + B(q) seen in coordinates that move with the flow phi of A.

    The state is w = (x, x'), in coordinates that the frame chooses, with z = phi_t(w).
    """

    @property
    def name(self) -> str:
        """The name for titles and tables, e.g. 'harmonic frame'."""

    @property
    def passes(self) -> int | None:
        """The number of passes of a step; None: as many as the tolerance needs at the start."""

    @property
    def reversible(self) -> bool:
        """Whether nodes do not depend on the start, so that steps back cancel steps forwards."""

    @property
    def conserved(self) -> str:
        """A clause on exactly conserved quantities."""

    def refusal(self, problem: Problem) -> str:
        """Sentences on why the frame does not apply to a problem; "" where it does."""

    def leaves(self, problem: Problem, step: float) -> str:
        """Sentences on why the flow does not cover a step from the problem's start; "" where it
        does."""

    def rows(self, problem: Problem) -> int:
        """n, the number of coordinates in the frame that collocation changes."""

    def enter(self, problem: Problem, q: Array, v: Array) -> Array:
        """The state (8, m) of q and v: rows q, v, x and x', each followed by its low part."""

    def motion(self, problem: Problem, step: float, c: Array) -> Motion:
        """The arguments of the kernel for steps of this size and nodes c (P,)."""

    def flow(self, problem: Problem, w: Array, t: Array) -> Array:
        """q (k, *shape) at times t (k,) after w (k, 2, m), also for complex w and t: analytic.

        w (k, 4, m) has its low parts in the last two rows.
        """

    def derivatives(self, problem: Problem, w: Array, t: float) -> tuple[Array, Array]:
        """D phi_t(w), and the derivative with respect to w of the collocated rate w' at the time t.

        Both are (2 d, 2 d), at w (2, m), for (x, x') with the d entries of a state in the frame.
        """


def matrix_of(frame: Frame, problem: Problem) -> Array:
    """The matrix (d, d) from positions, or velocities, to those in the frame."""
    unit, zero = np.eye(problem.q0.size), np.zeros_like(problem.q0)
    states = (frame.enter(problem, x.reshape(problem.q0.shape), zero) for x in unit)
    columns = [state[4] + state[5] for state in states]
    return np.array(columns).T[: problem.q0.size]


def revolution(M: Array, e: float) -> tuple[Array, Array]:
    """Approximate eccentric anomalies u of mean anomalies M, and u - e sin u; the same formula as
    in galvi.lanes.frames.rows.place_nodes."""
    u = M + e * np.sin(M) * (1.0 + e * np.cos(M))
    return u, u - e * np.sin(u)
