"""Compiler settings of all kernels: cached on disk, IEEE division, no reordering of sums.

Kernels release the interpreter's lock while they run. Functions that they call are parts of them,
compiled to what a kernel is linked from, and no further: numba makes machine code of every function
that another one calls, optimised with all that it calls in turn, as if it were called from Python
too. Without that a kernel of three hundred functions takes half as long to compile and runs as
fast.
"""

from __future__ import annotations

import threading
from contextlib import suppress
from functools import cache
from typing import Any

import numba
from numba import types
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import CompilerBase, DefaultPassBuilder, Flags
from numba.core.compiler_machinery import PassManager, register_pass
from numba.core.typed_passes import NativeLowering

from galvi.kernels.compile.cache import KernelCache
from galvi.kernels.compile.watching import watch_compilation


class PartCode(JITCodeLibrary):
    """Code that is optimised and made machine code by what it is linked into."""

    def _optimize_final_module(self):
        pass

    def _finalize_final_module(self):
        self._finalize_dynamic_globals()
        self._finalized = True


@register_pass(mutates_CFG=True, analysis_only=False)
class PartLowering(NativeLowering):
    """LLVM's code of a function, without an address."""

    _name = "part_lowering"

    def run_pass(self, state):
        context = state.targetctx
        state.library = PartCode(context.codegen(), state.func_id.func_qualname)
        state.flags.no_compile = True
        super().run_pass(state)
        key: object = [].append  # numba has built-in functions only as keys; each list's is another
        context.insert_user_function(key, state.cr.fndesc, [state.library])
        state["cr"] = state.cr._replace(cfunc=key)
        return True


class PartFlags(Flags):
    """numba's Flags, compared by the options that are set.

    numba's own compare all of them, for each operation of a function several times: a fifth of the
    time that a kernel takes to compile.
    """

    __slots__ = ()

    def __hash__(self):
        return hash(frozenset(self._values))

    def __eq__(self, other):
        return isinstance(other, PartFlags) and self._values == other._values


class PartCompiler(CompilerBase):
    """numba's, with `PartLowering`; for `pipeline_class`."""

    def __init__(self, typing, target, library, args, returned, flags, local):
        super().__init__(typing, target, library, args, returned, PartFlags(flags), local)

    def define_pipelines(self):
        usual = DefaultPassBuilder.define_nopython_pipeline(self.state)
        parts = PassManager("part")
        for step, text in usual.passes:
            parts.add_pass(PartLowering if step is NativeLowering else step, text)
        parts.finalize()
        return [parts]


AS_PART = {"pipeline_class": PartCompiler, "no_cpython_wrapper": True, "no_cfunc_wrapper": True}


def call_as_part(dispatcher, options):
    """Let functions that call a jitted one compile it as a part; calls from Python as before."""

    @cache
    def part():
        return numba.njit(**{**options, **AS_PART})(dispatcher.py_func)

    dispatcher.get_call_template = lambda args, kws: part().get_call_template(args, kws)
    dispatcher.get_overload = lambda signature: part().get_overload(signature)


_ONE_AT_A_TIME = threading.RLock()


def watch_before_compiling(dispatcher):
    """Let a dispatcher's first compilation, or load from disk, begin with `watch_compilation`."""
    compile_it = dispatcher.compile

    def watched(signature):
        watch_compilation()
        return compile_it(signature)

    dispatcher.compile = watched


def jit(function, **options):
    """``function`` compiled at the first call, for the types of its arguments; options of njit.

    All options are stated, since numba would inherit missing ones from the first calling kernel.
    """
    given = {"error_model": "numpy", "nogil": True, "_nrt": True, "forceinline": False, **options}
    dispatcher: Any = numba.njit(**given)(function)
    if hasattr(dispatcher, "_cache"):  # absent under NUMBA_DISABLE_JIT
        # Without a writable folder or readable sources, every process compiles again.
        with suppress(RuntimeError, OSError):
            KernelCache(function).serve(dispatcher)
        watch_before_compiling(dispatcher)
        call_as_part(dispatcher, given)
    return dispatcher


def jit_inline(function):
    """As ``jit``, for a function that allocates no arrays and is called many times a step.

    It is inlined and compiled without reference counting (``_nrt``, not public in numba): passing
    arrays takes as long as one iteration for a few bodies.
    """
    return jit(function, _nrt=False, forceinline=True)


def jit_noalloc(function):
    """As ``jit_inline``, but not inlined: for long functions, or those with many callers."""
    return jit(function, _nrt=False)


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
