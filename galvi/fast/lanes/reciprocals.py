"""1 / x, 1 / sqrt(x) and x^(-n/4) of eight numbers, from the processor's estimates if it has them.

To about 1 ulp, 3 for x^(-7/4), enough inside of a step: AVX-512 estimates to 2^-14, and one
correction of fourth or fifth order replaces a division or a square root, which take several times
as long. (To third order, 6e-13, the outer planets' energy drifts by 1e-18 a step.)
"""

from __future__ import annotations

from llvmlite import ir
from numba.core import cgutils

from galvi.fast.lanes.functions import inverse_fourth_root
from galvi.fast.lanes.values import Lane
from galvi.fast.lanes.vectors import LANES, NOTHING, VECTOR, has_avx512


class Reciprocals:
    """The three functions for the processor that a context compiles for."""

    def __init__(self, context, builder):
        self.builder = builder
        self.fast = has_avx512(context)

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

    def quarters(self, x, n):
        """x^(-n/4), from the estimates y of 1 / sqrt(x) and of 1 / sqrt(x y)."""
        if not self.fast:
            return inverse_fourth_root(x).power_by_products(2 * n)
        y = self._estimate("rsqrt", x * self._estimate("rsqrt", x))
        error = 1.0 - x * y.power_by_products(8)  # below 4e-4
        coefficients = [1.0]  # of (1 - error)^(-n/4)
        for k in range(1, 5):
            coefficients.append(coefficients[-1] * (0.25 * n + k - 1.0) / k)
        factor = coefficients.pop()
        for coefficient in reversed(coefficients):
            factor = coefficient + error * factor
        return y.power_by_products(2 * n) * factor
