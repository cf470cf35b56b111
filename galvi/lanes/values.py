"""Arithmetic operators on the numbers in a vector: eight, four or one.

A `Lane` wraps an LLVM vector of a function that is being generated. Its sums of products may be
fused, unless it is exact.
"""

from __future__ import annotations

from llvmlite import ir

from galvi.kernels.compile.internals import cgutils
from galvi.lanes import functions
from galvi.lanes.vectors import DOUBLE, FUSED, everywhere, spread

QUARTER_BITS = 6  # powers below 2^6 / 4 are computed by products


class Lane:
    """A vector of doubles, with +, -, * and / by another Lane or a number, and comparisons.

    Parameters
    ----------
    flags
        LLVM flags of its operations: FUSED, or () if their rounding errors are computed

    Attributes
    ----------
    sine_cosine
        (sine, cosine), or None before they are computed
    """

    def __init__(self, builder, value, flags=FUSED):
        self.builder, self.value, self.flags = builder, value, flags
        self.sine_cosine = None

    @property
    def exact(self):
        """The same numbers as a lane whose operations are not fused."""
        return Lane(self.builder, self.value, ())

    @property
    def fused(self):
        """The same numbers as a lane whose sums of products may be fused."""
        return Lane(self.builder, self.value)

    def _lane(self, operand):
        if isinstance(operand, Lane):
            return operand.value
        return everywhere(self.value.type, float(operand))

    def same(self, operand):
        """The operand as a lane: itself, or a number in all lanes of this vector's type."""
        return operand if isinstance(operand, Lane) else self._with_value(self._lane(operand))

    def power_by_products(self, twice):
        """x^(twice / 2) for an integer ``twice``, by products and, if it is odd, a square root."""
        exponent, half = divmod(abs(twice), 2)
        factors = [self.call("sqrt")] if half else []
        square = self
        while exponent:
            factors += [square] if exponent & 1 else []
            exponent >>= 1
            square = square * square if exponent else square
        product = factors[0] if factors else self.same(1.0)
        for factor in factors[1:]:
            product = product * factor
        return 1.0 / product if twice < 0 else product

    def power(self, exponent):
        """x^exponent; the exponent is that of the first lane. x to its nearest multiple of 1/4,
        below 2^QUARTER_BITS / 4, is computed by products and roots; a remainder r by exp(r log
        x)."""
        builder, largest_count = self.builder, DOUBLE(2.0**QUARTER_BITS - 1.0)
        scalar = builder.extract_element(self.same(exponent).value, ir.IntType(32)(0))
        nearest = _call_scalar(builder, "rint", builder.fmul(scalar, DOUBLE(4.0)))
        count = _call_scalar(
            builder, "minnum", _call_scalar(builder, "fabs", nearest), largest_count
        )
        signed = _call_scalar(builder, "copysign", count, scalar)
        remainder = builder.fsub(scalar, builder.fmul(signed, DOUBLE(0.25)))
        pointer = cgutils.alloca_once_value(builder, self.same(1.0).value)
        self._multiply_by_quarters(pointer, builder.fptoui(count, ir.IntType(64)))
        with builder.if_then(builder.fcmp_ordered("<", scalar, DOUBLE(0.0))):
            builder.store((1.0 / self._with_value(builder.load(pointer))).value, pointer)
        with builder.if_then(builder.fcmp_ordered("!=", remainder, DOUBLE(0.0))):
            lane = self._with_value(spread(builder, remainder, self.value.type.count))
            factor = functions.exponential(lane * functions.logarithm(self))
            builder.store((self._with_value(builder.load(pointer)) * factor).value, pointer)
        return self._with_value(builder.load(pointer))

    def _multiply_by_quarters(self, pointer, count):
        """Multiply the numbers at ``pointer`` by x^(count / 4), for a count below
        2^QUARTER_BITS."""
        builder, factor = self.builder, self.call("sqrt")
        for bit in range(QUARTER_BITS):
            if bit > 1:
                factor = self if bit == 2 else factor * factor
            is_set = builder.trunc(builder.lshr(count, count.type(bit)), ir.IntType(1))
            with builder.if_then(is_set):
                power = factor if bit else factor.call("sqrt")
                builder.store((self._with_value(builder.load(pointer)) * power).value, pointer)

    def _with_value(self, value):
        return Lane(self.builder, value, self.flags)

    def __add__(self, other):
        return self._with_value(self.builder.fadd(self.value, self._lane(other), flags=self.flags))

    def __sub__(self, other):
        return self._with_value(self.builder.fsub(self.value, self._lane(other), flags=self.flags))

    def __mul__(self, other):
        return self._with_value(self.builder.fmul(self.value, self._lane(other), flags=self.flags))

    def __truediv__(self, other):
        return self._with_value(self.builder.fdiv(self.value, self._lane(other)))

    def __rtruediv__(self, other):
        return self._with_value(self.builder.fdiv(self._lane(other), self.value))

    def __rsub__(self, other):
        return self._with_value(self.builder.fsub(self._lane(other), self.value, flags=self.flags))

    def __abs__(self):
        return self.call("fabs")

    def __neg__(self):
        return self._with_value(self.builder.fneg(self.value))

    __radd__, __rmul__ = __add__, __mul__

    def _comparison(self, operator, operand, compare="fcmp_ordered"):
        mask = getattr(self.builder, compare)(operator, self.value, self._lane(operand))
        return Truth(self.builder, mask)

    def __gt__(self, other):
        return self._comparison(">", other)

    def __lt__(self, other):
        return self._comparison("<", other)

    def __ge__(self, other):
        return self._comparison(">=", other)

    def __le__(self, other):
        return self._comparison("<=", other)

    def where(self, condition, alternative):
        """These numbers where a `Truth` is true, elsewhere the alternative."""
        return self._with_value(
            self.builder.select(condition.value, self.value, self._lane(alternative))
        )

    def clipped(self, low, high):
        """These numbers, clipped to [low, high]; NaN stays NaN."""
        clipped_below = self.where(self._comparison(">=", low, "fcmp_unordered"), low)
        return clipped_below.where(clipped_below._comparison("<=", high, "fcmp_unordered"), high)

    def call(self, name, *operands):
        """The LLVM intrinsic ``name`` of this lane and the operands, lanes or numbers."""
        values = [self.value, *(self._lane(operand) for operand in operands)]
        kind = self.value.type
        function = cgutils.get_or_insert_function(
            self.builder.module,
            ir.FunctionType(kind, [kind] * len(values)),
            f"llvm.{name}.v{kind.count}f64",
        )
        return self._with_value(self.builder.call(function, values))

    def _integers_of(self, bits):
        return ir.VectorType(ir.IntType(bits), self.value.type.count)

    @property
    def bits(self):
        """The bits of the numbers, 64-bit integers."""
        return self.builder.bitcast(self.value, self._integers_of(64))

    def integers(self, number):
        """A 64-bit integer constant in all lanes."""
        return everywhere(self._integers_of(64), number)

    def is_odd(self, bits):
        """The `Truth` whether each of these integers is odd."""
        return Truth(self.builder, self.builder.trunc(bits, self._integers_of(1)))

    def of_bits(self, bits):
        """The numbers with these bits, as a lane."""
        return self._with_value(self.builder.bitcast(bits, self.value.type))


