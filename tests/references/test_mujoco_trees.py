"""Trees as MuJoCo's models, its integrators on them, and DOP853 on its accelerations."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import galvi
from references.mujoco.accelerations_ivp import MUJOCO_ACCELERATIONS
from references.mujoco.body import MujocoTree
from references.mujoco.steps import MUJOCO_RK4
from tests.properties.random_trees import random_state, random_tree
from tests.properties.tree_equations import defects

mujoco = pytest.importorskip("mujoco")
EIGHT = galvi.Galerkin(galvi.Polynomials(8), galvi.gauss(8))
ARM, FLOATING = galvi.problems.skew_arm(damping=0.2), galvi.problems.skew_arm(floating=True)


@settings(max_examples=30)
@given(st.integers(1, 8), st.integers(0, 2**32 - 1))
def test_a_tree_written_as_mjcf_is_the_same_tree(joints, seed):
    system = galvi.from_mujoco(random_tree(joints, seed)).system
    model = mujoco.MjModel.from_xml_string(MujocoTree(system).mjcf())
    assert np.max(defects(model, system, *random_state(model, seed))[[0, 2]]) < 1e-11


@pytest.mark.slow_cases("floating arm")
@pytest.mark.parametrize("problem", [ARM, FLOATING], ids=lambda problem: problem.name)
def test_dop853_on_mujoco_s_accelerations_finds_galvi_s_motion(problem):
    ours = galvi.integrate(problem, EIGHT, 0.01, 50)
    theirs = MUJOCO_ACCELERATIONS.run(problem, 0.5, {"samples": 2})
    assert theirs.success and np.max(np.abs(theirs.q[1:] - ours.q[25::25])) < 1e-12  # 1e-14
    assert np.max(np.abs(theirs.p[1:] - ours.p[25::25])) < 1e-11


def test_a_tree_with_an_anchor_on_the_other_side_would_be_seen():
    system = galvi.from_mujoco(random_tree(4, 3, kinds=("hinge",))).system
    links = [replace(link, joints=[replace(joint, anchor=-joint.anchor) for joint in link.joints])
             for link in system.links]  # fmt: skip
    model = mujoco.MjModel.from_xml_string(MujocoTree(system).mjcf())
    wrong = galvi.Multibody(links, system.gravity)
    assert defects(model, wrong, *random_state(model, 1))[0] > 1e-3


def test_a_spring_that_mjcf_cannot_say_is_not_taken():
    turned = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    for rest, taken in ((None, True), (turned, False)):
        ball = galvi.Joint("ball", stiffness=1.0, rest=rest)
        system = galvi.Multibody(galvi.Link(ball, 1.0, (0, 0, 1), (0.1, 0.1, 0.1)))
        problem = galvi.Problem(system, np.eye(3), [0.0, 0.0, 1.0])
        assert MUJOCO_RK4.supports(problem) is MUJOCO_ACCELERATIONS.supports(problem) is taken


def test_who_does_not_take_trees_says_so():
    from references.scipy.rigid_ivp import RIGID_DOP853

    with pytest.raises(ValueError, match="does not solve this kind of problem"):
        RIGID_DOP853.run(ARM, 1.0, {"samples": 1})
