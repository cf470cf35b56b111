"""Bodies that MuJoCo takes, skew and tilted ones among them, for its tests."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import galvi

pytest.importorskip("mujoco")

from references.mujoco.steps import (
    MUJOCO_DISCRETE,
    MUJOCO_EULER,
    MUJOCO_IMPLICIT,
    MUJOCO_IMPLICITFAST,
    MUJOCO_RK4,
)

ALL = (MUJOCO_EULER, MUJOCO_RK4, MUJOCO_IMPLICIT, MUJOCO_IMPLICITFAST, MUJOCO_DISCRETE)
if MUJOCO_RK4.missing:
    pytest.skip(MUJOCO_RK4.missing, allow_module_level=True)

TILT = Rotation.from_rotvec([0.7, -1.1, 0.4]).as_matrix()
SKEW = np.array([[3.3, 0.2, -0.3], [0.2, 2.5, 0.4], [-0.3, 0.4, 3.4]])
SPIN = [2.0, -1.9, 1.0]
MOTION = np.block([[TILT, np.array([[0.5], [-1.0], [2.0]])], [np.zeros((1, 3)), np.ones((1, 1))]])
LEVER = galvi.UniformGravity(0.8, (0.3, -0.5, 0.7), (1.0, 2.0, -7.0))
TILTED = galvi.Problem(galvi.RigidBody(SKEW), TILT, SPIN)
PROBLEMS = {
    "free body": galvi.problems.free_rigid_body(),
    "free body, tilted": TILTED,
    "free box": galvi.problems.free_box(),
    "3D pendulum": galvi.problems.pendulum_3d(),
    "3D pendulum, skew": galvi.Problem(galvi.RigidBody(SKEW, LEVER), TILT, SPIN),
    "heavy top": galvi.problems.heavy_top(),
    "spherical pendulum": galvi.problems.spherical_pendulum(),
    "thrown body": galvi.problems.free_body_se3(g=(0.5, -1.0, -9.81)),
    "thrown body, skew": galvi.Problem(
        galvi.FreeBody(1.7, SKEW, (1.0, 2.0, -7.0)), MOTION, [*SPIN, 0.3, 0.2, -0.1]
    ),
    "planar pendulum": galvi.problems.planar_pendulum(),
    "planar pendulum, light": galvi.Problem(
        galvi.Canonical([[0.3]], galvi.CosinePotential(1.7)), [-1.0], [2.0]
    ),
}
