"""Runs on groups: reversal, symplecticity, momentum, energy and orthogonality."""

from itertools import cycle

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

import galvi
from galvi.charts import CHARTS
from tests.properties.group_matrices import title
from tests.properties.group_motions import (
    ALL,
    DURATION,
    EXPONENTIAL,
    FREE,
    PENDULUM,
    collocation,
    each_chart,
    hall,
)

SPINNING = galvi.Problem(
    galvi.FreeBody(2.0, (1.0, 2.0, 2.5)), np.eye(4), [0.3, 1.0, 0.2, 0.5, -0.4, 0.7]
)


@pytest.mark.slow_cases("packed-Exponential", "packed-ModifiedRodrigues")
@each_chart
@pytest.mark.parametrize("extra_points", [0, 1], ids=["packed", "H's"])
def test_backwards_undoes_forwards_to_one_order_more_than_that_of_the_method(extra_points, chart):
    for degree, counts in ((2, (64, 128)), (3, (45, 64))):
        method = galvi.Galerkin(
            galvi.Polynomials(degree), galvi.gauss(degree + extra_points), chart
        )
        errors = [galvi.round_trip_error(PENDULUM, method, DURATION / n, n) for n in counts]
        measured = np.log(errors[0] / errors[1]) / np.log(counts[1] / counts[0])
        assert 2 * degree + 0.5 < measured < 2 * degree + 1.5, measured


@pytest.mark.parametrize("problem", ALL, ids=title)
def test_backwards_undoes_forwards_for_degree_one_in_the_exponential_chart(problem):
    """exp(-x) exp((1 - tau) x) = exp(-tau x): the same curve from its other end."""
    for method in (collocation(1, EXPONENTIAL), hall(2, EXPONENTIAL)):
        assert galvi.round_trip_error(problem, method, 0.02, 100) < 2e-13  # 6e-14, while falling


@pytest.mark.slow_cases("pendulum and body-Galerkin")
@pytest.mark.parametrize(
    ("problem", "method"),
    list(zip(ALL, cycle([hall(4), collocation(1), collocation(3, EXPONENTIAL)]), strict=False)),
    ids=title,
)
def test_every_step_is_symplectic_in_left_trivialisation(problem, method):
    assert galvi.symplecticity_defect(problem, method, 0.1) < 2e-11


@pytest.mark.slow_cases("collocation-Exponential", "collocation-ModifiedRodrigues")
@each_chart
@pytest.mark.parametrize("method", [collocation, hall])
@given(rotation_vector=st.lists(st.floats(-3.0, 3.0), min_size=3, max_size=3))
@settings(max_examples=8)
def test_a_body_that_starts_turned_moves_turned(method, chart, rotation_vector):
    Q = Rotation.from_rotvec(rotation_vector).as_matrix()
    gravity = PENDULUM.system.potential
    field = galvi.UniformGravity(gravity.mass, gravity.centre, Q @ gravity.g)
    rotated_pendulum = galvi.Problem(
        galvi.RigidBody(PENDULUM.system.inertia, field), Q @ PENDULUM.q0, PENDULUM.v0
    )
    for problem, rotated in (
        (FREE, FREE.with_initial_state(Q @ FREE.q0, FREE.v0)),
        (PENDULUM, rotated_pendulum),
    ):
        unrotated_run, rotated_run = (
            galvi.integrate(p, method(5, chart), 0.2, 12) for p in (problem, rotated)
        )
        assert np.allclose(rotated_run.q, Q @ unrotated_run.q, rtol=0.0, atol=2e-14)
        assert np.allclose(rotated_run.p, unrotated_run.p, rtol=0.0, atol=2e-13)


@each_chart
@pytest.mark.parametrize(
    ("problem", "method", "steps", "drift"),
    [
        # Rounding is not quite random: 1.0e-17 a step for the packed method in Cayley's chart.
        (FREE, collocation, 50_000, 3e-17),
        (FREE, hall, 10_000, 1e-16),
        (SPINNING, collocation, 10_000, 1e-16),
    ],
    ids=["packed", "H's", "flying"],
)
def test_momenta_energy_and_the_rotation_stay(problem, method, steps, drift, chart):
    """The rounding of the moment of the linear momentum limits the spin of a body far away."""
    run = galvi.integrate(problem, method(6, chart), 0.2, steps, save_every=steps // 100)
    distance = np.linalg.norm(run.q[:, :3, 3:], axis=1).max(initial=0.0)
    moment_rounding = 2.0**-52 * distance * np.linalg.norm(run.p[0, 3:])
    for mu in np.split(run.p, run.p.shape[1] // 3, axis=1):
        spatial = np.einsum("kij,kj->ki", run.q[:, :3, :3], mu)
        size = np.linalg.norm(spatial[0])
        assert np.abs(spatial - spatial[0]).max() < 3e-14 * size + moment_rounding  # 6e-16, packed
    assert galvi.orthogonality_defect(run).max() < 2e-15
    energy_errors = galvi.energy(run) / galvi.energy(run)[0] - 1.0
    assert abs(np.polyfit(np.arange(101) * (steps // 100), energy_errors, 1)[0]) < drift
    assert np.abs(energy_errors).max() < 1e-11


@pytest.mark.slow(beside="test_momenta_energy_and_the_rotation_stay")
def test_a_million_steps_leave_the_momentum_and_the_rotation_at_round_off():
    run = galvi.integrate(FREE, collocation(10), 0.2, 1_000_000, save_every=1000)
    spatial = galvi.momentum_map(run)
    momentum_errors = np.linalg.norm(spatial - spatial[0], axis=1) / np.linalg.norm(spatial[0])
    assert momentum_errors.max() < 1e-13 and galvi.orthogonality_defect(run).max() < 1e-13
    assert momentum_errors[-100:].max() < 10.0 * np.sqrt(10.0) * momentum_errors[50:150].max()


@each_chart
def test_the_energy_of_a_swinging_body_has_an_error_that_does_not_grow(chart):
    run = galvi.integrate(PENDULUM, collocation(4, chart), 0.25, 20_000)
    energy_errors = np.abs(galvi.energy(run) / galvi.energy(run)[0] - 1.0)
    first, last = energy_errors[:2000].max(), energy_errors[-2000:].max()
    assert 1e-12 < first < 1e-6 and last < 2.0 * first  # 6e-8 and 1e-11 or so


@pytest.mark.slow_cases("pendulum and body-Exponential")
@pytest.mark.parametrize(
    ("problem", "chart"), list(zip(ALL, cycle(CHARTS), strict=False)), ids=title
)
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
    assert run.velocity(t).shape == (33, group.dimension)
    assert run(0.3).shape == group.shape and run.velocity(0.3).shape == (group.dimension,)
