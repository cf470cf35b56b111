"""Forces on trees: a user's, those of a MuJoCo model against its accelerations, and controls."""

from dataclasses import replace

import numba
import numpy as np
import pytest

import galvi
from galvi.interop import from_mujoco as reader
from galvi.interop import mujoco_forces
from galvi.interop.mujoco_limits import BeyondTrees
from galvi.systems.trees.joint_forces import Drive
from galvi.tracing.laws_of_systems import law_of, lines_of
from tests.properties.random_trees import random_tree

mujoco = pytest.importorskip("mujoco")

METHOD = galvi.Galerkin(galvi.Polynomials(6), galvi.gauss(6))
INERTIA = '<inertial pos="0 .1 -.2" mass="1.5" diaginertia=".01 .02 .015" quat="1 .2 .4 .3"/>'
FIXED = '<joint joint="a" coef="2"/><joint joint="b" coef="-1"/>'
SITES = """<site site="w"/><site site="s1"/><pulley divisor="2"/><site site="s2"/><site site="s3"/>
<pulley divisor="3"/><site site="s4"/><site site="s3"/>"""


def model(elements="", option="", joint="", body=""):
    """MJCF with every kind of joint and with sites; ``elements`` are tendons and actuators."""
    return f"""<mujoco>{option}<worldbody><site name="w" pos=".3 .1 .2"/>
<body {body}><joint name="a" axis="0 1 0" {joint}/>{INERTIA}<site name="s1" pos=".1 0 -.1"/>
<body pos="0 0 -.4"><joint name="b" axis="1 .3 0" ref=".2"/><joint name="c" type="slide"/>{INERTIA}
<site name="s2" pos=".1 .2 -.1" quat="1 .3 .2 .1"/>
<body pos="0 0 -.4"><joint name="d" type="ball"/>{INERTIA}<site name="s3" pos=".1 .2 -.1"/></body>
</body></body><body pos="1 0 0" {body}><freejoint name="f"/>{INERTIA}
<site name="s4" pos=".1 .2 -.1"/></body></worldbody>{elements}</mujoco>"""


def actuators(*kinds):
    return f"<actuator>{''.join(f'<{kind}/>' for kind in kinds)}</actuator>"


def tendon(kind, path, inner=""):
    return f'<tendon><{kind} name="t" {inner}>{path}</{kind}></tendon>'


AFFINE = 'gaintype="affine" gainprm="1 2 3" biastype="affine" biasprm=".1 .2 .3"'
SPRING = 'stiffness="3 4 5" damping="2 3 4"'
MEDIUM = '<option density="900" viscosity="2" wind="1 2 3"/>'
MODELS = {  # Name -> MJCF, and its controls or None
    "motors": (model(actuators('motor joint="a" gear="3"', 'motor joint="c" gear="2"',
        'motor joint="d" gear="1 2 3"', 'motor joint="f" gear="1 2 3 4 5 6"')), [1, 2, 3, 4]),
    "servos": (model(actuators('position joint="a" kp="10" kv="2" gear="3"',
                         'velocity joint="c" kv="3"')), [1, 2]),
    "affine gain and bias": (model(actuators(f'general joint="b" {AFFINE} gear="2"')), [0.7]),
    "a motor of a tendon": (model(tendon("fixed", FIXED)
                                  + actuators('motor tendon="t" gear="2"')), [2]),
    "a servo of a path": (model(tendon("spatial", SITES)
                                + actuators('position tendon="t" kp="3" gear="2"')), [0.7]),
    "thrusters": (model(actuators('motor site="s2" gear="1 2 3 4 5 6"',
                                  'motor site="s4" gear="0 0 9"')),
                  [0.7, 0.3]),
    "a fixed tendon": (model(tendon("fixed", FIXED, SPRING + ' springlength=".1 .3"')), None),
    "a path": (model(tendon("spatial", SITES, SPRING + ' springlength=".2 .25"')), None),
    "held weights": (model(body='gravcomp=".7"'), None),
    "a polynomial spring": (model(joint='stiffness="1 2 3" springref="10"'), None),
    "a polynomial damper": (model(joint='damping="1 2 3"'), None),
    "a medium": (model(option=MEDIUM), None),
    "wind alone": (model(option='<option density="1.2" wind="9 0 1"/>'), None),
}  # fmt: skip


