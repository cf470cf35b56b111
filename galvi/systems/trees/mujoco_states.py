"""States of a tree in MuJoCo's coordinates.

joint         qpos                     qvel
hinge, slide  coordinate               its rate
ball          quaternion               w
free          place, then quaternion   velocity of the place in space, then w

Quaternions have w first and take the link's frame to that before the joint; w is the angular
velocity in the link's frame.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from galvi.arrays import Array
from galvi.groups.group import Group
from galvi.kernels.lanes.tree import DOFS, ENTRIES, SLIDE
from galvi.systems.trees.joint import Joint

POSITIONS = (1, 1, 4, 7)  # entries of qpos
FROM_SCIPY, TO_SCIPY = [3, 0, 1, 2], [1, 2, 3, 0]  # w last there


def _places(joints: Sequence[Joint]) -> Iterator[tuple[int, slice, slice, slice]]:
    """The kind of each joint, and its entries of qpos, q and velocities."""
    at, entry, dof = 0, 0, 0
    for joint in joints:
        kind = joint.number
        ends = at + POSITIONS[kind], entry + ENTRIES[kind], dof + DOFS[kind]
        yield kind, slice(at, ends[0]), slice(entry, ends[1]), slice(dof, ends[2])
        at, entry, dof = ends


def from_mujoco(joints: Sequence[Joint], group: Group, qpos: Any, qvel: Any) -> tuple[Array, Array]:
    """(q, v) of states (..., nq) and (..., nv)."""
    nq = sum(POSITIONS[joint.number] for joint in joints)
    given, rates = _pair(("qpos", "qvel"), (qpos, qvel), ((nq,), (group.dimension,)))
    q = np.empty((*given.shape[:-1], int(np.prod(group.shape))))
    v = rates.copy()
    for kind, at, entries, dofs in _places(joints):
        part = given[..., at]
        if kind <= SLIDE:
            q[..., entries] = part
            continue
        R, known = _rotations(part[..., -4:])
        if part.shape[-1] == 4:
            q[..., entries] = R.reshape(*R.shape[:-2], 9)
            continue
        g = np.zeros((*R.shape[:-2], 4, 4))
        g[..., :3, :3], g[..., :3, 3], g[..., 3, 3] = R, part[..., :3], np.where(known, 1.0, np.nan)
        q[..., entries] = g.reshape(*g.shape[:-2], 16)
        linear, angular = rates[..., dofs][..., :3], rates[..., dofs][..., 3:]
        v[..., dofs] = np.concatenate([angular, np.einsum("...ji,...j->...i", R, linear)], axis=-1)
    return q.reshape(*q.shape[:-1], *group.shape), v


def to_mujoco(joints: Sequence[Joint], group: Group, q: Any, v: Any) -> tuple[Array, Array]:
    """(qpos, qvel) of states (..., *group.shape) and (..., d)."""
    places, rates = _pair(("q", "v"), (q, v), (group.shape, (group.dimension,)))
    flat = places.reshape(*rates.shape[:-1], -1)
    nq = sum(POSITIONS[joint.number] for joint in joints)
    qpos, qvel = np.empty((*rates.shape[:-1], nq)), rates.copy()
    for kind, at, entries, dofs in _places(joints):
        part = flat[..., entries]
        if kind <= SLIDE:
            qpos[..., at] = part
            continue
        side = 3 if part.shape[-1] == 9 else 4
        g = part.reshape(*part.shape[:-1], side, side)
        R = g[..., :3, :3]
        qpos[..., at.stop - 4 : at.stop] = _quaternions(R)
        if side == 4:
            qpos[..., at.start : at.start + 3] = g[..., :3, 3]
            angular, linear = rates[..., dofs][..., :3], rates[..., dofs][..., 3:]
            drift = np.einsum("...ij,...j->...i", R, linear)
            qvel[..., dofs] = np.concatenate([drift, angular], axis=-1)
    return qpos, qvel


def _rotations(quaternions: Array) -> tuple[Array, Array]:
    """Matrices (..., 3, 3), NaN where they are not finite, and whether they are finite (...)."""
    flat = quaternions.reshape(-1, 4)
    known = np.all(np.isfinite(flat), axis=1)
    if not np.all(np.any(flat[known] != 0.0, axis=1)):
        raise ValueError("qpos has a quaternion that is 0; it must have a length above 0.")
    R = np.full((len(flat), 3, 3), np.nan)
    R[known] = Rotation.from_quat(flat[known][:, TO_SCIPY]).as_matrix()
    lead = quaternions.shape[:-1]
    return R.reshape(*lead, 3, 3), known.reshape(lead)


def _quaternions(R: Array) -> Array:
    flat = R.reshape(-1, 3, 3)
    known = np.all(np.isfinite(flat), axis=(1, 2))
    found = np.full((len(flat), 4), np.nan)
    found[known] = Rotation.from_matrix(flat[known]).as_quat(canonical=True)[:, FROM_SCIPY]
    return found.reshape(*R.shape[:-2], 4)


def _pair(
    names: tuple[str, str], values: tuple[Any, Any], shapes: tuple[tuple[int, ...], ...]
) -> tuple[Array, Array]:
    """Both as arrays with the same leading axes; ValueError for wrong shapes."""
    found = tuple(np.asarray(value, dtype=np.float64) for value in values)
    leads = []
    for name, value, shape in zip(names, found, shapes, strict=True):
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
    return found[0], found[1]
