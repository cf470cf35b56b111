"""Elementary functions of the numbers in all lanes at once.

Each errs by less than 1 ulp, a hyperbolic one by less than 3. Where an argument is outside the
domain, or too large to be reduced exactly, the result is NaN. tests/properties/
test_lane_functions.py computes the coefficients, in ascending order; a constant of more than one
number is the sum of these.
"""

from __future__ import annotations

import math

from llvmlite import ir

from galvi.kernels.compile.internals import cgutils
from galvi.kernels.constants import LEAST_NORMAL
from galvi.kernels.lie import arithmetic
from galvi.kernels.lie.arithmetic import polynomial
from galvi.lanes.vectors import LANES, VECTOR, ZEROS, has_avx512

# fmt: off
SINE = (  # to 1.2e-20
    -0.16666666666666666, 0.008333333333333331, -0.00019841269841265063, 2.7557319219337312e-06,
    -2.5052106231802837e-08, 1.6058531516797758e-10, -7.586691094197958e-13,
)
COSINE = (  # to 6.4e-22
    0.041666666666666664, -0.0013888888888888887, 2.4801587301584645e-05, -2.755731922140179e-07,
    2.0876755790721963e-09, -1.1470460830795304e-11, 4.7458685530816656e-14,
)
EXPONENTIAL = (  # to 1.7e-20
    0.5, 0.16666666666666666, 0.04166666666666668, 0.008333333333333333, 0.0013888888888879073,
    0.00019841269841263298, 2.4801587336442236e-05, 2.755731924721873e-06, 2.75572632790885e-07,
    2.505207109429355e-08, 2.0918137737642736e-09, 1.608662795678037e-10,
)
LOGARITHM = (  # to 1.9e-18
    0.4, 0.28571428571429364, 0.22222222221655885, 0.18181818335392802, 0.1538459496251843,
    0.1333480469384731, 0.11706236339491206, 0.11723178623876518,
)
ARCTANGENT = (  # to 1.2e-18
    -0.3333333333333333, 0.19999999999999804, -0.14285714285659779, 0.11111111105150588,
    -0.09090908753259112, 0.07692296368042296, -0.0666642476020052, 0.05878927554473807,
    -0.05230443640686948, 0.045515447340221615, -0.03456931506332609, 0.016284375050043393,
)
HALF_PI = (1.5707963267948966, 6.123233995736766e-17)
QUARTER_TURN = (1.5707963267341256, 6.077100506506192e-11, 3.5215598651832e-27)
LOG_2 = (0.6931471805598903, 5.4979230187085024e-14)
TWO_THIRDS = (0.6666666666666666, 3.700743415417188e-17)
# fmt: on


NAN = float("nan")
LARGEST_REDUCED_ANGLE = 1e9  # the nearest multiple of pi / 2 has a factor of at most 30 bits
INTEGER_SHIFT = 1.5 * 2.0**52  # added to a number, leaves its nearest integer in the last bits
LARGEST_FINITE = 1.7976931348623157e308
ROOT_HALF_BITS = 0x3FE6A09E667F3BCD  # bits of sqrt(1/2)
# Minus a quarter of the bits of x, these are nearly the bits of x^(-1/4).
INVERSE_FOURTH_ROOT_BITS = 0x4FEB03126E978C00
INTEGER_SHIFT_BITS = 0x4338000000000000  # bits of INTEGER_SHIFT
SIGN_BIT = -(2**63)
BIAS, MANTISSA = 1023, 52  # of the exponent of a double, and the bits after it
HUGE = 2.0**1000  # larger numbers are scaled: the sum of two may overflow
OVERFLOW, UNDERFLOW = 710.0, -746.0  # exp x is infinite for larger x, and 0 for smaller x
SINH = tuple(1.0 / math.factorial(2 * k + 3) for k in range(9))  # Taylor; the next is 2e-20
TANH_IS_ONE_ABOVE = 20.0
TAN_PI_EIGHTH = 0.41421356237309503  # tan(pi / 8)


