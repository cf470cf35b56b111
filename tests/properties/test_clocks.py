"""Steps in a clock: constant in tau, dt = g(q) dtau, and as variational as those in time."""

from __future__ import annotations

import math
from decimal import Decimal
from itertools import combinations
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

import galvi
from galvi.arrays import Array
from galvi.checkpoint import Checkpoint
from galvi.extended_precision import decimals, extended_precision
from galvi.kernels.forces.celestial import pulls
from galvi.run.clocked import in_lanes as clock_stepper
from galvi.run.clocked.in_lanes import energy_of, masses_in_clock, motion_in_lanes
from galvi.run.clocked.motion import Motion
from galvi.systems.nbody import NBody
from references.stored.encounters import sitnikov
from references.stored.planets import STORED_TRUTH
from tests.properties.clock_problems import (
    BURRAU,
    CASES,
    DAMPED,
    DRIVEN,
    DYNAMICAL,
    GAUSS,
    KEPLER,
    LOBATTO,
    MORE_POINTS,
    SUNDMAN,
    method,
    three_bodies,
)

in_lanes = pytest.mark.skipif(not galvi.FAST, reason="the general kernel alone has none")
FORCED = {
    name: (galvi.Problem(system, [1.0, 0.0], [0.0, 0.8], 0.5), SUNDMAN, 1.5, 0.8)
    for name, system in (("damped", DAMPED), ("driven", DRIVEN))
}
CASES_AND_RULES = [
    ("Kepler, Sundman", LOBATTO),
    ("Kepler, eccentric anomaly", MORE_POINTS),
    ("elastic pendulum", GAUSS),
    ("3D pendulum", LOBATTO),
    ("three bodies", GAUSS),
    ("three bodies", MORE_POINTS),
]


@pytest.mark.slow_cases("elastic pendulum-gauss", "damped-lobatto", "driven-gauss")
@pytest.mark.parametrize(
    ("case", "rule_name"),
    [*CASES_AND_RULES, ("damped", GAUSS), ("damped", LOBATTO), ("driven", GAUSS)],
)
def test_a_run_ends_at_its_time_with_the_order_of_the_method(case: str, rule_name: str) -> None:
    problem, clock, duration, step = {**CASES, **FORCED}[case]

    def end(s: int, rule_name: str, step: float) -> Any:
        run = galvi.integrate(problem, method(s, clock, rule_name), step, duration=duration)
        assert run.success and run.t[-1] == problem.t0 + duration
        return run.q[-1]

    truth, steps = end(8, GAUSS, 0.05), step / np.array([2.0, 3.0, 4.0])
    errors = [float(np.max(np.abs(end(2, rule_name, h) - truth))) for h in steps]
    order = np.polyfit(np.log(steps), np.log(errors), 1)[0]
    assert 3.6 < order < 4.6, (errors, order)


@pytest.mark.slow_cases(but=["three bodies-gauss"])
@pytest.mark.parametrize(("case", "rule_name"), CASES_AND_RULES)
def test_a_step_is_symplectic_in_the_extended_phase_space(case: str, rule_name: str) -> None:
    problem, clock, _, step = CASES[case]
    assert galvi.symplecticity_defect(problem, method(2, clock, rule_name), step) < 1e-10


def test_momenta_are_kept_to_round_off_where_g_is_invariant() -> None:
    run = galvi.integrate(three_bodies(), method(4, DYNAMICAL), 0.4, duration=40.0)
    for momentum in (run.p.sum(axis=1), np.cross(run.q, run.p).sum(axis=1)):
        assert np.max(np.abs(momentum - momentum[0])) < 1e-14
    assert np.ptp(galvi.energy(run)) > 1e-12  # coarse, and not kept


