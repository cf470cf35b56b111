"""Bodies without mass."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import galvi
from galvi.run import loop
from galvi.run.clocked import run as clocked
from galvi.run.point_masses import encounters
from references.rebound.ias15 import IAS15
from references.scipy.ivp import DOP853, TIGHT

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


def watched(monkeypatch: pytest.MonkeyPatch, runs: Any = loop) -> list[encounters.MasslessError]:
    """The estimates of the runs that follow, in equal steps or, with ``clocked``, in a clock."""
    seen: list[encounters.MasslessError] = []
    estimate = runs.massless_error

    def noted(*arguments):  # type: ignore[no-untyped-def]
        seen.append(estimate(*arguments))
        return seen[-1]

    monkeypatch.setattr(runs, "massless_error", noted)
    return seen


def binary() -> galvi.Problem:
    """Two equal stars, 3 apart, and a body without mass at half a unit from one of them."""
    q, v = np.zeros((3, 3)), np.zeros((3, 3))
    q[1, 0], v[1, 1] = 3.0, np.sqrt(2.0 / 3.0)
    q[2, 1], v[2, 0] = -0.5, np.sqrt(2.0)
    return galvi.Problem(galvi.NBody([1.0, 1.0, 0.0]), q, v)


@pytest.mark.slow_cases("70000")
@pytest.mark.parametrize("steps", [1, 50, 70_000])
def test_a_step_too_large_for_a_planet_of_a_binary_is_said_to_be(steps: int) -> None:
    """The stars are right to round-off, and so is the energy of the whole."""
    run = galvi.integrate(binary(), method(2, FRAME), 1.0, steps, save_every=steps)
    if steps < 100:
        exact = galvi.integrate(binary(), method(12), 1.0 / 64, 64 * steps, curves=False)
        off = np.linalg.norm(run.q[-1] - exact.q[-1], axis=1)
        assert off[2] > 3e-3 and np.max(off[:2]) < 1e-14
    looked_at = 1 if steps < 100 else 3
    assert run.success and f"an estimate, from {looked_at} of the steps" in run.status, run.status
    assert "a step changes the energy of the massless body 2 by about 0.0" in run.status
    assert "Use a smaller step or a higher degree" in run.status


@pytest.mark.parametrize("chart", [None, FRAME], ids=["inertial", "frame"])
@pytest.mark.parametrize(
    "e, degree, a_turn", [(0.2, 2, 20), (0.2, 6, 4), (0.6, 4, 50), (0.6, 8, 20)]
)
def test_there_is_no_false_alarm(chart, e, degree, a_turn, monkeypatch) -> None:
    seen = watched(monkeypatch)
    run = galvi.integrate(comet(e), method(degree, chart), PERIOD / a_turn, 20 * a_turn)
    assert run.outcome.end is galvi.End.COMPLETED
    assert len(seen) == 1 and seen[0].share < encounters.RESOLVED_ENERGY_CHANGE


@pytest.mark.parametrize("solver", ["auto", "newton"])
def test_the_estimate_is_the_energy_that_the_last_step_changes(solver, monkeypatch) -> None:
    """Against the same step in 64 parts."""
    seen, step, coarse = watched(monkeypatch), PERIOD / 12, method(2)
    before = galvi.integrate(comet(0.2), coarse, step, 99, solver=solver)
    run = galvi.integrate(comet(0.2), coarse, step, 100, solver=solver)
    there = galvi.Problem(run.problem.system, before.q[-1], before.v[-1])
    fine = galvi.integrate(there, coarse, step / 64, 64)

    def energy(state: galvi.Trajectory) -> float:
        q, v = state.q[-1], state.v[-1]
        return 0.5 * np.sum((v[2] - v[0]) ** 2) - 1.0 / np.linalg.norm(q[2] - q[0])

    assert before.success and run.success
    true = abs(energy(run) - energy(fine)) / (2.0 * abs(energy(fine)))
    assert 0.3 * true < seen[1].share < 10.0 * true and seen[1].states == 1


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


def test_ctrl_c_in_the_estimate_keeps_the_run(monkeypatch) -> None:
    def pressed(*arguments):  # type: ignore[no-untyped-def]
        raise KeyboardInterrupt

    monkeypatch.setattr(loop, "massless_error", pressed)
    run = galvi.integrate(comet(0.2), method(6), 0.1, 100)
    with pytest.raises(KeyboardInterrupt):
        print(run.success)
    monkeypatch.undo()
    assert run.success and run.t[-1] == 10.0


def test_a_body_that_a_kernel_moves_wrongly_is_named(monkeypatch) -> None:
    """Planted: whole steps are 1e-2 too fast for one of three bodies without mass."""
    problem = comet(0.2)
    q, v = (np.vstack([x, 1.2 * x[2], 1.5 * x[2]]) for x in (problem.q0, problem.v0))
    problem = galvi.Problem(galvi.NBody([1.0, 1e-3, 0.0, 0.0, 0.0]), q, v / 1.3)
    estimate = loop.massless_error

    def planted(problem, ends):  # type: ignore[no-untyped-def]
        def wrong(n):  # type: ignore[no-untyped-def]
            q, v = ends(n)
            v[:, 3] *= 1.01 if n == 1 else 1.0
            return np.stack([q, v])

        return estimate(problem, wrong)

    sound = galvi.integrate(problem, method(6), 0.1, 100)
    assert sound.outcome.end is galvi.End.COMPLETED
    monkeypatch.setattr(loop, "massless_error", planted)
    run = galvi.integrate(problem, method(6), 0.1, 100)
    assert "massless body 3 by about 0.0" in run.status


@pytest.mark.parametrize("steps", [5, 60, 127, 128, 700])
@pytest.mark.parametrize("runs, clock", [(loop, None), (clocked, galvi.DynamicalTime())])
def test_what_is_done_again_is_a_tenth_of_a_run_at_most(runs, clock, steps, monkeypatch) -> None:
    """A whole step and two halves at each state: the last one, and in a clock the start too."""
    seen = watched(monkeypatch, runs)
    form = galvi.Galerkin(galvi.Polynomials(6), galvi.gauss(6), clock=clock)
    assert galvi.integrate(comet(0.2), form, 0.2, steps).outcome.end is galvi.End.COMPLETED
    assert 3 * seen[0].states <= max(0.1 * steps, 3 if clock is None else 6)


def test_bodies_with_a_mass_alone_are_not_looked_at(monkeypatch) -> None:
    seen = watched(monkeypatch)
    run = galvi.integrate(galvi.problems.outer_solar_system(), method(6), 200.0, 20)
    assert run.success and not seen


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
