"""Massless bodies: they feel and do not pull, in any order, and keep their velocities."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import galvi
from references.rebound.ias15 import IAS15
from references.scipy.ivp import DOP853, TIGHT

PLANETS = galvi.problems.outer_solar_system()
EIGHT = galvi.Galerkin(galvi.Polynomials(8), galvi.gauss(8))
STEP = 200.0  # days


def with_asteroids(count: int, mass: float = 0.0, seed: int = 1) -> galvi.Problem:
    """The outer planets, and bodies between and beyond them on nearly circular orbits."""
    draw = np.random.default_rng(seed)
    masses, q0, v0 = PLANETS.system.masses, PLANETS.q0, PLANETS.v0
    angle, far = draw.uniform(0.0, 2 * np.pi, count), draw.uniform(13.0, 17.0, count)
    speed, tilt = np.sqrt(masses[0] / far), draw.normal(0.0, 0.1, count)
    q = np.stack([far * np.cos(angle), far * np.sin(angle), tilt], axis=1)
    v = np.stack([-speed * np.sin(angle), speed * np.cos(angle), 0.0 * angle], axis=1)
    return galvi.Problem(
        galvi.NBody(np.append(masses, np.full(count, mass)), PLANETS.system.G),
        np.vstack([q0, q + q0[0]]), np.vstack([v0, v + v0[0]]),
    )  # fmt: skip


def permuted(problem: galvi.Problem, order: np.ndarray) -> galvi.Problem:
    system = galvi.NBody(problem.system.masses[order], problem.system.G)
    return galvi.Problem(system, problem.q0[order], problem.v0[order])


def test_they_move_as_independent_codes_say_and_do_not_pull():
    problem, planets = with_asteroids(12), PLANETS.q0.shape[0]
    run = galvi.integrate(problem, EIGHT, STEP, 100)
    alone = galvi.integrate(PLANETS, EIGHT, STEP, 100)
    for code, setting in ((DOP853, TIGHT), (IAS15, {})):
        other = code.run(problem, 100 * STEP, {"samples": 1, **setting})
        assert np.max(np.abs(run.q[-1] - other.q[-1])) < 1e-11
        assert np.max(np.abs(run.v[-1] - other.v[-1])) < 1e-13
    assert np.max(np.abs(run.q[:, :planets] - alone.q)) < 1e-12
    assert not np.any(run.p[:, planets:]) and np.all(np.isfinite(galvi.energy(run)))
    pulling = galvi.integrate(with_asteroids(12, 1e-12), EIGHT, STEP, 100)  # planted
    assert np.max(np.abs(pulling.q[:, :planets] - alone.q)) > 1e-8


@settings(max_examples=15)
@given(seed=st.integers(0, 2**32 - 1), count=st.integers(1, 9), plane=st.booleans())
def test_their_place_among_the_bodies_does_not_matter(seed, count, plane):
    problem = with_asteroids(count, seed=seed)
    if plane:
        problem = galvi.Problem(problem.system, problem.q0[:, :2], problem.v0[:, :2])
    order = np.random.default_rng(seed).permutation(problem.q0.shape[0])
    run = galvi.integrate(problem, EIGHT, STEP, 10)
    other = galvi.integrate(permuted(problem, order), EIGHT, STEP, 10)
    general = galvi.integrate(permuted(problem, order), EIGHT, STEP, 10, solver="newton")
    for each in (other, general):
        assert np.max(np.abs(run.q[:, order] - each.q)) < 1e-12
        assert np.max(np.abs(run.v[:, order] - each.v)) < 1e-14


def test_each_costs_as_much_as_there_are_bodies_that_pull():
    heavy = PLANETS.system.masses.size
    assert with_asteroids(0).system.pairs == heavy * (heavy - 1) // 2
    assert with_asteroids(40).system.pairs - with_asteroids(39).system.pairs == heavy
    run = galvi.integrate(with_asteroids(40), EIGHT, STEP, 2)
    pairs = run.counts["force_evaluations"] * with_asteroids(40).system.pairs
    assert pairs <= run.counts["pair_evaluations"] < 1.2 * pairs


def jacobi_constants(steps: int, degree: int) -> np.ndarray:
    """Of a massless body in the circular restricted three-body problem, at each step."""
    mu, period = 0.1, 2 * np.pi
    x, y = np.array([[-mu, 0.0], [1.0 - mu, 0.0]]), np.array([[0.0, -mu], [0.0, 1.0 - mu]])
    problem = galvi.Problem(
        galvi.NBody([0.0, 1.0 - mu, mu]), np.vstack([[0.2, 0.1], x]), np.vstack([[0.1, 1.8], y])
    )
    method = galvi.Galerkin(galvi.Polynomials(degree), galvi.gauss(degree))
    run = galvi.integrate(problem, method, period / steps, steps)
    assert run.success
    q, v = run.q[:, 0], run.v[:, 0]
    gaps = [np.linalg.norm(q - run.q[:, k], axis=1) for k in (1, 2)]
    spin = q[:, 0] * v[:, 1] - q[:, 1] * v[:, 0]
    return 0.5 * np.sum(v * v, axis=1) - (1.0 - mu) / gaps[0] - mu / gaps[1] - spin


def test_the_jacobi_constant_is_kept_to_the_order_of_the_method():
    coarse, fine = (np.ptp(jacobi_constants(steps, 3)) for steps in (800, 1600))
    assert 5.4 < np.log2(coarse / fine) < 6.6
    assert np.ptp(jacobi_constants(800, 12)) < 1e-12


def test_a_run_is_saved_resumed_and_returned_with_their_velocities(tmp_path):
    problem = with_asteroids(3)
    whole = galvi.integrate(problem, EIGHT, STEP, 30)
    half = galvi.integrate(problem, EIGHT, STEP, 20)
    galvi.save(half, tmp_path / "run.npz")
    loaded = galvi.load(tmp_path / "run.npz")
    rest = galvi.resume(loaded, 10)
    assert np.array_equal(loaded.v, half.v) and np.array_equal(half.v, whole.v[:21])
    assert np.array_equal(rest.v, whole.v[20:]) and np.array_equal(rest.q, whole.q[20:])
    assert np.allclose(whole.velocity(whole.t[5]), whole.v[5], rtol=0, atol=1e-12)
    assert galvi.round_trip_error(problem, EIGHT, STEP, 10) < 1e-12
    assert np.all(galvi.orbital_elements(whole).semi_major_axis > 0.0)
    plain = galvi.integrate(PLANETS, EIGHT, STEP, 2)
    assert plain.velocities is None
    assert np.allclose(plain.v[0], PLANETS.v0, rtol=1e-15)


def test_a_passage_too_fast_for_the_step_is_named_and_two_massless_bodies_do_not_meet():
    star, planet = ([0.0, 0.0], [0.0, 0.0]), ([1.0, 0.0], [0.0, 1.0])
    q0, v0 = np.stack([star[0], planet[0], [1.001, -0.01]]), np.zeros((3, 2))
    v0[1], v0[2] = planet[1], [0.0, 1.2]
    passing = galvi.Problem(galvi.NBody([1.0, 1e-3, 0.0]), q0, v0)
    run = galvi.integrate(passing, EIGHT, 0.05, 20)
    assert "bodies 1 and 2" in run.status and run.status != "Completed."
    together = galvi.Problem(galvi.NBody([1.0, 0.0, 0.0]), q0[[0, 1, 1]], v0[[0, 1, 1]])
    run = galvi.integrate(together, EIGHT, 0.05, 20)
    assert run.status == "Completed." and np.array_equal(run.q[:, 1], run.q[:, 2])


def test_a_belt_of_massless_bodies_stays_a_belt():
    problem = galvi.problems.outer_solar_system(particles=30)
    run = galvi.integrate(problem, EIGHT, 487.0, 750, save_every=50)  # a thousand years
    assert run.status == "Completed." and problem.parameters["bodies"][-1] == "particle 30"
    far = np.linalg.norm(run.q[:, 6:], axis=2)
    assert far.min() > 40.0 and far.max() < 51.0
    spin = np.cross(run.q[:, 6:], run.v[:, 6:])
    whole = galvi.momentum_map(run)[0]
    cosine = spin @ whole / np.linalg.norm(spin, axis=2) / np.linalg.norm(whole)
    assert cosine[0].min() > 1.0 - 1e-12 and cosine.min() > 0.9995
    with pytest.raises(ValueError, match="particles must be"):
        galvi.problems.outer_solar_system(particles=-1)


@pytest.mark.parametrize("masses", [[0.0, 0.0], [1.0, -1e-9], [1.0, np.nan]])
def test_other_masses_are_refused(masses):
    with pytest.raises(ValueError, match="masses must"):
        galvi.NBody(masses)


def test_what_needs_momenta_that_determine_velocities_is_refused():
    with pytest.raises(ValueError, match="massless bodies is always 0"):
        galvi.symplecticity_defect(with_asteroids(1), EIGHT, STEP)
    asteroid = galvi.Problem(galvi.NBody([1.0, 0.0]), [[0.0, 0.0], [1.0, 0.0]], np.zeros((2, 2)))
    with pytest.raises(ValueError, match="at the same point"):
        galvi.Problem(asteroid.system, [[1.0, 0.0], [1.0, 0.0]], np.zeros((2, 2)))