def read(name):
    text, ctrl = MODELS[name]
    return reader.read(text, ("contacts",), ctrl=ctrl)


def states(problem, number=6):
    """Yields 2 ``number`` states: random displacements and velocities, and their opposites."""
    generator, system = np.random.default_rng(4), problem.system
    qpos, qvel = system.to_mujoco(problem.q0, problem.v0)
    for _ in range(number):
        displacement, velocity = (
            0.5 * generator.normal(size=qpos.size),
            generator.normal(size=qvel.size),
        )
        for sign in (1.0, -1.0):
            yield system.from_mujoco(qpos + sign * displacement, sign * velocity)


def largest_error(problem, mujoco_model):
    """The largest relative difference between galvi's accelerations and MuJoCo's of its model."""
    largest, mj_data = 0.0, mujoco_model.start_data()
    for q, v in states(problem):
        mj_data.qpos[:], mj_data.qvel[:] = problem.system.to_mujoco(q, v)
        mujoco.mj_forward(mujoco_model.model, mj_data)
        by_galvi = problem.system.acceleration(q, v)
        largest = max(
            largest, np.max(np.abs(by_galvi - mj_data.qacc)) / np.max(np.abs(mj_data.qacc))
        )
    return largest


@pytest.mark.slow_cases("motors")
@pytest.mark.parametrize("name", MODELS)
def test_forces_of_a_model_accelerate_as_in_mujoco(name):
    problem, mujoco_model = read(name)
    assert not mujoco_model.differences.keys() - {"contacts"}
    assert largest_error(problem, mujoco_model) < 1e-12  # 4e-14
    unforced = replace(problem.system, force=None, timed_force=False)
    q, v = next(states(problem))
    assert np.max(np.abs(unforced.acceleration(q, v) - problem.system.acceleration(q, v))) > 1e-3


@pytest.mark.parametrize("name", MODELS)
def test_the_law_for_lanes_is_the_kernels(name):
    system, namespace = read(name)[0].system, {}
    exec(lines_of(system.force), namespace)
    for q, v in states(read(name)[0], 2):
        kernels, numbers = system.force(q, v, 0.0), system.force.compiled()[1]
        lanes = namespace["force"](q.ravel().tolist(), v.tolist(), 0.0, numbers)
        assert np.array(lanes) == pytest.approx(kernels, rel=1e-13, abs=1e-13)


FAULTS = {  # Name of the model -> a field of its forces, and a change of each entry, mostly 1e-6
    "motors": ("pulls", lambda pull: replace(pull, constant=pull.constant + 1e-6)),
    "a servo of a path": ("pulls", lambda pull: replace(pull, points=pull.points[:2])),
    "thrusters": ("pushes", lambda push: (push[0], push[1] + 1e-6, *push[2:])),
    "a fixed tendon": ("pulls", lambda pull: replace(pull, slack=(0.1 - 1e-4, 0.3 + 1e-4))),
    "held weights": ("weights", lambda held: (held[0], held[1] + 1e-6)),
    "a polynomial spring": ("pulls", lambda pull: replace(pull, spring=(0.0, 2.0, 3.0 + 1e-4))),
    "a medium": ("wet", lambda wet: (*wet[:2], wet[2] * (1.0 + 1e-6))),
    "wind alone": ("wet", lambda wet: (wet[0], np.eye(3), wet[2])),
}


@pytest.mark.parametrize("name", FAULTS)
def test_a_misread_force_is_caught_by_the_accelerations(name, monkeypatch):
    """Planted: each force with one number changed."""
    field, change = FAULTS[name]
    forces_of = mujoco_forces.forces_of

    def wrong(*arguments):
        force = forces_of(*arguments)
        changes = {field: tuple(change(force_part) for force_part in getattr(force, field))}
        return replace(force, **changes, drives=())  # drives would compute the numbers anew

    monkeypatch.setattr(reader, "forces_of", wrong)
    with pytest.raises(ValueError, match="misreads this model: MuJoCo accelerates joint"):
        read(name)


