"""Models of MuJoCo are read completely, or refused by the names of what is not supported."""

import copy
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import galvi
from galvi.interop import from_mujoco as reader
from galvi.interop import mujoco_model
from galvi.interop.mujoco_limits import PARTS, BeyondTrees, _counted, _pairs

mujoco = pytest.importorskip("mujoco")

# every kind of joint; a mocap body that carries some; nothing beyond trees
PLAIN = """<mujoco><option gravity="0 1 -9.81"/><worldbody>
<body name="hand" mocap="true" pos="0 0 1"><geom size=".05" contype="0" conaffinity="0"/>
<body pos="0 .1 0"><joint name="a" axis="0 1 0" armature=".1" damping=".3" stiffness="2"
springref="10" ref="5"/><geom type="capsule" size=".02" fromto="0 0 0 0 .1 -.5" contype="0"
conaffinity="0"/>
<body pos="0 0 -.5"><joint type="slide" axis="1 1 0" damping="1"/><geom type="box" size=".1 .2 .3"
pos=".1 0 0" contype="0" conaffinity="0"/>
<body pos="0 0 -.5"><joint type="ball" stiffness="1"/><geom type="box" size=".1 .2 .3"
pos=".1 0 0" contype="0" conaffinity="0"/><site/></body></body></body></body>
<body pos="2 0 0"><freejoint/><geom type="ellipsoid" size=".1 .2 .3" contype="0" conaffinity="0"/>
</body></worldbody><sensor><clock/></sensor>
<keyframe><key name="home" time="3" mpos="0 0 1.5" mquat="1 1 0 0"
qpos=".1 .2 1 0 0 0 2 0 0 1 0 0 0" qvel="1 0 0 0 0 0 0 0 0 0 1"/><key name="other"/></keyframe>
</mujoco>"""
HAND = """<mujoco><worldbody><body mocap="true" pos="0 0 1"><geom size=".05" contype="0"
conaffinity="0"/><body><joint name="wrist" axis="0 1 0"/><geom type="capsule" size=".02"
fromto="0 0 0 0 0 -.5" mass="1" contype="0" conaffinity="0"/></body></body></worldbody><keyframe>
<key qpos="0" mpos="0 0 1" mquat=".70710678 0 .70710678 0"/></keyframe></mujoco>"""
SEVERAL = """<mujoco><worldbody><body><joint name="b" type="ball"/><geom type="box"
size=".1 .2 .3"/></body><body pos="1 0 0"><joint name="h"/><geom size=".1"/></body></worldbody>
<actuator><orientation joint="b" kp="1"/><motor joint="h" gear="3" armature=".2" damping=".5"/>
</actuator></mujoco>"""
BODY = '<inertial pos="0 .1 -.2" mass="1.5" diaginertia=".01 .02 .015"/>'


def model_of(text=PLAIN):
    return mujoco.MjModel.from_xml_string(text)


def one_body(joint, option="", body=BODY):
    return f"<mujoco>{option}<worldbody><body>{joint}{body}</body></worldbody></mujoco>"


def accelerations(model, problem):
    """MuJoCo's accelerations of the model, with mocap bodies at its first keyframe, and galvi's, at
    a state near the start."""
    system, generator = problem.system, np.random.default_rng(2)
    qpos, qvel = system.to_mujoco(problem.q0, problem.v0)
    q, v = system.from_mujoco(
        qpos + 0.1 * generator.normal(size=qpos.size), generator.normal(size=qvel.size)
    )
    mj_data = mujoco.MjData(model)
    if model.nkey:
        mujoco.mj_resetDataKeyframe(model, mj_data, 0)
    mj_data.qpos[:], mj_data.qvel[:] = system.to_mujoco(q, v)
    mujoco.mj_forward(model, mj_data)
    return mj_data.qacc.copy(), system.acceleration(q, v)


# ---------------------------------------------------------------- the positive list

FIELDS = sorted(
    name
    for name in dir(model_of())
    if isinstance(value := getattr(model_of(), name), np.ndarray)
    and value.size
    and value.dtype.kind in "fb"
    and not name.startswith("_")
)
OPTIONS = sorted(
    name
    for name in dir(model_of().opt)
    if not name.startswith("_")
    and name not in ("disableflags", "enableflags", "cone", "solver", "jacobian", "integrator")
)


