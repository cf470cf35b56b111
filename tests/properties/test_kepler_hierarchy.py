"""Kepler's frame with a hierarchy of the user's: moons, pairs of pairs, massless bodies."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import galvi
from galvi.frames.hierarchy import hierarchy_of, jacobi, nested_in

EARTH = 3
PLANETS = galvi.problems.solar_system(pluto=False)
NAMES = PLANETS.parameters["bodies"]


def with_moon() -> galvi.Problem:
    """The Sun, Venus, the Earth, the Moon and Jupiter, the Moon's orbit about the Earth made up."""
    kept = [0, 2, EARTH, EARTH, 5]
    masses, q, v = PLANETS.system.masses[kept], PLANETS.q0[kept].copy(), PLANETS.v0[kept].copy()
    whole, share = masses[2], 1.0 / 82.3
    gap = 0.00257 * np.array([0.6, 0.78, 0.09])
    pace = np.sqrt(whole / 0.00257) * np.array([-0.79, 0.61, 0.05])
    masses[2:4] = (1.0 - share) * whole, share * whole
    q[2:4] += [-share * gap, (1.0 - share) * gap]
    v[2:4] += [-share * pace, (1.0 - share) * pace]
    names = ["Sun", "Venus", "Earth", "Moon", "Jupiter"]
    return galvi.Problem(galvi.NBody(masses), q, v, parameters={"bodies": names})


MOON = with_moon()
TREE = ("Sun", "Venus", ("Earth", "Moon"), "Jupiter")


def method(s: int, hierarchy: Any, **given: Any) -> galvi.Galerkin:
    frame = galvi.KeplerFrame(hierarchy=hierarchy, **given)
    return galvi.Galerkin(galvi.Polynomials(s), galvi.gauss(s), chart=frame)


def in_inertial_frame(problem: galvi.Problem, step: float, steps: int) -> Any:
    plain = galvi.Galerkin(galvi.Polynomials(12), galvi.gauss(12))
    return galvi.integrate(problem, plain, step, steps)


def test_the_moon_goes_round_in_steps_of_days() -> None:
    """100 days in steps of 5 against the inertial frame in steps of 1; the Moon's period is 27."""
    true = in_inertial_frame(MOON, 1.0, 100)
    run = galvi.integrate(MOON, method(16, TREE), 5.0, 20)
    assert run.status == "Completed." and np.max(np.abs(run.q - true.q[::5])) < 1e-13  # 5e-15
    times = np.linspace(0.0, 100.0, 31)
    assert np.max(np.abs(run(times) - true(times))) < 1e-12
    alone = galvi.Galerkin(galvi.Polynomials(16), galvi.gauss(16), chart=galvi.KeplerFrame())
    other = galvi.integrate(MOON, alone, 5.0, 20)  # the Moon as a planet
    assert other.counts["iterations"] > 1.5 * run.counts["iterations"]


def test_energy_and_momenta_of_the_moon_do_not_drift() -> None:
    run = galvi.integrate(MOON, method(8, TREE), 4.0, 9_000, save_every=100)
    energies = galvi.energy(run)
    assert np.ptp(energies) < 1e-13 * abs(energies[0])  # 4e-15
    turning = galvi.momentum_map(run)
    assert np.max(np.abs(turning - turning[0])) < 1e-13 * np.max(np.abs(turning[0]))


def test_a_star_with_planets_is_the_hierarchy_that_is_taken_without_one() -> None:
    planets = tuple(NAMES)
    one, other = (
        galvi.integrate(PLANETS, method(8, given), 20.0, 100) for given in (planets, None)
    )
    assert np.max(np.abs(one.q - other.q)) < 1e-12  # 5e-14


def test_massless_bodies_join_by_their_distance_from_the_first_barycentre() -> None:
    """That of the pair is at 0.18, not halfway at 1: the body at 3.5 is beyond that at -3."""
    q = np.array([[0.0, 0.0], [2.0, 0.0], [-3.0, 0.0], [3.5, 0.0], [2.7, 0.0]])
    v = np.array([[0.0, 0.0], [0.0, 0.7], [0.0, -0.6], [0.0, 0.5], [0.0, 0.6]])
    problem = galvi.Problem(galvi.NBody([1.0, 0.1, 0.01, 0.0, 0.0]), q, v)
    assert nested_in(problem, ((0, 1), 2)) == (((0, 1), 4, 2, 3), "")


@settings(max_examples=25)
@given(seed=st.integers(0, 10_000), bodies=st.integers(2, 6), D=st.integers(2, 3))
def test_jacobis_coordinates_are_canonical(seed: int, bodies: int, D: int) -> None:
    """p dq and the kinetic energy are the same in the pairs of a random tree as in the bodies."""
    random = np.random.default_rng(seed)
    masses, q, v, w = random.uniform(0.1, 2.0, bodies), *random.normal(size=(3, bodies, D))
    parts: list[Any] = list(random.permutation(bodies))
    while len(parts) > 1:
        k = int(random.integers(len(parts) - 1))
        parts[k : k + 2] = [(parts[k], parts[k + 1])]
    problem = galvi.Problem(galvi.NBody(masses, G=1.4), q, v)
    found = hierarchy_of(problem, parts[0])
    mass = found.whole * found.share * (1.0 - found.share)

    def form(x: Any, y: Any) -> float:
        X, Y = (
            np.array(jacobi(problem, found.bodies, found.pairs, z), dtype=float) for z in (x, y)
        )
        centre = 1.4 * np.sum(masses) * X[0] @ Y[0]
        return float(centre + np.sum(mass[:, None] * X[1:] * Y[1:]))

    for x, y in ((v, v), (v, w)):
        assert np.isclose(form(x, y), 1.4 * np.sum(masses[:, None] * x * y), rtol=1e-12, atol=1e-12)
    mass[0] *= 1.0 + 1e-6  # the planted fault: another mass is not canonical
    assert not np.isclose(form(v, v), 1.4 * np.sum(masses[:, None] * v * v), rtol=1e-12)


def test_a_wrong_hierarchy_is_refused_in_words() -> None:
    for wrong in ("Sun", (), ("Sun",), ("Sun", ("Earth",)), (0, 1.5), (0, True), ((0, 1), None)):
        with pytest.raises(ValueError, match="hierarchy must be nested tuples"):
            galvi.KeplerFrame(hierarchy=wrong)
    for tree, words in (
        (("Sun", ("Earth", "Moon"), "Jupiter"), "received one without Venus"),
        ((*TREE, "Moon"), "received one with Moon twice"),
        ((*TREE, "Mars"), r"received one with 'Mars', which is none of \['Sun', 'Venus'"),
        ((0, 1, (2, 3), 5), "received one with 5, which is none of"),
        ((0, 1, (2, -1), 4), "received one with -1"),
    ):
        with pytest.raises(ValueError, match=f"must name every body that has a mass once; {words}"):
            galvi.integrate(MOON, method(4, tree), 1.0, 1)
    masses = np.append(MOON.system.masses[:3], [0.0, 0.0])
    light = galvi.Problem(galvi.NBody(masses), MOON.q0, MOON.v0)
    with pytest.raises(ValueError, match="one that joins 3 and others, all of them massless"):
        galvi.integrate(light, method(4, (0, 1, 2, (3, 4))), 1.0, 1)
    with pytest.raises(ValueError, match="about what its hierarchy names; received one of body"):
        galvi.integrate(MOON, method(4, (("Sun", "Venus", "Earth"), ("Moon", "Jupiter"))), 1.0, 1)
    assert galvi.KeplerFrame(hierarchy=[np.int64(0), [1, 2]]).hierarchy == (0, (1, 2))
