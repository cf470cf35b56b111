"""The curves of a run in a moving frame."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from galvi.arrays import Array
from galvi.curves.curves import Curves, located
from galvi.spaces.space import Space

TINY = 1e-100  # imaginary increments of complex steps


class MovingPath(Protocol):
    """The frame of a run."""

    def node(self, number: Array, tau: Array) -> tuple[Array, Array]:
        """c and dc/dtau at shares tau (k,) of the steps ``number`` (k,) since the start."""

    def flow(self, w: Any, t: Any) -> Any:
        """q (k, *shape) at times t (k,) after w (k, 2, m), or (k, 4, m) with its low parts."""

    def curves(self, number: int, base: Array) -> Curves:
        """Those of a step that was done in the inertial frame, from time 0 on."""


@dataclass(frozen=True, eq=False)
class FrameCurves:
    """q = phi_t(w) with w = base + sum_i coefficients[k, :, i] psi_i(c), t since a step's centre.

    space         psi_i are its basis functions after the constant, minus their values at 0
    t0, step      start of the first curve and the length h of each
    bases         (steps, 4, m) the state in the frame before each step, and its low parts, which
                  files of older versions lack
    coefficients  (steps, 2 n, dimension - 1): n rows of places, and n of velocities; of a step that
                  was done in the inertial frame all but the first are NaN, and its base has (q, v)
    first         number of the first step since the problem's start
    path          the frame
    """

    space: Space
    t0: float
    step: float
    bases: Array
    coefficients: Array
    first: int
    path: MovingPath

    def position(self, t: Any) -> Array:
        """q at t: its shape for a scalar t, (k, ...) for (k,). ValueError outside the run."""
        index, tau, single = located(self.t0, self.step, self.coefficients, t)
        places = self.places(index, tau)
        return places[0] if single else places

    def places(self, index: Any, tau: Array) -> Array:
        """q (k, ...) at fractions tau (k,) of the steps ``index`` (k,)."""
        return self._each(index, tau, self._own_places, Curves.position)

    def velocity(self, t: Any) -> Array:
        """dq/dt at t, where two steps meet that of the later one. ValueError outside the run."""
        index, tau, single = located(self.t0, self.step, self.coefficients, t)
        velocities = self.velocities(index, tau)
        return velocities[0] if single else velocities

    def velocities(self, index: Any, tau: Array) -> Array:
        """dq/dt (k, ...) at fractions tau (k,) of the steps ``index`` (k,)."""
        return self._each(index, tau, self._own_velocities, Curves.velocity)

    def _each(self, index: Any, tau: Array, own: Any, elsewhere: Any) -> Array:
        """Values by ``own`` in the frame, and by ``elsewhere`` on curves in the inertial one."""
        away = np.isnan(self.coefficients[index, -1, -1]) & ~np.isnan(self.bases[index, 0, 0])
        rows, values = [np.flatnonzero(~away)], [own(index[~away], tau[~away])]
        for k in np.unique(index[away]).tolist():
            rows.append(np.flatnonzero(away & (index == k)))
            curves = self.path.curves(self.first + k, self.bases[k])
            values.append(elsewhere(curves, tau[rows[-1]] * self.step))
        return np.concatenate(values)[np.argsort(np.concatenate(rows))]

    def _own_places(self, index: Any, tau: Array) -> Array:
        w, _rate, since = self._moving(index, tau)
        return self.path.flow(w, since)

    def _own_velocities(self, index: Any, tau: Array) -> Array:
        w, rate, since = self._moving(index, tau)
        moved = self.path.flow(w + 1j * TINY * rate, since + 1j * TINY)
        return np.imag(moved) / TINY

    def _moving(self, index: Any, tau: Array) -> tuple[Array, Array, Array]:
        """w (k, 4, m), dw/dt, and the times (k,) since the steps' centres."""
        c, slope = self.path.node(self.first + index, tau)
        basis = self.space.basis(np.append(c, 0.0))[:, 1:]
        ways = np.einsum("kdi,ki->kd", self.coefficients[index], basis[:-1] - basis[-1])
        rates = np.einsum("kdi,ki->kd", self.coefficients[index], self.space.derivative(c)[:, 1:])
        w, rate = self.bases[index].copy(), np.zeros_like(self.bases[index])
        n = ways.shape[1] // 2
        w[:, :2, :n] += ways.reshape(-1, 2, n)
        rate[:, :2, :n] = (rates * (slope / self.step)[:, None]).reshape(-1, 2, n)
        return w, rate, (tau - 0.5) * self.step
