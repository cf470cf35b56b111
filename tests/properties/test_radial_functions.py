"""The functions of the angle that charts are made of, against mpmath, and their series."""

import mpmath as mp
import numpy as np
import pytest

from galvi.charts import CHARTS
from galvi.kernels.lie import dispatch
from galvi.kernels.lie.charts import exponential
from galvi.kernels.lie.groups import so2
from tests.properties.angles import CAYLEY, DECADES, EXPONENTIAL, RODRIGUES, each_size

# the angle of a rotation with |xi| = x, and its derivative
ANGLES = {
    CAYLEY: (lambda x: 2 * mp.atan(x / 2), lambda x: 1 / (1 + x * x / 4)),
    EXPONENTIAL: (lambda x: x, lambda x: mp.mpf(1)),
    RODRIGUES: (lambda x: 4 * mp.atan(x / 4), lambda x: 1 / (1 + x * x / 16)),
}


def exact_radial(chart, u):
    """(sine, cosine), (a, b, c) and (k, d) of galvi.kernels.lie.charts, in mpmath."""
    x = mp.sqrt(u)
    angle, slope = (function(x) for function in ANGLES[chart])
    sine, cosine = mp.sin(angle) / x, (1 - mp.cos(angle)) / u
    k = x / 2 * mp.cot(angle / 2)
    return (sine, cosine), (sine, cosine, (slope - sine) / u), (k, (1 / slope - k) / u)


def slope_of_radial(chart, u, order):
    """The derivatives of a, b and c by u, of order ``order``."""
    return [mp.diff(lambda x, i=i: exact_radial(chart, x)[1][i], u, order) for i in range(3)]


@each_size
def test_the_functions_of_the_angle_are_exact_to_a_few_units(chart, size):
    u = float(size) ** 2
    with mp.workdps(60):
        exact = mp.mpf(u)
        rotation, tangent, inverse = exact_radial(chart, exact)
        first, second = (slope_of_radial(chart, exact, order) for order in (1, 2))
    value, slope, second_slope = dispatch.tangent_radial(chart.number, u)
    differences_cancel = size > 5.0 and chart == EXPONENTIAL
    for computed, expected, tolerance in (
        (
            dispatch.rotation_radial(chart.number, u),
            rotation,
            4e-15,
        ),  # 1.4e-15, 2e-16 below 5
        (value, tangent, 1e-15),  # 3e-16
        (
            dispatch.inverse_radial(chart.number, u),
            inverse,
            1e-13 if differences_cancel else 4e-15,
        ),  # 4e-14, 1e-15 of 1 - u d
        (slope, first, 2e-15),  # 6e-16
        (second_slope, second, 1e-14),  # 4e-15
    ):
        numbers = np.array(expected, dtype=float)
        assert np.allclose(computed, numbers, rtol=0.0, atol=tolerance * np.max(np.abs(numbers)))


@each_size
def test_quaternions_and_plane_angles_are_those_of_the_angle(chart, size):
    number = chart.number
    with mp.workdps(60):
        x = mp.mpf(size)
        angle, slope = (function(x) for function in ANGLES[chart])
        half = mp.cos(angle / 2), mp.sin(angle / 2)
        second_slope = mp.diff(ANGLES[chart][1], x)
    sine_over_size, cosine_less_1 = dispatch.half_turn(number, float(size) ** 2)
    assert sine_over_size * size == pytest.approx(float(half[1]), rel=1e-15, abs=1e-15)
    assert cosine_less_1 == pytest.approx(float(half[0] - 1), rel=1e-14)
    expected = float(angle), float(slope), float(second_slope)
    assert (
        dispatch.angle_of(number, size),
        *so2.slopes(number, float(size)),
    ) == (pytest.approx(expected, rel=1e-14))
    if expected[0] < 3.0:
        assert dispatch.coordinate_of(number, expected[0]) == pytest.approx(size, rel=1e-14)
        factor = dispatch.from_quaternion(number, *map(float, half))
        assert factor * float(half[1]) == pytest.approx(size, rel=1e-14)


def test_a_series_with_too_few_terms_is_seen_at_the_switch(monkeypatch):
    u = exponential.LARGEST_SERIES_U * (1.0 - 1e-15)
    full = np.array(exponential.stumpff(u))
    monkeypatch.setattr(exponential, "STUMPFF_TERMS", 5)
    wrong = np.array(exponential.stumpff(u))
    beyond = np.array(exponential.stumpff(exponential.LARGEST_SERIES_U))
    assert np.max(np.abs(full - beyond) / full) < 1e-13  # 1.4e-14, in c7
    assert np.max(np.abs(wrong - beyond) / full) > 1e-10


@pytest.mark.parametrize("chart", CHARTS, ids=lambda chart: type(chart).__name__)
@pytest.mark.parametrize("fraction", [0.0, *(s / 2 for s in DECADES), 0.7, 0.86, 0.9999999, 1.0])
def test_the_functions_for_lanes_are_exact_as_far_as_they_are_used(chart, fraction):
    module = dispatch.CHARTS[chart.number]
    u = (fraction * module.LARGEST_IN_LANES) ** 2
    with mp.workdps(150):
        x = mp.mpf(u) or mp.mpf(10) ** -30
        _, tangent, inverse = exact_radial(chart, x)
    lanes = np.array(u)  # an array, so that the series for lanes is used
    computed = np.array([float(x) for x in (*module.tangent(lanes)[0], *module.inverse(lanes))])
    # 5e-16 in sin(x) / x; 2e-16 otherwise
    exact = np.array([*tangent, *inverse], dtype=float)
    assert np.allclose(computed, exact, rtol=2e-15, atol=1e-40)


def test_a_series_for_lanes_that_is_shorter_is_caught(monkeypatch):
    assert exponential.LARGEST_IN_LANES == 2.0
    full = float(exponential.stumpff(np.array(4.0))[0])
    assert abs(full / (np.sin(2.0) / 2.0) - 1.0) < 1e-15
    monkeypatch.setattr(exponential, "LANE_SERIES", [x[:-4] for x in exponential.LANE_SERIES])
    assert abs(float(exponential.stumpff(np.array(4.0))[0]) / full - 1.0) > 1e-14
