"""Trees of rigid bodies: accelerations, energies, states and motions against MuJoCo's."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import galvi
from galvi.tracing.laws_of_systems import lines_of
from tests.properties.random_trees import FLAGS, random_state, random_tree
from tests.properties.tree_equations import defects

mujoco = pytest.importorskip("mujoco")

SIX = galvi.Galerkin(galvi.Polynomials(6), galvi.gauss(6))
TOLERANCE = 1e-12  # 2e-14 measured over 300 trees


def problem_of(xml, seed):
    """MuJoCo's model of the MJCF, and galvi's problem with a random start."""
    model = mujoco.MjModel.from_xml_string(xml)
    problem = galvi.from_mujoco(model)
    return model, problem.with_initial_state(
        *problem.system.from_mujoco(*random_state(model, seed))
    )


def distances_of_mujoco(model, run, h):
    """The distances of MuJoCo's RK4 with steps h and h / 2 from the end of a run."""
    system, distances = run.problem.system, []
    for step in (h, 0.5 * h):
        mj_data = mujoco.MjData(model)
        model.opt.timestep, model.opt.integrator = step, mujoco.mjtIntegrator.mjINT_RK4
        mj_data.qpos[:], mj_data.qvel[:] = system.to_mujoco(run.q[0], run.problem.v0)
        mujoco.mj_step(model, mj_data, nstep=round(run.t[-1] / step))
        distances.append(
            np.max(np.abs(system.from_mujoco(mj_data.qpos, mj_data.qvel)[0] - run.q[-1]))
        )
    return distances


@pytest.mark.slow(beside="test_a_planted_fault_of_a_tree_is_seen")
@settings(max_examples=200)
@given(st.integers(1, 12), st.integers(0, 2**32 - 1))
def test_200_random_trees_have_the_accelerations_energies_and_states_of_mujoco(joints, seed):
    model = mujoco.MjModel.from_xml_string(random_tree(joints, seed))
    system = galvi.from_mujoco(model).system
    qpos, qvel = random_state(model, seed)
    assert np.max(defects(model, system, qpos, qvel)) < TOLERANCE
    q, v = system.from_mujoco(qpos, qvel)
    returned = system.to_mujoco(q, v)
    np.testing.assert_allclose(returned[1], qvel, rtol=0, atol=1e-13)  # 2e-15
    np.testing.assert_allclose(system.from_mujoco(*returned)[0], q, rtol=0, atol=1e-14)
    # one quaternion or its negative
    np.testing.assert_allclose(np.abs(returned[0]), np.abs(qpos), rtol=0, atol=1e-14)


def test_the_armature_and_damping_of_motors_are_those_of_their_joints():
    xml = random_tree(4, 2, kinds=("hinge", "slide")).replace("<joint ", '<joint name="j" ', 1)
    motor = '<actuator><general joint="j" gear="3" armature="0.5" damping="0.2"/></actuator>'
    flags = '<flag contact="disable" actuation="disable"/>'
    with_motor = xml.replace("</mujoco>", f"{motor}</mujoco>").replace(FLAGS, flags)
    model = mujoco.MjModel.from_xml_string(with_motor)
    state = random_state(model, 1)
    assert np.max(defects(model, galvi.from_mujoco(model).system, *state)) < TOLERANCE
    assert np.min(defects(model, galvi.from_mujoco(xml).system, *state)[[0, 2]]) > 1e-3


def on_joints(change):
    return lambda link: replace(link, joints=[change(joint) for joint in link.joints])


