"""The same kernel source, run by the interpreter, for user functions that cannot be compiled.

Only the functions that call the user's code leave the compiler; what they call otherwise stays
compiled. Exceptions and Ctrl-C then behave as in any Python program.
"""

from __future__ import annotations

import operator
from collections.abc import Callable
from functools import cache
from types import FunctionType
from typing import Any

from numba.core.registry import CPUDispatcher

from galvi.kernels.compile.function_pointers import call_matrix, call_vector, call_void

CALLS = (call_void, call_vector, call_matrix)


def interpreted(kernel: Any) -> Callable[..., Any]:
    """The plain Python form of a compiled kernel and of every kernel below it that calls out."""
    source = kernel.py_func
    names = dict(source.__globals__)
    for name, value in _used(kernel).items():
        if value in CALLS:
            names[name] = operator.call
        elif isinstance(value, CPUDispatcher) and _calls_out(value):
            names[name] = interpreted(value)
    return FunctionType(source.__code__, names, source.__name__, source.__defaults__)


@cache
def _calls_out(kernel: Any) -> bool:
    """Whether it, or a kernel below it, calls a function by its address."""
    return any(
        value in CALLS or (isinstance(value, CPUDispatcher) and _calls_out(value))
        for value in _used(kernel).values()
    )


def _used(kernel: Any) -> dict[str, Any]:
    """The functions that its source names, but for itself."""
    source = kernel.py_func
    found = {name: source.__globals__.get(name) for name in source.__code__.co_names}
    return {name: value for name, value in found.items() if callable(value) and value is not kernel}
