"""The Galerkin curves of a run: dense output that is part of the method, not an interpolant."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from galvi.arrays import Array
from galvi.spaces.space import Space

EPSILON = float(np.finfo(np.float64).eps)


@dataclass(frozen=True, eq=False)
class Pieces:
    """Which step of a run a time falls into; fields as of `Curves`."""

    t0: float
    step: float
    coefficients: Array

    def locate(self, t: Any) -> tuple[Any, Array, bool]:
        """Step (k,), place in it (k,) from 0 to 1, and whether t is a scalar."""
        times = np.asarray(t, dtype=np.float64)
        if times.ndim > 1:
            raise ValueError(f"t must be a scalar or of shape (k,); received shape {times.shape}.")
        steps = len(self.coefficients)
        place = (np.atleast_1d(times) - self.t0) / self.step
        largest = max(abs(self.t0), abs(self.t0 + steps * self.step)) / abs(self.step)
        slack = 4.0 * EPSILON * (largest + steps) + 1e-14
        if not np.all((place >= -slack) & (place <= steps + slack)):
            last = self.t0 + steps * self.step
            raise ValueError(
                f"t must lie inside the run, from {self.t0!r} to {last!r}; received {t!r}."
            )
        joint = np.round(place)
        place = np.where(np.abs(place - joint) <= slack, joint, place)
        index = np.clip(np.floor(place).astype(np.intp), 0, steps - 1)
        past = (place == index) & np.isnan(self.coefficients[index, 0, 0]) & (index > 0)
        index = np.where(past, index - 1, index)  # the last state before a failure ends its curve
        return index, place - index, times.ndim == 0


@dataclass(frozen=True, eq=False)
class Curves:
    """q(t_k + tau h) = base_k + sum_i coefficients[k, :, i] psi_i(tau), tau in [0, 1].

    space         gives psi_i = its basis functions after the constant, less their value at 0
    t0, step      start of the first curve and the length h of each
    bases         (steps, d) configuration at the start of each step
    coefficients  (steps, d, dimension - 1)
    shape         of one configuration

    Steps that failed hold NaN.
    """

    space: Space
    t0: float
    step: float
    bases: Array
    coefficients: Array
    shape: tuple[int, ...]

    def position(self, t: Any) -> Array:
        """q at t: shape (...) for a scalar, (k, ...) for (k,). ValueError outside the run."""
        index, tau, single = Pieces(self.t0, self.step, self.coefficients).locate(t)
        basis = self.space.basis(tau)[:, 1:] - self.space.basis(np.zeros(1))[:, 1:]
        moved = np.einsum("kdi,ki->kd", self.coefficients[index], basis)
        return self._shaped(self.bases[index] + moved, single)

    def velocity(self, t: Any) -> Array:
        """dq/dt at t; at the joint of two steps, the later one's. ValueError outside the run."""
        index, tau, single = Pieces(self.t0, self.step, self.coefficients).locate(t)
        derivative = self.space.derivative(tau)[:, 1:]
        moved = np.einsum("kdi,ki->kd", self.coefficients[index], derivative)
        return self._shaped(moved / self.step, single)

    def _shaped(self, flat: Array, single: bool) -> Array:
        states: Array = flat.reshape(len(flat), *self.shape)
        return states[0] if single else states
