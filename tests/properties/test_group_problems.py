"""The physics of problems on groups; every problem, system and group has a run in the tests."""

import inspect
import pickle
from dataclasses import dataclass, fields

import numpy as np
import pytest
from scipy.special import ellipk

import galvi
import galvi.run.saving.files
from galvi.charts import CHARTS
from galvi.groups import GROUPS
from tests.properties.group_matrices import title

ARGUMENTS = {"kepler": (0.3,)}  # arguments of problems that have no defaults for them
ALL_PROBLEMS = [
    getattr(galvi.problems, name)(*ARGUMENTS.get(name, ())) for name in galvi.problems.__all__
]
EIGHT = galvi.Galerkin(galvi.Polynomials(8), galvi.gauss(8))
VERTICAL = np.array([0.0, 0.0, 1.0])


def step_of(problem):
    """A step that resolves the fastest motion of the problem."""
    if hasattr(problem.system, "group"):
        return 0.05
    return {"NBody": 5.0}.get(type(problem.system).__name__, 0.1)


@pytest.mark.slow_cases("chain of 5 rods")
@pytest.mark.parametrize("problem", ALL_PROBLEMS, ids=title)
def test_every_problem_says_what_it_is_and_can_be_run_saved_resumed_and_pickled(problem, tmp_path):
    assert (
        problem.name
        and problem.units
        and isinstance(problem.parameters, dict | type(galvi.problems.kepler(0.1).parameters))
    )
    chart = CHARTS[ALL_PROBLEMS.index(problem) % len(CHARTS)]
    method = galvi.Galerkin(EIGHT.space, EIGHT.rule, chart)
    run = galvi.integrate(problem, method, step_of(problem), 5)
    assert run.success, run.status
    if hasattr(problem.system, "group"):
        for g in run.q:
            problem.system.group.check("q", g)
    energy = galvi.energy(run)
    if not getattr(problem.system, "explicit_time", False):
        assert np.allclose(energy, energy[0], rtol=1e-6, atol=1e-6)
    assert run.to_frame().shape[1] == 1 + problem.q0.size + problem.p0.size
    storable = galvi.run.saving.files.is_storable(problem.system)
    galvi.save(run, tmp_path / "run.npz")
    loaded = galvi.load(tmp_path / "run.npz", *([] if storable else [problem]))
    assert loaded.method == method and loaded.problem.name == problem.name
    copied = pickle.loads(pickle.dumps(problem))
    assert np.array_equal(galvi.integrate(copied, method, step_of(problem), 5).q, run.q)
    assert np.array_equal(galvi.resume(loaded, 3).q, galvi.resume(run, 3).q)


def test_every_system_and_every_group_has_a_run_in_the_tests():
    systems = {type(problem.system) for problem in ALL_PROBLEMS} | {galvi.Lagrangian}
    exported = {value for value in vars(galvi).values() if inspect.isclass(value)}
    assert {kind for kind in exported if hasattr(kind, "velocity_shape")} == systems
    assert {kind for kind in exported if hasattr(kind, "layout")} == {type(g) for g in GROUPS}
    assert {kind for kind in exported if hasattr(kind, "farthest")} == {type(c) for c in CHARTS}


def test_every_system_but_functions_can_be_stored():
    stored = set(galvi.run.saving.files.storable_values().values())
    systems = {type(problem.system) for problem in ALL_PROBLEMS}
    assert systems <= stored and {type(chart) for chart in CHARTS} <= stored
    potentials = {type(getattr(p.system, "potential", None)) for p in ALL_PROBLEMS}
    assert galvi.UniformGravity in stored & potentials
    for kind in stored:
        assert all(field.init or not field.compare for field in fields(kind))


def test_a_value_of_somebody_else_is_not_stored_as_one_of_galvi():
    @dataclass(frozen=True)
    class Polynomials(galvi.Polynomials):
        pass

    assert galvi.run.saving.files.is_storable(galvi.Polynomials(3))
    assert not galvi.run.saving.files.is_storable(Polynomials(3))


@pytest.mark.parametrize("spin", [6.0, 20.0])
def test_the_top_keeps_what_it_should_and_nutates_between_the_roots_of_its_cubic(spin):
    """From rest in the tilt: u = cos(tilt) moves between u0 and the smaller root below it.

    With moments (A, A, C), m g l = 2, p3 = C spin: p_z = p3 u0, and
    A^2 u'^2 / 2 = 2 A (u0 - u)(1 - u^2) - p3^2 (u0 - u)^2 / 2 has the root
    (1 - u^2) 4 A = p3^2 (u0 - u).
    """
    A, p3, u0 = 1.5, 0.5 * spin, np.cos(0.5)
    # 4 A (1 - u^2) = p3^2 (u0 - u)
    smallest_root = min(
        u for u in np.roots([-4.0 * A, p3**2, 4.0 * A - p3**2 * u0]) if abs(u) < 1.0
    )
    run = galvi.integrate(galvi.problems.heavy_top(spin), EIGHT, 0.02, 500)
    height = run(np.linspace(0.0, 10.0, 20_001))[:, 2, 2]
    assert height.max() == pytest.approx(u0, abs=1e-12)
    assert height.min() == pytest.approx(smallest_root, abs=1e-6)
    assert np.ptp(galvi.energy(run)) < 1e-10 * abs(galvi.energy(run)[0])
    about_vertical = galvi.momentum_map(run) @ VERTICAL
    assert np.ptp(about_vertical) < 1e-13 * about_vertical[0]
    assert np.ptp(run.p[:, 2]) < 1e-13 * run.p[0, 2]  # the axis of symmetry
    assert run.p[0, 2] == p3


