"""States of a tree in MuJoCo's coordinates.

joint         qpos                     q
hinge, slide  coordinate               the same
ball          quaternion               its rotation matrix
free          place, then quaternion   the place, then its rotation matrix

Quaternions have w first and rotate the link's frame to the frame before the joint. Both use the
same velocities; a free joint has the velocity of its origin in space, then the angular velocity in
its own frame.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from galvi.arrays import Array
from galvi.groups.group import Group
from galvi.kernels.trees.tree import SLIDE
from galvi.systems.trees.joint import Joint

POSITIONS = (1, 1, 4, 7)  # entries of qpos of a hinge, a slide, a ball and a free joint
FROM_SCIPY, TO_SCIPY = [3, 0, 1, 2], [1, 2, 3, 0]  # orders of quaternions: SciPy has w last


def _joint_slices(joints: Sequence[Joint]) -> Iterator[tuple[slice, slice, int, int]]:
    """For each joint: the slices of qpos and of q that hold equal coordinates, then the index of
    its quaternion in qpos and of its matrix in q; -1 and -1 for a joint without."""
    at = entry = 0
    for joint in joints:
        scalars = {"ball": 0, "free": 3}.get(joint.type, 1)
        has_rotation = joint.number > SLIDE
        slices = slice(at, at + scalars), slice(entry, entry + scalars)
        at, entry = at + scalars, entry + scalars
        yield *slices, *((at, entry) if has_rotation else (-1, -1))
        at, entry = at + 4 * has_rotation, entry + 9 * has_rotation


def from_mujoco(joints: Sequence[Joint], group: Group, qpos: Any, qvel: Any) -> tuple[Array, Array]:
    """(q, v), (..., *group.shape) and (..., nv), of states qpos (..., nq) and qvel (..., nv)."""
    nq = sum(POSITIONS[joint.number] for joint in joints)
    positions, rates = _pair(("qpos", "qvel"), (qpos, qvel), ((nq,), (group.dimension,)))
    lead = positions.shape[:-1]
    q = np.empty((*lead, int(np.prod(group.shape))))
    for qpos_slice, q_slice, at, entry in _joint_slices(joints):
        q[..., q_slice] = positions[..., qpos_slice]
        if at >= 0:
            R = _rotations(positions[..., at : at + 4])
            q[..., entry : entry + 9] = R.reshape(*lead, 9)
    return q.reshape(*lead, *group.shape), rates.copy()


def to_mujoco(joints: Sequence[Joint], group: Group, q: Any, v: Any) -> tuple[Array, Array]:
    """(qpos, qvel), (..., nq) and (..., d), of states q (..., *group.shape) and v (..., d)."""
    configurations, rates = _pair(("q", "v"), (q, v), (group.shape, (group.dimension,)))
    lead = rates.shape[:-1]
    flat = configurations.reshape(*lead, -1)
    qpos = np.empty((*lead, sum(POSITIONS[joint.number] for joint in joints)))
    for qpos_slice, q_slice, at, entry in _joint_slices(joints):
        qpos[..., qpos_slice] = flat[..., q_slice]
        if at >= 0:
            R = flat[..., entry : entry + 9].reshape(*lead, 3, 3)
            qpos[..., at : at + 4] = _quaternions(R)
    return qpos, rates.copy()


def _rotations(quaternions: Array) -> Array:
    """Rotation matrices (..., 3, 3) of quaternions (..., 4), NaN where these are not finite;
    ValueError for a quaternion that is 0."""
    from scipy.spatial.transform import Rotation  # would lengthen galvi's import by a fifth

    flat = quaternions.reshape(-1, 4)
    finite = np.all(np.isfinite(flat), axis=1)
    if not np.all(np.any(flat[finite] != 0.0, axis=1)):
        raise ValueError("qpos has a quaternion that is 0; it must have a length above 0.")
    R = np.full((len(flat), 3, 3), np.nan)
    R[finite] = Rotation.from_quat(flat[finite][:, TO_SCIPY]).as_matrix()
    return R.reshape(*quaternions.shape[:-1], 3, 3)


def _quaternions(R: Array) -> Array:
    from scipy.spatial.transform import Rotation  # would lengthen galvi's import by a fifth

    flat = R.reshape(-1, 3, 3)
    finite = np.all(np.isfinite(flat), axis=(1, 2))
    quaternions = np.full((len(flat), 4), np.nan)
    quaternions[finite] = Rotation.from_matrix(flat[finite]).as_quat(canonical=True)[:, FROM_SCIPY]
    return quaternions.reshape(*R.shape[:-2], 4)


def _pair(
    names: tuple[str, str], values: tuple[Any, Any], shapes: tuple[tuple[int, ...], ...]
) -> tuple[Array, Array]:
    """Both values as float64 arrays; ValueError for a wrong shape, or if their leading axes
    differ."""
    arrays = tuple(np.asarray(value, dtype=np.float64) for value in values)
    leads = []
    for name, value, shape in zip(names, arrays, shapes, strict=True):
        lead = value.ndim - len(shape)
        if lead < 0 or value.shape[lead:] != shape:
            raise ValueError(
                f"{name} must have shape {shape}, or that after leading axes; received shape "
                f"{value.shape}."
            )
        leads.append(value.shape[:lead])
    if leads[0] != leads[1]:
        raise ValueError(
            f"{names[0]} and {names[1]} must have the same leading axes; received {leads[0]} and "
            f"{leads[1]}."
        )
    return arrays[0], arrays[1]
