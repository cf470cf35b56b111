"""What runs on groups keep: the way back, the form, momentum, energy, the rotation."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

import galvi
from tests.properties.group_matrices import title
from tests.properties.group_motions import (
    ALL,
    EXPONENTIAL,
    FLYING,
    FREE,
    LENGTH,
    PENDULUM,
    collocation,
    each_chart,
    hall,
)


@pytest.mark.slow_cases(
    "3D pendulum, m g = 9.81-packed-Exponential",
    "3D pendulum, m g = 9.81-packed-ModifiedRodrigues",
    "free body on SE(3)-packed-Cayley",
    "free body on SE(3)-packed-Exponential",
    "free body on SE(3)-packed-ModifiedRodrigues",
    "free body on SE(3)-H's-Cayley",
    "free body on SE(3)-H's-Exponential",
    "free body on SE(3)-H's-ModifiedRodrigues",
)
@each_chart
@pytest.mark.parametrize("more", [0, 1], ids=["packed", "H's"])
@pytest.mark.parametrize("problem", [PENDULUM, galvi.problems.heavy_top(), FLYING], ids=title)
def test_backwards_undoes_forwards_to_one_order_more_than_that_of_the_method(problem, more, chart):
    for degree, counts in ((2, (64, 128)), (3, (45, 64))):
        method = galvi.Galerkin(galvi.Polynomials(degree), galvi.gauss(degree + more), chart)
        errors = [galvi.round_trip_error(problem, method, LENGTH / n, n) for n in counts]
        measured = np.log(errors[0] / errors[1]) / np.log(counts[1] / counts[0])
        assert 2 * degree + 0.5 < measured < 2 * degree + 1.5, measured


@pytest.mark.slow_cases(
    "1-pendulum and body", "3-free rigid body", "3-pendulum and body", "H's-pendulum and body"
)
@pytest.mark.parametrize("problem", ALL, ids=title)
@pytest.mark.parametrize(
    "method", [collocation(1), collocation(3, EXPONENTIAL), hall(4)], ids=["1", "3", "H's"]
)
def test_every_step_is_symplectic_in_left_trivialisation(problem, method):
    assert galvi.symplecticity_defect(problem, method, 0.1) < 2e-11


@pytest.mark.slow_cases("collocation-Exponential", "collocation-ModifiedRodrigues")
@each_chart
@pytest.mark.parametrize("method", [collocation, hall])
@given(turn=st.lists(st.floats(-3.0, 3.0), min_size=3, max_size=3))
def test_a_body_that_starts_turned_moves_turned(method, chart, turn):
    Q = Rotation.from_rotvec(turn).as_matrix()
    gravity = PENDULUM.system.potential
    field = galvi.UniformGravity(gravity.mass, gravity.centre, Q @ gravity.g)
    heavy = galvi.Problem(
        galvi.RigidBody(PENDULUM.system.inertia, field), Q @ PENDULUM.q0, PENDULUM.v0
    )
    for problem, turned in (
        (FREE, FREE.with_initial_state(Q @ FREE.q0, FREE.v0)),
        (PENDULUM, heavy),
    ):
        one, two = (galvi.integrate(p, method(5, chart), 0.2, 12) for p in (problem, turned))
        assert np.allclose(two.q, Q @ one.q, rtol=0.0, atol=2e-14)
        assert np.allclose(two.p, one.p, rtol=0.0, atol=2e-13)


@pytest.mark.slow_cases("collocation-Exponential")
@each_chart
@pytest.mark.parametrize("method", [collocation, hall])
def test_momentum_energy_and_the_rotation_stay(method, chart):
    steps = 200_000 if method is collocation else 3000
    run = galvi.integrate(FREE, method(6, chart), 0.2, steps, save_every=steps // 100)
    spatial, energy = galvi.momentum_map(run), galvi.energy(run)
    size = np.linalg.norm(spatial[0])
    assert np.abs(spatial - spatial[0]).max() < 1e-13 * size  # 6e-16 packed, 1.5e-14 with Newton
    assert galvi.orthogonality_defect(run).max() < 2e-15
    off = energy / energy[0] - 1.0
    drift = np.polyfit(np.arange(101) * (steps // 100), off, 1)[0]
    # What rounding leaves in a step is not quite random: 1.0e-17 a step, packed, Cayley.
    assert abs(drift) < (3e-17 if method is collocation else 3e-16)
    assert np.abs(off).max() < 1e-11


@each_chart
def test_the_energy_of_a_swinging_body_has_an_error_that_does_not_grow(chart):
    run = galvi.integrate(PENDULUM, collocation(4, chart), 0.25, 20_000)
    off = np.abs(galvi.energy(run) / galvi.energy(run)[0] - 1.0)
    first, last = off[:2000].max(), off[-2000:].max()
    assert 1e-12 < first < 1e-6 and last < 2.0 * first  # 6e-8 and 1e-11 or so


@pytest.mark.slow(beside="test_momentum_energy_and_the_rotation_stay")
def test_a_million_steps_leave_the_momentum_and_the_rotation_at_round_off():
    run = galvi.integrate(FREE, collocation(10), 0.2, 1_000_000, save_every=1000)
    spatial = galvi.momentum_map(run)
    off = np.linalg.norm(spatial - spatial[0], axis=1) / np.linalg.norm(spatial[0])
    assert off.max() < 1e-13 and galvi.orthogonality_defect(run).max() < 1e-13
    assert off[-100:].max() < 10.0 * np.sqrt(10.0) * off[50:150].max()


@pytest.mark.slow_cases(
    "Cayley-free body on SE(3)",
    "Cayley-pendulum and body",
    "Exponential-free body on SE(3)",
    "Exponential-pendulum and body",
    "ModifiedRodrigues-free body on SE(3)",
    "ModifiedRodrigues-pendulum and body",
)
@pytest.mark.parametrize("problem", ALL, ids=title)
@each_chart
def test_the_curve_goes_through_the_steps_without_a_gap(problem, chart):
    run = galvi.integrate(problem, collocation(5, chart), 0.1, 20)
    size = np.abs(run.q).max()
    assert np.allclose(run(run.t), run.q, rtol=0.0, atol=1e-14 * size)
    before = np.nextafter(run.t[1:], 0.0)
    assert np.allclose(run(before), run.q[1:], rtol=0.0, atol=3e-14 * size)
    t = np.linspace(0.0, 2.0, 33)
    group = problem.system.group
    for g in run(t):
        group.check("g", g)
    assert run(t).shape == (33, *group.shape) and run.velocity(t).shape == (33, group.dimension)
    assert run(0.3).shape == group.shape and run.velocity(0.3).shape == (group.dimension,)
