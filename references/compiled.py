"""numba's compiler for the suite's own loops, where folders can be written and where none can."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numba


def njit(*signature: Any, **options: Any) -> Callable[[Callable[..., Any]], Any]:
    """As ``numba.njit``, with compiled code kept on disk where a folder can be written."""

    def compiled(function: Callable[..., Any]) -> Any:
        try:
            return numba.njit(*signature, cache=True, **options)(function)
        except RuntimeError:  # numba found no folder that can be written
            return numba.njit(*signature, **options)(function)

    return compiled