def read_or_refused(model):
    """The message with which galvi refuses the model, or ""; asserts that a model which is read has
    MuJoCo's accelerations."""
    try:
        problem = galvi.from_mujoco(model, key=0)
    except ValueError as refused:
        return str(refused)
    if model.opt.enableflags & int(mujoco.mjtEnableBit.mjENBL_IPC):
        return ""  # MuJoCo runs it with its integrator discrete alone
    by_mujoco, by_galvi = accelerations(model, problem)
    assert by_galvi == pytest.approx(by_mujoco, rel=1e-8, abs=1e-8 * np.max(np.abs(by_mujoco)))
    return ""


@pytest.mark.slow(beside="test_a_flag_is_read_harmless_or_refused")
@settings(max_examples=200, deadline=None)
@given(st.sampled_from([*FIELDS, *(f"opt.{name}" for name in OPTIONS)]), st.floats(0.05, 0.5))
def test_a_number_of_a_model_is_read_harmless_or_refused(name, increment):
    model = model_of()
    holder = model.opt if name.startswith("opt.") else model
    name = name.removeprefix("opt.")
    values = getattr(holder, name)
    try:
        if isinstance(values, np.ndarray):
            values[...] = ~values if values.dtype.kind == "b" else values + increment
        else:
            setattr(holder, name, values + (1 if isinstance(values, int) else increment))
    except ValueError:
        return  # MuJoCo lets nobody write it
    read_or_refused(model)


BITS = [
    (kind, bit)
    for kind, flags in (("disableflags", "mjtDisableBit"), ("enableflags", "mjtEnableBit"))
    for bit in range(len(getattr(mujoco, flags).__members__) + 2)
]


@pytest.mark.parametrize(("field", "bit"), BITS)
def test_a_flag_is_read_harmless_or_refused(field, bit):
    model = model_of()
    setattr(model.opt, field, 1 << bit)
    refusal = read_or_refused(model)
    flags = mujoco.mjtDisableBit if field == "disableflags" else mujoco.mjtEnableBit
    names = {int(value): name for name, value in flags.__members__.items() if "_" in name}
    if 1 << bit not in names:
        assert f"bits {1 << bit:#x} of {field}" in refusal
    else:
        assert ("\n  sleep: " in refusal) is (names[1 << bit] == "mjENBL_SLEEP")


@pytest.mark.parametrize(
    ("list_of_names", "name", "description"),
    [
        ("READ", "body_pos", "body_pos"),
        ("DERIVED", "dof_M0", "dof_M0"),
        ("OBJECTS", "signature", "signature"),
        ("OPTIONS", "magnetic", "option magnetic"),
    ],
)
def test_a_field_of_a_newer_version_is_refused_by_name(
    monkeypatch, list_of_names, name, description
):
    """Planted: a list lacks a field that the model has."""
    assert not list(mujoco_model.unknown(model_of()))
    remaining = set(getattr(mujoco_model, list_of_names)) - {name}
    monkeypatch.setattr(mujoco_model, list_of_names, remaining)
    with pytest.raises(
        ValueError, match=rf"what these settings .* to its motion: {description}\. Leave"
    ):
        galvi.from_mujoco(model_of())


def test_a_flag_and_a_tendons_field_of_a_newer_version_are_refused_by_name(monkeypatch):
    monkeypatch.setattr("galvi.interop.mujoco_limits.QUIET", ())
    text = PLAIN.replace(
        "<sensor>", '<tendon><fixed><joint joint="a" coef="1"/></fixed></tendon><sensor>'
    )
    with pytest.raises(BeyondTrees, match="tendons: some with what galvi does not know"):
        galvi.from_mujoco(text)
    model = model_of()
    model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_EULERDAMP)
    assert galvi.from_mujoco(model).parameters["dt"] == 0.002
    monkeypatch.setattr(mujoco_model, "FLAGS", ["GRAVITY"])
    with pytest.raises(ValueError, match=r"bits 0x.* of disableflags"):
        galvi.from_mujoco(model)


def test_callbacks_of_the_user_are_refused_by_name():
    model = model_of()
    try:
        mujoco.set_mjcb_passive(lambda model, mj_data: None)
        with pytest.raises(ValueError, match="the callback mjcb_passive"):
            galvi.from_mujoco(model)
    finally:
        mujoco.set_mjcb_passive(None)
    assert galvi.from_mujoco(PLAIN).v0.size == 11


