"""Derivatives by central differences of order eight, for functions that come without them.

With w = 4/5, -1/5, 4/105, -1/280 and a step d = 2^-6 max(1, |q|): the truncation is d^8 / 630 of
the ninth derivative and the round-off about eps |V| / d (Fornberg, Math. Comp. 51 (1988), table 1).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numba
import numpy as np
from numba.core.registry import CPUDispatcher

from galvi.arrays import Array

WEIGHTS = (4.0 / 5.0, -1.0 / 5.0, 4.0 / 105.0, -1.0 / 280.0)
STEP = 2.0**-6


def differenced_gradient(potential: Callable[..., Any], explicit_time: bool) -> Callable[..., Any]:
    """dV/dq from V by differences, compiled when V is; 8 d evaluations of V a call."""

    def plain(q, t):  # type: ignore[no-untyped-def]
        gradient = np.zeros(q.size)
        step = STEP * max(1.0, np.max(np.abs(q)))
        for i in range(q.size):
            there = q.copy()
            for k in range(4):
                there[i] = q[i] + (k + 1) * step
                ahead = value(there, t)
                there[i] = q[i] - (k + 1) * step
                gradient[i] += WEIGHTS[k] * (ahead - value(there, t)) / step
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
    """d2V/dq2 from dV/dq by differences, made symmetric; 8 d gradients a call."""

    def hessian(q: Array, *time: float) -> Array:
        columns = np.zeros((q.size, q.size))
        step = STEP * max(1.0, float(np.max(np.abs(q))))
        for i, unit in enumerate(np.eye(q.size)):
            for k, weight in enumerate(WEIGHTS, start=1):
                ahead = np.asarray(gradient(q + k * step * unit, *time))
                behind = np.asarray(gradient(q - k * step * unit, *time))
                columns[i] += weight * (ahead - behind) / step
        return 0.5 * (columns + columns.T)

    return hessian


def _same(function: Callable[..., Any]) -> Callable[..., Any]:
    return function
