"""Kepler's frame: planets, moons and hierarchies, forces of position, states between steps."""

from __future__ import annotations

from typing import Any

import mpmath as mp
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import galvi
from galvi.frames.hierarchy import number_hierarchy
from galvi.lanes.frames import universal
from references.rebound.ias15 import IAS15
from references.stored.planets import STORED_TRUTH

OUTER = galvi.problems.outer_solar_system()
PLANETS = galvi.problems.solar_system(pluto=False)
FINE = galvi.Galerkin(galvi.Polynomials(8), galvi.gauss(8))


def method(s: int, **options: Any) -> galvi.Galerkin:
    return galvi.Galerkin(galvi.Polynomials(s), galvi.gauss(s), chart=galvi.KeplerFrame(**options))


@given(beta=st.floats(-2.0, 2.0), X=st.floats(-2.5, 2.5))
def test_universal_functions_are_their_series(beta: float, X: float) -> None:
    functions = universal.universal(beta, X, 10, exact=True)
    for n, value in enumerate(functions, start=1):
        terms = (
            (-mp.mpf(beta)) ** k * mp.mpf(X) ** (n + 2 * k) / mp.factorial(n + 2 * k)
            for k in range(40)
        )
        exact = float(sum(terms))
        assert abs(value - exact) <= 4e-15 * abs(X) ** n * np.cosh(abs(beta) ** 0.5 * abs(X)), n
    shifted = universal.shifted(beta, universal.universal(beta, X - 1e-6, 10), 1e-6)
    assert np.allclose(shifted, functions, rtol=1e-13, atol=1e-13)


# ---------------------------------------------------------------- planets


@pytest.mark.parametrize(("even", "tolerance"), [(False, 1e-10), (True, 1e-8)])
def test_planets_are_where_the_stored_truth_has_them(even: bool, tolerance: float) -> None:
    truth = STORED_TRUTH.run(PLANETS, 7_305.0, {"samples": 1}).q[-1]
    run = galvi.integrate(PLANETS, method(16, even=even), 7_305.0 / 183, 183, save_every=183)
    assert run.success and np.max(np.abs(run.q[-1] - truth)) < tolerance  # 1e-11 au


def test_momenta_are_kept_to_rounding_and_the_energy_does_not_drift() -> None:
    """2,670 years of the outer planets."""
    run = galvi.integrate(OUTER, method(8), 400.0, 2_435, save_every=50)
    for values in (galvi.momentum_map(run), galvi.linear_momentum(run)):
        size = np.max(np.abs(run.p)) * max(1.0, float(np.max(np.abs(run.q))))
        assert np.max(np.abs(values - values[0])) < 1e-14 * size  # 1e-15
    energies = galvi.energy(run)
    assert np.max(np.abs(energies / energies[0] - 1.0)) < 1e-14


def test_a_frame_that_never_applies_is_not_replaced() -> None:
    run = galvi.integrate(PLANETS, method(8), 130.0, 10)
    assert run.failed_step == 1 and "inertial_steps" not in run.counts
    assert "the step is 1.48 revolutions of body Mercury, more than the Kepler frame" in run.status
    assert np.all(np.isnan(run.q[1:]))


# ---------------------------------------------------------------- hierarchies


def with_moon() -> galvi.Problem:
    """The Sun, Venus, the Earth, the Moon on an invented orbit, and Jupiter."""
    rows = [0, 2, 3, 3, 5]
    masses, q, v = (
        PLANETS.system.masses[rows],
        PLANETS.q0[rows].copy(),
        PLANETS.v0[rows].copy(),
    )
    pair_mass, mass_fraction = masses[2], 1.0 / 82.3
    relative_position = 0.00257 * np.array([0.6, 0.78, 0.09])
    relative_velocity = np.sqrt(pair_mass / 0.00257) * np.array([-0.79, 0.61, 0.05])
    masses[2:4] = (1.0 - mass_fraction) * pair_mass, mass_fraction * pair_mass
    q[2:4] += [-mass_fraction * relative_position, (1.0 - mass_fraction) * relative_position]
    v[2:4] += [-mass_fraction * relative_velocity, (1.0 - mass_fraction) * relative_velocity]
    names = ["Sun", "Venus", "Earth", "Moon", "Jupiter"]
    return galvi.Problem(galvi.NBody(masses), q, v, parameters={"bodies": names})


