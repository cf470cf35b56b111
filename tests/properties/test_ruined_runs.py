"""Ruined runs, and runs with passages too fast for a step, are not called good."""

from __future__ import annotations

import math

import numpy as np
import pytest
import sympy as sp
from hypothesis import given
from hypothesis import strategies as st
from numba import njit

import galvi
from galvi.kernels.energy_errors import MEASURE, ROWS, errors_since_start
from galvi.kernels.forces.passages import PASSAGE_REACH, UNRESOLVED, passage_error
from galvi.run.energies import kick_energy
from galvi.run.energy_assessment import report_on
from references.rebound.ias15 import IAS15

NO_ERRORS_YET = np.array([0.0, 0.0, 0.0, 0.0])


def gauss(points):
    """Gauss collocation with ``points`` stages."""
    return galvi.Galerkin(galvi.Polynomials(points), galvi.gauss(points))


def spring(compiled, gradient_factor=1.0):
    """V = |q|^2 / 2, with a gradient that is ``gradient_factor`` times the right one."""

    def potential(q):
        return 0.5 * np.sum(q * q)

    def gradient(q):
        return gradient_factor * q

    wrap = njit if compiled else (lambda function: function)
    return galvi.Canonical(1.0, wrap(potential), wrap(gradient), check=False)


def test_an_energy_without_a_measure_is_told_without_a_falsehood():
    """A wrong force drives a pendulum up from rest in its equilibrium."""

    def potential(q):
        return 1.0 - np.cos(q[0])

    pushed = galvi.Canonical(1.0, potential, lambda q: 0.0 * q + 1e-3, check=False)
    run = galvi.integrate(galvi.Problem(pushed, [0.0], [0.0]), gauss(4), 0.2, 20)
    assert np.ptp([potential(q) for q in run.q]) > 1e-6
    assert "the energy changed by 4e-05, and no step kept it to 0.01 times the larger" in run.status


def top(compiled, gradient_factor=1.0):
    """A pendulum on SO(3), V = 2 R_33, with ``gradient_factor`` times its gradient."""

    def potential(R):
        return 2.0 * R[2, 2]

    def gradient(R):
        out = np.zeros((3, 3))
        out[2, 2] = 2.0 * gradient_factor
        return out

    wrap = njit if compiled else (lambda function: function)
    return galvi.RigidBody([1.0, 2.0, 2.5], wrap(potential), wrap(gradient), check=False)


