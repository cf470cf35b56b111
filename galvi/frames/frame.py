"""Interface of frames: an integrable flow as chart."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from galvi.arrays import Array
from galvi.problem import Problem

EVEN = (0.0, -1.0, 0.0)  # the clock of nodes that are not moved


@dataclass(frozen=True, eq=False)
class Motion:
    """The arguments of galvi.lanes.frames.collocation for a frame on a problem and one step size.

    Attributes
    ----------
    functions : array, shape (3,)
        addresses of RATES, DRIFT and LEAVE (galvi.lanes.frames.collocation)
    alive
        the functions that must outlive these addresses
    numbers : array, shape (c,)
        their constants
    work
        rows of scratch that they need
    guesses
        rows that they keep between passes; a pass at other nodes can interpolate them
    sizes : array, shape (2 n,)
        of the places and velocities in the frame, to which changes are relative
    clock
        (3,) revolutions a step of a reference orbit, its eccentricity and its mean anomaly at the
        start over 2 pi; `EVEN` for Gauss nodes
    stretch
        alpha of arcsin(alpha y) / arcsin(alpha), to which nodes y in [-1, 1] are moved
    """

    functions: Any
    alive: Any
    numbers: Array
    work: int
    guesses: int
    sizes: Array
    clock: tuple[float, float, float] = EVEN
    stretch: float = 0.0


class Frame(Hashable, Protocol):
    """A system H = A + B(q) seen in coordinates that move with the flow phi of A.

    The state is w = (x, x'), in coordinates that the frame chooses, with z = phi_t(w).
    """

    @property
    def name(self) -> str:
        """For titles and tables, e.g. 'harmonic frame'."""

    @property
    def passes(self) -> int | None:
        """Passes of the iteration of a step; None: as many as the tolerance needs at the start."""

    @property
    def reversible(self) -> bool:
        """Whether nodes are the same from every start, so that steps back cancel those forwards."""

    @property
    def conserved(self) -> str:
        """Exactly conserved quantities, for messages."""

    def refusal(self, problem: Problem) -> str:
        """Why it does not apply to a problem, one sentence; "" where it does."""

    def leaves(self, problem: Problem, step: float) -> str:
        """Why its flow does not cover a step from the problem's start, or ""."""

    def rows(self, problem: Problem) -> int:
        """n, the coordinates in the frame that collocation moves."""

    def enter(self, problem: Problem, q: Array, v: Array) -> Array:
        """A state (8, m): q, its low part, v, its low part, then x, its low part, x' and its."""

    def motion(self, problem: Problem, step: float, c: Array) -> Motion:
        """The frame for steps of this size and nodes c (P,)."""

    def flow(self, problem: Problem, w: Array, t: Array) -> Array:
        """q (k, *shape) at times t (k,) after w (k, 2, m), also for complex w and t: analytic.

        w (k, 4, m) has its low parts in the last two rows.
        """

    def derivatives(self, problem: Problem, w: Array, t: float) -> tuple[Array, Array]:
        """D phi_t(w), and the derivative by w of the collocated rate w' at the time t, at w (2, m).

        Both (2 d, 2 d), of (x, x') with the d entries that a state has in the frame.
        """


def matrix_of(frame: Frame, problem: Problem) -> Array:
    """The matrix (d, d) from places, or velocities, to those in the frame."""
    unit, zero = np.eye(problem.q0.size), np.zeros_like(problem.q0)
    states = (frame.enter(problem, x.reshape(problem.q0.shape), zero) for x in unit)
    columns = [state[4] + state[5] for state in states]
    return np.array(columns).T[: problem.q0.size]


def revolution(M: Array, e: float) -> tuple[Array, Array]:
    """u and u - e sin u at mean anomalies, as galvi.lanes.frames.rows.place_nodes."""
    u = M + e * np.sin(M) * (1.0 + e * np.cos(M))
    return u, u - e * np.sin(u)
