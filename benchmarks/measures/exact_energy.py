"""Energy errors far below float64 round-off, in double-double arithmetic."""

from __future__ import annotations

from typing import Any

import numpy as np

from galvi import Problem
from galvi.arrays import Array
from references.closed_forms.double_double import DoubleDouble


def relative_energy_error(problem: Problem, q: Any, v: Any) -> Array:
    """(E(q, v) - E(q0, v0)) / |E(q0, v0)| of point masses, to about 1e-29.

    q, v  DoubleDouble of shape (..., bodies, dimension): a state with its low parts
    """
    start = _energy(problem, exactly(problem.q0), exactly(problem.v0))
    change = (_energy(problem, q, v) - start) / start
    error: Array = -np.asarray(change.hi) if start.hi < 0.0 else np.asarray(change.hi)
    return error


def exactly(x: Array) -> DoubleDouble:
    """The same numbers as DoubleDouble, with zero low parts."""
    return DoubleDouble(x, np.zeros_like(x))


def _energy(problem: Problem, q: DoubleDouble, v: DoubleDouble) -> DoubleDouble:
    """sum m v.v / 2 - sum over pairs G m_i m_j / r_ij, shape (...)."""
    system: Any = problem.system
    i, j = np.triu_indices(system.masses.size, 1)
    kinetic = _total(_total(v * v) * exactly(0.5 * system.masses))
    gap = q[..., i, :] - q[..., j, :]
    weight = exactly(system.masses[i]) * exactly(system.masses[j])
    return kinetic - _total(weight / _root(_total(gap * gap))) * system.G


def _total(x: DoubleDouble) -> DoubleDouble:
    """The sum over the last axis."""
    result = x[..., 0]
    for k in range(1, x.hi.shape[-1]):
        result = result + x[..., k]
    return result


def _root(x: DoubleDouble) -> DoubleDouble:
    """The square root: one Newton step from that of the high part."""
    guess = np.sqrt(x.hi)
    return (x - DoubleDouble(guess) * guess) / (2.0 * guess) + guess
