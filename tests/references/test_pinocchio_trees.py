"""Trees of rigid bodies in Pinocchio: accelerations and motions, those of galvi and MuJoCo."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

import galvi
from references.mujoco.accelerations_ivp import MUJOCO_ACCELERATIONS
from references.pinocchio.tree import PINOCCHIO_ACCELERATIONS, PinocchioTree
from tests.properties.random_trees import random_state, random_tree
from tests.properties.tree_equations import terms

pytest.importorskip("pinocchio")
mujoco = pytest.importorskip("mujoco")
EIGHT = galvi.Galerkin(galvi.Polynomials(8), galvi.gauss(8))
RESIDUAL_BOUND = 1e-12  # 2e-14 measured for 300 trees


def state_of(model, seed):
    """(galvi's system of a model, random qpos, random qvel)."""
    return galvi.from_mujoco(model).system, *random_state(model, seed)


def relative_residual(system, qpos, qvel, acceleration):
    """|M a - tau| over |tau|, by galvi's Lagrangian."""
    q, v = system.from_mujoco(qpos, qvel)
    tau = terms(system, q, v).sum(axis=0)
    return np.linalg.norm(system.tree.mass(q) @ acceleration - tau) / np.linalg.norm(tau)


@settings(max_examples=200)
@given(st.integers(1, 12), st.integers(0, 2**32 - 1))
def test_200_random_trees_have_one_acceleration_in_three_codes(joints, seed):
    model = mujoco.MjModel.from_xml_string(random_tree(joints, seed))
    system, qpos, qvel = state_of(model, seed)
    accelerations = PinocchioTree.of(system).accelerations(qpos, qvel)
    assert relative_residual(system, qpos, qvel, accelerations) < RESIDUAL_BOUND
    mj_data = mujoco.MjData(model)
    mj_data.qpos[:], mj_data.qvel[:] = qpos, qvel
    mujoco.mj_forward(model, mj_data)
    assert np.linalg.norm(accelerations - mj_data.qacc) < 1e-11 * np.linalg.norm(
        mj_data.qacc
    )  # 2e-14


@settings(max_examples=20)
@given(st.integers(2, 6), st.integers(0, 2**32 - 1))
def test_springs_of_balls_at_rest_where_mjcf_cannot_say_are_galvis(joints, seed):
    model = mujoco.MjModel.from_xml_string(random_tree(joints, seed, kinds=("ball", "hinge")))
    plain, qpos, qvel = state_of(model, seed)
    rest_rotation = Rotation.from_rotvec([0.3, -0.2, 0.5]).as_matrix()

    def sprung(joint):
        return replace(joint, rest=rest_rotation, stiffness=1.5) if joint.type == "ball" else joint

    links = [replace(link, joints=[sprung(joint) for joint in link.joints]) for link in plain.links]
    system = galvi.Multibody(links, plain.gravity)
    assert (
        relative_residual(system, qpos, qvel, PinocchioTree.of(system).accelerations(qpos, qvel))
        < RESIDUAL_BOUND
    )


@pytest.mark.parametrize(("joints", "seed"), [(3, 8), (4, 1), (6, 2)])
def test_motions_of_random_trees_are_those_of_galvi_and_of_mujoco(joints, seed):
    model = mujoco.MjModel.from_xml_string(random_tree(joints, seed, springs=False))
    system, *state = state_of(model, seed)
    problem = galvi.Problem(system, *system.from_mujoco(*state))
    by_galvi = galvi.integrate(problem, EIGHT, 0.005, 60)
    for contender in (PINOCCHIO_ACCELERATIONS, MUJOCO_ACCELERATIONS):
        by_contender = contender.run(problem, 0.3, {"samples": 3})
        assert by_contender.success
        np.testing.assert_allclose(by_contender.q, by_galvi.q[::20], rtol=0, atol=1e-11)  # 2e-13


@pytest.mark.parametrize(
    "fault",
    [
        lambda joint: replace(joint, anchor=-joint.anchor),
        lambda joint: replace(joint, armature=0.0),
        lambda joint: replace(joint, damping=0.0),
        lambda joint: replace(joint, rest=None),
    ],
    ids=["anchor", "armature", "damping", "rest"],
)
def test_a_planted_fault_of_a_tree_is_seen(fault):
    model = mujoco.MjModel.from_xml_string(random_tree(8, 5))
    system, qpos, qvel = state_of(model, 1)
    links = [replace(link, joints=[fault(joint) for joint in link.joints]) for link in system.links]
    wrong = PinocchioTree.of(galvi.Multibody(links, system.gravity))
    assert (
        relative_residual(system, qpos, qvel, PinocchioTree.of(system).accelerations(qpos, qvel))
        < RESIDUAL_BOUND
    )
    assert relative_residual(system, qpos, qvel, wrong.accelerations(qpos, qvel)) > 1e-5
