"""The equations of motion that a tree's Lagrangian gives, and how far MuJoCo's motion is off them.

M a = ad*_v mu + dL/dq + f - (d mu / dq) q',   the last term by a complex step.
"""

import numpy as np

from galvi.kernels.trees import tree

STEP = 1e-30


def joints_of(system):
    """Kind, entries and velocities of each joint."""
    entry = dof = 0
    for joint in system.tree.joints:
        kind = joint.number
        ends = entry + tree.ENTRIES[kind], dof + tree.DOFS[kind]
        yield kind, slice(entry, ends[0]), slice(dof, ends[1])
        entry, dof = ends


def rates(system, q, v):
    """q' of the entries."""
    flat, derivative = q.ravel(), np.empty(q.size)
    for kind, entries, dofs in joints_of(system):
        straight = entries.stop - entries.start - 9 * (kind > tree.SLIDE)
        first, dof = entries.start, dofs.start
        derivative[first : first + straight] = v[dof : dof + straight]
        if kind > tree.SLIDE:
            first, w = first + straight, v[dofs.stop - 3 : dofs.stop]
            R = flat[first : first + 9].reshape(3, 3)
            derivative[first : first + 9] = np.cross(w, -R).ravel()  # R hat(w)
    return derivative


def terms(system, q, v):
    """The terms of the right-hand side, rows."""
    d, numbers = v.size, system.tree.numbers.tolist()
    momenta, left = system.tree.left_slopes(q, v)
    moving = list(q.ravel() + 1j * STEP * rates(system, q, v))
    work, unused, change = [0.0] * (tree.STRIDE * (int(numbers[0]) + 1)), [0.0] * d, [0.0] * d
    tree.outward(numbers, moving, list(v.astype(complex)), work)
    tree.inward(numbers, list(v.astype(complex)), work, unused, change)
    turning = np.zeros(d)
    for kind, _, dofs in joints_of(system):
        if kind > tree.SLIDE:
            turns = slice(dofs.stop - 3, dofs.stop)
            turning[turns] = np.cross(momenta[turns], v[turns])
    force = np.zeros(d) if system.force is None else system.force(q, v, 0.0)
    return np.stack([turning, left, force, -np.imag(change) / STEP])


def defects(model, system, qpos, qvel):
    """Errors of MuJoCo's acceleration and of both energies at one state: |M a - tau| over |tau| and
    over the sum of its terms' sizes, and those of the energies over their sizes."""
    import mujoco

    mj_data = mujoco.MjData(model)
    mj_data.qpos[:], mj_data.qvel[:] = qpos, qvel
    mujoco.mj_forward(model, mj_data)
    mujoco.mj_energyPos(model, mj_data)
    mujoco.mj_energyVel(model, mj_data)
    q, v = system.from_mujoco(qpos, qvel)
    mass, potential = system.tree.mass_and_potential(q)
    force_terms = terms(system, q, v)
    tau = force_terms.sum(axis=0)
    off = np.linalg.norm(mass @ mj_data.qacc - tau)
    size = np.abs(mj_data.xipos @ model.opt.gravity) @ model.body_mass + abs(mj_data.energy[0])
    return np.array(
        [
            off / max(np.linalg.norm(tau), 1e-300),
            off / max(np.linalg.norm(force_terms, axis=1).sum(), 1e-300),
            abs(0.5 * v @ mass @ v - mj_data.energy[1]) / mj_data.energy[1],
            abs(potential - mj_data.energy[0]) / max(size, 1e-300),
        ]
    )
