"""numba's compiler for the suite's own loops, with its cache on disk where a folder is writable."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numba


def njit(*signature: Any, **options: Any) -> Callable[[Callable[..., Any]], Any]:
    """As ``numba.njit``, with compiled code cached on disk where a folder is writable."""

    def compiled(function: Callable[..., Any]) -> Any:
        try:
            return numba.njit(*signature, cache=True, **options)(function)
        except RuntimeError:  # numba found no writable folder
            return numba.njit(*signature, **options)(function)

    return compiled
