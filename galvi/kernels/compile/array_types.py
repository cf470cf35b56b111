"""Types of the numbers and arrays that kernels pass to functions."""

from __future__ import annotations

from numba import types

REAL = types.float64
VECTOR = types.float64[::1]
MATRIX = types.float64[:, ::1]
TENSOR3 = types.float64[:, :, ::1]
