"""The start of the solar system against the ephemeris it came from."""

from __future__ import annotations

from importlib import resources

import numpy as np
import pytest

import galvi
from references.jpl import states as jpl

BODIES = (
    *("Sun", "Mercury", "Venus", "Earth", "Mars"),
    *("Jupiter", "Saturn", "Uranus", "Neptune", "Pluto"),
)
DATA = resources.files("galvi") / "problems" / "data" / "solar_system.csv"


def test_the_stored_file_is_what_its_command_writes():
    if jpl.missing():
        pytest.skip(jpl.missing())
    stored, made = DATA.read_text("ascii").splitlines(), jpl.table(jpl.ephemeris()).splitlines()
    assert len(stored) == len(made)
    for old, new in zip(stored, made, strict=True):
        if "," not in old or old.startswith(("#", "body")):
            assert old == new
            continue
        assert old.split(",")[0] == new.split(",")[0]
        numbers = [np.array([float(x) for x in line.split(",")[1:]]) for line in (old, new)]
        np.testing.assert_allclose(*numbers, rtol=1e-14)  # sums may be ordered otherwise elsewhere


def test_the_problem_holds_the_file_to_the_last_digit():
    problem = galvi.problems.solar_system()
    rows = np.genfromtxt(DATA.read_text("ascii").splitlines()[6:], delimiter=",", skip_header=1)
    assert np.array_equal(problem.system.masses, rows[:, 1])
    assert np.array_equal(problem.q0, rows[:, 2:5]) and np.array_equal(problem.v0, rows[:, 5:])
    assert problem.parameters["bodies"] == BODIES
    assert problem.system.G == 1.0 and "au^3/day^2" in problem.units


def test_without_pluto_there_are_nine_bodies():
    problem = galvi.problems.solar_system(pluto=False)
    assert problem.q0.shape == (9, 3) and problem.parameters["bodies"] == BODIES[:-1]


def test_the_planets_are_where_almanacs_have_them():
    problem = galvi.problems.solar_system()
    masses, q, v = problem.system.masses, problem.q0, problem.v0
    distance = np.linalg.norm(q[1:] - q[0], axis=1)
    known = [0.466, 0.720, 0.983, 1.391, 4.965, 9.184, 19.924, 30.121, 30.223]  # au, 2000-01-01
    np.testing.assert_allclose(distance, known, atol=1e-3)
    semi_axis = 1.0 / (
        2.0 / distance - np.sum((v[1:] - v[0]) ** 2, axis=1) / (masses[0] + masses[1:])
    )
    mean = [0.3871, 0.7233, 1.0000, 1.5237, 5.203, 9.54, 19.19, 30.07, 39.5]  # Standish, J2000
    np.testing.assert_allclose(semi_axis, mean, rtol=0.01)
    ratio = masses[0] / masses[1:]  # IAU 1976-2009
    inverse = [6.0236e6, 408523.7, 328900.56, 3098708, 1047.3486, 3497.9, 22903, 19412.2, 1.36e8]
    np.testing.assert_allclose(ratio, inverse, rtol=2e-3)
    gauss = 0.01720209895**2
    np.testing.assert_allclose(masses[0], gauss, rtol=1e-9)


def test_the_barycentre_is_at_rest_at_the_origin_but_for_what_is_left_out():
    problem = galvi.problems.solar_system()
    total = np.sum(problem.system.masses)
    centre = problem.system.masses @ problem.q0 / total
    drift = np.sum(problem.p0, axis=0) / total
    assert np.linalg.norm(centre) < 1e-8  # au; 2e-9: asteroids and relativity
    assert np.linalg.norm(drift) < 1e-10  # au / day; 7e-12
