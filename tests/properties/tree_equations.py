"""The equations of motion that a tree's Lagrangian gives, and how far MuJoCo's motion is off them.

M a = ad*_v mu + dL/dq + f - (d mu / dq) q',   the last term by a complex step.
"""

import numpy as np

from galvi.kernels.trees import tree

STEP = 1e-30


def _each(system):
    """Kind, entries and velocities of each joint."""
    entry = dof = 0
    for joint in system.tree.joints:
        kind = joint.number
        ends = entry + tree.ENTRIES[kind], dof + tree.DOFS[kind]
        yield kind, slice(entry, ends[0]), slice(dof, ends[1])
        entry, dof = ends


def rates(system, q, v):
    """q' of the entries."""
    flat, found = q.ravel(), np.empty(q.size)
    for kind, entries, dofs in _each(system):
        straight = entries.stop - entries.start - 9 * (kind > tree.SLIDE)
        first, dof = entries.start, dofs.start
        found[first : first + straight] = v[dof : dof + straight]
        if kind > tree.SLIDE:
            first, w = first + straight, v[dofs.stop - 3 : dofs.stop]
            R = flat[first : first + 9].reshape(3, 3)
            found[first : first + 9] = np.cross(w, -R).ravel()  # R hat(w)
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
        if kind > tree.SLIDE:
            turns = slice(dofs.stop - 3, dofs.stop)
            turning[turns] = np.cross(momenta[turns], v[turns])
    force = np.zeros(d) if system.force is None else system.force(q, v, 0.0)
    return np.stack([turning, left, force, -np.imag(change) / STEP])


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
    off = np.linalg.norm(mass @ data.qacc - tau)
    far = np.abs(data.xipos @ model.opt.gravity) @ model.body_mass + abs(data.energy[0])
    return np.array(
        [
            off / max(np.linalg.norm(tau), 1e-300),
            off / max(np.linalg.norm(asked, axis=1).sum(), 1e-300),
            abs(0.5 * v @ mass @ v - data.energy[1]) / data.energy[1],
            abs(potential - data.energy[0]) / max(far, 1e-300),
        ]
    )