def test_sleep_is_named_and_switched_off_where_it_is_ignored():
    """When asleep, the pendulum of the file stops 4.2e-3 from where its damping takes it."""
    text = PLAIN.replace("<option", '<option><flag sleep="enable"/></option><option')
    with pytest.raises(BeyondTrees, match="\n  sleep: slow trees may be put to sleep") as refused:
        galvi.from_mujoco(text)
    assert refused.value.names == ("sleep",) and isinstance(refused.value, ValueError)
    problem, mujoco_model = reader.read(text, "sleep")
    assert problem.parameters["ignored"] == ("sleep",) and mujoco_model.model.opt.enableflags == 0
    assert mujoco_model.differences == {"sleep": "the flag sleep disabled"}


def flexible(inner, attributes='dim="2" count="3 3 1"'):
    return f"""<mujoco><worldbody><flexcomp type="grid" {attributes} spacing=".1 .1 .1" name="f"
        mass="1" radius=".01">{inner}</flexcomp></worldbody></mujoco>"""


ELASTIC = '<elasticity young="1e3" poisson=".1" thickness=".01" damping=".1"'
BEYOND = {
    "cloth": flexible(f'{ELASTIC} elastic2d="both"/>'),
    "edges": flexible('<edge stiffness="10" damping="1"/>', 'dim="1" count="4 1 1"'),
    "held edges": flexible('<edge equality="true"/>'),
    "solid": flexible(f"{ELASTIC}/>", 'dim="3" count="3 3 3"'),
    "few nodes": flexible(f"{ELASTIC}/>", 'dim="3" count="3 3 3" dof="trilinear"'),
    "plastic": one_body('<joint axis="1 0 0" stiffness="1" springyield=".1"/>'),
    "medium": one_body(
        "<freejoint/>",
        '<option density="900" viscosity="1" wind="1 2 3"/>',
        '<geom type="box" size=".1 .2 .3" fluidshape="ellipsoid"/>',
    ),
    "tendon": one_body('<joint name="a" axis="1 0 0"/>').replace(
        "</worldbody>",
        """</worldbody>
        <tendon><fixed name="t" armature="2" stiffness="3" damping="1"><joint joint="a" coef="1"/>
        </fixed></tendon><actuator><motor tendon="t" armature="5" damping="3"/></actuator>""",
    ),
    "ball and motor": one_body('<joint type="ball" name="b"/>').replace(
        "</worldbody>",
        """</worldbody>
        <actuator><motor joint="b" armature=".1" damping="2"/></actuator>""",
    ),
}


@pytest.mark.parametrize("name", BEYOND)
def test_what_is_left_out_is_switched_off_by_which_the_numbers_agree(name):
    with pytest.raises(BeyondTrees) as refused:
        galvi.from_mujoco(BEYOND[name])
    names = refused.value.names
    problem, mujoco_model = reader.read(BEYOND[name], names)
    assert set(mujoco_model.differences) == set(names) <= set(PARTS)
    by_mujoco, by_galvi = accelerations(mujoco_model.model, problem)
    assert by_galvi == pytest.approx(by_mujoco, rel=1e-9, abs=1e-9)
    unreduced, _ = accelerations(model_of(BEYOND[name]), problem)
    # The parts left out do act, except a plastic spring, which acts once it has yielded.
    assert name == "plastic" or np.max(np.abs(unreduced - by_galvi)) > 1e-4


WRAPPED = """<mujoco><option>{}</option><worldbody><site name="a" pos="0 0 1"/>
<geom name="g" size=".1" contype="0" conaffinity="0"/><body pos="0 0 -.5"><joint axis="0 1 0"/>
<geom size=".05" pos=".3 0 0" contype="0" conaffinity="0"/><site name="b" pos=".3 0 0"/></body>
</worldbody><tendon><spatial {}><site site="a"/><geom geom="g"/><site site="b"/></spatial></tendon>
</mujoco>"""


