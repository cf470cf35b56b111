"""Trees of rigid bodies in Pinocchio, and their motion by its accelerations.

joint         Pinocchio's coordinates and velocities
hinge, slide  q - zero; its rate
ball          quaternion, w last; angular velocity in the body's frame
free          position, quaternion, w last; velocity and angular velocity in the body's frame

Those of `galvi.Multibody.to_mujoco` have w first, and a free joint's velocity in space.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, ClassVar

import numpy as np

from galvi import Joint, Link, Multibody, Problem, Trajectory
from galvi.arrays import Array
from references.contender import require
from references.tree_ivp import SCALAR, integrated, joints_of

OLDEST_PINOCCHIO = 3  # major version; earlier ones leave armatures out of accelerations


def missing() -> str:
    """Why Pinocchio cannot be used here, and what to install; empty when it can."""
    try:
        import pinocchio
    except ImportError as error:
        return f"{error}. Install pin, which is Pinocchio."
    installed = str(getattr(pinocchio, "__version__", "of another project"))
    if not hasattr(pinocchio, "aba") or int(installed.partition(".")[0]) < OLDEST_PINOCCHIO:
        return f"pinocchio {installed} is not Pinocchio {OLDEST_PINOCCHIO} or newer. Install pin."
    return ""


def version() -> str:
    """Name and version of the engine."""
    import pinocchio

    return f"pinocchio {pinocchio.__version__}"


@lru_cache(maxsize=8)
def tree_of(system: Multibody) -> PinocchioTree:
    """The tree in Pinocchio; those of the last 8 systems are cached."""
    return PinocchioTree.of(system)


@dataclass(frozen=True, eq=False)
class PinocchioTree:
    """Pinocchio's model of a tree, with springs and damping, which Pinocchio does not model.

    Attributes
    ----------
    model, pin_data
        Pinocchio's
    qpos_order : array, shape (nq,)
        indices of qpos in Pinocchio's order
    zeros : array, shape (nq,)
        subtracted from qpos[qpos_order]
    scalars
        of the k hinges and slides, arrays of shape (k,): indices in qpos and in qvel, stiffness,
        and rest, a value of qpos
    turning
        of balls and free joints: joint, indices of its first entries of qpos and of qvel
    damping : array, shape (nv,)
        coefficients
    """

    model: Any
    pin_data: Any
    qpos_order: Array
    zeros: Array
    scalars: tuple[Array, Array, Array, Array]
    turning: tuple[tuple[Joint, int, int], ...]
    damping: Array

    @classmethod
    def of(cls, system: Multibody) -> PinocchioTree:
        """The tree of a system in Pinocchio."""
        import pinocchio

        model = pinocchio.Model()
        model.gravity.linear = np.array(system.gravity)
        carried: list[tuple[int, Any]] = []
        for link in system.links:
            ground = (0, pinocchio.SE3.Identity())
            parent = ground if link.parent is None else carried[link.parent]
            carried.append(_add_link(model, link, *parent))
        armature, damping, zeros = np.zeros(model.nv), np.zeros(model.nv), np.zeros(model.nq)
        qpos_order: list[int] = []
        scalars: list[tuple[float, ...]] = []
        turning = []
        for joint, at, dof in joints_of(system):
            armature[dof : dof + joint.dimension] = joint.armature
            damping[dof : dof + joint.dimension] = joint.damping
            if joint.type in SCALAR:
                qpos_order, zeros[at] = [*qpos_order, at], joint.zero
                scalars.append((at, dof, joint.stiffness, joint.rest))
                continue
            first = at + 3 * (joint.type == "free")
            qpos_order += [*range(at, first), first + 1, first + 2, first + 3, first]
            turning.append((joint, at, dof))
        model.armature = armature
        table = np.array(scalars).reshape(-1, 4).T
        split = (table[0].astype(int), table[1].astype(int), table[2], table[3])
        return cls(
            model, model.createData(), np.array(qpos_order), zeros, split, tuple(turning), damping
        )

    def accelerations(self, qpos: Array, qvel: Array) -> Array:
        """qvel' (nv,) at qpos (nq,) and qvel (nv,), by the articulated-body algorithm.

        All three are in the convention of `galvi.Multibody.to_mujoco`, not in Pinocchio's;
        quaternions in qpos may have any length.
        """
        import pinocchio
        from scipy.spatial.transform import Rotation

        coordinates, rates = qpos[self.qpos_order] - self.zeros, qvel.copy()
        forces = -self.damping * qvel
        entries, dofs, stiffness, rests = self.scalars
        forces[dofs] -= stiffness * (qpos[entries] - rests)
        floating = []
        for joint, at, dof in self.turning:
            free = joint.type == "free"
            quaternion = coordinates[at + 3 * free : at + 3 * free + 4]
            quaternion /= np.linalg.norm(quaternion)  # in place
            R = Rotation.from_quat(quaternion).as_matrix()
            spin = slice(dof + 3 * free, dof + 3 * free + 3)
            if joint.stiffness:
                from_rest = Rotation.from_matrix(joint.rest[:3, :3].T @ R).as_rotvec()
                forces[spin] -= joint.stiffness * from_rest
            if free:
                linear = slice(dof, dof + 3)
                pull = forces[linear] - joint.stiffness * (qpos[at : at + 3] - joint.rest[:3, 3])
                rates[linear] = R.T @ qvel[linear]
                # The armature acts on the velocity in space, whose rate has this further term.
                omega_cross_v = np.cross(qvel[spin], rates[linear])
                forces[linear] = R.T @ pull - joint.armature * omega_cross_v
                floating.append((R, linear, omega_cross_v))
        accelerations = np.array(
            pinocchio.aba(self.model, self.pin_data, coordinates, rates, forces)
        )
        for R, linear, omega_cross_v in floating:
            accelerations[linear] = R @ (accelerations[linear] + omega_cross_v)
        return accelerations


def _add_link(model: Any, link: Link, joint: int, placement: Any) -> tuple[int, Any]:
    """Add a link's joints and its inertia to the model.

    Parameters
    ----------
    joint, placement
        the joint that carries the parent, and the parent's frame in it

    Returns
    -------
    joint, placement
        the same of this link, which its parent's joint carries where it has none of its own
    """
    import pinocchio

    free = any(link_joint.type == "free" for link_joint in link.joints)
    if not free:  # the coordinates of a free joint are its placement
        placement = placement * pinocchio.SE3(np.array(link.attitude), np.array(link.place))
    for link_joint in link.joints:
        anchor = pinocchio.SE3(np.eye(3), np.array(link_joint.anchor) * (not free))
        joint = model.addJoint(
            joint, _joint(link_joint), placement * anchor, f"joint {model.njoints}"
        )
        placement = anchor.inverse()
    inertia = pinocchio.Inertia(link.mass, np.array(link.centre), np.array(link.inertia))
    model.appendBodyToJoint(joint, inertia, placement)
    return joint, placement


def _joint(joint: Joint) -> Any:
    import pinocchio

    if joint.type == "ball":
        return pinocchio.JointModelSpherical()
    if joint.type == "free":
        return pinocchio.JointModelFreeFlyer()
    axis = np.array(joint.axis)
    if joint.type == "hinge":
        return pinocchio.JointModelRevoluteUnaligned(axis)
    return pinocchio.JointModelPrismaticUnaligned(axis)


@dataclass(frozen=True, eq=False)
class PinocchioAccelerations:
    """DOP853 on accelerations by the articulated-body algorithm, in adaptive steps; the setting is
    that of `references.tree_ivp.integrated`."""

    fixed_step: ClassVar[bool] = False
    engine: ClassVar[str] = "pin"

    name: str = "SciPy DOP853 on Pinocchio's accelerations"
    order: int = 8
    exact: bool = False

    @property
    def missing(self) -> str:
        """Why the engine cannot be used here; empty when it can."""
        return missing()

    def supports(self, problem: Problem) -> bool:
        """Whether it is a tree without a given force; springs and damping are included."""
        system = problem.system
        return isinstance(system, Multibody) and system.given_force[0] is None

    def run(self, problem: Problem, duration: float, setting: Mapping[str, Any]) -> Trajectory:
        """Adaptive steps; see `Contender`."""
        require(self, problem)
        tree = tree_of(problem.system)
        return integrated(self.name, version(), tree.accelerations, problem, duration, setting)


PINOCCHIO_ACCELERATIONS = PinocchioAccelerations()
