"""Problems on groups whose parts are coupled, with motions by Newton's and Euler's equations."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from galvi import Problem
from galvi.arrays import Array
from references.rigid_equations import quaternion_slope, rotation
from references.scipy.ivp import TIGHT, solve

EXTRAPOLATION_COLUMNS = 6  # of the table of extrapolation: order 12; with more, round-off grows


def extrapolated(slope: Callable[[Array], Array], y: Array, duration: float, steps: int) -> Array:
    """y(duration) of y' = slope(y) by equal steps of order 12, in the precision of y."""
    h = y.dtype.type(duration) / steps
    for _ in range(steps):
        first = slope(y)
        table: list[Array] = []
        for j in range(1, EXTRAPOLATION_COLUMNS + 1):
            row = [_midpoint(slope, y, first, h, 2 * j)]
            for k, above in enumerate(table, start=1):
                weight = (y.dtype.type(j) / (j - k)) ** 2 - 1
                row.append(row[-1] + (row[-1] - above) / weight)
            table = row
        y = table[-1]
    return y


def _midpoint(
    slope: Callable[[Array], Array], y: Array, first: Array, h: np.floating, n: int
) -> Array:
    """y after the time h, by n steps of the midpoint rule, the first of Euler's method."""
    part = h / n
    before, y_now = y, y + part * first
    for _ in range(n - 1):
        before, y_now = y_now, before + 2 * part * slope(y_now)
    return y_now


# Newton's and Euler's equations of several bodies, solved twice over, without galvi.
#
# With w = J^-1 p for each body:  p' = p x w + torque,  R' = R hat(w),  and extra' from `pull`.

Pull = Callable[[Array, Array], tuple[Array, Array]]
State = tuple[Array, Array, Array]
NEXT, LAST = np.array([1, 2, 0]), np.array([2, 0, 1])
EXTRAPOLATED_STEP = 0.1  # about this long; 4e-14 of round-off where there is no extended precision


@dataclass(frozen=True, eq=False)
class NewtonEuler:
    """A motion of b bodies from a state.

    Attributes
    ----------
    inertias, attitudes : array, shape (b, 3, 3)
    momenta : array, shape (b, 3)
        angular momenta in the bodies' frames
    extra : array, shape (k,)
        further coordinates and velocities of the motion
    pull
        (attitudes, extra) -> torques (b, 3) in the bodies' frames, extra'

    Notes
    -----
    Both solvers return (attitudes, momenta, extra) at `duration`.
    """

    inertias: Array
    attitudes: Array
    momenta: Array
    extra: Array
    pull: Pull

    def by_extrapolation(self, duration: float) -> State:
        """Gragg's and Stoer's method on the entries of R, in extended precision if available."""
        b = len(self.inertias)
        inverse = np.linalg.inv(self.inertias).astype(np.longdouble)

        def slope(y: Array) -> Array:
            R, p, extra = y[: 9 * b].reshape(b, 3, 3), y[9 * b : 12 * b].reshape(b, 3), y[12 * b :]
            w = np.einsum("bij,bj->bi", inverse, p)
            torques, extra_rate = self.pull(R, extra)
            attitude_rate = cross(R, w[:, None, :])  # row by row: R_i x w
            return np.concatenate(
                [attitude_rate.ravel(), (cross(p, w) + torques).ravel(), extra_rate]
            )

        start = np.concatenate([self.attitudes.ravel(), self.momenta.ravel(), self.extra])
        steps = max(1, round(duration / EXTRAPOLATED_STEP))
        y = extrapolated(slope, start.astype(np.longdouble), duration, steps)
        return y[: 9 * b].reshape(b, 3, 3), y[9 * b : 12 * b].reshape(b, 3), y[12 * b :]

    def by_quaternions(self, duration: float) -> State:
        """SciPy's DOP853 on quaternions of the rotation since the start."""
        b, inverse = len(self.inertias), np.linalg.inv(self.inertias)

        def slope(t: float, y: Array) -> Array:
            quaternions, p, extra = (
                y[: 4 * b].reshape(b, 4),
                y[4 * b : 7 * b].reshape(b, 3),
                y[7 * b :],
            )
            w = np.einsum("bij,bj->bi", inverse, p)
            torques, extra_rate = self.pull(self.attitudes @ rotation(quaternions), extra)
            quaternion_rates = [
                quaternion_slope(quaternion, u)
                for quaternion, u in zip(quaternions, w, strict=True)
            ]
            return np.concatenate([*quaternion_rates, (cross(p, w) + torques).ravel(), extra_rate])

        unit = np.tile([1.0, 0.0, 0.0, 0.0], b)
        start = np.concatenate([unit, self.momenta.ravel(), self.extra])
        states, _, _ = solve("DOP853", slope, np.array([0.0, duration]), start, TIGHT)
        y = states[-1]
        attitudes = self.attitudes @ rotation(y[: 4 * b].reshape(b, 4))
        return attitudes, y[4 * b : 7 * b].reshape(b, 3), y[7 * b :]


def cross(a: Array, b: Array) -> Array:
    """a x b along the last axis; faster than numpy's for small arrays."""
    return a.take(NEXT, -1) * b.take(LAST, -1) - a.take(LAST, -1) * b.take(NEXT, -1)


@dataclass(frozen=True, eq=False)
class Coupled:
    """A problem, and the same motion by Newton's and Euler's equations.

    Attributes
    ----------
    motion
        (q, mu) -> the motion from q and the left-trivialised momentum mu
    state
        (attitudes, momenta, extra) of the motion -> (q, mu)
    """

    problem: Callable[[], Problem]
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
        """q at `duration` from the problem's start, by DOP853 on quaternions."""
        start = self.problem()
        return self.state(*self.motion(start.q0, start.p0).by_quaternions(duration))[0]
