"""What is no tree, or has more than one, is refused in words."""

from __future__ import annotations

import numpy as np
import pytest

import galvi
from galvi.interop.mujoco_limits import PARTS, _counted

mujoco = pytest.importorskip("mujoco")

BODY = '<inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>'
MORE = """<mujoco><option density="1.2"/><worldbody>
<body gravcomp="1"><joint name="one" type="hinge" frictionloss="0.1" limited="true" range="-1 1"
actuatorfrclimited="true" actuatorfrcrange="-1 1" actuatorgravcomp="true"/>
<joint name="two" type="slide" stiffness="1 2" springyield="1"/>
<geom size="1" mass="1" fluidshape="ellipsoid"/></body>
<body pos="5 0 0"><joint name="three" type="ball" damping="1 2 3"/><geom size="1" mass="1"/></body>
</worldbody>
<tendon><fixed armature="2"><joint joint="one" coef="1"/></fixed></tendon>
<actuator><general name="lazy" joint="one" dyntype="filter"/></actuator>
<equality><joint joint1="one" joint2="two"/></equality></mujoco>"""


def mjcf(inner):
    return f"<mujoco><worldbody>{inner}</worldbody></mujoco>"


def test_a_key_of_a_model_without_keyframes_is_refused():
    with pytest.raises(ValueError, match="the model has no keyframes; received key 0"):
        galvi.from_mujoco(mjcf(f'<body><joint type="hinge"/>{BODY}</body>'), key=0)


def test_all_that_a_model_has_beyond_a_tree_is_named_in_one_refusal():
    with pytest.raises(ValueError) as refusal:
        galvi.from_mujoco(MORE)
    lines = str(refusal.value).splitlines()
    expected = [
        "  contacts: 1 pair of geoms may meet", "  limits: 1 limited joint",
        "  actuators: some with a state of their own (lazy)",
        "  tendons: some with an armature (0)", "  equality: 1 equality constraint",
        "  fluid: a medium with ellipsoids in it", "  friction loss: 1 degree of freedom",
        "  gravity compensation: weights held by joints with limits of force",
        "  nonlinear springs: 1 of a ball or free joint, or that yields",
        "  nonlinear damping: 3 of a ball or free joint, or of an actuator",
    ]  # fmt: skip
    assert lines[1:-1] == expected
    names = [line.partition(":")[0].strip() for line in expected]
    assert lines[-1] == f"Leave them out with ignore={tuple(names)!r}."
    for name in names:
        others = [other for other in names if other != name]
        with pytest.raises(ValueError, match=f"\n  {name}: .*\nLeave"):
            galvi.from_mujoco(MORE, ignore=others)
    problem = galvi.from_mujoco(MORE, ignore=names)
    assert set(problem.parameters["ignored"]) == set(names) <= set(PARTS)
    assert [joint.stiffness for joint in problem.system.tree.joints] == [0.0, 1.0, 0.0]


def test_what_a_model_disables_is_not_there():
    flags = " ".join(f'{name}="disable"' for name in ("contact", "limit", "actuation", "equality",
                     "frictionloss", "gravity", "spring", "damper"))  # fmt: skip
    quiet = MORE.replace("<option", f"<option><flag {flags}/></option><option")
    problem = galvi.from_mujoco(quiet, ignore=("tendons", "fluid"))
    assert problem.system.force is None and not np.any(problem.system.gravity)
    assert not any(joint.stiffness for joint in problem.system.tree.joints)


@pytest.mark.parametrize(
    ("given", "error", "sentence"),
    [
        (mjcf(f"<body>{BODY}</body>"), ValueError, "one in which nothing can move"),
        (mjcf("<body><joint/></body>"), ValueError, "MuJoCo cannot read the text as a model"),
        (mjcf('<body><joint type="screw"/></body>'), ValueError, "cannot read the text as a model"),
        ("no/such/file.xml", ValueError, "there is no file no/such/file.xml"),
        (3, TypeError, "model must be a mujoco.MjModel or MjSpec, the text of a model or a path"),
    ],
    ids=["nothing moves", "no mass", "no such joint", "no file", "a number"],
)
def test_what_is_no_model_of_a_motion_is_refused(given, error, sentence):
    with pytest.raises(error, match=sentence):
        galvi.from_mujoco(given)