def two_sum(x, y):
    """The rounded x + y of lanes and its rounding error; operations on both are not fused."""
    return arithmetic.two_sum(x.exact, y.exact)


def two_product(x, y):
    """The rounded x y of lanes and its rounding error; y may be a number."""
    x = x.exact
    product = x * y
    return product, x.call("fma", y, -product)


def nearest(x):
    """The integer nearest to x, |x| < 2^51, as a lane, and as 64-bit integers of whose bits the
    last ones hold it."""
    shifted = x.exact + INTEGER_SHIFT
    return shifted - INTEGER_SHIFT, shifted.bits


def square_root(x):
    """The square root of a lane; NaN below 0."""
    return x.call("sqrt")


def inverse_fourth_root(x):
    """x^(-1/4) without square roots and divisions; NaN unless x is at least LEAST_NORMAL.

    The bits of a number are nearly linear in its logarithm, so that a quarter of them, subtracted
    from a constant, gives z with e = 1 - x z^4 below 0.124. The root is z (1 - e)^(-1/4), whose
    series in e is used twice.
    """
    quarter = x.builder.lshr(x.bits, x.integers(2))
    z = x.of_bits(x.builder.sub(x.integers(INVERSE_FOURTH_ROOT_BITS), quarter))
    for _ in range(2):
        square = z * z
        e = 1.0 - x * (square * square)
        z = z + z * (e * (0.25 + e * (0.15625 + e * 0.1171875)))
    return z.where(x >= LEAST_NORMAL, NAN)


def sine_cosine(x):
    """(sin x, cos x); NaN where |x| is above LARGEST_REDUCED_ANGLE.

    x = k pi / 2 + r, r as a sum of two, with pi / 2 as a sum of three (Cody and Waite). k times the
    first part has 63 bits, and x less that is exact. The low part of r is small beside what r adds
    to the result, also where it is not small beside r.
    """
    builder = x.builder
    k, bits = nearest(x * (1.0 / HALF_PI[0]))
    first = (-k).call("fma", QUARTER_TURN[0], x)
    second, second_low = two_product(k, QUARTER_TURN[1])
    r, low = two_sum(first, -second)
    r, low = r.fused, low.fused - (second_low + k * QUARTER_TURN[2])
    square = r * r
    half = square * 0.5
    sine = r + (square * r * polynomial(SINE, square) + low * (1.0 - half))
    leading = 1.0 - half.exact
    leading_error = ((1.0 - leading) - half.exact).fused
    cosine = leading.fused + (
        leading_error + (square * square * polynomial(COSINE, square) - r * low)
    )
    odd = x.is_odd(bits)
    swapped_sine, swapped_cosine = cosine.where(odd, sine), sine.where(odd, cosine)
    sign = builder.shl(builder.and_(bits, x.integers(2)), x.integers(62))
    cosine_bits = builder.and_(builder.add(bits, x.integers(1)), x.integers(2))
    cosine_sign = builder.shl(cosine_bits, x.integers(62))
    valid = x.call("fabs") <= LARGEST_REDUCED_ANGLE
    return (
        with_sign(swapped_sine, sign).where(valid, NAN),
        with_sign(swapped_cosine, cosine_sign).where(valid, NAN),
    )


def with_sign(x, sign):
    """x, negated where the highest bit of ``sign`` is set."""
    return x.of_bits(x.builder.xor(x.bits, sign))


def exponential(x):
    """exp x, over the whole range; infinite above 709.78."""
    return _exponential(x, 0.0)


def _exponential(x, low):
    """exp(x + low) for a small correction ``low``, a lane or a number.

    x = k log 2 + r, with log 2 as a sum of two whose first part times k is exact.
    """
    builder = x.builder
    x = x.clipped(UNDERFLOW, OVERFLOW)
    k, bits = nearest(x * (1.0 / LOG_2[0]))
    r, r_low = two_sum(x.exact - k * LOG_2[0], low - k.fused * LOG_2[1])
    r, r_low = r.fused, r_low.fused
    value = 1.0 + (r + (r * r * polynomial(EXPONENTIAL, r) + r_low))
    exponent = builder.sub(bits, x.integers(INTEGER_SHIFT_BITS))
    half = builder.ashr(exponent, x.integers(1))
    return value * _power_of_two(x, half) * _power_of_two(x, builder.sub(exponent, half))


