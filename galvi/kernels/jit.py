"""How every kernel is compiled: cached on disk, IEEE division, no reordering of sums."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

import numba

F = TypeVar("F", bound=Callable[..., Any])

jit: Callable[[F], F] = numba.njit(cache=True, error_model="numpy")