@pytest.mark.parametrize(
    ("fault", "faulty_rows"),
    [
        (on_joints(lambda joint: replace(joint, anchor=-joint.anchor)), (0, 2, 3)),
        (on_joints(lambda joint: replace(joint, armature=0.0)), (0, 2)),
        (on_joints(lambda joint: replace(joint, rest=None)), (0, 3)),
        (lambda link: replace(link, centre=-link.centre), (0, 2, 3)),
        (lambda link: replace(link, attitude=link.attitude.T), (0, 2, 3)),
        (lambda link: replace(link, inertia=link.inertia + 0.01 * np.eye(3)), (0, 2)),
    ],
    ids=["anchor", "armature", "rest", "centre", "attitude", "inertia"],
)
def test_a_planted_fault_of_a_tree_is_seen(fault, faulty_rows):
    model = mujoco.MjModel.from_xml_string(random_tree(8, 5, kinds=("hinge", "slide", "ball")))
    right = galvi.from_mujoco(model).system
    wrong = galvi.Multibody([fault(link) for link in right.links], right.gravity)
    state = random_state(model, 1)
    assert np.max(defects(model, right, *state)) < TOLERANCE
    assert np.min(defects(model, wrong, *state)[list(faulty_rows)]) > 1e-5


def test_a_tree_of_more_than_40_velocities_has_no_law_for_lanes():
    for joints, has_law in ((40, True), (41, False)):
        _, problem = problem_of(random_tree(joints, 1, kinds=("hinge",)), 1)
        assert problem.v0.size == joints and bool(lines_of(problem.system.tree)) is has_law


@pytest.mark.slow_cases("a free joint, a slide and a ball")
@pytest.mark.parametrize(
    ("joints", "seed", "kinds"),
    [(3, 8, ("hinge", "slide")), (3, 1, ("hinge", "slide", "ball", "free"))],
    ids=["hinges and slides", "a free joint, a slide and a ball"],
)
def test_a_motion_is_that_of_mujoco_and_the_same_in_lanes_and_in_the_general_kernel(
    joints, seed, kinds
):
    model, problem = problem_of(random_tree(joints, seed, kinds=kinds), seed)
    runs = [
        galvi.integrate(problem, SIX, 0.01, 40, solver=solver)
        for solver in ("fixed_point", "newton")
    ]
    assert all(run.success for run in runs)
    np.testing.assert_allclose(runs[0].q, runs[1].q, rtol=0, atol=1e-12)  # 2e-14
    distance_of_coarse, distance = distances_of_mujoco(model, runs[0], 4e-4)
    assert distance < 1e-9 and (distance_of_coarse > 8.0 * distance or distance < 1e-12)


FLOATING = galvi.problems.skew_arm(floating=True)


def test_the_momenta_of_a_floating_tree_are_kept_and_those_of_its_free_joint():
    run = galvi.integrate(FLOATING, SIX, 0.05, 200)
    assert run.success and np.ptp(galvi.energy(run)) < 1e-13  # 2e-15
    x, R, linear = run.q[:, :3], run.q[:, 3:12].reshape(-1, 3, 3), run.p[:, :3]
    angular = np.einsum("nij,nj->ni", R, run.p[:, 3:6]) + np.cross(x, linear)
    assert np.max(np.ptp(linear, axis=0)) < 1e-13  # 4e-15
    assert np.max(np.ptp(angular, axis=0)) < 1e-12  # 4e-15
    np.testing.assert_allclose(galvi.linear_momentum(run), linear, rtol=0, atol=1e-13)
    np.testing.assert_allclose(galvi.momentum_map(run), angular, rtol=0, atol=1e-12)
    between = galvi.momentum_map(run, [1.234, 5.678])
    np.testing.assert_allclose(between, angular[:2], rtol=0, atol=1e-4)  # not kept between steps
    assert galvi.momentum_map(run, []).shape == galvi.linear_momentum(run, []).shape == (0, 3)