@pytest.mark.parametrize(
    ("flag", "force", "acts"),
    [
        ("", "", False),
        ('<flag spring="disable"/>', 'stiffness="3"', False),
        ("", 'stiffness="3"', True),
        ('<flag spring="disable"/>', 'stiffness="3" damping="1"', True),
    ],
)
def test_a_tendon_may_wrap_around_a_geom_where_it_has_no_force(flag, force, acts):
    model = WRAPPED.format(flag, force)
    if acts:
        with pytest.raises(BeyondTrees, match="tendons: some that wrap around geoms"):
            galvi.from_mujoco(model)
    else:
        assert galvi.from_mujoco(model).q0.shape == (1,)


# ---------------------------------------------------------------- the check by numbers


def with_changed_links(**fields):
    """Planted: a reader of links that changes ``fields`` by functions of the link."""
    read_link = reader._link

    def wrong(*arguments):
        link = read_link(*arguments)
        return replace(link, **{name: change(link) for name, change in fields.items()})

    return wrong


FAULTS = {
    "a mass off by 1e-6": with_changed_links(mass=lambda link: link.mass * (1.0 + 1e-6)),
    "no damping": with_changed_links(
        joints=lambda link: [replace(j, damping=0.0) for j in link.joints]
    ),
    "another anchor": with_changed_links(
        joints=lambda link: [
            j if j.type == "free" else replace(j, anchor=j.anchor + 1e-3) for j in link.joints
        ]
    ),
    "mocap poses left out": lambda model, body, mj_data, read_link=reader._link: read_link(
        model, body, mujoco.MjData(model)
    ),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_a_misreading_is_caught_by_the_accelerations(fault, monkeypatch):
    monkeypatch.setattr(reader, "_link", FAULTS[fault])
    with pytest.raises(ValueError, match=r"misreads this model: MuJoCo accelerates joint .* by"):
        galvi.from_mujoco(PLAIN, key="home")


def test_a_dropped_option_is_caught_by_the_accelerations(monkeypatch):
    text = PLAIN.replace("<option", '<option><flag gravity="disable"/></option><option')
    assert not np.any(galvi.from_mujoco(text).system.gravity)
    monkeypatch.setattr(reader, "disabled", lambda model, flag: False)
    with pytest.raises(ValueError, match="misreads this model"):
        galvi.from_mujoco(text)


def test_constants_that_are_older_than_the_masses_are_refused_with_the_remedy():
    model = model_of()
    model.body_mass[5] = 3.0  # MuJoCo keeps the old value in dof_M0
    with pytest.raises(ValueError, match=r"MuJoCo accelerates joint 3 by .* mujoco.mj_setConst"):
        galvi.from_mujoco(model)
    mujoco.mj_setConst(model, mujoco.MjData(model))
    assert galvi.from_mujoco(model).system.links[4].mass == 3.0


def largest_misfit(model, *options):
    problem, loaded = reader.read(model, *options)
    states = mujoco_model.sample_states(problem.system, problem.q0, problem.v0)
    return max(np.max(defect) for defect, _ in mujoco_model.misfits(loaded, problem, states))


WEIGHTLESS = '<option gravity="0 0 0"/>'
BALANCED = {  # forces cancel, and rounding is all that is left of the accelerations
    "an axis along gravity": one_body('<joint axis="0 0 1"/>'),
    "an axis along gravity, tilted": one_body(
        '<joint axis=".36 .48 .8"/>', '<option gravity="-3.6 -4.8 -8"/>'
    ),
    "hanging": one_body('<joint axis="1 0 0"/>', body='<geom size=".1" pos="0 0 -.3"/>'),
    "at rest without weight": one_body("<freejoint/>", WEIGHTLESS),
    "a spring at rest": one_body('<joint type="ball" stiffness="5"/>', WEIGHTLESS).replace(
        "<body>", '<body quat=".1 .7 -.3 .4">'
    ),
    "a free spring at rest": one_body('<joint type="free" stiffness="50"/>', WEIGHTLESS).replace(
        "<body>", '<body pos="100 7 3" quat=".1 .7 -.3 .4">'
    ),
}


@pytest.mark.parametrize("name", BALANCED)
def test_forces_that_cancel_are_not_taken_for_a_misreading(name):
    assert largest_misfit(BALANCED[name]) < 1e-11


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 2), st.floats(1e-3, 1e3), st.floats(1e-6, 1e6))
def test_a_body_that_spins_about_a_principal_axis_is_not_taken_for_a_misreading(k, rate, size):
    body = f'<inertial pos="0 0 0" mass="{size}" diaginertia="{size} {size} {size}"/>'
    text = one_body("<freejoint/>", WEIGHTLESS, body).replace(
        "<body>", '<body quat=".1 .7 -.3 .4">'
    )
    assert (
        largest_misfit(text, (), None, None, [0.0] * 3 + [rate * (j == k) for j in range(3)])
        < 1e-11
    )


