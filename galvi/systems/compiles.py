"""Whether a user's function can run inside a compiled kernel."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, cast

from numba.core.registry import CPUDispatcher


def compiles(function: Callable[..., Any], signature: Any) -> bool:
    """Whether a function is jitted and, for the signature's arguments, returns its return type."""
    if not isinstance(function, CPUDispatcher):
        return False
    try:
        function.compile(signature.args)
        returned = cast(Any, function.overloads[signature.args]).signature.return_type
    except Exception:  # numba's typing errors have no common public base; Python mode still works
        return False
    return bool(returned == signature.return_type)
