"""The reference for grains that meet the ground: closed forms, SciPy's events and heyoka's."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import galvi
from references.newton import acceleration
from references.textbook.grain_flights import landings

G = 9.80665
FAR = 1e6  # m from the axis, where the wind is 1e-13 m/s


def starts(n, seed=4):
    """Positions (n, 3) above the annulus of 5 to 11 m, velocities (n, 3) and times (n,)."""
    random = np.random.default_rng(seed)
    r, angle = random.uniform(5.0, 11.0, n), random.uniform(0.0, 2.0 * np.pi, n)
    q = np.stack([r * np.cos(angle), r * np.sin(angle), random.uniform(0.05, 1.5, n)], axis=1)
    return q, random.normal(size=(n, 3)), random.uniform(0.0, 1.0, n)


def test_a_fall_in_still_air_is_the_textbooks():
    problem = galvi.problems.brownout(200e-6)
    terminal_speed = math.sqrt(float(problem.system.mass) * G / problem.system.force.factor)
    heights = np.array([0.1, 0.5, 2.0])
    q = np.stack([0.0 * heights + FAR, 0.0 * heights, heights], axis=1)
    flights = landings(problem, q, 0.0 * q, 0.0 * heights, 5.0)
    time = terminal_speed / G * np.arccosh(np.exp(G * heights / terminal_speed**2))
    assert np.all(flights.landed) and np.all(flights.q[:, 2] == 0.0)
    np.testing.assert_allclose(flights.t, time, rtol=1e-12)  # 3e-14


def test_a_rebound_leaves_the_ground_with_its_share_of_the_speed():
    problem = galvi.problems.brownout(200e-6)
    terminal_speed = math.sqrt(float(problem.system.mass) * G / problem.system.force.factor)
    time = terminal_speed / G * math.acosh(math.exp(G / terminal_speed**2))
    u = 0.5 * terminal_speed * math.tanh(G * time / terminal_speed)
    rise = terminal_speed / G * math.atan(u / terminal_speed)
    flights = landings(
        problem, [[FAR, 0.0, 1.0]], np.zeros((1, 3)), [0.0], time + rise, restitution=0.5
    )
    top = terminal_speed**2 / (2.0 * G) * math.log(1.0 + (u / terminal_speed) ** 2)
    assert not flights.landed[0]
    assert flights.q[0, 2] == pytest.approx(top, rel=1e-11) and abs(flights.v[0, 2]) < 1e-11


@pytest.mark.slow_cases("0.44")
@pytest.mark.parametrize("coefficient", [0.44, None])
def test_scipys_events_find_the_same_landings(coefficient):
    problem = galvi.problems.brownout(200e-6, drag_coefficient=coefficient)
    q, v, t = starts(5)
    flights, acceleration_at = landings(problem, q, v, t, 3.0), acceleration(problem)

    def ground(t, y):
        return y[2]

    ground.terminal, ground.direction = True, -1.0
    for k in range(5):
        solution = solve_ivp(
            lambda t, y: np.concatenate([y[3:], acceleration_at(y[:3], y[3:], t)]),
            (t[k], 3.0),
            np.concatenate([q[k], v[k]]),
            "DOP853",
            rtol=1e-12,
            atol=1e-13,
            events=ground,
            max_step=0.02,
        )
        assert flights.landed[k] == (solution.status == 1)
        end = solution.y_events[0][0] if flights.landed[k] else solution.y[:, -1]
        np.testing.assert_allclose(flights.q[k], end[:3], atol=1e-9)


def test_steps_that_become_too_small_and_contacts_without_end_are_refused():
    problem = galvi.problems.brownout(200e-6)
    with pytest.raises(RuntimeError, match=r"DOP853 did not complete 1 flights"):
        landings(problem, [[9.0, 0.0, 1.0]], np.zeros((1, 3)), [0.0], 1.0, tolerance=1e-40)
    with pytest.raises(RuntimeError, match=r"a grain had 1000 contacts"):
        landings(
            problem,
            [[FAR, 0.0, 0.05]],
            np.zeros((1, 3)),
            [0.0],
            2.0,
            restitution=0.5,
            slowest=0.0,
            tolerance=1e-9,
        )
