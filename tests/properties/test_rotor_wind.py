"""The wind of the descending rotor: a stated field, checked against its stream function."""

import mpmath as mp
import numpy as np
import pytest

from galvi.kernels.forces import rotor_wind as kernel
from galvi.kernels.forces.rotor_wind import CORE, DOWNWASH, HIGH, SHARES, STRENGTH, R

PLACES = np.random.default_rng(5).uniform([-15, -15, 0, 0], [15, 15, 20, 4], (12, 4))


def wind(x, y, z, t):
    return kernel.rotor_wind((x, y, z), kernel.decay(t))


def off():
    """How far the wind is from the curl of its stream function."""

    def stream(r, z, t):
        height = kernel.LOW + (HIGH - kernel.LOW) * mp.exp(-t / kernel.DESCENT)
        total = mp.mpf(0)
        for share in SHARES:
            for zeta, sign in ((z - share * height, 1), (z + share * height, -1)):
                inner = (r - R) ** 2 + zeta**2 + mp.mpf(CORE) ** 2
                outer = (r + R) ** 2 + zeta**2 + mp.mpf(CORE) ** 2
                total += sign * STRENGTH * r**2 / (inner * outer) ** mp.mpf(0.75)
        return total

    worst = 0.0
    with mp.workdps(40):
        for x, y, z, t in PLACES.tolist():
            r = mp.hypot(x, y)
            out = -mp.diff(lambda s, r=r, t=t: stream(r, s, t), z) / r
            up = mp.diff(lambda s, z=z, t=t: stream(s, z, t), r) / r
            exact = [float(out * x / r), float(out * y / r), float(up)]
            worst = max(worst, np.max(np.abs(np.array(wind(x, y, z, t)) - exact)))
    return worst


def test_the_wind_is_the_curl_of_its_stream_function():
    assert off() < 1e-12  # 2e-14


def test_a_ring_with_a_digit_wrong_is_caught(monkeypatch):
    """It has divergence."""

    def ring(square, zeta):
        P = square + R * R + zeta * zeta + CORE * CORE
        B = P * P - 4.0 * R * R * square
        scale = B**0.25 / (B * B)
        return P * zeta * scale, (2.0 * B - 3.0 * square * (P - 2.001 * R * R)) * scale

    monkeypatch.setattr(kernel, "ring", ring)
    assert off() > 1e-4


def test_no_wind_goes_through_the_ground_and_the_images_are_why():
    rng = np.random.default_rng(6)
    for x, y, t in rng.uniform([-20, -20, 0], [20, 20, 5], (100, 3)):
        assert wind(x, y, 0.0, t)[2] == 0.0
    assert abs(kernel.ring(25.0, -4.0)[1] * STRENGTH) > 1.0  # one ring alone does blow through it


def test_far_away_a_ring_is_that_of_biot_and_savart_and_on_the_axis_with_its_core():
    for zeta in (0.0, -3.0, 40.0):
        spread, rise = kernel.ring(0.0, zeta)
        assert rise == pytest.approx(2.0 * (R**2 + zeta**2 + CORE**2) ** -1.5, rel=1e-13)
        assert np.isfinite(spread)
    rho, zeta = 3e4, 4e4  # a dipole: psi = r^2 / s^3
    spread, rise = kernel.ring(rho**2, zeta)
    s = np.hypot(rho, zeta)
    assert spread == pytest.approx(zeta / s**5, rel=1e-6)
    assert rise == pytest.approx(2.0 / s**3 - 3.0 * rho**2 / s**5, rel=1e-6)


def test_the_downwash_at_the_hub_is_the_one_stated_and_the_rotor_descends():
    alone = sum(STRENGTH * kernel.ring(0.0, (1.0 - s) * HIGH)[1] for s in SHARES)
    assert alone == pytest.approx(-DOWNWASH, rel=1e-14)
    heights = [kernel.rotor_height(kernel.decay(t)) for t in (0.0, 1.0, 2.0, 50.0)]
    assert heights[0] == HIGH and np.all(np.diff(heights) < 0.0)
    assert heights[-1] == pytest.approx(kernel.LOW, rel=1e-9)


def test_on_the_axis_the_wind_is_exactly_vertical():
    assert wind(0.0, 0.0, 7.0, 1.0)[:2] == (0.0, 0.0)
