"""Ensembles of trees whose forces have branches, and forces that depend on masses, against MuJoCo
and closed forms."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import galvi

mujoco = pytest.importorskip("mujoco")

EIGHT = galvi.Galerkin(galvi.Polynomials(8), galvi.gauss(8))
HINGE = """<mujoco>{option}<worldbody><body><joint name="a" axis="0 1 0" {joint}/>
<inertial pos="0 0 -.5" mass="1" diaginertia=".1 .2 .1"/></body></worldbody>{more}</mujoco>"""
SERVO = '<actuator><position name="drive" joint="a" kp="10" {}/></actuator>'
BRANCHES = {
    "a limit of a force": {"more": SERVO.format('forcerange="-9 9"')},
    "a limit on a joint": {"joint": 'actuatorfrcrange="-9 9"', "more": SERVO.format("")},
    "a medium": {"option": '<option density="100" viscosity=".1" wind="1 2 3"/>'},
    "damping by |v|": {"joint": 'damping=".1 2 3"'},
    "slack": {
        "more": """<tendon><fixed stiffness="3 4 5" springlength="-.1 .2">
        <joint joint="a" coef="2"/></fixed></tendon>"""
    },
}
STARTS = np.array([[0.5, 1.0], [-0.5, -1.0], [0.05, 0.1], [0.6, 0.2]])  # q, v
MASSES = np.array([[1.0], [4.0], [0.5], [2.0]])


def hinge(name: str) -> galvi.Problem:
    return galvi.from_mujoco(
        HINGE.format(**{"option": "", "joint": "", "more": ""} | BRANCHES[name])
    )


def members(problem: galvi.Problem, rows: list[int], vary_masses: bool, **options: Any) -> Any:
    parameters = {"masses": MASSES[rows]} if vary_masses else None
    q, v = STARTS[rows, :1], STARTS[rows, 1:]
    return galvi.integrate_ensemble(problem, q, v, EIGHT, 0.02, 5, parameters=parameters, **options)


@pytest.mark.slow_cases(but=["a medium-masses"])
@pytest.mark.parametrize("vary_masses", [False, True], ids=["", "masses"])
@pytest.mark.parametrize("name", BRANCHES)
def test_members_with_branches_are_runs_by_themselves(name: str, vary_masses: bool) -> None:
    problem = hinge(name)
    ends = members(problem, [0, 1, 2, 3], vary_masses)
    q, p = members(problem, [0, 1, 2, 3], vary_masses, keep=galvi.StatesAt([0.0, 0.04, 0.1])).kept
    assert set(ends.status) == {"Completed."}
    for k in range(4):
        system = problem.system.with_numbers(masses=MASSES[k]) if vary_masses else problem.system
        run = galvi.integrate(galvi.Problem(system, *STARTS[k][:, None]), EIGHT, 0.02, 5)
        assert run.success
        np.testing.assert_allclose(q[k], run.q[[0, 2, 5]], rtol=0, atol=1e-14)  # 6e-17
        np.testing.assert_allclose(p[k], run.p[[0, 2, 5]], rtol=0, atol=1e-13)  # 4e-16
    subset = members(problem, [3, 1], vary_masses)
    assert np.array_equal(np.asarray(subset), np.asarray(ends)[[3, 1]])


def test_a_member_beyond_a_limit_fails_alone() -> None:
    problem = hinge("a limit on a joint")
    starts = np.array([[0.1, 0.0], [0.1, 9.0], [0.95, 0.0]])  # the last starts beyond the limit
    ends = galvi.integrate_ensemble(problem, starts[:, :1], starts[:, 1:], EIGHT, 0.02, 40)
    run = galvi.integrate(problem.with_initial_state(*starts[1][:, None]), EIGHT, 0.02, 40)
    assert ends.status[0] == "Completed." and ends.status[1].startswith(run.status)
    assert ends.failed_step.tolist() == [0, run.failed_step, 1] and run.failed_step
    assert "at the start. Start elsewhere" in ends.status[2]
    assert np.all(np.isnan(np.asarray(ends)[1:])) and np.all(np.isfinite(np.asarray(ends)[0]))


# ---------------------------------------------------------------- forces that follow masses

TREE = """<mujoco><option density="100" viscosity=".1" wind="1 0 2"/><worldbody>
<body gravcomp=".5"><joint axis="0 1 0" armature=".1" springdamper=".5 .8"/>
<inertial pos="0 0 -.4" mass="1" diaginertia=".02 .03 .01"/>
<body pos="0 0 -1" gravcomp="2"><joint name="b" axis="1 0 .3" armature=".1"/>
<inertial pos="0 .1 -.4" mass="1" diaginertia=".02 .03 .01" quat="1 .2 .4 .3"/>
</body></body></worldbody>
<actuator><position joint="b" kp="3" dampratio=".7"/></actuator></mujoco>"""
VARIED_MASSES = [[1.0, 1.0], [4.0, 0.3], [0.0, 1.0], [2.0, 0.0]]


def test_forces_follow_masses_as_in_mujoco() -> None:
    """Stiffness and damping that MuJoCo's compiler derived from the masses stay as they were."""
    problem, model = galvi.from_mujoco(TREE), mujoco.MjModel.from_xml_string(TREE)
    mj_data, q, v = mujoco.MjData(model), [0.3, 0.7], [1.0, -2.0]
    for masses in VARIED_MASSES:
        model.body_mass[1:], mj_data.qpos[:], mj_data.qvel[:] = masses, q, v
        mujoco.mj_forward(model, mj_data)
        system = problem.system.with_numbers(masses=masses)
        assert system.acceleration(q, v) == pytest.approx(mj_data.qacc, rel=1e-12)  # 2e-14


def test_the_speed_of_a_cube_in_syrup_follows_its_mass() -> None:
    """v = v_0 exp(-3 pi eta s t / m) with sides s of sqrt(6 I / m)."""
    cube = galvi.from_mujoco("""<mujoco><option viscosity=".4" gravity="0 0 0"/><worldbody><body>
        <joint type="slide"/><inertial pos="0 0 0" mass="1" diaginertia=".1 .1 .1"/></body>
        </worldbody></mujoco>""")
    masses = np.array([0.5, 1.0, 3.0])
    ends = galvi.integrate_ensemble(
        cube, [0.0], [2.0], EIGHT, 0.05, 10, {"masses": masses[:, None]}
    )
    rate = 3.0 * np.pi * 0.4 * np.sqrt(0.6 / masses) / masses
    speeds = np.asarray(ends)[:, 1, 0] / masses
    assert speeds == pytest.approx(2.0 * np.exp(-0.5 * rate), rel=1e-13)  # 6e-16
    assert np.max(np.abs(speeds / (2.0 * np.exp(-0.5 * rate[1] / masses)) - 1.0)) > 0.1


def test_a_saved_run_in_a_medium_can_get_other_masses(tmp_path: Any) -> None:
    problem = galvi.from_mujoco(TREE).with_initial_state([0.3, 0.7], [1.0, -2.0])
    run = galvi.integrate(problem, EIGHT, 0.01, 3)
    galvi.save(run, tmp_path / "run.npz")
    stored = galvi.load(tmp_path / "run.npz").problem.system
    for system in (stored, stored.with_numbers(masses=VARIED_MASSES[1])):
        expected = problem.system.with_numbers(masses=[link.mass for link in system.links])
        state = [0.3, 0.7], [1.0, -2.0]
        assert np.array_equal(system.acceleration(*state), expected.acceleration(*state))
