"""Can a user's function run inside a compiled kernel?"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, cast

from numba.core.registry import CPUDispatcher


def compiles(function: Callable[..., Any], arguments: tuple[Any, ...], expected: Any) -> bool:
    """Whether it is jitted and, for these types, returns what a kernel's type promises."""
    if not isinstance(function, CPUDispatcher):
        return False
    try:
        function.compile(arguments)
        returned = cast(Any, function.overloads[arguments]).signature.return_type
    except Exception:  # numba's typing errors have no common public base; Python mode still works
        return False
    return bool(returned == expected)