def _power_of_two(x, exponent):
    """2^exponent as a lane, for integers from -1022 to 1023."""
    biased = x.builder.add(exponent, x.integers(BIAS))
    return x.of_bits(x.builder.shl(biased, x.integers(MANTISSA)))


def _split(x):
    """(k, f) with x = 2^k (1 + f) exactly, and 1 + f from sqrt(1/2) to sqrt(2)."""
    builder, bits = x.builder, x.bits
    shifted = builder.sub(bits, x.integers(ROOT_HALF_BITS))
    exponent = builder.ashr(shifted, x.integers(MANTISSA))
    mantissa = builder.sub(bits, builder.shl(exponent, x.integers(MANTISSA)))
    k = x.exact.of_bits(builder.add(exponent, x.integers(INTEGER_SHIFT_BITS))) - INTEGER_SHIFT
    return k.fused, (x.exact.of_bits(mantissa) - 1.0).fused


def logarithm(x):
    """log x; NaN unless x is positive, normal and finite.

    With s = f / (2 + f): log(1 + f) = 2 s + s R = f - (f^2 / 2 - s (f^2 / 2 + R)).
    """
    k, f = _split(x)
    s = f / (2.0 + f)
    square, half = s * s, f * f * 0.5
    series = square * (TWO_THIRDS[0] + square * polynomial(LOGARITHM, square))
    value = k * LOG_2[0] - ((half - (s * (half + series) + k * LOG_2[1])) - f)
    return _where_normal(x, value)


def _where_normal(x, value):
    """The value where x is positive, normal and finite; NaN elsewhere."""
    return value.where((x >= LEAST_NORMAL) & (x <= LARGEST_FINITE), NAN)


def power(x, y):
    """x to the power y, x and y lanes; NaN unless x is positive, normal and finite.

    log x is a sum of two numbers; its error times y stays below one half ulp of the result.
    """
    k, f = _split(x)
    d, d_low = two_sum(f, 2.0 + 0.0 * f)
    s = (f / d).fused
    s_low = (s.call("fma", -d, f) - s * d_low.fused) / d
    z, z_low = two_product(s, s)
    z_low = z_low.fused + 2.0 * s * s_low
    cube, cube_low = two_product(z, s)
    cube_low = cube_low.fused + (z_low * s + z * s_low)
    third, third_low = two_product(cube, TWO_THIRDS[0])
    third_low = third_low.fused + (cube_low * TWO_THIRDS[0] + cube.fused * TWO_THIRDS[1])
    z = z.fused
    tail = z * z * s * polynomial(LOGARITHM, z)
    total, low = two_sum(k * LOG_2[0], 2.0 * s)
    total, lower = two_sum(total, third)
    low = low.fused + lower + (k * LOG_2[1] + (2.0 * s_low + third_low + tail))
    total, low = two_sum(total, low)
    scaled, scaled_low = two_product(total, y)
    scaled_low = scaled_low.fused + low.fused * y
    moderate = scaled.call("fabs") <= 2.0 * OVERFLOW
    return _where_normal(x, _exponential(scaled.fused, scaled_low.where(moderate, 0.0)))


