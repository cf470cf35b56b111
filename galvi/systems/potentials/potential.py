"""Interface of potentials that references recognise by their type and fields."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol, runtime_checkable

import numpy as np

from galvi.arrays import Array


@dataclass(frozen=True, eq=False)
class Law:
    """Derivatives of a potential as compiled functions of all s stages at once.

    gradient   (Q (d, s), t (s,), constants, out (d, s)) fills out with dV/dq
    hessian    (Q (d, s), t (s,), constants, out (d, d, s)) fills out with d2V/dq2
    constants  (c,) constants of both functions
    """

    gradient: Callable[..., Any]
    hessian: Callable[..., Any]
    constants: Array


@runtime_checkable
class Potential(Protocol):
    """V(q) of one configuration of shape (d,), with its derivatives."""

    def __call__(self, q: Array) -> float:
        """V(q)."""

    def gradient(self, q: Array) -> Array:
        """dV/dq, shape (d,)."""

    def hessian(self, q: Array) -> Array:
        """d2V/dq2, shape (d, d)."""

    def law(self) -> Law:
        """Compiled derivatives and their constants."""


def values_at(
    potential: Callable[..., Any], q: Array, t: Array, arguments: Callable[..., tuple[Any, ...]]
) -> Array:
    """V (k,) at k configurations (k, ...) and times (k,), NaN where these are not finite.

    arguments  (q, t) -> what the potential takes; one with ``at_states(q)`` is called once
    """
    known = np.all(np.isfinite(q.reshape(len(q), -1)), axis=1)
    result = np.full(len(q), np.nan)
    if hasattr(potential, "at_states"):
        result[known] = potential.at_states(q[known])
    else:
        for k in np.flatnonzero(known):
            result[k] = potential(*arguments(q[k], t[k]))
    return result