# ---------------------------------------------------------------- limits, controls, refusals

ARM = """<mujoco><worldbody><body><joint name="a" axis="0 1 0" {joint}/><inertial pos="0 0 -.5"
mass="1" diaginertia=".1 .1 .1"/></body></worldbody><actuator><position name="drive" joint="a"
kp="10" {drive}/></actuator><keyframe><key name="bent" ctrl=".5"/></keyframe></mujoco>"""


@pytest.mark.parametrize(
    ("limits", "message"),
    [
        ({"drive": 'forcerange="-3 3"', "joint": ""}, "the force of actuator drive is beyond"),
        ({"joint": 'actuatorfrcrange="-3 3"', "drive": ""}, "actuators push a beyond its limits"),
    ],
    ids=["actuator", "joint"],
)
def test_a_run_ends_where_a_force_reaches_its_limit(limits, message):
    problem = galvi.from_mujoco(ARM.format(**limits), ctrl=[0.2])
    assert galvi.integrate(problem, METHOD, 0.02, 20).success
    faster = problem.with_initial_state(problem.q0, [2.0])
    for solver in ("auto", "newton"):
        run = galvi.integrate(faster, METHOD, 0.02, 200, solver=solver)
        assert not run.success and message in run.status and "[-3.0, 3.0]" in run.status
        angles = run.q[: run.failed_step, 0]
        assert np.all(np.isfinite(angles)) and np.all(np.abs(10 * (0.2 - angles)) <= 3.0)
        assert np.max(np.abs(10 * (0.2 - angles))) > 2.5
    free = galvi.from_mujoco(ARM.format(drive="", joint=""), ctrl=[0.2])
    free = galvi.integrate(free.with_initial_state(problem.q0, [2.0]), METHOD, 0.02, 200)
    assert free.success and np.array_equal(free.q[: len(angles)], run.q[: len(angles)]) is False
    assert free.q[: len(angles), 0] == pytest.approx(angles, abs=1e-12)
    with pytest.raises(ValueError, match=f"{message}.* at the start. Start elsewhere"):
        galvi.integrate(problem.with_initial_state([1.0], [0.0]), METHOD, 0.02, 20)


def test_controls_are_given_a_keyframes_or_zero():
    text, pull = ARM.format(joint="", drive='ctrlrange="-1 1"'), lambda p: p.system.force.pulls[0]
    assert pull(galvi.from_mujoco(text)).constant == 0.0
    assert pull(galvi.from_mujoco(text, key="bent")).constant == 5.0
    assert pull(galvi.from_mujoco(text, key="bent", ctrl=[0.3])).constant == 3.0
    beyond_range = text.replace('ctrl=".5"', 'ctrl="7"')
    assert (
        pull(galvi.from_mujoco(beyond_range, key="bent")).constant == 10.0
    )  # clamped, as by MuJoCo


ROUND = '<site site="w"/><geom geom="g"/><site site="s1"/>'
WRAPPED = tendon("spatial", ROUND, 'stiffness="1"')
REFUSED = {
    "with a state of their own (slow)": actuators('general name="slow" joint="a" dyntype="filter"'),
    "some with a state of their own": actuators('muscle joint="a" lengthrange="0 1"'),
    "on cranks": actuators('motor cranksite="s1" slidersite="s2" cranklength=".5"'),
    "some that are servos of ball or free joints (spin)": actuators(
        'position name="spin" joint="d" kp="1"'
    ),
    "some in the parent frame on ball or free joints": actuators(
        'motor jointinparent="d" gear="1 2 3"'
    ),
    "between sites": actuators('position site="s1" refsite="s2" kp="1" gear="1"'),
    "that wrap around geoms (t)": WRAPPED,
    "on tendons that wrap around geoms (actuator 0)": WRAPPED + actuators('motor tendon="t"'),
    "with an armature (t)": tendon("fixed", FIXED, 'armature="1"'),
}


