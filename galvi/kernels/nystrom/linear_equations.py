"""Linear equations by LAPACK, as ``np.linalg.solve`` has it, but in place and without its checks:
their messages alone would take a third of the time in which the kernel compiles."""

from __future__ import annotations

from typing import Any

from numba import types

from galvi.kernels.compile.jit import jit

NUMBERS, INDICES = types.CPointer(types.float64), types.CPointer(types.int64)
INTEGER = types.intp
SIGNATURE = types.intc(
    types.char, INTEGER, INTEGER, NUMBERS, INTEGER, INDICES, NUMBERS, INTEGER,
)  # fmt: skip
DGESV: Any = types.ExternalFunction("numba_xgesv", SIGNATURE)  # numba's name for SciPy's
DOUBLE = ord("d")


@jit
def solve_equations(columns, pivots, right):
    """right (n,) <- the solution; returns whether there is one.

    columns (n, n): those of the matrix, as rows; overwritten. pivots (n,) of int64: overwritten,
    half of it where LAPACK's integers have 32 bits. Where right is not finite, the solution is not.
    """
    n = right.size
    return DGESV(DOUBLE, n, 1, columns.ctypes, n, pivots.ctypes, right.ctypes, n) == 0
