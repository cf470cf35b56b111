"""Exact curves in Cayley's chart, and up to which n Galerkin curves are as good as step ends."""

from __future__ import annotations

import math

import numpy as np
import pytest

from benchmarks.claims.lie_groups.cayley_curve import cayley_rate, distance_of_polynomials, turned
from benchmarks.claims.lie_groups.curves_and_ends import NS, crossing
from galvi.arrays import Array


def turn_about(axis: Array, angles: Array) -> Array:
    """Rotations (k, 3, 3) by Rodrigues' formula."""
    x, y, z = axis / np.linalg.norm(axis)
    hat = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    sines, versines = np.sin(angles)[:, None, None], (1.0 - np.cos(angles))[:, None, None]
    return np.eye(3) + sines * hat + versines * (hat @ hat)


@pytest.mark.parametrize("angle", [0.3, 2.9, 3.1, 3.2, 5.0])
def test_a_turn_is_followed_beyond_pi(angle: float) -> None:
    path = turn_about(np.array([1.0, -2.0, 0.5]), np.linspace(0.0, angle, 161))
    assert turned(path) == pytest.approx(angle, abs=1e-12)  # 1e-15 was measured


def test_polynomials_are_as_far_from_a_steady_turn_as_its_pole_says() -> None:
    """n r^-n, with r of Bernstein's ellipse through the pole, which in xi' is a double one."""
    axis, angle, step = np.array([0.6, 0.0, 0.8]), 2.8, 0.6
    t = np.linspace(0.0, angle, 401)
    path, omega = turn_about(axis, t), np.tile(axis * angle / step, (401, 1))
    xi, rate = cayley_rate(path, omega)
    assert np.allclose(xi, 2.0 * np.tan(0.5 * t)[:, None] * axis, rtol=1e-12)
    assert np.allclose(rate, (angle / step / np.cos(0.5 * t) ** 2)[:, None] * axis, rtol=1e-12)
    away = 2.0 * np.pi / angle - 1.0
    r = away + np.sqrt(away**2 - 1.0)
    found = [distance_of_polynomials(path, omega, degree) for degree in (11, 13)]
    assert found[0] / found[1] == pytest.approx(11 / 13 * r**2, rel=0.05)  # 0.5 % was measured


def test_n_star_is_where_the_curve_s_own_error_is_that_of_the_ends() -> None:
    """2^(n - 6.25) is 1 at n = 6.25; there is no n* where it is below or above 1 for all n."""
    excess = 2.0 ** (np.array(NS) - 6.25)
    assert crossing(excess) == pytest.approx(6.25, abs=1e-12)
    assert crossing(4.0 * excess) == pytest.approx(4.25, abs=1e-12)
    for none in (
        1e3 * excess,
        1e-3 * excess,
        np.where(excess < 1.0, -1.0, excess),
        math.nan * excess,
    ):
        assert math.isnan(crossing(none))
