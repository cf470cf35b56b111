"""The force of a vector-space system as compiled kernels evaluate it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from galvi.arrays import Array
from galvi.kernels.compile.function_pointers import addresses
from galvi.kernels.forces import force_kinds


@dataclass(frozen=True, eq=False)
class ForceKernel:
    """Functions and constants that give the acceleration a(q, t) of a system.

    force         function of this kind, see galvi.kernels.forces.force_kinds
    slope         its derivative by q, for Newton's method; None: differenced in the kernel
    kind          force_kinds.BUILT_IN, GRADIENT or TIMED_GRADIENT
    constants     (c,) numbers for a built-in force
    inverse_mass  (d, 1) diagonal or (d, d) full; applied to -force. (0, 0): a built-in force that
                  already returns accelerations
    width         components that a Newton block couples; d must be a multiple of it
    compiled      whether both functions can run inside a compiled kernel
    """

    force: Callable[..., Any]
    slope: Callable[..., Any] | None
    kind: int
    inverse_mass: Array
    width: int
    constants: Array = field(default_factory=force_kinds.no_constants)
    compiled: bool = True

    @property
    def functions(self) -> Any:
        """Addresses (2,) of the compiled functions, or the Python functions for the interpreter."""
        given = (self.force, self.slope)
        if not self.compiled:
            return given
        return addresses(*zip(given, force_kinds.SIGNATURES[self.kind], strict=True))