@settings(max_examples=20)
@given(st.integers(1, 8), st.integers(0, 2**32 - 1))
def test_the_momenta_and_energies_of_a_tree_are_those_that_mujoco_adds_up(joints, seed):
    model, problem = problem_of(random_tree(joints, seed), seed)
    mj_data, tree = mujoco.MjData(model), problem.system.tree
    mj_data.qpos[:], mj_data.qvel[:] = problem.system.to_mujoco(problem.q0, problem.v0)
    mujoco.mj_forward(model, mj_data)
    mujoco.mj_subtreeVel(model, mj_data)
    mass, centre = model.body_subtreemass[0], mj_data.subtree_com[0]
    linear = mass * mj_data.subtree_linvel[0]
    expected = np.concatenate([mj_data.subtree_angmom[0] + np.cross(centre, linear), linear])
    momenta = tree.momenta(problem.q0[None], problem.v0[None])[0]
    np.testing.assert_allclose(momenta, expected, rtol=0, atol=1e-13 * np.max(np.abs(expected)))
    mujoco.mj_energyPos(model, mj_data)
    mujoco.mj_energyVel(model, mj_data)
    L, at_rest, _ = tree.at_states(problem.q0[None], problem.v0[None], np.zeros(1))
    size = (
        np.abs(mj_data.xipos @ model.opt.gravity) @ model.body_mass + np.abs(mj_data.energy).sum()
    )
    energies = [-at_rest[0], L[0] - at_rest[0]]
    np.testing.assert_allclose(energies, mj_data.energy, rtol=0, atol=1e-12 * size)


@pytest.mark.slow_cases("Problem('floating arm', q0 of shape (15,))")
@pytest.mark.parametrize("problem", [galvi.problems.skew_arm(), FLOATING], ids=str)
def test_steps_of_a_tree_are_symplectic(problem):
    method = galvi.Galerkin(galvi.Polynomials(2), galvi.gauss(2))
    assert galvi.symplecticity_defect(problem, method, 0.01) < 1e-10  # 2e-12


def test_a_damped_tree_is_not_symplectic_and_loses_what_its_energy_says():
    braked = galvi.problems.skew_arm(damping=0.1)
    assert galvi.symplecticity_defect(braked, SIX, 0.01) > 1e-3
    run = galvi.integrate(braked, SIX, 0.01, 50)
    nodes, weights = np.polynomial.legendre.leggauss(8)
    times = 0.01 * (np.arange(50)[:, None] + 0.5 + nodes / 2)
    power = 0.1 * np.sum(run.velocity(times.ravel()) ** 2, axis=1).reshape(times.shape)
    energy_loss = galvi.energy(run)[0] - galvi.energy(run)[-1]
    assert energy_loss == pytest.approx(float(np.sum(power @ weights) * 0.005), rel=1e-8)


def energy_errors(seed, damping=0.0):
    """The largest energy error in 100,000 steps and its drift over all, relative to the largest
    kinetic energy."""
    kinds = (("hinge",), ("hinge", "slide"), ("ball", "hinge"), ("hinge", "slide", "ball"))[seed]
    _, problem = problem_of(random_tree(3, seed, damping=False, kinds=kinds), seed)
    braked = problem.system.with_numbers(damping=[damping] * len(problem.system.tree.joints))
    run = galvi.integrate(replace(problem, system=braked), SIX, 0.005, 100_000, save_every=100)
    assert run.success
    error = galvi.energy(run) - galvi.energy(run)[0]
    error /= 0.5 * np.max(np.sum(run.p * run.v, axis=1))
    return np.max(np.abs(error)), np.polyfit(np.linspace(0.0, 1.0, error.size), error, 1)[0]


@pytest.mark.slow(beside="test_the_momenta_of_a_floating_tree_are_kept_and_those_of_its_free_joint")
@pytest.mark.parametrize("seed", range(4))
def test_energies_of_conservative_trees_do_not_drift_over_100_000_steps(seed):
    largest, drift = energy_errors(seed)
    assert largest < 1e-13 and abs(drift) < 1e-14  # 1.3e-15 and 3.3e-16


@pytest.mark.slow(beside="test_a_damped_tree_is_not_symplectic_and_loses_what_its_energy_says")
def test_a_damping_that_takes_a_trillionth_of_the_energy_would_be_seen():
    assert energy_errors(0, 1e-14)[1] < -1e-13
