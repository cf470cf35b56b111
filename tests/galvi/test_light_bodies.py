"""Light and massless bodies in a clock: truths in quadruple precision, and the restricted problem
of three bodies."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import galvi
from galvi.fast import clock_stepper
from references.stored.encounters import THIRD_BODIES, third_body
from references.stored.planets import STORED_TRUTH
from tests.galvi.clock_problems import DYNAMICAL, method

pytestmark = pytest.mark.skipif(not galvi.FAST, reason="massless bodies need galvi.fast")
MU, DURATION = 0.1, 10.0


@pytest.fixture
def light_below() -> Iterator[Callable[[float], None]]:
    """Sets the share of the second largest mass below which a body does not feel H - E0."""

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
    for share in (0.0, 2.0):  # all feel H - E0, or the heaviest alone
        light_below(share)
        tried += [error(mass, step) for step in (0.4, 0.3)]
    assert max(ours) < max(10.0 * min(tried), rounding)


def test_a_third_body_that_felt_the_rounding_of_the_energy_would_be_seen(light_below: Any) -> None:
    light_below(0.0)
    assert error(1e-6, 0.3) > 1e-12
    assert error(1e-9, 0.3) == np.inf


@pytest.mark.parametrize("mass", THIRD_BODIES.values())
def test_the_status_says_in_which_bodies_a_run_is_not_variational(mass: float) -> None:
    run = galvi.integrate(third_body(mass), method(8, DYNAMICAL), 0.3, duration=0.5)
    said = (
        "Bodies third body, lighter than 2% of the second heaviest, do not feel H - E" in run.status
    )
    assert said == (mass > 0.0) and run.success


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