MOON = with_moon()
TREE = ("Sun", "Venus", ("Earth", "Moon"), "Jupiter")
OBLATE = (
    galvi.Oblateness(2, 0.02, 5e-4, pole=(0.3, 0.2, 0.9)),
    galvi.Oblateness(0, 2e-4, 4.65e-2, pole=(0.1, 0.0, 1.0)),
    galvi.Relativity(173.14463, form="potential"),
)


@pytest.mark.parametrize("forces", [(), OBLATE], ids=["gravity", "oblate"])
def test_energy_and_momenta_of_the_moon_do_not_drift(forces: Any) -> None:
    """The planet's J2 moves the Moon by 8e-5 in 100 days."""
    system = galvi.NBody(MOON.system.masses, forces=forces)
    moon = galvi.Problem(system, MOON.q0, MOON.v0, parameters=MOON.parameters)
    run = galvi.integrate(moon, method(8, hierarchy=TREE), 4.0, 3_000, save_every=100)
    energies = galvi.energy(run)
    assert np.ptp(energies) < 1e-13 * abs(energies[0])  # 4e-15
    angular_momenta, momenta = galvi.momentum_map(run), galvi.linear_momentum(run)
    assert forces or np.max(np.abs(angular_momenta - angular_momenta[0])) < 1e-13 * np.max(
        np.abs(angular_momenta[0])
    )
    assert np.max(np.abs(momenta - momenta[0])) < 1e-13 * np.max(np.abs(run.p))


def test_a_moon_about_its_planet_takes_fewer_passes_than_as_a_planet() -> None:
    numbers = [np.int64(0), 1, [2, 3], 4]
    nested, without_hierarchy = (
        galvi.integrate(MOON, method(16, hierarchy=tree), 5.0, 20) for tree in (numbers, None)
    )
    assert nested.status == "Completed."
    assert without_hierarchy.counts["iterations"] > 1.5 * nested.counts["iterations"]


def test_massless_bodies_join_by_their_distance_from_the_first_barycentre() -> None:
    """The pair's barycentre is at 0.18, not halfway at 1: the body at 3.5 is beyond that at -3."""
    q = np.array([[0.0, 0.0], [2.0, 0.0], [-3.0, 0.0], [3.5, 0.0], [2.7, 0.0]])
    v = np.array([[0.0, 0.0], [0.0, 0.7], [0.0, -0.6], [0.0, 0.5], [0.0, 0.6]])
    problem = galvi.Problem(galvi.NBody([1.0, 0.1, 0.01, 0.0, 0.0]), q, v)
    assert number_hierarchy(problem, ((0, 1), 2)) == (((0, 1), 4, 2, 3), "")


# ---------------------------------------------------------------- forces


def one_planet(force: Any, e: float) -> galvi.Problem:
    """A planet at the pericentre of an orbit of semi-major axis 1 about a mass of 1."""
    velocity = np.sqrt((1.0 + e) / (1.0 - e)) * np.array([0.0, np.cos(0.4), np.sin(0.4)])
    q, v = [[0.0, 0.0, 0.0], [1.0 - e, 0.0, 0.0]], [[0.0, 0.0, 0.0], velocity]
    return galvi.Problem(galvi.NBody([1.0, 1e-9], forces=force), q, v)


def test_steps_where_what_is_left_is_too_strong_are_done_elsewhere() -> None:
    """A comet from its apocentre, which an oblate star bends where it is near."""
    problem = one_planet(galvi.Oblateness(0, 0.1, 0.1), 0.8)
    outbound = galvi.integrate(problem, FINE, 0.01, 314)
    comet = galvi.Problem(problem.system, outbound.q[-1], outbound.v[-1])
    run = galvi.integrate(comet, method(8), 0.05, 150)
    truth = galvi.integrate(comet, FINE, 0.00125, 6_000, save_every=40)
    assert run.success and 0 < run.counts["inertial_steps"] < 15
    assert np.max(np.abs(run.q - truth.q)) < 1e-11  # 1e-13
    times = np.linspace(0.0, 7.5, 60)
    assert np.max(np.abs(run(times) - truth(times))) < 1e-7


