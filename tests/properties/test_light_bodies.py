"""Light and massless bodies in a clock: truths in quadruple precision, and the restricted problem
of three bodies."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import galvi
from galvi.lanes.clocks.rows import COLUMNS, PACE, TURN
from galvi.run.clocked import in_lanes as clock_stepper
from references.rebound.ias15 import IAS15
from references.stored.encounters import THIRD_BODIES, third_body
from references.stored.planets import STORED_TRUTH
from tests.properties.clock_problems import DYNAMICAL, method

pytestmark = pytest.mark.skipif(not galvi.FAST, reason="the general kernel alone has none")
MU, DURATION = 0.1, 10.0


@pytest.fixture
def light_below() -> Iterator[Callable[[float], None]]:
    """Sets the share of the second largest mass below which a body is light."""

    def change(share: float) -> None:
        patch.setattr(clock_stepper, "LIGHT", share)
        forget()

    def forget() -> None:
        clock_stepper.masses_in_clock.cache_clear()
        clock_stepper._motion.cache_clear()

    with pytest.MonkeyPatch.context() as patch:
        yield change
    forget()


def error(mass: float, step: float) -> float:
    run = galvi.integrate(third_body(mass), method(8, DYNAMICAL), step, duration=20.0)
    truth = STORED_TRUTH.run(third_body(mass), 20.0, {"samples": 1})
    return float(np.max(np.abs(run.q[-1] - truth.q[-1]))) if run.success else np.inf


@pytest.mark.parametrize("mass", THIRD_BODIES.values())
def test_a_third_body_of_any_mass_is_as_near_to_the_truth_as_any_way_lets_it(
    mass: float, light_below: Any
) -> None:
    rounding = 1e-13  # of places and velocities over 34 revolutions
    ours = [error(mass, step) for step in (0.4, 0.3)]
    tried = []
    for share in (0.0, 2.0):  # none is light, or all but the heaviest
        light_below(share)
        tried += [error(mass, step) for step in (0.4, 0.3)]
    assert max(ours) < max(10.0 * min(tried), rounding)


def test_a_third_body_that_felt_the_rounding_of_the_energy_would_be_seen(light_below: Any) -> None:
    light_below(0.0)
    assert error(1e-6, 0.3) > 1e-12
    assert error(1e-9, 0.3) == np.inf


def moon(mass: float, e: float = 0.9) -> galvi.Problem:
    """A star, a planet of 1e-3 on a circle, and its moon, at its farthest, 0.01 away."""
    masses, share = np.array([1.0, 1e-3, mass]), 0.01 * (1.0 + e)
    speed = np.sqrt((masses[1] + mass) / 0.01 * (1.0 - e) / (1.0 + e))
    q = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0 - share, 0.0, 0.0]])
    v = np.array([[0.0, 0.0, 0.0], [0.0, np.sqrt(1.001), 0.0], [0.0, np.sqrt(1.001) - speed, 0.0]])
    return at_rest(galvi.NBody(masses), q, v)


def at_rest(system: galvi.NBody, q: Any, v: Any) -> galvi.Problem:
    """The problem in a frame in which the centre of mass rests in the origin."""
    share = system.masses / system.masses.sum()
    return galvi.Problem(system, q - share @ q, v - share @ v)


def by_ias15(problem: galvi.Problem, duration: float, **options: Any) -> Any:
    """Places at the end, relative to the first body."""
    run = IAS15.run(problem, duration, {"samples": 1, **options})
    return run.q[-1] - run.q[-1, 0]


BOOSTS = [3.0 * sign * axis for axis in np.eye(3) for sign in (1.0, -1.0)]
MASSES = (1e-3, 1e-5, 1e-6, 1e-9, 0.0)
REVOLUTION = 2.0 * np.pi * np.sqrt(0.01**3 / 1e-3)


@pytest.mark.parametrize("mass", MASSES)
def test_a_moon_of_any_mass_moves_alike_in_every_inertial_frame_and_keeps_momentum(
    mass: float,
) -> None:
    """A hundred revolutions of a moon of e = 0.9: 1.8 units wrong where a light body felt no term
    of H - E0 and its planet did, so that momentum was lost and the error grew a hundredfold a
    revolution."""
    start, duration = moon(mass), 100.0 * REVOLUTION
    clock, ends = method(8, DYNAMICAL), []
    for boost in (np.zeros(3), *BOOSTS):
        moved = galvi.Problem(start.system, start.q0, start.v0 + boost)
        run = galvi.integrate(moved, clock, 0.3, duration=duration)
        assert run.success, run.status
        ends.append(run.q[-1] - run.q[-1, 0])
        momentum = galvi.linear_momentum(run)
        scale = np.max(np.abs(run.p).sum(axis=1))
        assert np.max(np.abs(momentum - momentum[0])) < 1e-14 * scale
    assert max(np.max(np.abs(end - ends[0])) for end in ends) < 1e-11  # 2e-13
    assert np.max(np.abs(ends[0] - by_ias15(start, duration))) < 3e-11  # 6e-12


def faulty(masses_of: Any) -> Any:
    """The planted fault: the term of a pair acts on its heavy body alone."""

    def masses(*given: Any) -> Any:
        pairs, *others = masses_of(*given)
        columns = pairs.reshape(-1, COLUMNS).copy()
        columns[:, TURN] = columns[:, PACE]
        return columns.ravel(), *others

    return masses


def test_a_term_on_one_body_of_a_pair_is_caught(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(clock_stepper, "masses_in_clock", faulty(clock_stepper.masses_in_clock))
    start, ends = moon(1e-9), []
    clock_stepper._motion.cache_clear()
    for boost in (np.zeros(3), BOOSTS[0]):
        moved = galvi.Problem(start.system, start.q0, start.v0 + boost)
        run = galvi.integrate(moved, method(8, DYNAMICAL), 0.3, duration=4.0 * REVOLUTION)
        ends.append(run)
    clock_stepper._motion.cache_clear()
    momentum = galvi.linear_momentum(ends[0])
    assert np.nanmax(np.abs(momentum - momentum[0])) > 1e-10
    assert not all(run.success for run in ends) or (
        np.max(np.abs((ends[0].q[-1] - ends[0].q[-1, 0]) - (ends[1].q[-1] - ends[1].q[-1, 0])))
        > 1e-6
    )


def test_the_sun_the_earth_and_the_moon_over_ten_years() -> None:
    """It ended within days, or was half an astronomical unit wrong."""
    sun = galvi.NBody([1.0, 3.0034896e-6, 3.694303e-8])
    q = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0 + 0.00257, 0.0, 0.00023]])
    v = np.array([[0.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 1.0 + 0.0342, 0.0]])
    start, duration = at_rest(sun, q, v), 20.0 * np.pi
    run = galvi.integrate(start, method(8, DYNAMICAL), 0.3, duration=duration)
    assert run.success, run.status
    error = np.max(np.abs(run.q[-1] - run.q[-1, 0] - by_ias15(start, duration)))
    assert error < 1e-11, error  # 3e-13


@pytest.mark.slow(beside="test_a_third_body_of_any_mass_is_as_near_to_the_truth_as_any_way_lets_it")
def test_a_planet_in_kozai_lidov_cycles_is_where_ias15_has_it() -> None:
    """Two equal stars and a planet of 1e-3 or 0: 0.16 wrong after 13,500 years, silently."""
    pi2 = 4.0 * np.pi**2
    far, tilt = 30.0, np.radians(80.0)
    speed = np.sqrt(2.001 / far)
    for mass in (1e-3, 0.0):
        system = galvi.NBody([1.0, mass, 1.0], G=pi2)
        way = np.array([0.0, np.cos(tilt), np.sin(tilt)])
        q = np.array([[0.0, 0.0, 0.0], [0.0, 1.01, 0.0], [far, 0.0, 0.0]])
        v = 2.0 * np.pi * np.array([[0.0, 0.0, 0.0], [-0.99, 0.0, 0.0], speed * way])
        start = at_rest(system, q, v)
        run = galvi.integrate(start, method(8, DYNAMICAL), 0.3, duration=3000.0, save_every=1000)
        assert run.success, run.status
        error = np.max(np.abs(run.q[-1] - run.q[-1, 0] - by_ias15(start, 3000.0)))
        assert error < 1e-7, (mass, error)


def restricted(n: int) -> galvi.Problem:
    """Two bodies on circles, and n massless ones about the heavier."""
    r, angle = np.linspace(0.2, 0.5, n), 2.4 * np.arange(n)
    way = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    turn = np.stack([-np.sin(angle), np.cos(angle)], axis=1)
    speed = np.sqrt((1.0 - MU) / r)[:, None]
    q = np.concatenate([[[-MU, 0.0], [1.0 - MU, 0.0]], r[:, None] * way - [MU, 0.0]])
    v = np.concatenate([[[0.0, -MU], [0.0, 1.0 - MU]], speed * turn - [0.0, MU]])
    return galvi.Problem(galvi.NBody([1.0 - MU, MU, *np.zeros(n)]), q, v)


def jacobi(run: galvi.Trajectory, v: Any) -> Any:
    """Jacobi's constant of each massless body at each state, (saved, n)."""
    q, v = run.q[:, 2:], v[:, 2:]
    far, near = (np.linalg.norm(q - run.q[:, k : k + 1], axis=-1) for k in (0, 1))
    turn = q[..., 0] * v[..., 1] - q[..., 1] * v[..., 0]
    return 0.5 * np.sum(v * v, axis=-1) - (1.0 - MU) / far - MU / near - turn


