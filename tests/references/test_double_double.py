"""Arithmetic of twice the precision, against the rationals."""

from __future__ import annotations

from decimal import Decimal
from fractions import Fraction

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from references.closed_forms.double_double import DoubleDouble

EPS = 2.0**-102
part = st.floats(-1e60, 1e60).filter(lambda x: abs(x) > 1e-60)
number = st.tuples(part, st.floats(-1.0, 1.0)).map(
    lambda x: DoubleDouble(x[0], x[0] * x[1] * 2.0**-54)
)


def exact(x: DoubleDouble) -> Fraction:
    return Fraction(x.hi) + Fraction(x.lo)


@given(number, number)
def test_each_operation_is_right_to_32_digits(a, b):
    size = abs(exact(a)) + abs(exact(b))
    assert abs(exact(a + b) - (exact(a) + exact(b))) <= EPS * abs(exact(a) + exact(b)) + EPS * (
        size / 2**100
    )
    assert exact(a - b) == exact(a + (-b))
    product, quotient = exact(a) * exact(b), exact(a) / exact(b)
    assert abs(exact(a * b) - product) <= EPS * abs(product)
    assert abs(exact(a / b) - quotient) <= 2 * EPS * abs(quotient)


def test_arrays_on_the_left_leave_the_work_to_the_pair():
    third = DoubleDouble(1.0) / 3.0
    left = np.array([3.0, 6.0]) * third
    assert isinstance(left, DoubleDouble)
    assert left.hi.tolist() == [1.0, 2.0]
    assert (1.0 - third).hi == 2.0 / 3.0


def test_a_decimal_keeps_its_first_32_digits():
    pi = Decimal("3.14159265358979323846264338327950288419716939937510")
    near = DoubleDouble.nearest(pi)
    assert abs(exact(near) - Fraction(pi)) < EPS * 4
    assert near.lo != 0.0
