"""Models that others wrote, as trees: what they have beyond, and their motion against MuJoCo's.

They are in wheels of suites, which `make install` keeps in the environment's ``models``.
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
MOVED = ("contacts", "limits", "actuators")
# what each model has beyond a tree, to be left out
MODELS = {
    f"{GYM}/ant.xml": MOVED,
    f"{GYM}/half_cheetah.xml": MOVED,
    f"{GYM}/hopper.xml": MOVED,
    f"{GYM}/humanoid.xml": MOVED,
    f"{GYM}/humanoidstandup.xml": MOVED,
    f"{GYM}/inverted_double_pendulum.xml": ("limits", "actuators"),
    f"{GYM}/inverted_pendulum.xml": ("limits", "actuators"),
    f"{GYM}/point.xml": ("contacts", "actuators"),
    f"{GYM}/pusher_v5.xml": MOVED,
    f"{GYM}/reacher.xml": ("limits", "actuators"),
    f"{GYM}/swimmer.xml": ("limits", "actuators", "fluid"),
    f"{GYM}/walker2d_v5.xml": MOVED,
    f"{SUITE}/acrobot.xml": ("actuators",),
    f"{SUITE}/ball_in_cup.xml": ("contacts", "actuators", "tendons", "limits"),
    f"{SUITE}/cartpole.xml": ("limits", "actuators"),
    f"{SUITE}/cheetah.xml": MOVED,
    f"{SUITE}/finger.xml": (*MOVED, "friction loss"),
    f"{SUITE}/fish.xml": ("actuators", "tendons", "fluid"),
    f"{SUITE}/humanoid.xml": MOVED,
    f"{SUITE}/humanoid_CMU.xml": MOVED,
    f"{SUITE}/manipulator.xml": (*MOVED, "equality"),
    f"{SUITE}/pendulum.xml": ("actuators",),
    f"{SUITE}/quadruped.xml": (*MOVED, "equality"),
    "dm_control/third_party/kinova/jaco_arm.xml": ("contacts", "limits", "friction loss"),
}


@cache
def _unpacked(package: str) -> tuple[TemporaryDirectory[str], Path]:
    """The wheel's MJCF files and meshes, in a folder that lives as long as the tests."""
    (wheel,) = FOLDER.glob(f"{package}-*.whl")
    folder = TemporaryDirectory(prefix="models-")
    with zipfile.ZipFile(wheel) as archive:
        wanted = {str(Path(name).parent) for name in MODELS} | {f"{SUITE}/common"}
        for name in archive.namelist():
            part = str(Path(name).parent)
            if part in wanted or any(part.startswith(f"{folder}/") for folder in wanted):
                archive.extract(name, folder.name)
    return folder, Path(folder.name)


def path_of(name: str) -> Path:
    """The file of a model; skips the test where its wheel is not here."""
    package = name.partition("/")[0]
    if len(list(FOLDER.glob(f"{package}-*.whl"))) != 1:
        pytest.skip(f"{FOLDER.name} in the environment has no wheel of {package}: make install")
    return _unpacked(package)[1] / name


@pytest.fixture(autouse=True)
def quiet():
    """MuJoCo's warnings of deprecated attributes would be written to a file."""
    before = mujoco.get_mju_user_warning()
    mujoco.set_mju_user_warning(lambda message: None)
    yield
    mujoco.set_mju_user_warning(before)


def without(model, parts):
    """The model with what galvi leaves out disabled."""
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
        named = {line.partition(":")[0].strip() for line in lines[1:-1]}
        assert named and named <= set(parts)  # actuators, tendons and others are read in part
    problem = galvi.from_mujoco(model, ignore=parts)
    errors = [
        defects(without(model, parts), problem.system, *random_state(model, k)) for k in (0, 1)
    ]
    assert np.max(np.array(errors)[:, 1:]) < 1e-12  # 2e-14


def test_a_model_of_a_suite_runs(tmp_path):
    problem = galvi.from_mujoco(path_of("dm_control/suite/acrobot.xml"), ignore="actuators")
    q, v = problem.system.from_mujoco([1.0, 0.5], [0.0, 0.0])
    eight = galvi.Galerkin(galvi.Polynomials(8), galvi.gauss(8))
    run = galvi.integrate(problem.with_initial_state(q, v), eight, 0.05, 100)
    assert run.success and "acrobot" in problem.name
