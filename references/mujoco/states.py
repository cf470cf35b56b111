"""Converts states between MuJoCo's coordinates and galvi's, for one body, a chain or a tree.

joint   qpos                  qvel
ball    quaternion            w
free    x, then quaternion    velocity of x in space, then w
hinge   angle                 rate
chain   angles between links  their rates

Quaternions have w first and take the body's frame to space; w is the angular velocity in the
body's frame.
"""

from __future__ import annotations

import numpy as np

from galvi import Multibody
from galvi.arrays import Array

FROM_SCIPY, TO_SCIPY = [3, 0, 1, 2], [1, 2, 3, 0]  # w last there


def to_mujoco(joint: str | Multibody, q: Array, v: Array) -> tuple[Array, Array]:
    """(qpos, qvel) of the state q, v; all may have leading axes."""
    if isinstance(joint, Multibody):
        return joint.to_mujoco(q, v)
    if joint == "hinge":
        return q, v
    if joint == "chain":
        return np.diff(q, prepend=0.0, axis=-1), np.diff(v, prepend=0.0, axis=-1)
    from scipy.spatial.transform import Rotation

    R = q[..., :3, :3]
    turned = Rotation.from_matrix(R).as_quat()[..., FROM_SCIPY]
    if joint == "ball":
        return turned, v
    drift = np.einsum("...ij,...j->...i", R, v[..., 3:])
    return (
        np.concatenate([q[..., :3, 3], turned], axis=-1),
        np.concatenate([drift, v[..., :3]], axis=-1),
    )


def from_mujoco(joint: str | Multibody, qpos: Array, qvel: Array) -> tuple[Array, Array]:
    """(q, v) of rows of qpos and qvel; NaN where they are not finite."""
    if isinstance(joint, Multibody):
        return joint.from_mujoco(qpos, qvel)
    if joint == "hinge":
        return qpos, qvel
    if joint == "chain":
        return np.cumsum(qpos, axis=-1), np.cumsum(qvel, axis=-1)
    from scipy.spatial.transform import Rotation

    finite = np.all(np.isfinite(qpos), axis=-1)
    R = np.full((len(qpos), 3, 3), np.nan)
    R[finite] = Rotation.from_quat(qpos[finite, -4:][:, TO_SCIPY]).as_matrix()
    if joint == "ball":
        return R, qvel
    q = np.zeros((len(qpos), 4, 4))
    q[:, :3, :3], q[:, :3, 3], q[:, 3, 3] = R, qpos[:, :3], 1.0
    drift = np.einsum("nji,nj->ni", R, qvel[:, :3])
    return q, np.concatenate([qvel[:, 3:], drift], axis=-1)
