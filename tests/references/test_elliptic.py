"""Circular and elliptic functions of decimals against mpmath with 160 digits."""

from __future__ import annotations

from decimal import Decimal, localcontext

import mpmath as mp
import numpy as np
import pytest

from galvi.extended_precision import decimals
from references.closed_forms.double_double import DIGITS, PI, angle, sine_cosine
from references.closed_forms.pendulum import Modulus, first_integral
from references.closed_forms.top_motion import principal_axes

COMPLEMENTS = ["1", "0.999999999999", "0.5", "1e-3", "1e-12", "1e-30", "1e-48"]


@pytest.fixture(autouse=True)
def extended_precision():
    with localcontext(DIGITS), mp.workdps(160):
        yield


def exact(x: Decimal) -> mp.mpf:
    return mp.mpf(str(x))


def gap(found: Decimal, true: mp.mpf) -> float:
    return float(abs(exact(found) - true) / max(1, abs(true)))


@pytest.mark.parametrize("x", ["0", "1e-30", "0.785", "-2", "3.1415926", "100", "-1e9", "1e15"])
def test_sine_cosine_and_angle_have_seventy_digits(x):
    x = Decimal(x)
    sine, cosine = sine_cosine(x)
    # 7e-66 was measured for the last, which 15 digits of the angle cost; 5e-80 for the first five
    allowed = 1e-78 * (1 + abs(float(x)))
    assert gap(sine, mp.sin(exact(x))) < allowed and gap(cosine, mp.cos(exact(x))) < allowed
    assert gap(angle(sine, cosine), mp.atan2(exact(sine), exact(cosine))) < 1e-78


def test_pi_and_the_corners_of_angle():
    assert gap(PI, mp.pi) < 1e-99
    half = [(Decimal(1), Decimal(0), PI / 2), (Decimal(0), Decimal(-1), PI)]
    for y, x, expected in [*half, (Decimal(0), Decimal(0), Decimal(0))]:
        assert gap(angle(y, x), exact(expected)) < 1e-78


@pytest.mark.parametrize("complement", COMPLEMENTS)
def test_the_functions_are_jacobis_up_to_the_separatrix(complement):
    modulus = Modulus(1 - Decimal(complement), Decimal(complement))
    m = exact(modulus.square)
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
        assert gap(even * back, exact(near)) < 1e-60  # 2e-65


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
