"""Extent and orientation of a known ellipse."""

from __future__ import annotations

import math

import numpy as np
import pytest

import galvi
from benchmarks.measures import orbit_shape
from references.closed_forms.kepler import KEPLER

ECCENTRICITY = 0.2


def planet() -> galvi.Problem:
    """A light body about a star, from its pericentre on the x axis, a = GM = 1."""
    speed = math.sqrt((1.0 + ECCENTRICITY) / (1.0 - ECCENTRICITY))
    return galvi.Problem(
        galvi.NBody([1.0 - 1e-9, 1e-9]),
        [[0.0, 0.0, 0.0], [1.0 - ECCENTRICITY, 0.0, 0.0]],
        [[0.0, 0.0, 0.0], [0.0, speed, 0.0]],
    )


def test_period_extent_and_perihelion_of_an_ellipse() -> None:
    problem = planet()
    assert orbit_shape.period(problem, 1) == pytest.approx(math.tau)
    run = KEPLER.run(problem, 3 * math.tau, {"samples": 300})
    closest, farthest = orbit_shape.extent(run.t, run.q, 1, 1.0, 1.0 + math.tau)
    assert closest == pytest.approx(1.0 - ECCENTRICITY, abs=1e-5)
    assert farthest == pytest.approx(1.0 + ECCENTRICITY, abs=1e-5)
    vector = orbit_shape.perihelion(run, 1)
    assert vector == pytest.approx(np.tile([ECCENTRICITY, 0.0, 0.0], (301, 1)), abs=1e-12)


def test_angles_are_accurate_when_tiny_and_when_right() -> None:
    x = np.array([1.0, 0.0, 0.0])
    assert orbit_shape.angle(x, np.array([1.0, 1e-9, 0.0])) == pytest.approx(1e-9)
    assert orbit_shape.angle(x, np.array([0.0, 0.0, 2.0])) == pytest.approx(0.5 * math.pi)