@pytest.mark.slow_cases("elastic pendulum")
@pytest.mark.parametrize("case", CASES)
def test_steps_back_cancel_steps_forward(case: str) -> None:
    problem, clock, duration, step = CASES[case]
    symmetric = case != "3D pendulum"  # charts on groups are based at the step's start
    error = galvi.round_trip_error(problem, method(3, clock), step, 10)
    assert error < (1e-13 if symmetric else 1e-3)
    forward = galvi.integrate(problem, method(8, clock), step, duration=duration)
    back = galvi.integrate(
        problem.moved(forward.q[-1], forward.v[-1], duration),
        forward.method,
        -step,
        duration=duration,
    )
    assert back.status == "Completed." and back.t[-1] == 0.0 and np.all(np.diff(back.t) < 0.0)
    assert np.max(np.abs(back.q[-1] - problem.q0)) < 1e-8


@given(st.floats(0.05, 0.9), st.floats(0.1, 0.4), st.floats(0.5, 9.0))
@settings(max_examples=15)
def test_a_duration_of_any_length_is_met(e: float, step: float, duration: float) -> None:
    run = galvi.integrate(galvi.problems.kepler(e), method(8, SUNDMAN), step, duration=duration)
    assert run.success and run.t[-1] == duration
    anomaly = duration
    for _ in range(60):
        anomaly -= (anomaly - e * math.sin(anomaly) - duration) / (1.0 - e * math.cos(anomaly))
    exact = [math.cos(anomaly) - e, math.sqrt(1.0 - e * e) * math.sin(anomaly)]
    assert np.max(np.abs(run.q[-1] - exact)) < 1e-9
    assert np.all(np.diff(run.t) > 0.0) and np.all(np.diff(run.tau) > 0.0)


def test_burrau_ends_where_quadruple_precision_does() -> None:
    """Close triple encounters; an adaptive code at its default tolerance errs by 1e-3."""
    run = galvi.integrate(BURRAU, method(8, DYNAMICAL), 0.4, duration=63.0)
    truth = [2.8394339724915002, 8.1128544246959514]  # heyoka, quadruple precision
    assert run.success and np.max(np.abs(run.q[-1, 0] - truth)) < 3e-5, run.q[-1, 0] - truth


@in_lanes
def test_sitnikovs_body_stays_on_its_axis_and_where_quadruple_precision_has_it() -> None:
    problem, duration = sitnikov(), 200.0
    run = galvi.integrate(problem, method(8, DYNAMICAL), 0.3, duration=duration)
    truth = STORED_TRUTH.run(problem, duration, {"samples": 1}).q[-1]
    assert not np.any(run.q[:, 2, :2])
    assert np.max(np.abs(run.q[-1] - truth)) < 1e-10


def test_a_sundman_clock_knows_its_gm_in_any_units() -> None:
    """A low orbit in km and s: steps of 0.4 as with G M = 1."""
    gm = 398600.4418
    orbit = galvi.Problem(galvi.Canonical(1.0, galvi.CentralForce(gm)), [7000.0, 0.0], [0.0, 9.0])
    ends = [
        galvi.integrate(orbit, method(8, clock), step, duration=86400.0)
        for clock, step in ((galvi.Sundman(gm=gm), 0.4), (galvi.Sundman(), 0.4 / math.sqrt(gm)))
    ]
    assert all(run.success and len(run.t) < 120 for run in ends)
    np.testing.assert_allclose(ends[0].q, ends[1].q, rtol=0.0, atol=1e-8)


# ---------------------------------------------------------------- states between steps


def test_states_of_a_damped_run_have_the_energy_that_is_left() -> None:
    problem = galvi.Problem(DAMPED, [1.0, 0.0], [0.0, 0.8])
    times = np.array([0.333, 1.7, 2.8])
    run = galvi.integrate(problem, method(6, SUNDMAN), 0.2, duration=3.0, save_every=4)
    fine = galvi.integrate(problem, method(12, None), 0.05, 60)
    assert np.max(np.abs(galvi.states_at(run, times)[0] - fine(times))) < 1e-10