def test_a_top_sleeps_only_when_it_is_fast():
    """Upright to 1e-3, it stays so for (0.5 spin)^2 > 12, and falls otherwise."""
    for spin, is_upright in ((6.5, False), (7.3, True)):
        run = galvi.integrate(galvi.problems.heavy_top(spin, 1e-3), EIGHT, 0.05, 400)
        assert (run.q[:, 2, 2].min() > 1.0 - 1e-3) == is_upright


@pytest.mark.parametrize(("angle", "rate"), [(2.0, 0.3), (0.4, 3.0)])
def test_the_spherical_pendulum_keeps_energy_and_the_momentum_about_the_vertical(angle, rate):
    problem = galvi.problems.spherical_pendulum(angle, rate)
    run = galvi.integrate(problem, EIGHT, 0.1, 200)
    energy, vertical = galvi.energy(run), galvi.momentum_map(run) @ VERTICAL
    assert energy[0] == pytest.approx(0.5 * (rate * np.sin(angle)) ** 2 - np.cos(angle))
    assert vertical[0] == pytest.approx(rate * np.sin(angle) ** 2)
    assert np.ptp(energy) < 1e-9 and np.ptp(vertical) < 1e-13
    assert np.abs(run.p[:, 2]).max() < 1e-13  # it does not spin about its rod


def test_the_spherical_pendulum_may_swing_round_in_a_cone():
    """At rate^2 = 1 / cos(angle), the height is constant and the azimuth uniform."""
    angle = 0.8
    rate = 1.0 / np.sqrt(np.cos(angle))
    run = galvi.integrate(galvi.problems.spherical_pendulum(angle, rate), EIGHT, 0.1, 100)
    x, y, z = run.q[:, :, 2].T
    assert np.allclose(z, -np.cos(angle), rtol=0.0, atol=1e-12)
    azimuth = np.unwrap(np.arctan2(y, x))
    assert np.allclose(azimuth - azimuth[0], rate * run.t, rtol=0.0, atol=1e-11)


def test_a_spherical_pendulum_without_momentum_about_the_vertical_is_the_plane_one():
    plane = galvi.integrate(galvi.problems.planar_pendulum(1.0), EIGHT, 0.1, 100)
    space = galvi.integrate(galvi.problems.spherical_pendulum(1.0, 0.0), EIGHT, 0.1, 100)
    assert np.allclose(space.q[:, 2, 2], -np.cos(plane.q[:, 0]), rtol=0.0, atol=1e-11)


@pytest.mark.parametrize("amplitude", [0.1, 2.0, 3.14])
def test_the_plane_pendulum_has_its_period(amplitude):
    period = 4.0 * ellipk(np.sin(0.5 * amplitude) ** 2)
    run = galvi.integrate(galvi.problems.planar_pendulum(amplitude), EIGHT, period / 64, 64)
    # Released near the top it is very sensitive there: 2e-9 at 3.14, 1e-13 elsewhere
    assert run.q[-1, 0] == pytest.approx(amplitude, abs=1e-8 if amplitude > 3.1 else 1e-11)
    assert run.q[32, 0] == pytest.approx(-amplitude, abs=1e-8 if amplitude > 3.1 else 1e-11)
    assert abs(run.p[-1, 0]) < (1e-6 if amplitude > 3.1 else 1e-11)


def test_halls_pendulum_hangs_and_stands_as_it_should():
    hanging, standing = galvi.problems.pendulum_3d(), galvi.problems.pendulum_3d(inverted=True)
    hanging_energy, standing_energy = (
        p.system.potential_energy(p.q0, np.zeros(())) for p in (hanging, standing)
    )
    assert hanging_energy == -9.81 and standing_energy == 9.81
    assert np.array_equal(np.diag(hanging.system.inertia), [4.8, 3.0, 3.8])
    assert np.linalg.det(standing.q0) == 1.0


def test_the_free_box_has_the_inertia_of_a_box():
    problem = galvi.problems.free_box()
    second_moments = (
        48.0 * np.array([0.1, 0.2, 0.3]) ** 2 / 3.0
    )  # of half sides, by their mean squares
    assert np.allclose(
        np.diag(problem.system.inertia), second_moments.sum() - second_moments, rtol=1e-14
    )


def test_halls_body_has_the_inertia_of_his_second_moments():
    second_moments = np.diag([1.3, 2.1, 1.2])
    inertia = np.trace(second_moments) * np.eye(3) - second_moments
    assert np.allclose(galvi.problems.free_rigid_body().system.inertia, inertia, atol=1e-15)


def test_a_missing_weight_is_caught_by_the_physics():
    """A top without gravity keeps its energy and all its momenta, but does not nutate."""
    top = galvi.problems.heavy_top()
    free = galvi.Problem(galvi.RigidBody(top.system.inertia), top.q0, top.v0)
    run = galvi.integrate(free, EIGHT, 0.05, 100)
    assert np.ptp(run.q[:, 2, 2]) < 1e-13