def tilted(angle):
    """A rotation about the first axis."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]])


def wrong_slopes(q, v):
    """dL/dv, and dL/dq of the wrong sign, of L = v^2 / 2 - q^2 / 2."""
    return np.concatenate([v, q])


ASTRAY = {
    "python": galvi.Problem(spring(False, -1.0), [1.0], [0.5]),
    "compiled": galvi.Problem(spring(True, -1.0), [1.0], [0.5]),
    "from rest": galvi.Problem(spring(True, -1.0), [1.0], [0.0]),
    "components": galvi.Problem(spring(False, -1.0), [1.0, 0.0], [0.0, 0.5]),
    "rigid body": galvi.Problem(top(False, -1.0), tilted(1.0), [0.1, 0.2, 0.3]),
    "compiled rigid body": galvi.Problem(top(True, -1.0), tilted(1.0), np.zeros(3)),
    "Lagrangian": galvi.Problem(
        galvi.Lagrangian(
            lambda q, v: 0.5 * (v @ v - q @ q), galvi.Rn(1), wrong_slopes, check=False
        ),
        [1.0],
        [0.1],
    ),
}


@pytest.mark.parametrize(
    ("name", "save_every"), [(name, (1, 7, 100)[k % 3]) for k, name in enumerate(ASTRAY)]
)
def test_a_gradient_of_the_wrong_sign_ruins_a_run_which_goes_on(name, save_every):
    """E of the springs grows from 0.5 by 1e8 and more; that of the bodies by twice the range."""
    run = galvi.integrate(ASTRAY[name], gauss(4), 0.1, 100, save_every=save_every)
    assert run.outcome.end is galvi.End.RUINED and not run.success
    assert "check that the derivatives are those of the energy" in run.outcome.remedy
    assert 1 <= run.failed_step < 20
    assert run.counts["steps"] == 100 and np.all(np.isfinite(run.q)) and np.all(np.isfinite(run.p))


def test_the_first_ruined_step_is_found_among_the_kept_ones():
    """E grows as cosh 2t from 1: the error, 2 sinh^2 t, reaches the measure, 0.5, at t = 0.48."""
    problem = galvi.Problem(spring(True, -1.0), [0.0, 1.0], [1.0, 0.0])
    run = galvi.integrate(problem, gauss(4), 0.001, 10_000)
    q, v = run.q, run.p
    error = np.abs(0.5 * np.sum(v * v + q * q, axis=1) - 1.0)
    assert run.failed_step == int(np.flatnonzero(error > 0.5)[0])
    thinned = galvi.integrate(problem, gauss(4), 0.001, 10_000, save_every=10_000)
    assert (
        run.failed_step <= thinned.failed_step <= run.failed_step + 128
    )  # a 64th of the run at most


@pytest.mark.slow_cases(but=["3"])
@pytest.mark.parametrize("points", [3, 5, 8])
def test_a_fall_onto_the_centre_is_never_called_good(points):
    """Steps jump over the singularity: of such runs some stop, some are ruined, some warn."""
    central = galvi.Canonical(1.0, galvi.CentralForce())
    ruined_runs = 0
    for step in np.geomspace(0.008, 0.3, 60):
        for problem in (
            galvi.Problem(central, [1.0, 0.0], [0.0, 0.0]),
            galvi.Problem(galvi.NBody([1.0, 1.0]), [[-0.5, 0], [0.5, 0]], np.zeros((2, 2))),
        ):
            run = galvi.integrate(problem, gauss(points), step, int(2.5 / step))
            assert run.status != "Completed."
            if np.all(np.isfinite(run.q[-1])):
                error = np.max(np.abs(galvi.energy(run) + 1.0))
                deepest = np.max(np.abs(galvi.energy(run) - 0.5 * np.sum(run.p**2)))
                assert run.success or error > 0.5
                assert not run.success or error < deepest
                ruined_runs += not run.success
    assert ruined_runs


def report(kinetic, potential, kinetic_at_start=0.0, floor=0.0):
    """The report on energies at steps 1, 2, ..., which are 0 at the start."""
    steps, table = np.arange(1, len(kinetic) + 1), np.empty((ROWS, len(kinetic)))
    errors_since_start(kinetic, potential, np.zeros(1), False, 0.0, kinetic_at_start, table)
    return report_on(steps, table, False, NO_ERRORS_YET, kinetic_at_start, floor)


def test_the_measure_is_not_that_of_where_a_run_went():
    """Planted energies: a jump into a well that is deeper than its error, and one that returns."""
    at_rest = np.zeros(6)
    potential = np.array([-1.0, -2.0, -1e5, -3.0, -3.0, -2.0])
    jumping = report(np.array([1.0, 2.0, 1e5 + 500, 503, 503, 502]), potential)
    assert jumping.ruined == 3 and jumping.energies[MEASURE] == 2.0
    returning = report(np.array([1.0, 2.0, 1e5 + 500, 3, 3, 2]), potential)
    assert returning.ruined is None and returning.energies[MEASURE] == 1e5 - 1.0 + 1.0
    drifting = report(-potential + 0.02 * np.arange(6), potential, 10.0)
    assert drifting.ruined is None and drifting.error < 0.01
    assert report(at_rest + 1e-16, at_rest, floor=1e-15).ruined is None
    assert report(at_rest + 1e-16, at_rest).ruined == 1  # no floor


@pytest.mark.parametrize(
    ("problem", "points", "step", "steps"),
    [
        (galvi.Problem(spring(True), [1.0], [0.0]), 8, 3.7, 1),
        (galvi.Problem(spring(False), [1.0], [0.0]), 1, 0.5, 2),
        (galvi.Problem(spring(True), [1.0], [0.0]), 4, 3.14, 3),
        (galvi.Problem(top(True), tilted(3.1), np.zeros(3)), 4, 0.9, 2),
        (galvi.problems.double_pendulum().with_initial_state([0.3, 0.0], [0.0, 0.0]), 3, 0.6, 1),
    ],
)
def test_a_coarse_run_from_rest_that_returns_is_not_ruined(problem, points, step, steps):
    """Half a period a step: V at the ends differs by less than the error of the energy."""
    assert galvi.integrate(problem, gauss(points), step, steps).success


EQUILIBRIA = {
    "upright, V = 0 there": (lambda q: 1.0 + np.cos(q[0]), lambda q: -np.sin(q), np.pi),
    "upright": (lambda q: np.cos(q[0]), lambda q: -np.sin(q), np.pi),
    "hanging": (lambda q: -np.cos(q[0]), np.sin, 0.0),
    "far away": (lambda q: 9.81 * q[0], lambda q: np.array([9.81]), 1e9),
}


@pytest.mark.parametrize("name", EQUILIBRIA)
@pytest.mark.parametrize("steps", [3, 600])
def test_round_off_at_rest_and_free_fall_are_no_ruin(name, steps):
    potential, gradient, q0 = EQUILIBRIA[name]
    problem = galvi.Problem(galvi.Canonical(1.0, potential, gradient), [q0], [0.0])
    assert galvi.integrate(problem, gauss(3), 0.1, steps).status == "Completed."


def wave(q, t):
    return 0.5 * q[0] ** 2 - 3.0 * q[0] * np.cos(t)


TIMED = galvi.Canonical(1.0, wave, lambda q, t: q - 3.0 * np.cos(t), explicit_time=True)
DAMPED = galvi.Canonical(1.0, lambda q: 0.5 * q[0] ** 2, lambda q: q, force=lambda q, v: -5.0 * v)


@pytest.mark.parametrize(("system", "energies"), [(TIMED, 0), (DAMPED, 4)])
def test_energy_is_not_asked_where_it_depends_on_the_time_nor_the_work_of_a_force(system, energies):
    run = galvi.integrate(galvi.Problem(system, [1.0], [0.0]), gauss(3), 0.1, 300)
    assert run.status == "Completed." and run.checkpoint.energies.size == energies


@pytest.mark.parametrize("cut", [1, 40])
def test_a_resumed_run_is_assessed_as_one_long_run(cut, tmp_path):
    problem = galvi.Problem(galvi.NBody([1.0, 1e-6, 1e-6]), *meeting(1e-6, 1e-3))
    for case, step, steps in ((problem, 0.05, 60), (ASTRAY["compiled"], 0.1, 60)):
        uncut = galvi.integrate(case, gauss(8), step, steps)
        part = galvi.integrate(case, gauss(8), step, cut)
        problem_of_file = None if case is problem else case
        galvi.save(part, tmp_path / "part.npz")
        resumed = galvi.resume(galvi.load(tmp_path / "part.npz", problem_of_file), steps - cut)
        assert np.array_equal(resumed.q, uncut.q[cut:])
        assert resumed.success == uncut.success
        assert np.array_equal(resumed.checkpoint.passage, uncut.checkpoint.passage)
        assert np.array_equal(resumed.checkpoint.energies, uncut.checkpoint.energies)
        if uncut.success:
            assert resumed.status == uncut.status
        else:
            assert resumed.failed_step == max(uncut.failed_step - cut, 1)


def meeting(mass, distance, duration=2.0):
    """Positions and velocities, (3, 3) each, of a star and two planets of this mass that IAS15
    computes backwards from where the planets are at this distance, at 1 au."""
    q = np.array([[0.0, 0, 0], [1.0, 0, 0], [1.0 + 0.6 * distance, 0, 0.8 * distance]])
    v = np.array([[0.0, 0, 0], [0.0, 1.0, 0], [0.2, np.sqrt(0.7), 0.05]])
    reversed_start = galvi.Problem(galvi.NBody([1.0, mass, mass]), q, -v)
    run = IAS15.run(reversed_start, duration, {})
    return run.q[-1], -reversed_start.system.velocity(run.p[-1])


@pytest.mark.parametrize(
    ("mass", "distance", "points", "step", "expected_error"),
    [
        (1e-6, 1e-3, 4, 0.05, 6.3e-2),
        (1e-6, 1e-3, 8, 0.05, 3.3e-3),
        (1e-6, 1e-3, 12, 0.2, 1.6e-2),
        (1e-6, 1e-3, 8, 0.4, 1.9e-2),
        (1e-3, 1e-2, 8, 0.2, 2.1),
        (1e-5, 1e-3, 8, 0.05, 1.1e-1),
    ],
)
def test_planets_that_meet_too_fast_for_a_step_are_named(
    mass, distance, points, step, expected_error
):
    """``expected_error`` is the distance from IAS15 at t = 8, which hardly shows in the energy."""
    problem = galvi.Problem(galvi.NBody([1.0, mass, mass]), *meeting(mass, distance))
    run = galvi.integrate(problem, gauss(points), step, duration=8.0)
    truth = IAS15.run(problem, 8.0, {})
    error = np.max(np.abs(run.q[-1] - truth.q[-1]))
    assert 0.3 * expected_error < error < 3.0 * expected_error
    assert run.success and run.status.startswith("Completed, but ")
    assert "bodies 1 and 2 passed at a distance of about " in run.status
    estimate = run.checkpoint.passage[0]
    assert 0.03 * error < estimate < 3.0 * error  # 0.07 to 1.1 when this was written


@pytest.mark.parametrize("solver", ["auto", "newton"])
def test_both_kernels_see_a_passage(solver):
    problem = galvi.Problem(galvi.NBody([1.0, 1e-6, 1e-6]), *meeting(1e-6, 1e-3))
    run = galvi.integrate(problem, gauss(8), 0.05, 60, solver=solver)
    assert "bodies 1 and 2 passed" in run.status
    assert run.checkpoint.passage[0] == pytest.approx(1.45e-3, rel=0.01)
    back = galvi.integrate(
        problem.with_initial_state(run.q[-1], -problem.system.velocity(run.p[-1])),
        gauss(8),
        0.05,
        60,
        solver=solver,
    )
    assert "bodies 1 and 2 passed" in back.status


@pytest.mark.parametrize(("points", "step"), [(8, 0.0125 / 2), (12, 0.0125), (4, 0.002)])
def test_a_close_passage_that_is_resolved_is_not_reported(points, step):
    problem = galvi.Problem(galvi.NBody([1.0, 1e-6, 1e-6]), *meeting(1e-6, 1e-3))
    run = galvi.integrate(problem, gauss(points), step, duration=4.0, save_every=10)
    truth = IAS15.run(problem, 4.0, {})
    assert run.status == "Completed."
    assert np.max(np.abs(run.q[-1] - truth.q[-1])) < 3e-5


FIGURE_EIGHT = (
    [[0.97000436, -0.24308753], [-0.97000436, 0.24308753], [0.0, 0.0]],
    [[0.46620369, 0.43236573], [0.46620369, 0.43236573], [-0.93240737, -0.86473146]],
)
CALM = [
    (galvi.problems.outer_solar_system(), 8, 541.0, 100),
    (galvi.problems.solar_system(), 25, 100.0, 100),
    (galvi.Problem(galvi.NBody([1.0] * 3), *FIGURE_EIGHT), 8, 0.1, 200),
    (galvi.problems.kepler(0.6), 8, 0.2, 200),
    (galvi.problems.henon_heiles(), 4, 0.2, 200),
    (galvi.problems.double_pendulum(), 8, 0.05, 100),
    (galvi.problems.heavy_top(), 8, 0.05, 100),
    (galvi.problems.pendulum_3d(), 8, 0.1, 100),
    (galvi.problems.free_body_se3(), 8, 0.1, 100),
    (galvi.problems.free_rigid_body(), 8, 0.2, 100),
    (galvi.problems.fermi_pasta_ulam_tsingou(masses=6, beta=0.3), 4, 0.2, 100),
    (galvi.problems.harmonic_oscillator(), 4, 0.5, 100),
]


@pytest.mark.parametrize(("index", "run"), [*enumerate(CALM)])
def test_good_runs_are_called_good(index, run):
    problem, points, step, steps = run
    run = galvi.integrate(problem, gauss(points), step, steps, save_every=(1, 50)[index % 2])
    assert run.status == "Completed." and run.success and run.failed_step is None


@given(
    eccentricity=st.floats(0.0, 0.8),
    mass=st.floats(1e-8, 1.0),
    phase=st.floats(0.0, 6.2),
    boost=st.floats(-3.0, 3.0),
    sign=st.sampled_from([-1, 1]),
)
def test_no_bound_pair_with_adequate_steps_raises_a_false_alarm(
    eccentricity, mass, phase, boost, sign
):
    """150 steps of degree 8 a period; the largest error of a passage was 2e-7."""
    gap, speed = 1.0 - eccentricity, np.sqrt((1 + mass) * (1 + eccentricity) / (1 - eccentricity))
    turn = np.array([[np.cos(phase), -np.sin(phase)], [np.sin(phase), np.cos(phase)]])
    q, v = turn @ [gap, 0.0], turn @ [0.0, speed]
    position, drift = np.array([5.0, 1.0]), np.array([boost, 0.0])
    problem = galvi.Problem(galvi.NBody([1.0, mass]), [position, position + q], [drift, drift + v])
    period = 2 * np.pi / np.sqrt(1 + mass)
    assert galvi.integrate(problem, gauss(8), sign * period / 150, 300).status == "Completed."


@given(frequency=st.floats(0.1, 30.0), start=st.floats(-1.0, 1.0), speed=st.floats(-1.0, 1.0))
def test_a_right_gradient_never_ruins_and_a_wrong_one_always_does(frequency, start, speed):
    def system(sign):
        k = frequency**2
        potential = lambda q: 0.5 * k * q[0] ** 2  # noqa: E731
        return galvi.Canonical(1.0, potential, lambda q: sign * k * q, check=False)

    if abs(start) + abs(speed) < 1e-3:
        start = 0.5
    for sign in (1.0, -1.0):
        problem = galvi.Problem(system(sign), [start], [speed])
        run = galvi.integrate(problem, gauss(4), 0.3 / frequency, 60)
        if sign > 0 or abs(start * frequency + speed) > 1e-3 * (abs(start) * frequency):
            assert run.success == (sign > 0), run.status


def test_the_pole_of_a_passage_is_that_of_its_conic():
    """exp(-2 n y) with y = 2 tau / h where it is small: tau = d / v straight, 4/3 parabolic."""
    d, v, h, n = 0.1, 1.0, 1.0, 8
    straight = passage_error(d**2, v**2, 0.0, 1e-12, 0.5, h, n) / (2.0 * 1e-12 / (d * v**2))
    assert straight == pytest.approx(np.exp(-4.0 * n * d / v / h), rel=1e-6)
    parabola = passage_error(d**2, v**2, 0.0, 0.5 * d * v**2, 0.5, h, n)
    assert parabola == pytest.approx(np.exp(-4.0 * n * 4.0 / 3.0 * d / v / h), rel=1e-6)
    circle = passage_error(d**2, v**2, 0.0, d * v**2, 0.5, h, n)
    assert circle == 0.0
    almost_parabola = passage_error(d**2, v**2, 0.0, 0.5 * d * v**2 * (1 + 3e-6), 0.5, h, n)
    assert almost_parabola == pytest.approx(parabola, rel=1e-4)
    at_edge = passage_error(d**2, v**2, 0.0, 0.5 * d * v**2, 1.0, h, n)
    assert at_edge < 0.1 * parabola
    assert np.hypot(np.log(1.0 / UNRESOLVED) / 4.0, np.pi / 4.0) < PASSAGE_REACH


@pytest.mark.parametrize("eccentricity", [0.2, 0.7, 1.0, 1.5, 6.0])
@pytest.mark.parametrize("time_from_pericentre", [-0.02, 0.0, 0.015])
def test_the_pericentre_is_found_from_any_point_of_the_conic(eccentricity, time_from_pericentre):
    """The error is the same from each point of a passage, at its own place in the step."""
    mu, nearest, h = 1.0, 0.05, 0.1
    speed = np.sqrt(mu * (1.0 + eccentricity) / nearest)
    problem = galvi.Problem(
        galvi.Canonical(1.0, galvi.CentralForce(mu)), [nearest, 0.0], [0.0, speed]
    )
    q, v = problem.q0, problem.v0
    if time_from_pericentre:
        run = galvi.integrate(problem, gauss(12), time_from_pericentre / 400, 400, save_every=400)
        q, v = run.q[-1], run.p[-1]
    error = passage_error(q @ q, v @ v, q @ v, mu, 0.5 + time_from_pericentre / h, h, 8)
    assert error == pytest.approx(passage_error(nearest**2, speed**2, 0.0, mu, 0.5, h, 8), rel=1e-5)


def test_a_ruined_energy_is_seen_far_from_the_origin() -> None:
    centre = 1e8
    system = galvi.Canonical(
        1.0, lambda q: float((q[0] - centre) ** 2 / 2), lambda q: 3.0 * (q - centre), check=False
    )
    run = galvi.integrate(galvi.Problem(system, [centre + 1.0], [0.5]), gauss(2), 0.1, 300)
    assert run.outcome.end is galvi.End.RUINED


def test_a_run_outside_the_domain_of_its_lagrangian_is_no_success() -> None:
    x, v = sp.symbols("x v", real=True)
    system = galvi.Lagrangian.from_sympy(v**2 / 2 + sp.log(x) - 10 * x, (x,), (v,))
    run = galvi.integrate(galvi.Problem(system, [1.0], [-1.0]), gauss(2), 0.05, 200)
    assert not run.success and "not a number" in run.status


# ---------------------------------------------------------------- starts at rest, and long steps

PENDULUM = galvi.Lagrangian(galvi.PlanarChain([1.0], [1.0], 1.0), galvi.Rn(1))


def falling(q, v):
    """L = -sqrt(f - v^2 / f), f = 1 - 2 / q, which is undefined beyond the speed of light."""
    f = 1.0 - 2.0 / q[0]
    return -math.sqrt(f - v[0] ** 2 / f)


@njit
def falling_slopes(q, v):
    """The derivatives of `falling` by v and q."""
    f, slope = 1.0 - 2.0 / q[0], 2.0 / q[0] ** 2
    r = np.sqrt(f - v[0] ** 2 / f)
    return np.array([v[0] / f / r, -0.5 * (slope + v[0] ** 2 / f**2 * slope) / r])


@pytest.mark.parametrize(
    ("speed_fraction", "step"), [(0.9, 0.02), (0.99, 0.1), (0.999, 0.2), (0.999, 0.02), (0.9, 0.2)]
)
def test_a_lagrangian_that_is_not_defined_for_a_near_velocity_does_not_end_a_run(
    speed_fraction, step
):
    system = galvi.Lagrangian(falling, galvi.Rn(1), falling_slopes)
    problem = galvi.Problem(system, [6.0], [-speed_fraction * (1.0 - 2.0 / 6.0)])
    run = galvi.integrate(problem, gauss(2), step, round(4.0 / step))
    assert run.success and run.status.startswith("Completed.")


def lifted(angle):
    """A heavy body turned about x from where its centre of mass is below."""
    return galvi.Problem(galvi.problems.pendulum_3d(2.0).system, tilted(angle), np.zeros(3))


SPRING = galvi.Canonical(3.0, lambda q: 0.5 * q[0] ** 2, lambda q: q)
LAGRANGIAN_SPRING = galvi.Lagrangian(lambda q, v: 1.5 * v[0] ** 2 - 0.5 * q[0] ** 2, galvi.Rn(1))
ABOUT_X = lifted(0.0).system.inertia[0, 0]
AT_REST = {  # Name -> problem, F . M^-1 F
    "canonical": (galvi.Problem(SPRING, [2.0], [0.0]), 4.0 / 3.0),
    "Lagrangian": (galvi.Problem(LAGRANGIAN_SPRING, [2.0], [0.0]), 4.0 / 3.0),
    "rigid body": (lifted(0.3), (2.0 * math.sin(0.3)) ** 2 / ABOUT_X),
    "free body": (galvi.problems.free_body_se3(g=(0.0, 0.0, -9.81)), 9.81**2),
}


@pytest.mark.parametrize("name", AT_REST)
def test_the_energy_that_a_force_gives_in_a_step_is_that_of_uniform_acceleration(name):
    """For the springs it is less by the change of their force along the displacement."""
    problem, power = AT_REST[name]
    mass = getattr(problem.system, "mass", 1.0) if name == "free body" else 1.0
    for step in (0.1, -0.1, 0.2):
        displacement = 0.5 * step**2 * 2.0 / 3.0 if name in ("canonical", "Lagrangian") else 0.0
        expected = 0.5 * step**2 * power * mass - 0.5 * displacement**2
        assert kick_energy(problem, step) == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize("name", ["canonical", "Lagrangian"])
def test_a_force_that_reverses_gives_no_more_than_the_potential_falls(name):
    """From rest at x = 2 with k = 1. V is sampled from 0.71 to 1.41 of the way to its minimum."""
    problem, _ = AT_REST[name]
    energies = [kick_energy(problem, step) for step in (2.5, 50.0, 3e4, -1e9)]
    assert all(0.91 * 2.0 <= energy <= 2.0 for energy in energies)
    gravity = galvi.Problem(
        galvi.Canonical(2.0, lambda q: 3.0 * q[0], lambda q: [3.0]), [1.0], [0.0]
    )
    assert kick_energy(gravity, 1e4) == pytest.approx(0.5 * 1e8 * 9.0 / 2.0, rel=1e-9)


def test_a_start_at_rest_excuses_no_error_in_steps_of_many_periods():
    """The elastic pendulum in steps of 35 periods, whose energy goes from 0.9 to 123: wherever
    Newton's method ends, or if it does not."""
    run = galvi.integrate(galvi.problems.elastic_pendulum(), gauss(5), 218, 5, solver="newton")
    assert not run.success


