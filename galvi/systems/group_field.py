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
    """Derivatives of a Lagrangian, and a force, as galvi.kernels.slopes evaluates them.

    Of the Lagrangian's functions at most one is the system's, and of the force's; the rest are
    stand-ins.

    kind       slopes.LAW, EUCLIDEAN, LEFT, GRADIENT, CANONICAL or CANONICAL_GRADIENT
    timed      whether a user's function takes the time
    side       rows of the matrix that a user's slopes and force take; 0 for a vector
    constants  (c,) numbers for law
    pushed     slopes.FREE, PUSHED, TIMED_PUSHED or PUSHED_BY_LAW
    push_constants  (c,) numbers for push
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
    field_law: Callable[..., Any] = laws.no_law
    field_gradient: Callable[..., Any] = laws.no_gradient
    timed_field_gradient: Callable[..., Any] = laws.no_timed_gradient
    push: Callable[..., Any] = stage.no_law
    force: Callable[..., Any] = stage.no_slopes
    timed_force: Callable[..., Any] = stage.no_timed_slopes
    matrix_force: Callable[..., Any] = stage.no_matrix_slopes
    timed_matrix_force: Callable[..., Any] = stage.no_timed_matrix_slopes
    timed: bool = False
    side: int = 0
    constants: Array = field(default_factory=laws.no_constants)
    pushed: int = stage.FREE
    push_constants: Array = field(default_factory=laws.no_constants)
    compiled: bool = True

    @property
    def functions(self) -> tuple[Callable[..., Any], ...]:
        """In the order in which galvi.kernels.group_advance takes them."""
        return (
            self.law, self.slopes, self.timed_slopes, self.matrix_slopes, self.timed_matrix_slopes,
            self.gradient, self.timed_gradient, self.field_law, self.field_gradient,
            self.timed_field_gradient, self.push, self.force, self.timed_force, self.matrix_force,
            self.timed_matrix_force,
        )  # fmt: skip
