"""Bodies without mass."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import galvi
from galvi.run import loop
from references.rebound.ias15 import IAS15

PERIOD = 2.0 * np.pi * 2.0**1.5
FRAME = galvi.KeplerFrame()


def comet(e: float) -> galvi.Problem:
    """A star, a planet at 5.2 and a body without mass of semi-major axis 2, at pericentre."""
    q = np.zeros((3, 3))
    v = np.zeros((3, 3))
    q[1, 0], v[1, 1] = 5.2, np.sqrt(1.001 / 5.2)
    q[2, 1], v[2, 0] = -2.0 * (1.0 - e), np.sqrt((1.0 + e) / (1.0 - e) / 2.0)
    return galvi.Problem(galvi.NBody([1.0, 1e-3, 0.0]), q, v)


def method(degree: int, chart: object = None) -> galvi.Galerkin:
    options = {} if chart is None else {"chart": chart}
    return galvi.Galerkin(galvi.Polynomials(degree), galvi.gauss(degree), **options)


def binary() -> galvi.Problem:
    """Two equal stars, 3 apart, and a body without mass at half a unit from one of them."""
    q, v = np.zeros((3, 3)), np.zeros((3, 3))
    q[1, 0], v[1, 1] = 3.0, np.sqrt(2.0 / 3.0)
    q[2, 1], v[2, 0] = -0.5, np.sqrt(2.0)
    return galvi.Problem(galvi.NBody([1.0, 1.0, 0.0]), q, v)


@pytest.mark.slow_cases("70000")
@pytest.mark.parametrize("steps", [1, 50, 70_000])
def test_a_step_too_large_for_a_planet_of_a_binary_is_said_to_be(steps: int) -> None:
    """The stars and the total energy are right to rounding. The estimate repeats a small part of
    the run."""
    run = galvi.integrate(binary(), method(2, FRAME), 1.0, steps, save_every=steps)
    if steps < 100:
        exact = galvi.integrate(binary(), method(12), 1.0 / 64, 64 * steps, curves=False)
        distances = np.linalg.norm(run.q[-1] - exact.q[-1], axis=1)
        assert distances[2] > 3e-3 and np.max(distances[:2]) < 1e-14
    examined_steps = 1 if steps < 100 else 3
    assert run.success and f"an estimate, from {examined_steps} of the steps" in run.status, (
        run.status
    )
    assert "a step changes the energy of the massless body 2 by about 0.0" in run.status


@pytest.mark.parametrize("chart", [None, FRAME], ids=["inertial", "frame"])
@pytest.mark.parametrize(
    ("e", "degree", "steps_per_period"), [(0.2, 2, 20), (0.2, 6, 4), (0.6, 8, 20)]
)
def test_there_is_no_false_alarm(chart: Any, e: float, degree: int, steps_per_period: int) -> None:
    run = galvi.integrate(
        comet(e), method(degree, chart), PERIOD / steps_per_period, 20 * steps_per_period
    )
    assert run.outcome.end is galvi.End.COMPLETED


@pytest.mark.parametrize("solver", ["auto", "newton"])
def test_the_estimate_is_the_energy_that_the_last_step_changes(solver: str) -> None:
    """The estimate is for the massless body that needs the shortest steps, and is compared with the
    same step in 64 parts."""
    q, v = np.zeros((4, 2)), np.zeros((4, 2))
    q[1:, 0] = 2.0, 1.0, 3.0
    v[1:, 1] = np.sqrt(0.8 / q[1:, 0])
    problem, midpoint, step = galvi.Problem(galvi.NBody([1.0, 0.0, 0.0, 0.0]), q, v), method(1), 0.3
    before, run = (galvi.integrate(problem, midpoint, step, n, solver=solver) for n in (6, 7))
    before_last = problem.with_initial_state(before.q[-1], before.v[-1])
    fine = galvi.integrate(before_last, midpoint, step / 64, 64)

    def energies(state: galvi.Trajectory) -> Any:
        q, v = (x[-1, 1:] - x[-1, 0] for x in (state.q, state.v))
        return 0.5 * np.sum(v * v, axis=1) - 1.0 / np.linalg.norm(q, axis=1)

    exact_change = np.max(np.abs((energies(run) - energies(fine)) / (2.0 * energies(fine))))
    stated = re.search(r"energy of the massless body 2 by about (\S+) ", run.status)
    assert stated is not None and 0.3 * exact_change < float(stated[1]) < 10.0 * exact_change


def test_a_step_that_was_not_taken_is_not_judged() -> None:
    """From apocentre almost to pericentre, where steps of this length would be too large."""
    q, v = np.array([[0.0, 0.0], [1.9, 0.0]]), np.array([[0.0, 0.0], [0.0, np.sqrt(0.1 / 1.9)]])
    problem = galvi.Problem(galvi.NBody([1.0, 0.0]), q, v)
    run = galvi.integrate(problem, method(8), 0.2, 15)
    fine = galvi.integrate(problem, method(8), 0.01, 300)
    assert np.max(np.abs(run.q[-1] - fine.q[-1])) < 1e-10 and run.outcome.end is galvi.End.COMPLETED


def test_a_fast_passage_is_measured_by_its_kinetic_energy() -> None:
    q, v = np.array([[0.0, 0.0], [-26.4, 0.5]]), np.array([[0.0, 0.0], [1000.0, 0.0]])
    problem = galvi.Problem(galvi.NBody([1.0, 0.0]), q, v)
    run = galvi.integrate(problem, method(2), 0.008, 6)
    assert "massless body" not in run.status


def test_ctrl_c_in_the_estimate_keeps_the_run(monkeypatch: pytest.MonkeyPatch) -> None:
    def pressed(*arguments: Any) -> Any:
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr(loop, "massless_error", pressed)
        run = galvi.integrate(comet(0.2), method(6), 0.1, 100)
        with pytest.raises(KeyboardInterrupt):
            print(run.success)
    assert run.success and run.t[-1] == 10.0


PLANETS = galvi.problems.outer_solar_system()
EIGHT = method(8)
STEP = 200.0  # days


def with_asteroids(count: int, mass: float = 0.0, seed: int = 1) -> galvi.Problem:
    """The outer planets, and bodies between and beyond them on nearly circular orbits."""
    generator = np.random.default_rng(seed)
    masses, q0, v0 = PLANETS.system.masses, PLANETS.q0, PLANETS.v0
    angle, distances = (
        generator.uniform(0.0, 2 * np.pi, count),
        generator.uniform(13.0, 17.0, count),
    )
    speed, tilt = np.sqrt(masses[0] / distances), generator.normal(0.0, 0.1, count)
    q = np.stack([distances * np.cos(angle), distances * np.sin(angle), tilt], axis=1)
    v = np.stack([-speed * np.sin(angle), speed * np.cos(angle), 0.0 * angle], axis=1)
    return galvi.Problem(
        galvi.NBody(np.append(masses, np.full(count, mass)), PLANETS.system.G),
        np.vstack([q0, q + q0[0]]),
        np.vstack([v0, v + v0[0]]),
    )


def permuted(problem: galvi.Problem, order: np.ndarray) -> galvi.Problem:
    system = galvi.NBody(problem.system.masses[order], problem.system.G)
    return galvi.Problem(system, problem.q0[order], problem.v0[order])


def test_they_move_as_an_independent_code_says_and_do_not_pull():
    problem, planets = with_asteroids(12), PLANETS.q0.shape[0]
    run = galvi.integrate(problem, EIGHT, STEP, 100)
    planets_only = galvi.integrate(PLANETS, EIGHT, STEP, 100)
    by_ias15 = IAS15.run(problem, 100 * STEP, {"samples": 1})
    assert np.max(np.abs(run.q[-1] - by_ias15.q[-1])) < 1e-11
    assert np.max(np.abs(run.v[-1] - by_ias15.v[-1])) < 1e-13
    assert np.max(np.abs(run.q[:, :planets] - planets_only.q)) < 1e-12
    assert not np.any(run.p[:, planets:]) and np.all(np.isfinite(galvi.energy(run)))
    pulling = galvi.integrate(with_asteroids(12, 1e-12), EIGHT, STEP, 100)  # planted
    assert np.max(np.abs(pulling.q[:, :planets] - planets_only.q)) > 1e-8


@settings(max_examples=15)
@given(seed=st.integers(0, 2**32 - 1), count=st.integers(1, 9), plane=st.booleans())
def test_their_place_among_the_bodies_does_not_matter(seed, count, plane):
    problem = with_asteroids(count, seed=seed)
    if plane:
        problem = galvi.Problem(problem.system, problem.q0[:, :2], problem.v0[:, :2])
    order = np.random.default_rng(seed).permutation(problem.q0.shape[0])
    run = galvi.integrate(problem, EIGHT, STEP, 10)
    reordered = galvi.integrate(permuted(problem, order), EIGHT, STEP, 10)
    assert np.max(np.abs(run.q[:, order] - reordered.q)) < 1e-12
    assert np.max(np.abs(run.v[:, order] - reordered.v)) < 1e-14


def test_each_costs_as_much_as_there_are_bodies_that_pull():
    planets = PLANETS.system.masses.size
    assert with_asteroids(0).system.pairs == planets * (planets - 1) // 2
    assert with_asteroids(40).system.pairs - with_asteroids(39).system.pairs == planets
    run = galvi.integrate(with_asteroids(40), EIGHT, STEP, 2)
    pairs = run.counts["force_evaluations"] * with_asteroids(40).system.pairs
    assert pairs <= run.counts["pair_evaluations"] < 1.2 * pairs


def test_a_run_is_saved_and_resumed_with_their_velocities(tmp_path: Path) -> None:
    problem = with_asteroids(3)
    uncut, half = (galvi.integrate(problem, EIGHT, STEP, steps) for steps in (30, 20))
    galvi.save(half, tmp_path / "run.npz")
    loaded = galvi.load(tmp_path / "run.npz")
    resumed = galvi.resume(loaded, 10)
    assert np.array_equal(loaded.v, half.v) and np.array_equal(resumed.v, uncut.v[20:])
    assert np.allclose(uncut.velocity(uncut.t[5]), uncut.v[5], rtol=0, atol=1e-12)
    assert galvi.round_trip_error(problem, EIGHT, STEP, 10) < 1e-12
    assert np.all(galvi.orbital_elements(uncut).semi_major_axis > 0.0)


def test_a_passage_too_fast_for_the_step_is_named_and_two_massless_bodies_do_not_meet():
    star, planet = ([0.0, 0.0], [0.0, 0.0]), ([1.0, 0.0], [0.0, 1.0])
    q0, v0 = np.stack([star[0], planet[0], [1.001, -0.01]]), np.zeros((3, 2))
    v0[1], v0[2] = planet[1], [0.0, 1.2]
    passing = galvi.Problem(galvi.NBody([1.0, 1e-3, 0.0]), q0, v0)
    run = galvi.integrate(passing, EIGHT, 0.05, 20)
    assert "bodies 1 and 2" in run.status and run.status != "Completed."
    coinciding = galvi.Problem(galvi.NBody([1.0, 0.0, 0.0]), q0[[0, 1, 1]], v0[[0, 1, 1]])
    run = galvi.integrate(coinciding, EIGHT, 0.05, 20)
    assert run.status == "Completed." and np.array_equal(run.q[:, 1], run.q[:, 2])


def test_a_belt_of_massless_bodies_stays_a_belt() -> None:
    problem = galvi.problems.outer_solar_system(particles=30)
    run = galvi.integrate(problem, EIGHT, 487.0, 375, save_every=25)  # five hundred years
    assert run.status == "Completed." and problem.parameters["bodies"][-1] == "particle 30"
    distances = np.linalg.norm(run.q[:, 6:], axis=2)
    assert distances.min() > 40.0 and distances.max() < 51.0
    spin = np.cross(run.q[:, 6:], run.v[:, 6:])
    total = galvi.momentum_map(run)[0]
    cosine = spin @ total / np.linalg.norm(spin, axis=2) / np.linalg.norm(total)
    assert cosine[0].min() > 1.0 - 1e-12 and cosine.min() > 0.9995
