"""What a turning body conserves, by formulas that do not know how it was computed."""

from __future__ import annotations

import numpy as np
import pytest

import galvi
from benchmarks.measures import independent_invariants, rigid_invariants
from references.textbook.quaternions import QUATERNION_DOP853, QUATERNION_RK4, TIGHT

TOP = galvi.problems.heavy_top()


def test_lagranges_top_keeps_its_three_quantities_and_an_unequal_one_only_two():
    unequal = galvi.Problem(galvi.RigidBody((1.0, 0.8, 0.5), TOP.system.potential), TOP.q0, TOP.v0)
    for problem, kept in ((TOP, True), (unequal, False)):
        run = QUATERNION_DOP853.run(problem, 20.0, {"samples": 40, **TIGHT})
        energy = rigid_invariants.energy(problem, run.q, run.p)
        upward = rigid_invariants.vertical_momentum(problem, run.q, run.p)
        along = rigid_invariants.axial_momentum(problem, run.q, run.p)
        assert np.abs(energy / energy[0] - 1.0).max() < 1e-13  # 1e-14
        assert np.abs(upward / upward[0] - 1.0).max() < 1e-13  # 4e-15
        assert (np.abs(along / along[0] - 1.0).max() < 1e-13) == kept  # 0, and 8e-4
        assert rigid_invariants.orthogonality_defect(run.q).max() < 2e-15  # 7e-16
        assert np.abs(rigid_invariants.spatial_momentum(run.q, run.p)[:, 0]).max() > 0.1


def test_large_steps_are_seen_in_every_quantity():
    run = QUATERNION_RK4.run(TOP, 20.0, {"step": 0.1})
    energy = rigid_invariants.energy(TOP, run.q, run.p)
    upward = rigid_invariants.vertical_momentum(TOP, run.q, run.p)
    assert np.abs(energy / energy[0] - 1.0).max() > 1e-5
    assert np.abs(upward / upward[0] - 1.0).max() > 1e-5


def test_the_values_are_those_written_out():
    """Moments (1, 1, 0.5), m = 1, l = 1, g = 2, spin 8, tilted by 0.5 about x."""
    R, p = TOP.q0[None], TOP.p0[None]
    assert rigid_invariants.energy(TOP, R, p) == pytest.approx(0.5 * 0.5 * 64.0 + 2.0 * np.cos(0.5))
    assert rigid_invariants.vertical_momentum(TOP, R, p) == pytest.approx(4.0 * np.cos(0.5))
    assert rigid_invariants.axial_momentum(TOP, R, p) == pytest.approx(4.0)
    skewed = R + np.array([[0.0, 1e-3, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]])
    assert rigid_invariants.orthogonality_defect(R) < 3e-16
    assert rigid_invariants.orthogonality_defect(skewed) == pytest.approx(1e-3, rel=1e-3)


def test_it_agrees_with_the_textbook_of_velocities_and_with_galvi():
    J = [[3.0, 0.4, 0.2], [0.4, 2.5, -0.3], [0.2, -0.3, 3.4]]
    weight = galvi.UniformGravity(1.3, (0.1, -0.4, 0.6), (1.0, 2.0, -5.0))
    problem = galvi.Problem(galvi.RigidBody(J, weight), TOP.q0, (1.0, -2.0, 0.5))
    run = QUATERNION_DOP853.run(problem, 3.0, {"samples": 6})
    v = problem.system.velocity(run.p)
    energy = rigid_invariants.energy(problem, run.q, run.p)
    np.testing.assert_allclose(energy, independent_invariants.energy(problem, run.q, v), rtol=1e-14)
    known = problem.system.kinetic_energy(v)
    known += problem.system.potential_energy(run.q, run.t)
    np.testing.assert_allclose(energy, known, rtol=1e-13)
    spatial = rigid_invariants.spatial_momentum(run.q, run.p)
    np.testing.assert_allclose(
        spatial, independent_invariants.angular_momentum(problem, run.q, v), atol=1e-14
    )


def test_the_pendulum_has_a_textbook_energy():
    problem = galvi.problems.planar_pendulum(2.0)
    energy = independent_invariants.energy(problem, problem.q0[None], np.array([[0.5]]))
    assert energy == pytest.approx(0.125 - np.cos(2.0))


def test_bodies_without_these_quantities_are_refused():
    free = galvi.problems.free_rigid_body()
    with pytest.raises(TypeError, match="body with UniformGravity"):
        rigid_invariants.vertical_momentum(free, free.q0[None], free.p0[None])
    orbit = galvi.problems.kepler(0.3)
    with pytest.raises(TypeError, match="formula for a RigidBody"):
        rigid_invariants.energy(orbit, orbit.q0[None], orbit.p0[None])