def arctangent(y, x):
    """The angle of the point (x, y), from -pi to pi; NaN at the origin.

    A ratio above tan(pi / 8) is reduced by atan t = pi / 4 + atan((t - 1) / (t + 1)).
    """
    builder = x.builder
    x_size, y_size = x.call("fabs"), y.call("fabs")
    large = (x_size > HUGE) | (y_size > HUGE)
    x_size, y_size = (x_size * 0.25).where(large, x_size), (y_size * 0.25).where(large, y_size)
    steep = y_size > x_size
    minor, major = x_size.where(steep, y_size), y_size.where(steep, x_size)
    is_wide = minor > major * TAN_PI_EIGHTH
    difference, difference_low = two_sum(minor, -major)
    total, total_low = two_sum(minor, major)
    numerator, numerator_low = (
        difference.where(is_wide, minor).fused,
        difference_low.where(is_wide, 0.0).fused,
    )
    denominator, denominator_low = (
        total.where(is_wide, major).fused,
        total_low.where(is_wide, 0.0).fused,
    )
    inverse = 1.0 / denominator
    ratio = numerator * inverse
    error = (-ratio).call("fma", denominator, numerator) + (numerator_low - ratio * denominator_low)
    square = ratio * ratio
    low = ratio * square * polynomial(ARCTANGENT, square) + error * inverse * (1.0 - square)
    is_left = x < 0.0
    eighths = (0.0 * x_size + 1.0).where(is_wide, 0.0)
    eighths = (2.0 - eighths).where(steep, eighths)
    eighths = (4.0 - eighths).where(is_left, eighths)
    is_negative = steep ^ is_left
    ratio, low = (-ratio).where(is_negative, ratio), (-low).where(is_negative, low)
    base_angle, base_angle_low = two_product(eighths, 0.5 * HALF_PI[0])
    value, error = two_sum(base_angle, ratio)
    value = value.fused + (error.fused + base_angle_low.fused + eighths * (0.5 * HALF_PI[1]) + low)
    return with_sign(value, builder.and_(y.bits, y.integers(SIGN_BIT)))


def hyperbolic_sine(x):
    """sinh x; infinite where |x| is above 709.78."""
    square, exponential_x = x * x, exponential(x)
    series = x + x * square * polynomial(SINH, square)
    return series.where(x.call("fabs") < 1.0, 0.5 * exponential_x - 0.5 / exponential_x)


def hyperbolic_cosine(x):
    """cosh x; infinite where |x| is above 709.78."""
    exponential_x = exponential(x)
    return 0.5 * exponential_x + 0.5 / exponential_x


def hyperbolic_tangent(x):
    """tanh x, by sinh x / cosh x."""
    x = x.clipped(-TANH_IS_ONE_ABOVE, TANH_IS_ONE_ABOVE)
    return hyperbolic_sine(x) / hyperbolic_cosine(x)


class Reciprocals:
    """1 / x, 1 / sqrt(x) and x^(-n/4) by the estimates of AVX-512, if the processor that a context
    compiles for has it.

    The error is about 1 ulp, 3 for x^(-7/4), which is enough inside a step. The estimates are
    accurate to 2^-14; one correction of fourth or fifth order replaces a division or a square root,
    which take several times as long. (With one of third order, 6e-13, the energy of the outer
    planets drifts by 1e-18 a step.)
    """

    def __init__(self, context, builder):
        self.builder = builder
        self.has_estimates = has_avx512(context)

    def _estimate(self, name, x):
        byte = ir.IntType(LANES)
        kind = ir.FunctionType(VECTOR, [VECTOR, VECTOR, byte])
        function = cgutils.get_or_insert_function(
            self.builder.module, kind, f"llvm.x86.avx512.{name}14.pd.512"
        )
        return type(x)(self.builder, self.builder.call(function, [x.value, ZEROS, byte(-1)]))

    def reciprocal(self, x):
        """1 / x."""
        if not self.has_estimates:
            return 1.0 / x
        y = self._estimate("rcp", x)
        error = 1.0 - x * y
        return y + y * (error + error * error * (1.0 + error))

    def root(self, x):
        """1 / sqrt(x)."""
        if not self.has_estimates:
            return 1.0 / x.call("sqrt")
        y = self._estimate("rsqrt", x)
        error = 1.0 - x * y * y
        return y + y * error * (0.5 + error * (0.375 + 0.3125 * error))

    def inverse_quarters(self, x, n):
        """x^(-n/4), from the estimates y of 1 / sqrt(x) and of 1 / sqrt(x y)."""
        if not self.has_estimates:
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