# ---------------------------------------------------------------- starts, names, actuators


def test_a_keyframe_places_mocap_bodies():
    """The expected value is from mj_resetDataKeyframe and mj_forward; it was read as 0."""
    problem = galvi.from_mujoco(HAND, key=0)
    assert problem.system.acceleration(problem.q0, problem.v0) == pytest.approx(-28.60527, rel=1e-6)
    assert problem.parameters["key"] == 0
    unturned = galvi.from_mujoco(HAND.replace(".70710678 0 .70710678 0", "0 0 0 0"), key=0)
    assert np.array_equal(unturned.system.links[0].attitude, np.eye(3))  # as MuJoCo takes it
    at_rest = galvi.from_mujoco(HAND)
    assert abs(at_rest.system.acceleration(at_rest.q0, at_rest.v0)[0]) < 1e-12
    assert "key" not in at_rest.parameters


def test_an_actuator_after_one_of_several_outputs_is_read():
    """The expected mass matrix is MuJoCo's; reading the model raised IndexError."""
    problem, mujoco_model = reader.read(SEVERAL, ("contacts", "actuators"))
    assert repr(problem.system) == "Multibody(links=2, velocities=4)"
    hinge = problem.system.links[1].joints[0]
    assert hinge.armature == pytest.approx(9 * 0.2) and hinge.damping == pytest.approx(9 * 0.5)
    mj_data, mass = mujoco_model.start_data(), np.zeros((4, 4))
    mujoco.mj_forward(mujoco_model.model, mj_data)
    mujoco.mj_fullM(mujoco_model.model, mj_data, mass)
    assert problem.system.tree.mass(problem.q0) == pytest.approx(mass, rel=1e-12, abs=1e-12)


def test_the_own_model_is_the_users_but_for_what_is_left_out():
    model = model_of(SEVERAL)
    model.opt.integrator, model.opt.timestep = int(mujoco.mjtIntegrator.mjINT_IMPLICIT), 0.007
    before = copy.copy(model)
    _, mujoco_model = reader.read(model, ("contacts", "actuators"))
    assert mujoco_model.differences == {
        "contacts": "the flag contact disabled",
        "actuators": "the flag actuation disabled",
    }
    bits = mujoco.mjtDisableBit
    disabled_flags = int(bits.mjDSBL_CONTACT) | int(bits.mjDSBL_ACTUATION)
    assert mujoco_model.model.opt.disableflags == disabled_flags and model.opt.disableflags == 0
    mujoco_model.model.opt.disableflags = 0
    size = mujoco.mj_sizeModel(before)
    saved = [np.empty(size, np.uint8) for _ in range(3)]
    for source, buffer in zip((before, model, mujoco_model.model), saved, strict=True):
        mujoco.mj_saveModel(source, None, buffer)
    assert np.array_equal(saved[0], saved[1]) and np.array_equal(saved[0], saved[2])


def test_the_own_data_begin_at_the_keyframe_or_at_what_is_given():
    problem, mujoco_model = reader.read(PLAIN, (), "home")
    mj_data = mujoco_model.start_data()
    assert mj_data.time == 3.0 and mj_data.mocap_pos[0].tolist() == [0.0, 0.0, 1.5]
    assert mj_data is not mujoco_model.start_data()
    assert mj_data.qvel[0] == 1.0 and problem.v0[0] == 1.0
    qpos = np.array([0.3, -0.1, 1, 0, 0, 0, 2, 0, 0, 0, 1, 0, 0])
    problem, mujoco_model = reader.read(PLAIN, (), "home", qpos)
    mj_data = mujoco_model.start_data()
    assert np.array_equal(mj_data.qpos, qpos) and mj_data.qvel[0] == 1.0
    assert mj_data.mocap_pos[0].tolist() == [0.0, 0.0, 1.5]
    assert np.array_equal(problem.q0, problem.system.from_mujoco(qpos, mj_data.qvel)[0])
    for name, values in (("qpos", ([1.0],)), ("qvel", (None, [1.0]))):
        with pytest.raises(ValueError, match=rf"{name} must have shape \(1[13],\)"):
            reader.read(PLAIN, (), None, *values)


