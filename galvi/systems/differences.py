"""Derivatives by central differences of order eight, for functions that come without them.

With weights 4/5, -1/5, 4/105, -1/280 (Fornberg, Math. Comp. 51 (1988), table 1) and steps of
2^-6, 2^-10 and 2^-14 times |q|: of two neighbouring steps that agree best, the finer is taken, so
that neither a short length scale nor round-off goes unseen.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import Any

import numba
import numpy as np
from numba.core.registry import CPUDispatcher

from galvi.arrays import Array

WEIGHTS = (4.0 / 5.0, -1.0 / 5.0, 4.0 / 105.0, -1.0 / 280.0)
STEPS = (2.0**-6, 2.0**-10, 2.0**-14)
CALLS = 2 * len(WEIGHTS) * len(STEPS)  # of the function, for each component


@lru_cache(maxsize=64)
def differenced_gradient(potential: Callable[..., Any], explicit_time: bool) -> Callable[..., Any]:
    """dV/dq from V by differences, compiled when V is; CALLS * d evaluations of V a call."""

    def plain(q, t):  # type: ignore[no-untyped-def]
        size = np.max(np.abs(q))
        size = size if size > 0.0 else 1.0
        gradient = np.zeros(q.size)
        found = np.zeros(len(STEPS))
        for i in range(q.size):
            there = q.copy()
            for n in range(len(STEPS)):
                found[n] = 0.0
                for k in range(len(WEIGHTS)):
                    there[i] = q[i] + (k + 1) * STEPS[n] * size
                    ahead = value(there, t)
                    there[i] = q[i] - (k + 1) * STEPS[n] * size
                    found[n] += WEIGHTS[k] * (ahead - value(there, t)) / (STEPS[n] * size)
            gradient[i] = found[-1]
            best = np.inf
            for n in range(1, len(STEPS)):
                if np.abs(found[n] - found[n - 1]) < best:
                    best = np.abs(found[n] - found[n - 1])
                    gradient[i] = found[n]
        return gradient

    compiled = isinstance(potential, CPUDispatcher)
    jit: Callable[..., Any] = numba.njit if compiled else _same
    if explicit_time:
        value = potential
        return jit(plain)

    value = jit(lambda q, t: potential(q))
    timed = jit(plain)
    return jit(lambda q: timed(q, 0.0))


def differenced_hessian(gradient: Callable[..., Any]) -> Callable[..., Array]:
    """d2V/dq2, row i the derivative of component i, from dV/dq; CALLS * d gradients a call."""

    def hessian(q: Array, *time: float) -> Array:
        size = float(np.max(np.abs(q))) or 1.0
        found = np.array([_slopes(gradient, q, step * size, *time) for step in STEPS])
        gaps = np.max(np.abs(np.diff(found, axis=0)), axis=(1, 2))
        gaps = np.where(np.isfinite(gaps), gaps, np.inf)
        finer: Array = found[1 + int(np.argmin(gaps))]
        return finer

    return hessian


def _slopes(gradient: Callable[..., Any], q: Array, step: float, *time: float) -> Array:
    columns = np.zeros((q.size, q.size))
    for i, unit in enumerate(np.eye(q.size)):
        for k, weight in enumerate(WEIGHTS, start=1):
            ahead = np.array(gradient(q + k * step * unit, *time))
            behind = np.array(gradient(q - k * step * unit, *time))
            columns[i] += weight * (ahead - behind) / step
    return columns.T


def _same(function: Callable[..., Any]) -> Callable[..., Any]:
    return function
