"""The parts of numba beyond its public interface that galvi uses; only this folder imports them.

Vector code is generated with the builders of ``cgutils``. galvi.kernels.compile.parts compiles
kernels, and galvi.kernels.compile.cache stores them, with the classes below.
"""

from numba.core import cgutils, errors, event
from numba.core.caching import FunctionCache
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import CompilerBase, DefaultPassBuilder, Flags
from numba.core.compiler_machinery import PassManager, register_pass
from numba.core.imputils import impl_ret_new_ref
from numba.core.registry import cpu_target
from numba.core.serialize import dumps
from numba.core.typed_passes import NativeLowering

__all__ = [
    "CompilerBase", "DefaultPassBuilder", "Flags", "FunctionCache", "JITCodeLibrary",
    "NativeLowering", "PassManager", "cgutils", "cpu_target", "dumps", "errors", "event",
    "impl_ret_new_ref", "register_pass",
]  # fmt: skip
