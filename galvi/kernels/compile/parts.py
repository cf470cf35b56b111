"""Functions that kernels call, compiled as parts of the kernels and not by themselves.

For every function that a kernel calls, numba makes optimised machine code that could be called from
Python, with all that the function calls. Without that a kernel of three hundred functions takes
half as long to compile and runs as fast.
"""

from __future__ import annotations

from functools import cache
from os import environ

import numba

from galvi.kernels.compile.internals import (
    CompilerBase,
    DefaultPassBuilder,
    Flags,
    JITCodeLibrary,
    NativeLowering,
    PassManager,
    register_pass,
)

if environ.get("GALVI_PLAIN_NUMBA", "0") not in ("0", "1"):
    raise ValueError(
        f"GALVI_PLAIN_NUMBA must be 0 or 1; received {environ['GALVI_PLAIN_NUMBA']!r}."
    )
# Whether numba compiles and caches functions in its usual way.
PLAIN = environ.get("GALVI_PLAIN_NUMBA", "0") == "1"


class PartCode(JITCodeLibrary):
    """LLVM code without optimisation and machine code, which the library it is linked into adds."""

    def _optimize_final_module(self):
        pass

    def _finalize_final_module(self):
        self._finalize_dynamic_globals()
        self._finalized = True


@register_pass(mutates_CFG=True, analysis_only=False)
class PartLowering(NativeLowering):
    """numba's lowering to LLVM code, for a function that is not called by an address."""

    _name = "part_lowering"

    def run_pass(self, state):
        context = state.targetctx
        state.library = PartCode(context.codegen(), state.func_id.func_qualname)
        state.flags.no_compile = True
        super().run_pass(state)
        # numba takes only built-in functions as keys; the method of a new list is a new one.
        key: object = [].append
        context.insert_user_function(key, state.cr.fndesc, [state.library])
        state["cr"] = state.cr._replace(cfunc=key)
        return True


class PartFlags(Flags):
    """numba's Flags, compared by the options that are set.

    numba's comparison reads all options, several times for each operation of a function, which is a
    fifth of the time to compile a kernel.
    """

    __slots__ = ()

    def __hash__(self):
        return hash(frozenset(self._values))

    def __eq__(self, other):
        return isinstance(other, PartFlags) and self._values == other._values


class PartCompiler(CompilerBase):
    """numba's compiler with `PartLowering`, for the option `pipeline_class`."""

    def __init__(self, typing, target, library, args, returned, flags, local):
        super().__init__(typing, target, library, args, returned, PartFlags(flags), local)

    def define_pipelines(self):
        numba_pipeline = DefaultPassBuilder.define_nopython_pipeline(self.state)
        part_pipeline = PassManager("part")
        for step, text in numba_pipeline.passes:
            part_pipeline.add_pass(PartLowering if step is NativeLowering else step, text)
        part_pipeline.finalize()
        return [part_pipeline]


def public_options(options):
    """The options of njit without those whose name has a leading underscore."""
    return {name: value for name, value in options.items() if not name.startswith("_")}


def part_settings(options):
    """The options of njit for a part of a kernel."""
    if PLAIN:
        return public_options(options)
    part_options = {
        "pipeline_class": PartCompiler,
        "no_cpython_wrapper": True,
        "no_cfunc_wrapper": True,
    }
    return {**options, **part_options}


def call_as_part(dispatcher, options):
    """Let jitted functions that call this dispatcher compile it as a part; calls from Python are
    unchanged."""

    @cache
    def part():
        return numba.njit(**part_settings(options))(dispatcher.py_func)

    dispatcher.get_call_template = lambda args, kws: part().get_call_template(args, kws)
    dispatcher.get_overload = lambda signature: part().get_overload(signature)
