"""How every kernel is compiled: cached on disk, IEEE division, no reordering of sums.

While a kernel runs, other threads of Python go on.
"""

from __future__ import annotations

import threading
from contextlib import suppress
from functools import cache
from typing import Any

import numba

from galvi.kernels.compile.cache import KernelCache

_ONE_AT_A_TIME = threading.RLock()


def jit(function, **options):
    """``function`` compiled when first called, for the types it is called with; options of njit.

    Options that are not said would be taken from the first kernel that calls it.
    """
    given = {"error_model": "numpy", "nogil": True, "_nrt": True, "forceinline": False, **options}
    dispatcher: Any = numba.njit(**given)(function)
    if hasattr(dispatcher, "_cache"):  # not so when numba is told not to compile
        # no folder to keep it in, or no sources to stamp: every process compiles anew
        with suppress(RuntimeError, OSError):
            KernelCache(function).serve(dispatcher)
    return dispatcher


def jit_inline(function):
    """As ``jit`` for a function that makes no arrays, to be called from another many times a step.

    It does not count references to the arrays it uses (``_nrt``, not public in numba), and is
    inlined: handing arrays over takes as long as a pass over few bodies does.
    """
    return jit(function, _nrt=False, forceinline=True)


def jit_noalloc(function):
    """As ``jit_inline``, but called: for what is long, or called from many places."""
    return jit(function, _nrt=False)


def compiled_for(dispatcher, signature, compiler=jit):
    """A dispatcher of the same function, by ``jit`` or another, for these types and no others."""
    with _ONE_AT_A_TIME:
        return _compiled_for(dispatcher, signature, compiler)


@cache
def _compiled_for(dispatcher, signature, compiler):
    fixed = compiler(dispatcher.py_func)
    fixed.compile(signature)
    fixed.disable_compile()
    return fixed
