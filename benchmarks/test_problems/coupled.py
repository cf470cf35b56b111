"""A problem on a group whose parts are coupled, with its motion by independent equations."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from benchmarks.test_problems.newton_euler import NewtonEuler
from galvi import Problem
from galvi.arrays import Array


@dataclass(frozen=True, eq=False)
class Coupled:
    """A problem, and the same motion by Newton's and Euler's equations.

    setup   problem and start in one line
    motion  (q, mu) -> that motion from q and the left-trivialised momentum mu
    state   (attitudes, momenta, rest) of the motion -> (q, mu)
    """

    problem: Callable[[], Problem]
    setup: str
    motion: Callable[[Array, Array], NewtonEuler]
    state: Callable[[Array, Array, Array], tuple[Array, Array]]

    def flow(self, q: Array, mu: Array, duration: float) -> tuple[Array, Array]:
        """(q, mu) after `duration`, by extrapolation."""
        return self.state(*self.motion(q, mu).by_extrapolation(duration))

    def end(self, duration: float) -> Array:
        """q at `duration` from the problem's start, by extrapolation."""
        start = self.problem()
        return self.flow(start.q0, start.p0, duration)[0]

    def end_again(self, duration: float) -> Array:
        """The same by DOP853 on quaternions."""
        start = self.problem()
        return self.state(*self.motion(start.q0, start.p0).by_quaternions(duration))[0]