@pytest.mark.parametrize("message", REFUSED)
def test_what_is_not_understood_is_refused_by_name(message):
    ball = '<geom name="g" size=".1" contype="0" conaffinity="0"/><site name="w"'
    text = model(REFUSED[message]).replace('<site name="w"', ball)
    with pytest.raises(BeyondTrees) as refused:
        galvi.from_mujoco(text, "contacts")
    assert message in str(refused.value)
    assert galvi.from_mujoco(text, ("contacts", *refused.value.names)).v0.size == 12


HANGING = """<mujoco><worldbody><site name="top"/><body><joint name="z" type="slide" axis="0 0 -1"/>
<inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/><site name="m"/></body></worldbody>
<tendon><spatial stiffness="100" damping="{damping}" springlength="{rest}"><site site="top"/>
<site site="m"/></spatial></tendon></mujoco>"""


@pytest.mark.parametrize(
    "spring_length, damping", [("0 1", 0.0), ("0 1", 3.0), ("0 0", 0.0), (".5 .5", 0.0)]
)
def test_a_tendon_whose_ends_meet_has_no_moment(spring_length, damping):
    problem, mujoco_model = reader.read(HANGING.format(rest=spring_length, damping=damping))
    for v in (0.0, 1.0):
        assert problem.system.acceleration([0.0], [v]) == pytest.approx([9.81], abs=1e-14)
        mj_data = mujoco_model.start_data()
        mj_data.qpos[:], mj_data.qvel[:] = 0.0, v
        mujoco.mj_forward(mujoco_model.model, mj_data)
        assert mj_data.qacc == pytest.approx([9.81], abs=1e-14)


def test_a_spring_of_no_length_is_linear_from_where_its_ends_meet():
    problem = galvi.from_mujoco(HANGING.format(rest="0 0", damping=0.0))
    run = galvi.integrate(problem, METHOD, 0.05, 20)
    exact = 9.81 / 100.0 * (1.0 - np.cos(10.0 * run.t))
    assert run.outcome.end is galvi.End.COMPLETED
    assert run.q[:, 0] == pytest.approx(exact, abs=1e-10)  # 7e-13


# ---------------------------------------------------------------- a user's force


def swirl(q, v, t):
    return 0.1 * v * v[0] + 0.3 * t


@pytest.mark.slow_cases("compiled")
@pytest.mark.parametrize(
    ("force", "timed"),
    [(swirl, True), (numba.njit(lambda q, v: 0.1 * v * v[0]), False)],
    ids=["of time", "compiled"],
)
def test_a_force_of_the_users_acts_beside_damping(force, timed):
    plain = galvi.from_mujoco(random_tree(3, 3, kinds=("hinge",)))
    system = galvi.Multibody(
        plain.system.links, plain.system.gravity, force=force, timed_force=timed
    )
    assert np.any(plain.system.force.coefficients) and system.given_force == (force, timed)
    q, v, t = plain.q0, plain.v0 + 0.5, (0.4,) * timed
    change = system.acceleration(q, v, 0.4) - plain.system.acceleration(q, v)
    assert system.tree.mass(q) @ change == pytest.approx(force(q, v, *t), abs=1e-12)
    runs = [
        galvi.integrate(galvi.Problem(system, q, v), METHOD, 0.01, 30, solver=solver)
        for solver in ("auto", "newton")
    ]
    assert runs[0].success and runs[0].q[-1] == pytest.approx(runs[1].q[-1], abs=1e-12)
    lighter = system.with_numbers(gravity=[0.0, 0.0, -1.0])
    assert lighter.given_force == (force, timed)
    replaced = replace(system, gravity=(0.0, 0.0, -1.0))
    assert np.array_equal(replaced.acceleration(q, v), lighter.acceleration(q, v))


def test_held_weights_follow_gravity():
    problem, mujoco_model = read("held weights")
    q, v = next(states(problem))
    mujoco_model.model.opt.gravity[:] = 0.0, 3.0, -5.0
    mj_data = mujoco_model.start_data()
    mj_data.qpos[:], mj_data.qvel[:] = problem.system.to_mujoco(q, v)
    mujoco.mj_forward(mujoco_model.model, mj_data)
    varied = problem.system.with_numbers(gravity=[0.0, 3.0, -5.0])
    assert varied.acceleration(q, v) == pytest.approx(mj_data.qacc, rel=1e-11, abs=1e-11)


