"""The equations of motion that a tree's Lagrangian gives, and how far MuJoCo's motion is off them.

M a = ad*_v mu + dL/dq + f - (d mu / dq) q',   the last term by a complex step.
"""

from __future__ import annotations

import numpy as np

from galvi.kernels.lanes import tree

STEP = 1e-30


def _each(system):
    """Kind, entries and velocities of each joint."""
    entry = dof = 0
    for joint in system.tree.joints:
        kind = joint.number
        ends = entry + tree.ENTRIES[kind], dof + tree.DOFS[kind]
        yield kind, slice(entry, ends[0]), slice(dof, ends[1])
        entry, dof = ends


def hat(w):
    """The matrix of w x."""
    return np.array([[0.0, -w[2], w[1]], [w[2], 0.0, -w[0]], [-w[1], w[0], 0.0]])


def rates(system, q, v):
    """q' of the entries."""
    flat, found = q.ravel(), np.empty(q.size)
    for kind, entries, dofs in _each(system):
        w = v[dofs]
        if kind <= tree.SLIDE:
            found[entries] = w
            continue
        side = 3 if kind == tree.BALL else 4
        turning = np.zeros((side, side))
        turning[:3, :3] = hat(w[:3])
        if side == 4:
            turning[:3, 3] = w[3:]
        found[entries] = (flat[entries].reshape(side, side) @ turning).ravel()
    return found


def terms(system, q, v):
    """The terms of the right-hand side, rows."""
    d, numbers = v.size, system.tree.numbers.tolist()
    momenta, left = system.tree.left_slopes(q, v)
    moving = list(q.ravel() + 1j * STEP * rates(system, q, v))
    work, unused, change = [0.0] * (tree.STRIDE * (int(numbers[0]) + 1)), [0.0] * d, [0.0] * d
    tree.outward(numbers, moving, list(v.astype(complex)), work)
    tree.inward(numbers, list(v.astype(complex)), work, unused, change)
    turning = np.zeros(d)
    for kind, _, dofs in _each(system):
        w = v[dofs][:3]
        if kind == tree.BALL:
            turning[dofs] = np.cross(momenta[dofs], w)
        elif kind == tree.FREE:
            (l, f), u = momenta[dofs].reshape(2, 3), v[dofs][3:]
            turning[dofs] = np.concatenate([np.cross(l, w) + np.cross(f, u), np.cross(f, w)])
    force = np.zeros(d) if system.force is None else system.force(q, v, 0.0)
    return np.stack([turning, left, force, -np.imag(change) / STEP])


def own_accelerations(system, q, v, qacc):
    """v' from MuJoCo's: of a free joint's place in its own frame."""
    found, flat = qacc.copy(), q.ravel()
    for kind, entries, dofs in _each(system):
        if kind == tree.FREE:
            R = flat[entries].reshape(4, 4)[:3, :3]
            drift = R.T @ qacc[dofs][:3] - np.cross(v[dofs][:3], v[dofs][3:])
            found[dofs] = np.concatenate([qacc[dofs][3:], drift])
    return found


def defects(model, system, qpos, qvel):
    """Errors of MuJoCo's acceleration and of both energies at one state: |M a - tau| over |tau| and
    over the sum of its terms' sizes, and those of the energies over their sizes."""
    import mujoco

    data = mujoco.MjData(model)
    data.qpos[:], data.qvel[:] = qpos, qvel
    mujoco.mj_forward(model, data)
    mujoco.mj_energyPos(model, data)
    mujoco.mj_energyVel(model, data)
    q, v = system.from_mujoco(qpos, qvel)
    mass, potential = system.tree.mass_and_potential(q)
    asked = terms(system, q, v)
    tau = asked.sum(axis=0)
    off = np.linalg.norm(mass @ own_accelerations(system, q, v, data.qacc.copy()) - tau)
    far = np.abs(data.xipos @ model.opt.gravity) @ model.body_mass + abs(data.energy[0])
    return np.array([
        off / max(np.linalg.norm(tau), 1e-300),
        off / max(np.linalg.norm(asked, axis=1).sum(), 1e-300),
        abs(0.5 * v @ mass @ v - data.energy[1]) / data.energy[1],
        abs(potential - data.energy[0]) / max(far, 1e-300),
    ])  # fmt: skip