def test_keyframes_have_numbers_and_names():
    by_name, by_number = (galvi.from_mujoco(PLAIN, key=key) for key in ("home", 0))
    assert np.array_equal(by_name.q0, by_number.q0) and by_name.v0[0] == 1.0
    assert by_name.parameters["key"] == "home" and by_number.parameters["key"] == 0
    for key, message in (
        ("hom", r"\('home', 'other'\); received 'hom'"),
        (2, "from 0 to 1"),
    ):
        with pytest.raises(ValueError, match=message):
            galvi.from_mujoco(PLAIN, key=key)
    nameless = PLAIN.replace('name="home"', "").replace('name="other"', "")
    with pytest.raises(ValueError, match=r"\(none has a name\); received ''"):
        galvi.from_mujoco(nameless, key="")


def test_joints_have_their_names():
    joints = galvi.from_mujoco(PLAIN).system.tree.joints
    assert [joint.name for joint in joints] == ["a", "", "", ""]


# ---------------------------------------------------------------- sources


def test_a_spec_is_read_by_compiling_a_copy():
    spec = mujoco.MjSpec.from_string(PLAIN)
    assert galvi.from_mujoco(spec).v0.size == 11
    spec.joints[0].armature = 0.7
    assert galvi.from_mujoco(spec).system.links[1].joints[0].armature == 0.7
    with pytest.raises(ValueError, match=r"MuJoCo cannot read the MjSpec as a model: .*mass"):
        empty = mujoco.MjSpec()
        empty.worldbody.add_body().add_joint()
        galvi.from_mujoco(empty)


def test_an_archive_is_read_and_what_is_no_model_refused(tmp_path):
    path = tmp_path / "model.mjz"
    spec = mujoco.MjSpec.from_string(PLAIN)
    spec.compile()
    with path.open("wb") as file:
        spec.to_zip(file)
    assert galvi.from_mujoco(path, key="home").v0[0] == 1.0
    for name in ("model.mjz", "model.xml", "model.mjb"):
        (tmp_path / name).write_text("not a model")
        with pytest.raises(ValueError, match=rf"MuJoCo cannot read .*{name} as a model"):
            galvi.from_mujoco(tmp_path / name)


# ---------------------------------------------------------------- what is no tree, or more

BEYOND_A_TREE = """<mujoco><option density="1.2"/><worldbody>
<body gravcomp="1"><joint name="one" type="hinge" frictionloss="0.1" limited="true" range="-1 1"
actuatorfrclimited="true" actuatorfrcrange="-1 1" actuatorgravcomp="true"/>
<joint name="two" type="slide" stiffness="1 2" springyield="1"/>
<geom size="1" mass="1" fluidshape="ellipsoid"/></body>
<body pos="5 0 0"><joint name="three" type="ball" damping="1 2 3"/><geom size="1" mass="1"/></body>
</worldbody>
<tendon><fixed armature="2"><joint joint="one" coef="1"/></fixed></tendon>
<actuator><general name="lazy" joint="one" dyntype="filter"/></actuator>
<equality><joint joint1="one" joint2="two"/></equality></mujoco>"""


def test_all_that_a_model_has_beyond_a_tree_is_named_in_one_refusal():
    names = (
        "contacts",
        "limits",
        "actuators",
        "tendons",
        "equality",
        "fluid",
        "friction loss",
        "gravity compensation",
        "nonlinear springs",
        "nonlinear damping",
    )
    with pytest.raises(BeyondTrees, match="\n  contacts: 1 pair of geoms may meet\n") as refusal:
        galvi.from_mujoco(BEYOND_A_TREE)
    assert refusal.value.names == names
    assert "\n  nonlinear damping: 3 of a ball or free joint" in str(refusal.value)
    for name in names:
        with pytest.raises(BeyondTrees) as refusal:
            galvi.from_mujoco(BEYOND_A_TREE, ignore=[part for part in names if part != name])
        assert refusal.value.names == (name,)
    problem = galvi.from_mujoco(BEYOND_A_TREE, ignore=names)
    assert set(problem.parameters["ignored"]) == set(names) <= set(PARTS)
    assert [joint.stiffness for joint in problem.system.tree.joints] == [0.0, 1.0, 0.0]


