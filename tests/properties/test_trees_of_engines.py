"""Models of gymnasium and dm_control as trees: their parts beyond a tree, and their motion against
MuJoCo's.

They are in wheels, which `make install` stores in the folder ``models`` of the environment.
"""

import sys
import zipfile
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest

import galvi
from tests.properties.random_trees import random_state
from tests.properties.tree_equations import defects

mujoco = pytest.importorskip("mujoco")

FOLDER = Path(sys.prefix) / "models"
GYM, SUITE = "gymnasium/envs/mujoco/assets", "dm_control/suite"
USUAL_PARTS = ("contacts", "limits", "actuators")
# File -> its parts beyond a tree, which are left out.
MODELS = {
    f"{GYM}/ant.xml": USUAL_PARTS,
    f"{GYM}/half_cheetah.xml": USUAL_PARTS,
    f"{GYM}/hopper.xml": USUAL_PARTS,
    f"{GYM}/humanoid.xml": USUAL_PARTS,
    f"{GYM}/humanoidstandup.xml": USUAL_PARTS,
    f"{GYM}/inverted_double_pendulum.xml": ("limits", "actuators"),
    f"{GYM}/inverted_pendulum.xml": ("limits", "actuators"),
    f"{GYM}/point.xml": ("contacts", "actuators"),
    f"{GYM}/pusher_v5.xml": USUAL_PARTS,
    f"{GYM}/reacher.xml": ("limits", "actuators"),
    f"{GYM}/swimmer.xml": ("limits", "actuators", "fluid"),
    f"{GYM}/walker2d_v5.xml": USUAL_PARTS,
    f"{SUITE}/acrobot.xml": ("actuators",),
    f"{SUITE}/ball_in_cup.xml": ("contacts", "actuators", "tendons", "limits"),
    f"{SUITE}/cartpole.xml": ("limits", "actuators"),
    f"{SUITE}/cheetah.xml": USUAL_PARTS,
    f"{SUITE}/finger.xml": (*USUAL_PARTS, "friction loss"),
    f"{SUITE}/fish.xml": ("actuators", "tendons", "fluid"),
    f"{SUITE}/humanoid.xml": USUAL_PARTS,
    f"{SUITE}/humanoid_CMU.xml": USUAL_PARTS,
    f"{SUITE}/manipulator.xml": (*USUAL_PARTS, "equality"),
    f"{SUITE}/pendulum.xml": ("actuators",),
    f"{SUITE}/quadruped.xml": (*USUAL_PARTS, "equality"),
    "dm_control/third_party/kinova/jaco_arm.xml": ("contacts", "limits", "friction loss"),
}


@cache
def _unpacked(package: str) -> tuple[TemporaryDirectory[str], Path]:
    """The wheel's MJCF files and meshes, in a folder that lives as long as the tests."""
    (wheel,) = FOLDER.glob(f"{package}-*.whl")
    folder = TemporaryDirectory(prefix="models-")
    with zipfile.ZipFile(wheel) as archive:
        folders = {str(Path(name).parent) for name in MODELS} | {f"{SUITE}/common"}
        for name in archive.namelist():
            parent = str(Path(name).parent)
            if parent in folders or any(parent.startswith(f"{folder}/") for folder in folders):
                archive.extract(name, folder.name)
    return folder, Path(folder.name)


def path_of(name: str) -> Path:
    """The file of a model; skips the test where its wheel is missing."""
    package = name.partition("/")[0]
    if len(list(FOLDER.glob(f"{package}-*.whl"))) != 1:
        pytest.skip(f"{FOLDER.name} in the environment has no wheel of {package}: make install")
    return _unpacked(package)[1] / name


@pytest.fixture(autouse=True)
def without_warnings():
    """Drops MuJoCo's warnings of deprecated attributes, which it would write to a file."""
    before = mujoco.get_mju_user_warning()
    mujoco.set_mju_user_warning(lambda message: None)
    yield
    mujoco.set_mju_user_warning(before)


def with_parts_disabled(model, parts):
    """The model, changed in place, with the parts that galvi leaves out disabled."""
    flags = mujoco.mjtDisableBit
    model.opt.disableflags |= int(flags.mjDSBL_CONSTRAINT) | int(flags.mjDSBL_ACTUATION)
    if "fluid" in parts:
        model.opt.density = model.opt.viscosity = 0.0
    if "tendons" in parts:
        model.tendon_stiffness[:] = 0.0
        model.tendon_damping[:] = 0.0
    return model


@pytest.mark.parametrize("name", MODELS, ids=lambda name: name.replace("/", "-"))
def test_the_trees_of_a_model_move_as_in_mujoco_once_what_is_beyond_is_left_out(name):
    parts = MODELS[name]
    model = mujoco.MjModel.from_xml_path(str(path_of(name)))
    try:
        galvi.from_mujoco(model)
    except ValueError as refusal:
        lines = str(refusal).splitlines()
        named_parts = {line.partition(":")[0].strip() for line in lines[1:-1]}
        assert named_parts and named_parts <= set(
            parts
        )  # actuators, tendons and others are read in part
    problem = galvi.from_mujoco(model, ignore=parts)
    errors = [
        defects(with_parts_disabled(model, parts), problem.system, *random_state(model, k))
        for k in (0, 1)
    ]
    assert np.max(np.array(errors)[:, 1:]) < 1e-12  # 2e-14


def test_a_model_of_a_suite_runs(tmp_path):
    problem = galvi.from_mujoco(path_of("dm_control/suite/acrobot.xml"), ignore="actuators")
    q, v = problem.system.from_mujoco([1.0, 0.5], [0.0, 0.0])
    method = galvi.Galerkin(galvi.Polynomials(8), galvi.gauss(8))
    run = galvi.integrate(problem.with_initial_state(q, v), method, 0.05, 100)
    assert run.success and "acrobot" in problem.name
