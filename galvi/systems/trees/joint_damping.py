"""Linear damping of velocities."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from galvi import input_checks
from galvi.arrays import Array
from galvi.kernels.compile.jit import jit


@jit
def damping(q, v, t, constants, out):  # type: ignore[no-untyped-def]
    """out[1] <- out[1] - constants v."""
    for i in range(v.size):
        out[1, i] -= constants[i] * v[i]


@dataclass(frozen=True, eq=False)
class JointDamping:
    """f = -coefficients v.

    coefficients  (d,), not negative, else ValueError
    varied        whether its law also has the terms of coefficients that are 0
    """

    coefficients: Any
    varied: bool = False

    def __post_init__(self) -> None:
        found = input_checks.array("coefficients", self.coefficients)
        if found.ndim != 1 or np.any(found < 0.0):
            raise ValueError(f"coefficients must be (d,), not negative; received {found.tolist()}.")
        object.__setattr__(self, "coefficients", found)

    def __call__(self, q: Array, v: Array, t: float) -> Array:
        result: Array = -self.coefficients * v
        return result

    @property
    def law(self) -> str:
        """As `BuiltinForce.law`."""
        terms = (
            f"-(c[{i}] * v[{i}])" if c or self.varied else "0.0"
            for i, c in enumerate(self.coefficients.tolist())
        )
        return f"def force(q, v, t, c):\n    return [{', '.join(terms)}]\n"

    def compiled(self) -> tuple[Callable[..., Any], Array]:
        """As `BuiltinForce.compiled`, with the coefficients for constants."""
        return damping, np.array(self.coefficients)
