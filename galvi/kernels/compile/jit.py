"""Compiler settings of all kernels: cached on disk, IEEE division, no reordering of sums.

Kernels release the interpreter's lock while they run. Functions that they call are parts of them,
see galvi.kernels.compile.parts. With GALVI_PLAIN_NUMBA=1 numba compiles and caches kernels in its
usual way, which takes about twice the time and gives the same bits.
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
from galvi.kernels.compile.parts import PLAIN, call_as_part, public_options
from galvi.kernels.compile.watching import watch_compilation

_COMPILATION_LOCK = threading.RLock()


def watch_before_compiling(dispatcher):
    """Call `watch_compilation` before a dispatcher's first compilation or load from disk."""
    compile_function = dispatcher.compile

    def compile_watched(signature):
        watch_compilation()
        return compile_function(signature)

    dispatcher.compile = compile_watched


def jit(function, **options):
    """A dispatcher that compiles ``function`` at the first call for each set of argument types.

    ``options`` are those of njit. All are set explicitly, since numba would take missing ones from
    the first kernel that calls the function.
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
    """``function`` compiled and cached by numba, without the options that are not public.

    numba's cache checks only the file of the function; the name of its folder contains a digest of
    all kernel sources. Without a writable folder the function is compiled in every process.
    """
    settings: Any = numba.config
    before = settings.CACHE_DIR
    try:
        folder = Path(KernelCache(function).cache_path) / f"galvi-plain-{stamp(*kernels())[:16]}"
        settings.CACHE_DIR = str(folder)
        return numba.njit(cache=True, **public_options(options))(function)
    except (RuntimeError, OSError):  # no folder can be written
        return numba.njit(**public_options(options))(function)
    finally:
        settings.CACHE_DIR = before


def jit_inline(function):
    """`jit` for a function that allocates no arrays and is called many times a step.

    It is inlined and compiled without reference counting (``_nrt``, not public in numba): to pass
    arrays with it takes as long as one iteration for a few bodies.
    """
    return jit(function, _nrt=False, forceinline=True)


def jit_noalloc(function):
    """`jit` for a long function, or one with many callers, that allocates no arrays: without
    reference counting, but not inlined."""
    return jit(function, _nrt=False)


def set_name(function, name):
    """Set the name of a function, which its files in the cache contain; returns the function."""
    function.__name__ = function.__qualname__ = name
    return function


def compiled_for(dispatcher, signature, compiler=jit):
    """A dispatcher of the function of ``dispatcher``, compiled by ``compiler`` for one
    signature."""
    with _COMPILATION_LOCK:
        return _compiled_for(dispatcher, signature, compiler)


@cache
def _compiled_for(dispatcher, signature, compiler):
    single_signature = compiler(dispatcher.py_func)
    single_signature.compile(signature)
    single_signature.disable_compile()
    return single_signature


REAL = types.float64
VECTOR = types.float64[::1]
MATRIX = types.float64[:, ::1]
TENSOR3 = types.float64[:, :, ::1]
