"""Functions that kernels call, compiled as parts of them and no further.

numba makes machine code of every function that another one calls, optimised with all that it calls
in turn, as if it were called from Python too. Without that a kernel of three hundred functions
takes half as long to compile and runs as fast.
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
# Leave numba as it is: no parts, and its own cache.
PLAIN = environ.get("GALVI_PLAIN_NUMBA", "0") == "1"


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


def public(options):
    """Those of numba's options that are public: without the leading underscore."""
    return {name: value for name, value in options.items() if not name.startswith("_")}


def as_part(options):
    """The options of njit for a part."""
    if PLAIN:
        return public(options)
    part_options = {
        "pipeline_class": PartCompiler,
        "no_cpython_wrapper": True,
        "no_cfunc_wrapper": True,
    }
    return {**options, **part_options}


def call_as_part(dispatcher, options):
    """Let functions that call a jitted one compile it as a part; calls from Python as before."""

    @cache
    def part():
        return numba.njit(**as_part(options))(dispatcher.py_func)

    dispatcher.get_call_template = lambda args, kws: part().get_call_template(args, kws)
    dispatcher.get_overload = lambda signature: part().get_overload(signature)