def test_a_changed_energy_is_told_however_large_the_step():
    """The bounds of the measure are T at the start, and the larger of it and the range of V."""
    rng = np.random.default_rng(0)
    reported, ruined = 0, 0
    for _ in range(80):
        start = rng.normal(scale=1.5, size=2)
        problem = galvi.Problem(PENDULUM, start[:1], start[1:])
        run = galvi.integrate(problem, gauss(2), rng.uniform(0.3, 6.0), int(rng.integers(1, 5)))
        if not np.all(np.isfinite(run.q[-1])):
            continue
        kinetic, potential = 0.5 * run.p[:, 0] ** 2, -np.cos(run.q[:, 0])
        energy_change = np.max(np.abs(kinetic + potential - kinetic[0] - potential[0]))
        lower_bound, upper_bound = kinetic[0], max(kinetic[0], np.ptp(potential))
        if energy_change > 0.011 * upper_bound:
            reported += 1
            assert "the energy changed" in run.status
        elif energy_change < 0.009 * lower_bound:
            assert run.status.startswith("Completed.")
        if energy_change > 1.01 * upper_bound:
            ruined += 1
            assert not run.success and run.status.startswith("Ruined from step ")
        elif energy_change < 0.99 * lower_bound:
            assert run.success
    assert reported > 10 and ruined > 3
