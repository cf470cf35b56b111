"""Compiler settings of all kernels: cached on disk, IEEE division, no reordering of sums.

Kernels release the interpreter's lock while they run. Functions that they call are parts of them,
see galvi.kernels.compile.parts. With GALVI_PLAIN_NUMBA=1 numba compiles and caches them as it does
by itself: the same bits, after about twice the time.
"""

from __future__ import annotations

import threading
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import Any

import numba
from numba import types

from galvi.kernels.compile.cache import KernelCache, kernels, stamp
from galvi.kernels.compile.parts import PLAIN, call_as_part, public
from galvi.kernels.compile.watching import watch_compilation

_ONE_AT_A_TIME = threading.RLock()


def watch_before_compiling(dispatcher):
    """Call `watch_compilation` before a dispatcher's first compilation or load from disk."""
    compile_it = dispatcher.compile

    def watched(signature):
        watch_compilation()
        return compile_it(signature)

    dispatcher.compile = watched


def jit(function, **options):
    """``function`` compiled at the first call, for the types of its arguments; options of njit.

    All options are stated, since numba would inherit missing ones from the first calling kernel.
    """
    settings = {
        "error_model": "numpy",
        "nogil": True,
        "_nrt": True,
        "forceinline": False,
        **options,
    }
    if PLAIN:
        return plainly_compiled(function, settings)
    dispatcher: Any = numba.njit(**settings)(function)
    if hasattr(dispatcher, "_cache"):  # absent under NUMBA_DISABLE_JIT
        # Without a writable folder or readable sources, every process compiles again.
        with suppress(RuntimeError, OSError):
            KernelCache(function).serve(dispatcher)
        watch_before_compiling(dispatcher)
        call_as_part(dispatcher, settings)
    return dispatcher


def plainly_compiled(function, options):
    """``function`` compiled and cached by numba as it is, but for options that are not public.

    numba's cache looks at the file of a function alone; its folder is named by all kernels here.
    """
    settings: Any = numba.config
    before = settings.CACHE_DIR
    try:
        folder = Path(KernelCache(function).cache_path) / f"galvi-plain-{stamp(*kernels())[:16]}"
        settings.CACHE_DIR = str(folder)
        return numba.njit(cache=True, **public(options))(function)
    except (RuntimeError, OSError):  # no folder can be written
        return numba.njit(**public(options))(function)
    finally:
        settings.CACHE_DIR = before


def jit_inline(function):
    """As ``jit``, for a function that allocates no arrays and is called many times a step.

    It is inlined and compiled without reference counting (``_nrt``, not public in numba): passing
    arrays takes as long as one iteration for a few bodies.
    """
    return jit(function, _nrt=False, forceinline=True)


def jit_noalloc(function):
    """As ``jit_inline``, but not inlined: for long functions, or those with many callers."""
    return jit(function, _nrt=False)


def renamed(function, name):
    """The function under a name of its own, which its code on disk has too."""
    function.__name__ = function.__qualname__ = name
    return function


def compiled_for(dispatcher, signature, compiler=jit):
    """A dispatcher of the same function compiled by ``compiler`` for this signature only."""
    with _ONE_AT_A_TIME:
        return _compiled_for(dispatcher, signature, compiler)


@cache
def _compiled_for(dispatcher, signature, compiler):
    fixed = compiler(dispatcher.py_func)
    fixed.compile(signature)
    fixed.disable_compile()
    return fixed


REAL = types.float64
VECTOR = types.float64[::1]
MATRIX = types.float64[:, ::1]
TENSOR3 = types.float64[:, :, ::1]