# ---------------------------------------------------------------- controls that change

TICK_SECONDS = 0.002
DRIVEN = """<mujoco><option timestep="0.0005" integrator="RK4"/><worldbody>
  <body><joint name="a" axis="0 1 0" damping="0.3"/><joint name="b" axis="1 0 0"/>
    <inertial pos="0 0 -0.2" mass="1" diaginertia="0.02 0.02 0.01"/>
    <body pos="0 0 -0.4"><joint name="c" axis="0 1 0"/>
      <inertial pos="0 0 -0.2" mass="0.5" diaginertia="0.01 0.01 0.005"/>
      <site name="nozzle" pos="0 0 -0.3" euler="20 30 0"/></body></body></worldbody>
  <tendon><fixed name="both"><joint joint="a" coef="1"/><joint joint="c" coef="-0.5"/></fixed>
  </tendon>
  <actuator>
    <motor name="pusher" joint="a" gear="2" ctrlrange="-3 3"/>
    <position name="servo" joint="b" kp="8" kv="0.2"/>
    <motor name="pull" tendon="both"/>
    <general name="stiff" joint="c" gaintype="affine" gainprm="0.5 0.4 -0.3" biastype="affine"
      biasprm="0.1 -1 -0.1"/>
    <motor name="jet" site="nozzle" gear="1 0.5 0 0 0 0.1" forcelimited="true" forcerange="-1 1"/>
  </actuator></mujoco>"""
CONTROLS = np.random.default_rng(3).uniform(-1.5, 1.5, (50, 5))


def arm(ctrl=None):
    return galvi.from_mujoco(DRIVEN, ctrl=ctrl)


@pytest.mark.parametrize("k", range(2))
def test_with_numbers_is_the_model_read_with_these_controls(k):
    read_system, controlled = arm(CONTROLS[k]).system, arm().system.with_numbers(ctrl=CONTROLS[k])
    q, v = CONTROLS[k + 1, :3], CONTROLS[k + 2, :3]
    assert controlled.acceleration(q, v) == pytest.approx(
        read_system.acceleration(q, v), rel=1e-13, abs=1e-13
    )
    np.testing.assert_array_equal(controlled.force.numbers, read_system.force.numbers)
    with_next_controls = controlled.with_numbers(
        ctrl=CONTROLS[k + 1]
    )  # from the last controls, without reading the model
    np.testing.assert_array_equal(
        with_next_controls.force.numbers, arm(CONTROLS[k + 1]).system.force.numbers
    )
    heavier = controlled.with_numbers(masses=[2.0, 1.0])  # keeps its controls
    assert heavier.with_numbers(masses=[1.0, 0.5]).acceleration(q, v) == pytest.approx(
        read_system.acceleration(q, v), rel=1e-12
    )


def test_ticks_of_resume_are_those_of_mujoco():
    problem = arm()
    first = replace(problem, system=problem.system.with_numbers(ctrl=CONTROLS[0]))
    run = galvi.integrate(first, METHOD, TICK_SECONDS, 1)
    mj_data = mujoco.MjData(mujoco.MjModel.from_xml_string(DRIVEN))
    for k, u in enumerate(CONTROLS):
        run = galvi.resume(run, 1, ctrl=u) if k else run
        mj_data.ctrl[:] = u
        mujoco.mj_step(mj_data.model, mj_data, nstep=4)
    assert run.engine == "lanes" and run.t[-1] == pytest.approx(len(CONTROLS) * TICK_SECONDS)
    assert run.q[-1] == pytest.approx(mj_data.qpos, abs=1e-9)
    assert run.v[-1] == pytest.approx(mj_data.qvel, abs=1e-7)


@pytest.mark.slow(beside="test_with_numbers_is_the_model_read_with_these_controls")
def test_members_with_controls_of_their_own():
    problem = arm()
    q, v = np.repeat(problem.q0[None], 4, axis=0), np.repeat(problem.v0[None], 4, axis=0)
    many = galvi.integrate_ensemble(
        problem, q, v, METHOD, TICK_SECONDS, 50, parameters={"ctrl": CONTROLS[:4]}
    )
    for k in range(4):
        single = galvi.integrate(arm(CONTROLS[k]), METHOD, TICK_SECONDS, 50)
        assert np.asarray(many)[k, 0] == pytest.approx(single.q[-1], abs=1e-13)