def test_what_a_model_disables_is_not_there():
    flags = " ".join(f'{name}="disable"' for name in ("contact", "limit", "actuation", "equality",
                     "frictionloss", "gravity", "spring", "damper"))  # fmt: skip
    quiet = BEYOND_A_TREE.replace("<option", f"<option><flag {flags}/></option><option")
    problem = galvi.from_mujoco(quiet, ignore=("tendons", "fluid"))
    assert problem.system.force is None and not np.any(problem.system.gravity)
    assert not any(joint.stiffness for joint in problem.system.tree.joints)


def test_what_is_beyond_is_counted_in_words():
    pairs = "pair of geoms may meet", "pairs of geoms may meet"
    assert [_counted(n, *pairs) for n in (0, 1, 2)] == [None, f"1 {pairs[0]}", f"2 {pairs[1]}"]
    assert _counted(3, "tendon") == "3 tendons"


def test_names_that_are_not_in_utf_8_are_refused(tmp_path):
    path = tmp_path / "model.xml"
    text = '<mujoco><worldbody><body name="ä"><joint/><geom size="1"/></body></worldbody></mujoco>'
    path.write_text(text, encoding="latin-1")
    with pytest.raises(ValueError, match="names in the model must be in UTF-8; received byte 0xe4"):
        galvi.from_mujoco(path)
    path.write_text(text, encoding="utf-8")
    assert galvi.from_mujoco(path).system.links[0].name == "ä"


# ---------------------------------------------------------------- pairs of geoms


@settings(max_examples=60, deadline=None)
@given(st.data())
def test_pairs_of_geoms_are_those_that_touch_in_mujoco_where_all_are_at_one_place(draws):
    bodies, closing_tags, names = "", "", []
    for k in range(draws.draw(st.integers(1, 7))):
        joint = draws.draw(st.sampled_from(["<joint/>", "<joint/>", ""]))
        bits = draws.draw(st.tuples(*[st.integers(0, 3)] * 2))
        geom = f'<geom size=".1" contype="{bits[0]}" conaffinity="{bits[1]}"/>'
        bodies += f'<body name="b{k}">{joint}{geom}'
        closing_tags += "</body>"
        names.append(f"b{k}")
        if draws.draw(st.booleans()):
            bodies, closing_tags = bodies + closing_tags, ""
    pair = st.tuples(st.sampled_from(names), st.sampled_from(names))
    excluded = (
        draws.draw(st.sets(pair.filter(lambda both: both[0] < both[1]), max_size=3))
        if (len(names) > 1)
        else set()
    )
    exclusions = "".join(f'<exclude body1="{a}" body2="{b}"/>' for a, b in excluded)
    flag = draws.draw(st.sampled_from(["enable", "disable"]))
    model = model_of(f"""<mujoco><option><flag filterparent="{flag}"/></option><worldbody>
        <geom size=".1"/>{bodies}{closing_tags}</worldbody>
        <contact>{exclusions}</contact></mujoco>""")
    mj_data = mujoco.MjData(model)
    mujoco.mj_forward(model, mj_data)
    assert _pairs(model) == len({tuple(contact.geom) for contact in mj_data.contact})


def test_an_inertia_that_a_compiled_model_was_given_is_read(tmp_path):
    text = '<mujoco><worldbody><body><freejoint/><inertial pos="0 0 0" mass="1" diaginertia="{}"/>'
    text += "</body></worldbody></mujoco>"
    model = mujoco.MjModel.from_xml_string(text.format("1 1 1"))
    model.body_inertia[1] = 1.0, 1.0, 5.0
    problem = galvi.from_mujoco(model)
    heavier = problem.system.with_numbers(masses=[2.0])
    assert np.array_equal(np.diag(heavier.links[0].inertia), [1.0, 1.0, 5.0])
    method = galvi.Galerkin(galvi.Polynomials(2), galvi.gauss(2))
    run = galvi.integrate(problem, method, 0.1, 2, solver="newton")
    galvi.save(run, tmp_path / "run.npz")
    loaded = galvi.load(tmp_path / "run.npz")
    assert np.array_equal(loaded.problem.system.links[0].inertia, problem.system.links[0].inertia)
