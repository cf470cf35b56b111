"""Runs kernels in the interpreter, for user functions that cannot be compiled.

Only the kernels that call user code, directly or indirectly, are interpreted; all others stay
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
    """The Python form of a compiled kernel and of every kernel below it that calls user code."""
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
    """Whether the kernel, or one that it calls, calls a function by its address."""
    return any(
        value in CALLS or (isinstance(value, CPUDispatcher) and _calls_out(value))
        for value in _used(kernel).values()
    )


def _used(kernel: Any) -> dict[str, Any]:
    """The functions named in the kernel's source, except itself."""
    source = kernel.py_func
    found = {name: source.__globals__.get(name) for name in source.__code__.co_names}
    return {name: value for name, value in found.items() if callable(value) and value is not kernel}
