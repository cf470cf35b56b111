"""The same kernel source, run by the interpreter, for user functions that cannot be compiled.

Only the functions that call the user's code leave the compiler; what they call otherwise stays
compiled. Exceptions and Ctrl-C then behave as in any Python program.
"""

from __future__ import annotations

from collections.abc import Callable
from types import FunctionType
from typing import Any

from numba.core.registry import CPUDispatcher

CALLS_USER_CODE = frozenset(
    {"accelerations", "jacobians", "solve_fixed_point", "solve_newton", "solve", "advance"}
    | {"slopes", "own_slopes", "canonical", "push", "local_slopes", "stage_slopes", "curvature"}
    | {"derivative", "form", "solve_group"}
)


def interpreted(kernel: Any) -> Callable[..., Any]:
    """The plain Python form of a compiled kernel and of every kernel below it that calls out."""
    source = kernel.py_func
    names = dict(source.__globals__)
    for name in CALLS_USER_CODE & set(source.__code__.co_names):
        if isinstance(names[name], CPUDispatcher) and names[name] is not kernel:
            names[name] = interpreted(names[name])
    return FunctionType(source.__code__, names, source.__name__, source.__defaults__)
