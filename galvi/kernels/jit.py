"""How every kernel is compiled: cached on disk, IEEE division, no reordering of sums.

While a kernel runs, other threads of Python go on.
"""

from __future__ import annotations

import threading
from contextlib import suppress
from functools import cache
from typing import Any

import numba

from galvi.kernels.cache import KernelCache

_ONE_AT_A_TIME = threading.RLock()


def jit(function):
    """``function`` compiled when first called, for the types it is called with."""
    dispatcher: Any = numba.njit(error_model="numpy", nogil=True)(function)
    if hasattr(dispatcher, "_cache"):  # not so when numba is told not to compile
        with suppress(RuntimeError):  # no folder to keep it in: every process compiles anew
            dispatcher._cache = KernelCache(function)
    return dispatcher


def compiled_for(dispatcher, signature):
    """A dispatcher of the same function that takes these types and no others."""
    with _ONE_AT_A_TIME:
        return _compiled_for(dispatcher, signature)


@cache
def _compiled_for(dispatcher, signature):
    fixed = jit(dispatcher.py_func)
    fixed.compile(signature)
    fixed.disable_compile()
    return fixed
