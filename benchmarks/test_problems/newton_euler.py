"""Newton's and Euler's equations of several bodies, solved twice over, without galvi.

With w = J^-1 p for each body:  p' = p x w + torque,  R' = R hat(w),  and rest' as given.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from benchmarks.test_problems.extrapolation import extrapolated
from galvi.arrays import Array
from references.rigid_equations import quaternion_slope, rotation
from references.scipy.ivp import TIGHT, solve

Pull = Callable[[Array, Array], tuple[Array, Array]]
State = tuple[Array, Array, Array]
NEXT, LAST = np.array([1, 2, 0]), np.array([2, 0, 1])
SPAN = 0.1  # of an extrapolated step; 4e-14 of round-off where there is no extended precision


@dataclass(frozen=True, eq=False)
class NewtonEuler:
    """A motion of b bodies from a state.

    inertias   (b, 3, 3); attitudes (b, 3, 3); momenta (b, 3), in the bodies' frames
    rest       (k,) what else moves
    pull       (attitudes, rest) -> torques (b, 3) in the bodies' frames, rest'

    Both solvers return (attitudes, momenta, rest) at `duration`.
    """

    inertias: Array
    attitudes: Array
    momenta: Array
    rest: Array
    pull: Pull

    def by_extrapolation(self, duration: float) -> State:
        """Gragg's and Stoer's method on the entries of R, in extended precision where there is."""
        b = len(self.inertias)
        inverse = np.linalg.inv(self.inertias).astype(np.longdouble)

        def slope(y: Array) -> Array:
            R, p, rest = y[: 9 * b].reshape(b, 3, 3), y[9 * b : 12 * b].reshape(b, 3), y[12 * b :]
            w = np.einsum("bij,bj->bi", inverse, p)
            torques, moved = self.pull(R, rest)
            turned = cross(R, w[:, None, :])  # row by row: R_i x w
            return np.concatenate([turned.ravel(), (cross(p, w) + torques).ravel(), moved])

        start = np.concatenate([self.attitudes.ravel(), self.momenta.ravel(), self.rest])
        steps = max(1, round(duration / SPAN))
        y = extrapolated(slope, start.astype(np.longdouble), duration, steps)
        return y[: 9 * b].reshape(b, 3, 3), y[9 * b : 12 * b].reshape(b, 3), y[12 * b :]

    def by_quaternions(self, duration: float) -> State:
        """SciPy's DOP853 on quaternions of the rotation since the start."""
        b, inverse = len(self.inertias), np.linalg.inv(self.inertias)

        def slope(t: float, y: Array) -> Array:
            turns, p, rest = y[: 4 * b].reshape(b, 4), y[4 * b : 7 * b].reshape(b, 3), y[7 * b :]
            w = np.einsum("bij,bj->bi", inverse, p)
            torques, moved = self.pull(self.attitudes @ rotation(turns), rest)
            rates = [quaternion_slope(turn, u) for turn, u in zip(turns, w, strict=True)]
            return np.concatenate([*rates, (cross(p, w) + torques).ravel(), moved])

        unit = np.tile([1.0, 0.0, 0.0, 0.0], b)
        start = np.concatenate([unit, self.momenta.ravel(), self.rest])
        states, _, _ = solve("DOP853", slope, np.array([0.0, duration]), start, TIGHT)
        y = states[-1]
        attitudes = self.attitudes @ rotation(y[: 4 * b].reshape(b, 4))
        return attitudes, y[4 * b : 7 * b].reshape(b, 3), y[7 * b :]


def cross(a: Array, b: Array) -> Array:
    """a x b along the last axis; faster than numpy's for small arrays."""
    result: Array = a.take(NEXT, -1) * b.take(LAST, -1) - a.take(LAST, -1) * b.take(NEXT, -1)
    return result
