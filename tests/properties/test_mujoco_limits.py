"""What is no tree, or has more than one, is refused in words."""

import numpy as np
import pytest

import galvi
from galvi.interop.mujoco_limits import PARTS, _counted

mujoco = pytest.importorskip("mujoco")

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


def test_all_that_a_model_has_beyond_a_tree_is_named_in_one_refusal():
    with pytest.raises(ValueError) as refusal:
        galvi.from_mujoco(MORE)
    lines = str(refusal.value).splitlines()
    expected = [
        "  contacts: 1 pair of geoms may meet", "  limits: 1 limited joint",
        "  actuators: some with a state of their own (lazy)",
        "  tendons: some with an armature (0)", "  equality: 1 equality constraint",
        "  fluid: a medium with ellipsoids in it", "  friction loss: 1 degree of freedom",
        "  gravity compensation: some weights held by joints with limits of force (one), which are "
        "read without their actuatorgravcomp or their actuatorfrcrange",
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


def test_a_file_that_is_no_model_is_refused(tmp_path):
    for name in ("model.xml", "model.mjb"):
        (tmp_path / name).write_text("not a model")
        with pytest.raises(ValueError, match=rf"MuJoCo cannot read .*{name} as a model"):
            galvi.from_mujoco(tmp_path / name)


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
