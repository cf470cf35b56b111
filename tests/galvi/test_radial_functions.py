"""The functions of the angle that charts are made of, against mpmath, and their series."""

import mpmath as mp
import numpy as np
import pytest

from galvi.kernels.lanes import body_formulas
from galvi.kernels.lanes.values import polynomial
from galvi.kernels.lie import chart_coefficients
from tests.galvi.angles import CAYLEY, DECADES, EXPONENTIAL, each_size


def exact_radial(chart, u):
    """(sine, cosine), (a, b, c) and (k, d) of galvi.kernels.lie.chart_coefficients, in mpmath."""
    if chart == CAYLEY:
        a = 1 / (1 + u / 4)
        return (a, a / 2), (a, a / 2, mp.mpf(0)), (1 + u / 4, mp.mpf(1) / 4)
    x = mp.sqrt(u)
    c1, c2 = mp.sin(x) / x, (1 - mp.cos(x)) / u
    return (c1, c2), (c1, c2, (1 - c1) / u), (mp.mpf(1), (1 - x / 2 * mp.cot(x / 2)) / u)


def slope_of_radial(chart, u, times):
    """Derivatives by u of a, b and c."""
    return [mp.diff(lambda x, i=i: exact_radial(chart, x)[1][i], u, times) for i in range(3)]


@each_size
def test_the_functions_of_the_angle_are_exact_to_a_few_units(chart, size):
    u = float(size) ** 2
    with mp.workdps(60):
        exact = mp.mpf(u)
        rotation, turn, inverse = exact_radial(chart, exact)
        first, second = (slope_of_radial(chart, exact, times) for times in (1, 2))
    value, slope, bend = chart_coefficients.tangent_radial(chart.number, u)
    near = size > 5.0 and chart == EXPONENTIAL
    for mine, expected, close in (
        (
            chart_coefficients.rotation_radial(chart.number, u),
            rotation,
            4e-15,
        ),  # 1.4e-15, 2e-16 below 5
        (value, turn, 1e-15),  # 3e-16
        (
            chart_coefficients.inverse_radial(chart.number, u),
            inverse,
            1e-13 if near else 1e-15,
        ),  # 4e-14, 2e-16
        (slope, first, 2e-15),  # 6e-16
        (bend, second, 1e-14),  # 4e-15
    ):
        numbers = np.array(expected, dtype=float)
        assert np.allclose(mine, numbers, rtol=0.0, atol=close * np.max(np.abs(numbers)))


def test_a_series_with_too_few_terms_is_seen_at_the_switch(monkeypatch):
    u = chart_coefficients.SMALL * (1.0 - 1e-15)
    sound = np.array(chart_coefficients.stumpff.py_func(u))
    assert np.array_equal(sound, chart_coefficients.stumpff(u))
    monkeypatch.setattr(chart_coefficients, "TERMS", 5)
    wrong = np.array(chart_coefficients.stumpff.py_func(u))
    beyond = np.array(chart_coefficients.stumpff(chart_coefficients.SMALL))
    assert np.max(np.abs(sound - beyond) / sound) < 1e-13  # 1.4e-14, in c7
    assert np.max(np.abs(wrong - beyond) / sound) > 1e-10


@pytest.mark.parametrize("u", [0.0, *(s * s for s in DECADES), 2.0, 3.0, 3.999999, 4.0])
def test_the_packed_series_are_exact_as_far_as_they_are_used(u):
    assert body_formulas.REACHES[1] == 2.0
    with mp.workdps(150):
        x = mp.mpf(u) or mp.mpf(10) ** -30
        _, turn, inverse = exact_radial(EXPONENTIAL, x)
        slope = mp.diff(lambda y: exact_radial(EXPONENTIAL, y)[2][1], x)
        rest = (inverse[1] - mp.mpf(1) / 12) / x
    k, d, dk, dd = body_formulas._inverse_terms(2, u)
    assert (k, dk) == (1.0, 0.0)
    found = np.array(
        [*body_formulas._tangent_terms(2, u), d, dd, polynomial(body_formulas.E_TERMS, u)]
    )
    exact = np.array([*turn, inverse[1], slope, rest], dtype=float)
    # 7e-16 in dd, a difference; 5e-16 in sin(x) / x; 2e-16 otherwise
    assert np.max(np.abs(found / exact - 1.0)) < 2e-15


def test_a_packed_series_that_is_shorter_is_caught():
    shorter = polynomial(body_formulas.E_TERMS[:-4], 4.0)
    assert abs(shorter / polynomial(body_formulas.E_TERMS, 4.0) - 1.0) > 1e-13