def test_other_controls_do_not_compile_anew():
    zero, nonzero = (arm().system.with_numbers(ctrl=u) for u in (np.zeros(5), CONTROLS[0]))
    assert law_of(zero)[0] == law_of(nonzero)[0] == law_of(arm().system)[0]


def test_a_planted_drive_that_keeps_its_slope_is_caught(monkeypatch):
    law = Drive.force_coefficients
    monkeypatch.setattr(
        Drive, "force_coefficients", lambda drive, u: (law(drive, u)[0], *law(drive, 0.0)[1:])
    )
    with pytest.raises(ValueError, match="misreads this model"):
        arm(CONTROLS[0])


@pytest.mark.slow(beside="tests/suite/reports/test_judge.py::test_sources_of_every_kind_are_judged")
def test_judge_takes_controls():
    """The servo rests at ctrl = 0; with these controls it moves, in MuJoCo's run and in galvi's."""
    ctrl = np.array([0.5, 0.4, 0.0, 0.2, 0.3])
    driven = mujoco.MjModel.from_xml_string(DRIVEN)
    verdict = galvi.judge(driven, 0.2, 1e-6, ctrl=ctrl, qpos=[0.1, 0.0, 0.0], quick=True)
    assert verdict.passed and verdict.own["error"] < 1e-8


def test_a_thruster_on_the_world_pushes_nothing():
    text = """<mujoco><worldbody><site name="w" pos="0.3 0.2 1"/>
      <body><joint axis="0 1 0"/><inertial pos="0 0 -0.2" mass="1" diaginertia=".2 .2 .1"/></body>
      </worldbody><actuator><motor site="w" gear="1 0 0 0 0 0"/></actuator></mujoco>"""
    run = galvi.integrate(galvi.from_mujoco(text), METHOD, TICK_SECONDS, 1)
    assert abs(galvi.resume(run, 50, ctrl=[3.0]).q[-1, 0]) < 1e-15


def test_a_gain_that_is_misread_is_caught_where_controls_are_0(monkeypatch):
    laws = mujoco_forces._gain_and_bias
    monkeypatch.setattr(
        mujoco_forces,
        "_gain_and_bias",
        lambda mujoco_model, k: ((2.0, 0.0, 0.0), laws(mujoco_model, k)[1]),
    )
    with pytest.raises(ValueError, match="misreads this model"):
        arm()


def test_resume_with_controls_refuses_what_it_cannot_keep(tmp_path):
    brake = galvi.Event(lambda q, v, t: np.sin(np.pi * t / 0.01), action=lambda q, v, t: (q, 0 * v))
    run = galvi.integrate(arm(), METHOD, 0.005, 5, events=[brake])
    galvi.save(run, tmp_path / "run")
    for trajectory in (run, galvi.load(tmp_path / "run")):
        with pytest.raises(ValueError, match="events"):
            galvi.resume(trajectory, 1, ctrl=np.zeros(5))
    strong = DRIVEN.replace('gear="2"', 'gear="2" forcelimited="true" forcerange="-1 1"')
    run = galvi.integrate(galvi.from_mujoco(strong), METHOD, TICK_SECONDS, 1)
    with pytest.raises(ValueError, match=r"actuator pusher is beyond its limits .* Choose other"):
        galvi.resume(run, 1, ctrl=[3.0, 0.0, 0.0, 0.0, 0.0])


@pytest.mark.parametrize("limits", ["5 10", "-9 -4", "-0.2 0.8", "0 0.1"])
def test_ranges_need_not_hold_0_or_1(limits):
    text = DRIVEN.replace('ctrlrange="-3 3"', f'ctrlrange="{limits}"')
    low, high = map(float, limits.split())
    force = galvi.from_mujoco(text).system.force
    assert low <= force.controls[0] <= high and low <= force.sample_controls()[0] <= high