def test_two_bodies_with_a_force_are_not_exact_at_any_step() -> None:
    """Without a force they are exact; with one the series of the iteration limit the step."""
    problem = one_planet(galvi.Oblateness(0, 1e-3, 0.01), 0.9)
    run = galvi.integrate(problem, method(8), 7.0, 2)
    assert not run.success and "revolutions of body" in run.status
    pair = galvi.Problem(galvi.NBody([1.0, 1e-9]), problem.q0, problem.v0)
    assert galvi.integrate(pair, method(8), 7.0, 2).success


# ---------------------------------------------------------------- states between steps


@pytest.mark.parametrize("steps", [1, 7])
def test_states_a_bit_of_time_after_kept_ones_are_those(steps: int) -> None:
    problem = galvi.Problem(
        galvi.NBody([1.0, 1e-6], forces=galvi.Oblateness(0, 1e-3, 0.1)),
        [[0, 0, 0], [0.8, 0, 0.3]],
        [[0, 0, 0], [0.1, 0.5, 0]],
    )
    run = galvi.integrate(problem, method(8), 0.03, 42, save_every=steps)
    q, p = galvi.states_at(run, np.nextafter(run.t[:-1], np.inf))
    assert np.allclose(q, run.q[:-1], rtol=0, atol=1e-14)
    assert np.allclose(p, run.p[:-1], rtol=0, atol=1e-19)  # of 3e-6


def test_states_in_steps_that_the_frame_refuses_to_begin_are_not_those_before() -> None:
    """An oblate star has made the orbit more eccentric than the frame takes at a start."""
    run = galvi.integrate(one_planet(galvi.Oblateness(0, 0.005, 0.2), 0.9), method(8), 0.9, 8)
    times = run.t[6:8] + 0.45
    q = galvi.states_at(run, times)[0]
    assert "inertial_steps" not in run.counts
    assert np.max(np.abs(q - run(times))) < 1e-5  # 6e-8


# A meteoroid that passes the Earth at 26,000 km with 8.5 km/s at t = 24.5 days
METEOROID = galvi.Problem(
    galvi.NBody([1.0, 3.003e-6, 0.0], 0.01720209895**2),
    [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.054739257525, -0.018119104481, 0.104431693901]],
    [
        [0.0, 0.0, 0.0],
        [0.0, 0.01720212477893, 0.0],
        [-0.00248197063638, 0.01785420576982, -0.00402509261234],
    ],
)


def test_states_and_events_of_a_run_through_a_passage_are_numbers_and_right() -> None:
    """Some of its states were NaN, and the event ended with a ValueError."""
    run = galvi.integrate(METEOROID, method(8), 1.0, duration=60.0)
    passage = slice(40, 60)  # of half days
    q, p = galvi.states_at(run, np.linspace(0.0, 60.0, 121)[passage])
    truth = IAS15.run(METEOROID, 60.0, {"samples": 120}).q[passage]
    assert run.counts["inertial_steps"] and np.all(np.isfinite(p))
    assert np.max(np.abs(q - truth)) < 1e-7  # 2e-14
    events = galvi.find_events(run, galvi.events.closest_approach(1, 2))
    at_passage = IAS15.run(METEOROID, float(events.t[0]), {"samples": 1})
    gap, speed = (x[-1, 2] - x[-1, 1] for x in (at_passage.q, at_passage.v))
    assert len(events) == 1 and events.value[0] == pytest.approx(np.linalg.norm(gap), rel=1e-5)
    assert abs(gap @ speed) < 1e-3 * np.linalg.norm(gap) * np.linalg.norm(speed)


@pytest.mark.parametrize("step", [20.0, 5.0])
def test_states_of_a_run_that_does_not_resolve_a_passage_are_numbers(step: float) -> None:
    run = galvi.integrate(METEOROID, method(8), step, duration=60.0)
    assert run.success
    assert all(np.all(np.isfinite(x)) for x in galvi.states_at(run, np.linspace(0.0, 60.0, 19)))
