"""1 / x and 1 / sqrt(x) of eight numbers, from the processor's estimates where it has them.

To about 1 ulp, which is enough inside of a step: AVX-512 estimates to 2^-14, and one correction of
fourth order replaces a division or a square root, which take several times as long. (To third
order, 6e-13, the outer planets' energy drifts by 1e-18 a step.)
"""

from __future__ import annotations

from llvmlite import ir
from numba.core import cgutils

from galvi.kernels.lanes.values import Lane
from galvi.kernels.lanes.vectors import LANES, NOTHING, VECTOR

FEATURE = "+avx512f"


class Reciprocals:
    """The two functions for the processor that a context compiles for."""

    def __init__(self, context, builder):
        self.builder = builder
        self.fast = FEATURE in context.codegen().magic_tuple()[2].split(",")

    def _estimate(self, name, x):
        byte = ir.IntType(LANES)
        kind = ir.FunctionType(VECTOR, [VECTOR, VECTOR, byte])
        function = cgutils.get_or_insert_function(
            self.builder.module, kind, f"llvm.x86.avx512.{name}14.pd.512"
        )
        return Lane(self.builder, self.builder.call(function, [x.value, NOTHING, byte(-1)]))

    def reciprocal(self, x):
        """1 / x."""
        if not self.fast:
            return 1.0 / x
        y = self._estimate("rcp", x)
        error = 1.0 - x * y
        return y + y * (error + error * error * (1.0 + error))

    def root(self, x):
        """1 / sqrt(x)."""
        if not self.fast:
            return 1.0 / x.call("sqrt")
        y = self._estimate("rsqrt", x)
        error = 1.0 - x * y * y
        return y + y * error * (0.5 + error * (0.375 + 0.3125 * error))