def test_states_between_steps_have_momenta_at_their_times() -> None:
    """The momentum of L = e^(0.3 t) (v^2 - q^2) / 2 depends on the time: taken at the time of
    another stage it was wrong by 5e-3."""

    def growing(q: Any, v: Any, t: Any) -> Any:
        return 0.5 * np.exp(0.3 * t) * (v @ v - q @ q)

    system = galvi.Lagrangian(growing, galvi.Rn(1), explicit_time=True)
    clock = galvi.Clock(lambda q: 1.0 / (1.0 + 0.3 * q[0] * q[0]))
    run = galvi.integrate(galvi.Problem(system, [1.0], [0.2]), method(4, clock), 0.1, 6)
    times = np.array([0.3 * run.t[4] + 0.7 * run.t[5], 0.5 * run.t[-1]])
    q, p = galvi.states_at(run, times)
    w = math.sqrt(1.0 - 0.15**2)
    decay, lag = np.exp(-0.15 * times), 0.35 / w
    assert np.max(np.abs(q[:, 0] - decay * (np.cos(w * times) + lag * np.sin(w * times)))) < 1e-12
    v = decay * ((lag * w - 0.15) * np.cos(w * times) - (w + 0.15 * lag) * np.sin(w * times))
    assert np.max(np.abs(p[:, 0] - np.exp(0.3 * times) * v)) < 1e-12


def test_states_at_grid_points_that_were_not_saved_are_those_of_the_grid() -> None:
    full, coarse = (
        galvi.integrate(KEPLER, method(4, SUNDMAN), 0.3, 40, save_every=k) for k in (1, 10)
    )
    q, p = galvi.states_at(coarse, full.t)
    assert np.max(np.abs(q - full.q)) < 1e-13 and np.max(np.abs(p - full.p)) < 1e-13


# ---------------------------------------------------------------- the law of point masses

TILTED = galvi.Oblateness(0, 0.02, 0.5, J4=-0.03, pole=(0.2, 0.3, 1.0))
BENT = galvi.Relativity(12.0, form="potential")
LOGARITHM = galvi.PowerLaw(0, -0.05, -1)


def spread_bodies(masses: Any, dimension: int, G: float = 1.0, forces: Any = ()) -> galvi.Problem:
    """Bodies about a unit apart, at moderate speeds."""
    rng = np.random.Generator(np.random.Philox(11))
    n = len(masses)
    q = 1.5 * np.arange(n)[:, None] ** [[1.0, 0.5, 0.2][:dimension]] + 0.2 * rng.normal(
        size=(n, dimension)
    )
    return galvi.Problem(NBody(masses, G, forces), q, 0.3 * rng.normal(size=(n, dimension)))


def clock_rate(problem: galvi.Problem, q: Any, fixed_q: Any) -> Any:
    """g by its definition; q, (bodies, dimension), may be complex.

    fixed_q  the positions, not differentiated, that count in pairs with a massless body
    """
    system: Any = problem.system
    sum_of_rates = 0.0
    for i, j in combinations(range(len(q)), 2):
        mass = system.G * (system.masses[i] + system.masses[j])
        heavy = system.masses[i] > 0.0 and system.masses[j] > 0.0
        gap = q[i] - q[j] if heavy else fixed_q[i] - fixed_q[j]
        sum_of_rates = sum_of_rates + (mass / np.sum(gap**2) ** 1.5) if mass else sum_of_rates
    return sum_of_rates**-0.5


def energy(problem: galvi.Problem, q: Any, v: Any) -> Any:
    system: Any = problem.system
    m = system.masses
    total = 0.5 * np.sum(m * np.sum(v * v, axis=1))
    for i, j in combinations(range(len(q)), 2):
        total = total - system.G * m[i] * m[j] / np.sqrt(np.sum((q[i] - q[j]) ** 2))
    return total + pulls(system.acting.terms, system.acting.poles, q)[1]