def _call_scalar(builder, name, *numbers):
    """The LLVM intrinsic ``name`` of scalars."""
    kind = ir.FunctionType(DOUBLE, [DOUBLE] * len(numbers))
    function = cgutils.get_or_insert_function(builder.module, kind, f"llvm.{name}.f64")
    return builder.call(function, numbers)


class Truth:
    """A truth value in each lane, with &, |, ^ and ~."""

    def __init__(self, builder, value):
        self.builder, self.value = builder, value

    def __and__(self, other):
        return Truth(self.builder, self.builder.and_(self.value, other.value))

    def __or__(self, other):
        return Truth(self.builder, self.builder.or_(self.value, other.value))

    def __xor__(self, other):
        return Truth(self.builder, self.builder.xor(self.value, other.value))

    def __invert__(self):
        return Truth(self.builder, self.builder.not_(self.value))

    def select(self, x, y):
        """x where this is true, else y, for lanes or numbers; the lane's operations are not
        fused."""
        kind = ir.VectorType(DOUBLE, self.value.type.count)
        values = [z.value if isinstance(z, Lane) else everywhere(kind, float(z)) for z in (x, y)]
        return Lane(self.builder, self.builder.select(self.value, *values), ())

    @property
    def bits(self):
        """An LLVM integer with one bit for each lane."""
        return self.builder.bitcast(self.value, ir.IntType(self.value.type.count))

    @property
    def any(self):
        """LLVM truth value: true if some lane is true."""
        return self.builder.icmp_unsigned("!=", self.bits, self.bits.type(0))

    @property
    def all(self):
        """LLVM truth value: true if all lanes are true."""
        return self.builder.icmp_unsigned("==", self.bits, self.bits.type(-1))


class LaneTuple:
    """One lane for each of a few planets, so that their long chains of operations run in
    parallel."""

    def __init__(self, lanes):
        self.lanes = tuple(lanes)

    def _lanes_of(self, operand):
        return operand.lanes if isinstance(operand, LaneTuple) else (operand,) * len(self.lanes)

    def map(self, function, *operands):
        """The function applied to the lanes of each planet."""
        columns = (self._lanes_of(operand) for operand in operands)
        return LaneTuple(function(*row) for row in zip(self.lanes, *columns, strict=True))

    def __add__(self, other):
        return self.map(lambda a, b: a + b, other)

    def __sub__(self, other):
        return self.map(lambda a, b: a - b, other)

    def __rsub__(self, other):
        return self.map(lambda a, b: b - a, other)

    def __mul__(self, other):
        return self.map(lambda a, b: a * b, other)

    def __neg__(self):
        return self.map(lambda a: -a)

    def __abs__(self):
        return self.map(abs)

    __radd__, __rmul__ = __add__, __mul__
