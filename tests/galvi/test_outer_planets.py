"""The two problems of the outer planets."""

from __future__ import annotations

import math

import numpy as np

import galvi


def total_energy(problem):
    kinetic = 0.5 * float(np.sum(problem.p0 * problem.v0))
    return kinetic + float(problem.system.potential_energy(problem.q0, np.array(0.0)))


def test_applegate_has_the_published_energy():
    # Msun au^2 / yr365^2; the notebook "Conserving first integrals via manifold projection" of
    # heyoka.py prints it for these masses and this start
    energy = total_energy(galvi.problems.applegate())
    assert math.isclose(energy, -0.004286848855986956, rel_tol=1e-15)  # to the last digit


def test_applegate_is_in_years_of_365_days():
    problem = galvi.problems.applegate()
    assert problem.system.G == 0.01720209895 * 0.01720209895 * 365.0 * 365.0
    mu = problem.system.G * problem.system.masses[0]
    distance = np.linalg.norm(problem.q0[1] - problem.q0[0])
    speed = np.linalg.norm(problem.v0[1] - problem.v0[0])
    period = 2.0 * math.pi * (2.0 / distance - speed**2 / mu) ** -1.5 / math.sqrt(mu)
    assert abs(period - 11.86) < 0.05  # Jupiter
    without_pluto = np.linalg.norm(problem.p0[:-1].sum(axis=0))
    assert without_pluto < 1e-14 * np.linalg.norm(problem.p0[1])  # 7e-16: where the data are from


def test_the_inner_planets_go_into_the_sun_with_all_their_momentum():
    whole, outer = galvi.problems.solar_system(), galvi.problems.outer_solar_system()
    masses, merged = whole.system.masses, outer.system.masses
    assert outer.q0.shape == (6, 3) and outer.parameters["bodies"][1:] == (
        *("Jupiter", "Saturn", "Uranus", "Neptune", "Pluto"),
    )
    assert merged[0] == math.fsum(masses[:5]) and np.array_equal(merged[1:], masses[5:])
    assert np.array_equal(outer.q0[1:], whole.q0[5:]) and np.array_equal(outer.v0[1:], whole.v0[5:])
    moment = whole.system.masses @ whole.q0
    np.testing.assert_allclose(merged @ outer.q0, moment, rtol=0, atol=1e-20)
    np.testing.assert_allclose(outer.p0.sum(axis=0), whole.p0.sum(axis=0), rtol=0, atol=1e-22)
    assert np.linalg.norm(outer.q0[0] - whole.q0[0]) < 1e-5  # au; 3e-6
