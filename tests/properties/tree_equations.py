"""The equations of motion of a tree's Lagrangian, and their defects for MuJoCo's accelerations.

M a = ad*_v mu + dL/dq + f - (d mu / dq) q',   the last term by a complex step.
"""

import numpy as np

from galvi.kernels.trees import tree

COMPLEX_STEP = 1e-30


def joints_of(system):
    """Yields the type of each joint and the slices of its entries in q and of its velocities."""
    entry = dof = 0
    for joint in system.tree.joints:
        joint_type = joint.number
        ends = entry + tree.ENTRIES[joint_type], dof + tree.DOFS[joint_type]
        yield joint_type, slice(entry, ends[0]), slice(dof, ends[1])
        entry, dof = ends


def entry_rates(system, q, v):
    """The time derivatives of the entries of q."""
    flat, derivative = q.ravel(), np.empty(q.size)
    for joint_type, entries, dofs in joints_of(system):
        straight = entries.stop - entries.start - 9 * (joint_type > tree.SLIDE)
        first, dof = entries.start, dofs.start
        derivative[first : first + straight] = v[dof : dof + straight]
        if joint_type > tree.SLIDE:
            first, w = first + straight, v[dofs.stop - 3 : dofs.stop]
            R = flat[first : first + 9].reshape(3, 3)
            derivative[first : first + 9] = np.cross(w, -R).ravel()  # R hat(w)
    return derivative


def terms(system, q, v):
    """The four terms of the right-hand side, (4, velocities)."""
    d, numbers = v.size, system.tree.numbers.tolist()
    momenta, left_slopes = system.tree.left_slopes(q, v)
    moving = list(q.ravel() + 1j * COMPLEX_STEP * entry_rates(system, q, v))
    work, unused_momenta, change = (
        [0.0] * (tree.STRIDE * (int(numbers[0]) + 1)),
        [0.0] * d,
        [0.0] * d,
    )
    tree.outward(numbers, moving, list(v.astype(complex)), work)
    tree.inward(numbers, list(v.astype(complex)), work, unused_momenta, change)
    gyroscopic = np.zeros(d)
    for joint_type, _, dofs in joints_of(system):
        if joint_type > tree.SLIDE:
            rotation = slice(dofs.stop - 3, dofs.stop)
            gyroscopic[rotation] = np.cross(momenta[rotation], v[rotation])
    force = np.zeros(d) if system.force is None else system.force(q, v, 0.0)
    return np.stack([gyroscopic, left_slopes, force, -np.imag(change) / COMPLEX_STEP])


def defects(model, system, qpos, qvel):
    """Four relative errors at one state: |M a - tau| for MuJoCo's acceleration a, over |tau| and
    over the sum of the sizes of its terms; and those of the kinetic and the potential energy."""
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
    force_error = np.linalg.norm(mass @ mj_data.qacc - tau)
    size = np.abs(mj_data.xipos @ model.opt.gravity) @ model.body_mass + abs(mj_data.energy[0])
    return np.array(
        [
            force_error / max(np.linalg.norm(tau), 1e-300),
            force_error / max(np.linalg.norm(force_terms, axis=1).sum(), 1e-300),
            abs(0.5 * v @ mass @ v - mj_data.energy[1]) / mj_data.energy[1],
            abs(potential - mj_data.energy[0]) / max(size, 1e-300),
        ]
    )
