"""How a Lagrangian on a group enters the kernels."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from galvi.arrays import Array
from galvi.kernels import laws
from galvi.kernels import slopes as stage


@dataclass(frozen=True, eq=False)
class GroupField:
    """Derivatives of a Lagrangian, as galvi.kernels.slopes evaluates them.

    Exactly one of the functions is the system's; the rest are stand-ins.

    kind       slopes.LAW, EUCLIDEAN, LEFT or GRADIENT
    timed      whether a user's function takes the time
    side       rows of the matrix that a user's slopes take; 0 for a vector
    constants  (c,) numbers for law
    compiled   whether every function can run inside a compiled kernel
    """

    kind: int
    law: Callable[..., Any] = stage.no_law
    slopes: Callable[..., Any] = stage.no_slopes
    timed_slopes: Callable[..., Any] = stage.no_timed_slopes
    matrix_slopes: Callable[..., Any] = stage.no_matrix_slopes
    timed_matrix_slopes: Callable[..., Any] = stage.no_timed_matrix_slopes
    gradient: Callable[..., Any] = stage.no_gradient
    timed_gradient: Callable[..., Any] = stage.no_timed_gradient
    timed: bool = False
    side: int = 0
    constants: Array = field(default_factory=laws.no_constants)
    compiled: bool = True