def test_a_file_that_is_no_model_is_refused(tmp_path):
    for name in ("model.xml", "model.mjb"):
        (tmp_path / name).write_text("not a model")
        with pytest.raises(ValueError, match=rf"MuJoCo cannot read .*{name} as a model"):
            galvi.from_mujoco(tmp_path / name)


def test_names_to_ignore_must_be_known():
    with pytest.raises(ValueError, match=r"ignore must name some of contacts, .*'wind'"):
        galvi.from_mujoco(MORE, ignore=("contacts", "wind"))
    with pytest.raises(TypeError, match="ignore must be names"):
        galvi.from_mujoco(MORE, ignore=3)


def test_a_model_changed_to_what_no_tree_has_is_refused():
    model = mujoco.MjModel.from_xml_string(
        mjcf(f'<body><joint type="ball" damping="1"/>{BODY}</body>')
    )
    model.dof_damping[1] = 2.0
    with pytest.raises(ValueError, match="the damping of joint 0 must be the same for all"):
        galvi.from_mujoco(model)
    model.dof_damping[1], model.body_mass[1] = 1.0, 0.0
    with pytest.raises(ValueError, match=r"link 0 has joints, .* mass above 0; received mass 0.0"):
        galvi.from_mujoco(model)


HINGE = galvi.Joint("hinge")
LINK = galvi.Link(HINGE, 1.0, (0.0, 0.0, -1.0))


@pytest.mark.parametrize(
    ("make", "error", "sentence"),
    [
        (lambda: galvi.Joint("screw"), ValueError, "type must be one of hinge, slide, ball, free"),
        (lambda: galvi.Joint("hinge", axis=(0, 0, 0)), ValueError, "axis must have a length"),
        (lambda: galvi.Joint("slide", axis=(1e300, 2, 0)), ValueError, "axis must have a length"),
        (lambda: galvi.Joint("hinge", damping=-1.0), ValueError, "damping must not be negative"),
        (lambda: galvi.Joint("ball", zero=1.0), ValueError, "zero is of a hinge or a slide"),
        (lambda: galvi.Joint("ball", rest=2.0), ValueError, r"rest must have shape \(3, 3\)"),
        (lambda: galvi.Link(HINGE, -1.0), ValueError, "mass must not be negative"),
        (lambda: galvi.Link(HINGE, 1.0, inertia=(1, -1, 1)), ValueError, "positive semidefinite"),
        (lambda: galvi.Link("hinge", 1.0), TypeError, "joints must be galvi.Joint values"),
        (lambda: galvi.Link([HINGE, galvi.Joint("free")]), ValueError, "must be the only one"),
        (lambda: galvi.Multibody([]), ValueError, "nothing can move"),
        (lambda: galvi.Multibody([galvi.Link(mass=1.0)]), ValueError, "nothing can move"),
        (lambda: galvi.Multibody([galvi.Link(HINGE)]), ValueError, "link 0 has joints, and"),
        (lambda: galvi.Multibody([galvi.Link(HINGE, 1.0, parent=0)]), ValueError, "parent of link"),
        (lambda: galvi.Multibody([LINK, galvi.Link(galvi.Joint("free"), 1.0, parent=0)]),
         ValueError, "between a link and the world; link 1"),
        (lambda: galvi.Multibody(LINK).from_mujoco([0.0, 1.0], [0.0]), ValueError,
         r"qpos must have shape \(1,\)"),
        (lambda: galvi.Multibody(galvi.Link(galvi.Joint("ball"), 1.0)).from_mujoco(
            np.zeros(4), np.zeros(3)), ValueError, "a quaternion that is 0"),
        (lambda: galvi.integrate(
            galvi.Problem(galvi.Multibody(galvi.Link(HINGE, 1.0, (0, 0, -1))), [0.0], [1.0]),
            galvi.Galerkin(galvi.Polynomials(2), galvi.gauss(2)), 0.1, 1),
         ValueError, "the Lagrangian is degenerate at the start"),
    ],
)  # fmt: skip
def test_a_tree_that_cannot_be_is_refused(make, error, sentence):
    with pytest.raises(error, match=sentence):
        make()


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
