"""Numbers of two doubles, trigonometry, differences."""

from __future__ import annotations

from decimal import Decimal, localcontext
from fractions import Fraction

import mpmath as mp
import pytest
from hypothesis import given
from hypothesis import strategies as st

from references.closed_forms.double_double import DIGITS, DoubleDouble, angle, sine_cosine
from references.closed_forms.pendulum import Modulus, first_integral

EPS = 2.0**-102
part = st.floats(-1e60, 1e60).filter(lambda x: abs(x) > 1e-60)
number = st.tuples(part, st.floats(-1.0, 1.0)).map(
    lambda x: DoubleDouble(x[0], x[0] * x[1] * 2.0**-54)
)


def whole(x: DoubleDouble) -> Fraction:
    return Fraction(x.hi) + Fraction(x.lo)


@given(number, number)
def test_each_operation_is_right_to_32_digits(a, b):
    size = abs(whole(a)) + abs(whole(b))
    assert abs(whole(a + b) - (whole(a) + whole(b))) <= EPS * abs(whole(a) + whole(b)) + EPS * (
        size / 2**100
    )
    assert whole(a - b) == whole(a + (-b))
    product, quotient = whole(a) * whole(b), whole(a) / whole(b)
    assert abs(whole(a * b) - product) <= EPS * abs(product)
    assert abs(whole(a / b) - quotient) <= 2 * EPS * abs(quotient)


COMPLEMENTS = ["1", "0.999999999999", "0.5", "1e-3", "1e-12", "1e-30", "1e-48"]


@pytest.fixture(autouse=True)
def extended_precision():
    with localcontext(DIGITS), mp.workdps(160):
        yield


def in_digits(x: Decimal) -> mp.mpf:
    return mp.mpf(str(x))


def gap(found: Decimal, true: mp.mpf) -> float:
    return float(abs(in_digits(found) - true) / max(1, abs(true)))


@pytest.mark.parametrize("x", ["0", "1e-30", "0.785", "-2", "3.1415926", "100", "-1e9", "1e15"])
def test_sine_cosine_and_angle_have_seventy_digits(x):
    x = Decimal(x)
    sine, cosine = sine_cosine(x)
    # 7e-66 was measured for the last, which 15 digits of the angle cost; 5e-80 for the first five
    allowed = 1e-78 * (1 + abs(float(x)))
    assert gap(sine, mp.sin(in_digits(x))) < allowed and gap(cosine, mp.cos(in_digits(x))) < allowed
    assert gap(angle(sine, cosine), mp.atan2(in_digits(sine), in_digits(cosine))) < 1e-78


@pytest.mark.parametrize("complement", COMPLEMENTS)
def test_the_functions_are_jacobis_up_to_the_separatrix(complement):
    modulus = Modulus(1 - Decimal(complement), Decimal(complement))
    m = in_digits(modulus.square)
    if m:
        assert gap(modulus.nome, mp.qfrom(m=m)) < 1e-70
    assert gap(modulus.quarter, mp.ellipk(m)) < 1e-70
    for u in ("0", "1e-20", "0.3", "-1.7", "5", "-40", "1000"):
        found = modulus.functions(Decimal(u))
        for name, value in zip(("sn", "cn", "dn"), found, strict=True):
            true = mp.ellipfun(name, mp.mpf(u), m=m)
            assert gap(value, true) < 1e-74, (name, u)  # 3e-77
        sn, cn, dn = found
        back = sn * first_integral(cn * cn, dn * dn, Decimal(1))
        halves = modulus.halves(Decimal(u))
        near = Decimal(u) - 2 * halves * modulus.quarter
        even = 1 if halves % 2 == 0 else -1
        assert gap(even * back, in_digits(near)) < 1e-60  # 2e-65