def pull(t: float, y: Any) -> Any:
    """The restricted problem: the two bodies on their circles."""
    q = y.reshape(2, -1, 2)[0]
    way = np.array([np.cos(t), np.sin(t)])
    gaps = q + MU * way, q - (1.0 - MU) * way
    one, other = (gap / np.sum(gap**2, axis=1, keepdims=True) ** 1.5 for gap in gaps)
    return np.concatenate([y[y.size // 2 :], (-(1.0 - MU) * one - MU * other).ravel()])


@pytest.mark.slow(beside="test_orbits_of_the_restricted_problem_are_where_ias15_has_them")
def test_a_hundred_particles_in_one_clock_keep_jacobis_constant_and_follow_the_restricted_problem(
) -> None:  # fmt: skip
    problem = restricted(100)
    run = galvi.integrate(problem, method(8, DYNAMICAL), 0.4, duration=DURATION)
    assert run.success
    constant = jacobi(run, run.v)
    off = np.max(np.abs(constant - constant[0]), axis=0)
    assert np.median(off) < 1e-11 and off.max() < 1e-8
    start = np.concatenate([problem.q0[2:].ravel(), problem.v0[2:].ravel()])
    end = solve_ivp(pull, (0.0, DURATION), start, method="DOP853", rtol=1e-12, atol=1e-13).y[:, -1]
    apart = np.max(np.abs(run.q[-1, 2:] - end.reshape(2, -1, 2)[0]), axis=1)
    assert np.median(apart) < 1e-9 and apart.max() < 1e-6


def test_particles_do_not_change_each_other_in_one_clock() -> None:
    problem = restricted(20)
    whole = galvi.integrate(problem, method(8, DYNAMICAL), 0.4, duration=DURATION)
    for k in (2, 9, 21):
        rows = [0, 1, k]
        system = galvi.NBody([1.0 - MU, MU, 0.0])
        alone = galvi.Problem(system, problem.q0[rows], problem.v0[rows])
        run = galvi.integrate(alone, method(8, DYNAMICAL), 0.4, duration=DURATION)
        assert np.max(np.abs(run.q[-1, 2] - whole.q[-1, k])) < 1e-11


def in_space(mu: float, q: Any, v: Any) -> galvi.Problem:
    """A massless body of the circular restricted problem, from places and velocities in its
    rotating frame at time 0."""
    turn = np.array([-q[1], q[0], 0.0])
    places = np.array([[-mu, 0.0, 0.0], [1.0 - mu, 0.0, 0.0], q])
    rates = np.array([[0.0, -mu, 0.0], [0.0, 1.0 - mu, 0.0], np.asarray(v) + turn])
    return galvi.Problem(galvi.NBody([1.0 - mu, mu, 0.0]), places, rates)


# Of the Earth and the Moon. Arenstorf's orbit as in Hairer, Norsett, Wanner, Solving ODEs I, II.0,
# whose period is 17.0652165601579625588917206249; a near-rectilinear halo orbit like the Gateway's
RESTRICTED = {
    "Arenstorf": (
        0.012277471, [0.994, 0.0, 0.0], [0.0, -2.00158510637908252240537862224, 0.0],
        17.0652165601579625588917206249,
    ),
    "near-rectilinear halo": (
        0.0121505856, [1.0213448959, 0.0, -0.1816295024], [0.0, -0.1017681053, 0.0], 6.0,
    ),
    "Sitnikov": (0.5, [0.0, 0.0, 1.2], [0.0, 0.0, 0.3], 60.0),
}  # fmt: skip


@pytest.mark.parametrize("name", RESTRICTED)
def test_orbits_of_the_restricted_problem_are_where_ias15_has_them(name: str) -> None:
    *start, duration = RESTRICTED[name]
    problem = in_space(*start)
    run = galvi.integrate(problem, method(8, DYNAMICAL), 0.1, duration=duration)
    assert run.success, run.status
    off = np.max(np.abs(run.q[-1] - run.q[-1, 0] - by_ias15(problem, duration)))
    assert off < 1e-9, off


def test_arenstorfs_orbit_closes() -> None:
    """In the rotating frame: errors grow about a hundred thousandfold on the way."""
    mu, q, v, period = RESTRICTED["Arenstorf"]
    run = galvi.integrate(in_space(mu, q, v), method(8, DYNAMICAL), 0.1, duration=period)
    back = np.array([[np.cos(period), np.sin(period)], [-np.sin(period), np.cos(period)]])
    assert np.max(np.abs(back @ run.q[-1, 2, :2] - q[:2])) < 1e-9