def right_side_in_clock(problem: galvi.Problem, e0: float) -> Any:
    """The function d(q, v, t)/dtau: Hamilton's equations of g (H - E0) for the bodies with a mass.

    The part of g from pairs with a massless body counts as a function of tau alone; the gradient
    of the rest is by complex steps.
    """
    system: Any = problem.system
    shape, d = problem.q0.shape, problem.q0.size

    def right_side(_tau: float, y: Array) -> Array:
        q, v = y[:d].reshape(shape), y[d : 2 * d].reshape(shape)
        g, g_slope = clock_rate(problem, q, q), np.zeros(d)
        for k in range(d):
            moved = q.astype(complex)
            moved.flat[k] += 1e-30j
            g_slope[k] = np.imag(clock_rate(problem, moved, q)) / 1e-30
        energy_excess = energy(problem, q, v) - e0
        mass = np.where(system.masses > 0.0, system.masses, np.inf)[:, None]
        acceleration = (
            g * system.acceleration(q, 0.0) - energy_excess * g_slope.reshape(shape) / mass
        )
        return np.concatenate([g * v.ravel(), acceleration.ravel(), [g]])

    return right_side


def lane_motion(problem: galvi.Problem, s: int, start_energy: float | None = None) -> Motion:
    motion = motion_in_lanes(problem, method(s, DYNAMICAL), start_energy)
    assert isinstance(motion, Motion)
    return motion


def start_checkpoint(problem: galvi.Problem, motion: Motion) -> Checkpoint:
    return motion.at(problem.q0, problem.v0, problem.t0)


@pytest.mark.parametrize(
    ("masses", "dimension", "G", "s", "forces"),
    [
        ([3.0, 4.0, 5.0], 2, 0.8, 8, (galvi.Oblateness(1, 0.02, 0.5), LOGARITHM)),
        ([1.0, 0.5, 0.0, 0.0, 0.7], 3, 2.5, 12, ()),
        ([1.0, 0.5, 0.0, 0.0, 0.7], 3, 2.5, 12, (LOGARITHM, TILTED, BENT)),
        ([2.0, 0.0], 3, 0.3, 3, BENT),
    ],
)
def test_steps_solve_the_equations_of_the_clock(
    masses: Any, dimension: int, G: float, s: int, forces: Any
) -> None:
    """E0 is not the energy of the state, so that each term counts; some bodies are massless."""
    problem = spread_bodies(masses, dimension, G, forces)
    shifted_energy = 1.1 * energy(problem, problem.q0, problem.v0) - 0.1
    motion, h = lane_motion(problem, s, shifted_energy), 0.02 if s == 3 else 0.1
    after = motion.advance(start_checkpoint(problem, motion), h, 10, None, False).after
    y = np.concatenate([problem.q0.ravel(), problem.v0.ravel(), [problem.t0]])
    options = {"method": "DOP853", "rtol": 1e-13, "atol": 1e-14}
    end = solve_ivp(right_side_in_clock(problem, shifted_energy), (0.0, 10 * h), y, **options).y[
        :, -1
    ]
    lane_end = np.concatenate([after.state[0], after.state[2], after.clock[:1]])
    assert np.max(np.abs(lane_end - end)) < 3e-11 * max(1.0, np.max(np.abs(end)))


def test_the_energy_of_the_start_has_a_low_part() -> None:
    problem = spread_bodies([3.0, 1e-9, 5.0, 0.0], 3, 0.7)
    system: Any = problem.system
    state = np.zeros((4, 12))
    state[0], state[2] = problem.q0.ravel(), problem.v0.ravel()
    state[1], state[3] = 1e-17 * np.arange(12), -1e-18 * np.arange(12)
    high, low = energy_of(masses_in_clock(system, 3), state.reshape(4, 4, 3))
    with extended_precision():
        M = decimals(system.G * system.masses)
        q, v = ((decimals(state[k]) + decimals(state[k + 1])).reshape(4, 3) for k in (0, 2))
        exact = sum(m * sum(x * x) for m, x in zip(M, v, strict=True)) / 2
        for i, j in combinations(range(4), 2):
            exact -= M[i] * M[j] / sum((q[i] - q[j]) ** 2).sqrt()
        error = abs(Decimal(float(high)) + Decimal(float(low)) - exact)
        assert error < abs(exact) * Decimal(2) ** -98


