"""The derivatives of a Lagrangian on a group as compiled kernels evaluate them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from galvi.arrays import Array
from galvi.kernels.compile.function_pointers import addresses
from galvi.kernels.forces import force_kinds, lagrangian_derivatives


@dataclass(frozen=True, eq=False)
class LagrangianKernel:
    """Derivatives of a Lagrangian, and a force, as galvi.kernels.forces.lagrangian_derivatives
    evaluates them.

    kind             LAW, EUCLIDEAN, LEFT, GRADIENT, CANONICAL or CANONICAL_GRADIENT of that module
    function         function of this kind
    time_dependent   whether a user's function takes the time
    matrix_rows      rows of the matrix that a user's slopes and force take; 0 for a vector
    constants        (c,) constants of the Lagrangian
    force_kind       NO_FORCE, FORCE, TIMED_FORCE or FORCE_LAW of that module
    force            external force of that kind; None for NO_FORCE
    force_constants  (c,) constants of the force
    compiled         whether both functions can run inside a compiled kernel
    """

    kind: int
    function: Callable[..., Any]
    time_dependent: bool = False
    matrix_rows: int = 0
    constants: Array = field(default_factory=force_kinds.no_constants)
    force_kind: int = lagrangian_derivatives.NO_FORCE
    force: Callable[..., Any] | None = None
    force_constants: Array = field(default_factory=force_kinds.no_constants)
    compiled: bool = True

    @property
    def functions(self) -> Any:
        """Addresses (2,) of the compiled functions, or the Python functions for the interpreter."""
        if not self.compiled:
            return self.function, self.force
        return addresses(
            (
                self.function,
                lagrangian_derivatives.signature(self.kind, self.time_dependent, self.matrix_rows),
            ),
            (self.force, lagrangian_derivatives.force_signature(self.force_kind, self.matrix_rows)),
        )
