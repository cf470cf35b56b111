"""Numbers of two doubles, trigonometry, differences."""

from __future__ import annotations

import math
from decimal import Decimal, localcontext
from fractions import Fraction

import mpmath as mp
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from galvi.extended_precision import decimals
from references.closed_forms.double_double import DIGITS, PI, DoubleDouble, angle, sine_cosine
from references.closed_forms.pendulum import Modulus, first_integral
from references.closed_forms.top_motion import principal_axes
from references.forces import force

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


def test_arrays_on_the_left_leave_the_work_to_the_pair():
    third = DoubleDouble(1.0) / 3.0
    left = np.array([3.0, 6.0]) * third
    assert isinstance(left, DoubleDouble)
    assert left.hi.tolist() == [1.0, 2.0]
    assert (1.0 - third).hi == 2.0 / 3.0


def test_a_decimal_keeps_its_first_32_digits():
    pi = Decimal("3.14159265358979323846264338327950288419716939937510")
    near = DoubleDouble.nearest(pi)
    assert abs(whole(near) - Fraction(pi)) < EPS * 4
    assert near.lo != 0.0


def test_the_first_step_is_a_sixteenth_of_the_scale_and_each_further_one_half_of_it():
    asked = []
    force.derivative(lambda x: asked.append(x) or math.exp(x), 3.0)
    assert asked[::2] == [3.0 / 16.0 / 2.0**k for k in range(force.ROWS)]
    assert asked[1::2] == [-x for x in asked[::2]]


@pytest.mark.parametrize("power", [3, 5, 7])
def test_each_extrapolation_removes_a_power_of_the_step(monkeypatch, power):
    """Two rows on which a column is exact agree, and that column is taken."""
    monkeypatch.setattr(force, "ROWS", (power + 3) // 2)
    assert force.derivative(lambda x: x**power + x, 1.0) == pytest.approx(1.0, abs=1e-15)


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


def test_pi_and_the_corners_of_angle():
    assert gap(PI, mp.pi) < 1e-99
    half = [(Decimal(1), Decimal(0), PI / 2), (Decimal(0), Decimal(-1), PI)]
    for y, x, expected in [*half, (Decimal(0), Decimal(0), Decimal(0))]:
        assert gap(angle(y, x), in_digits(expected)) < 1e-78


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


def test_on_the_separatrix_the_functions_are_hyperbolic():
    modulus = Modulus(Decimal(1), Decimal(0))
    for u in ("0", "0.3", "-20"):
        sn, cn, dn = modulus.functions(Decimal(u))
        assert gap(sn, mp.tanh(mp.mpf(u))) < 1e-70
        assert cn == dn and gap(cn, mp.sech(mp.mpf(u))) < 1e-70
    with pytest.raises(ZeroDivisionError):
        _ = modulus.quarter


def test_the_first_integral_is_carlsons():
    for args in (("1", "2", "3"), ("0", "0.5", "1"), ("1e-20", "1e-40", "1"), ("0", "1e-48", "1")):
        true = mp.elliprf(*map(mp.mpf, args))
        assert gap(first_integral(*map(Decimal, args)), true) < 1e-70


@pytest.mark.parametrize(
    "matrix",
    [
        [[3, 0.4, 0.2], [0.4, 2.5, -0.3], [0.2, -0.3, 3.4]],
        [[2, 0.5, 0.5], [0.5, 2, 0.5], [0.5, 0.5, 2]],
        [[2, 1e-14, 0], [1e-14, 2, 0], [0, 0, 1]],
    ],
)
def test_principal_axes_diagonalise(matrix):
    J = decimals(np.array(matrix, dtype=np.float64))
    moments, axes = principal_axes(J)
    assert list(moments) == sorted(moments)
    for left, right in ((axes.T @ axes, np.eye(3)), (axes.T @ J @ axes, np.diag(moments))):
        assert max(abs((left - decimals_of(right)).ravel())) < Decimal("1e-76")


def decimals_of(matrix):
    return matrix if matrix.dtype == object else decimals(matrix)


def test_principal_axes_of_a_diagonal_matrix_are_exactly_its_own():
    moments, axes = principal_axes(decimals(np.diag([3.0, 1.0, 2.0])))
    assert list(moments) == [1, 2, 3]
    assert np.array_equal(axes.astype(float), np.eye(3)[:, [1, 2, 0]])