def energy_drift(
    problem: galvi.Problem, blocks: int = 60, steps: int = 2000
) -> tuple[float, float]:
    """The mean change of K = g (H - E0) in a step, in units of g |E0|, and its standard error."""
    motion = lane_motion(problem, 8)
    state = start_checkpoint(problem, motion)
    masses = masses_in_clock(problem.system, problem.q0.shape[1])
    K = [0.0]
    for _ in range(blocks):
        state = motion.advance(state, 0.4, steps, None, False).after
        energies = energy_of(masses, state.state.reshape(4, *problem.q0.shape))
        K.append(float(motion.rate(state.state[0])) * float(np.sum(energies - state.clock[2:])))
    size = float(motion.rate(problem.q0.ravel())) * abs(state.clock[2])
    changes = np.diff(K) / (steps * size)
    return float(np.mean(changes)), float(np.std(changes, ddof=1) / np.sqrt(blocks))


@pytest.mark.slow(beside="test_steps_solve_the_equations_of_the_clock")
def test_the_energy_does_not_drift(monkeypatch: pytest.MonkeyPatch) -> None:
    """The drift is at most 4 standard errors; where the iteration stops early it is more than 8.

    Two bodies of masses 3/4 and 1/4, e = 0.9, at pericentre, in a plane through no axis.
    """
    e, m = 0.9, np.array([[-0.25], [0.75]])
    x, y = np.array([0.8, 0.36, 0.48]), np.array([-0.6, 0.48, 0.64])
    start = m * (1.0 - e) * x, m * np.sqrt((1.0 + e) / (1.0 - e)) * y
    small = galvi.Oblateness(0, 0.02, 0.02, J4=-0.03, pole=(0.2, 0.3, 1.0))
    plain, forced = (
        galvi.Problem(NBody([0.75, 0.25], forces=forces), *start) for forces in ((), (BENT, small))
    )
    for problem in (plain, forced):
        mean, error = energy_drift(problem)
        assert abs(mean) < 4.0 * error < 8e-17
    monkeypatch.setattr(clock_stepper, "CLOCK_TOLERANCE", 2.0**-48)
    monkeypatch.setattr(clock_stepper, "CLOCK_ROUNDING", 0.0)
    mean, error = energy_drift(plain)
    assert abs(mean) > 8.0 * error


def test_the_path_of_a_light_body_tends_to_that_without_mass() -> None:
    """A comet about one of two stars sets the clock. Its path differs from the massless one by 200
    times its mass and 1e-11 at most: the rounding of H - E0 is not divided by its mass."""
    ends = {}
    for mass in (0.0, 1e-12, 1e-9, 1e-6, 1e-4):
        q = np.array([[0.0, 0.0, 0.0], [9.0, 4.0, 1.0], [0.2, 0.0, 0.05]])
        v = np.array([[0.0, 0.0, 0.0], [-0.15, 0.3, 0.1], [0.0, 2.9, 0.3]])
        problem = galvi.Problem(NBody([1.0, 0.5, mass]), q, v)
        ends[mass] = galvi.integrate(problem, method(8, DYNAMICAL), 0.3, duration=20.0).q[-1]
        assert np.max(np.abs(ends[mass] - ends[0.0])) < 200.0 * mass + 1e-11


def test_bodies_of_less_than_two_percent_of_the_second_are_light() -> None:
    masses = [1.0, 1e-3, 3e-5, 1e-5, 0.0]
    for direction in (1, -1):
        masses_of_clock = masses_in_clock(NBody(masses[::direction]), 3)[3][1]
        assert (masses_of_clock == 0.0)[::direction].tolist() == [False, False, False, True, True]
