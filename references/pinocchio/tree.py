"""Trees of rigid bodies in Pinocchio, and their motion by its accelerations."""

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

# Converts trees of rigid bodies to Pinocchio, and their states and accelerations.
#
# joint         Pinocchio's coordinates and velocities
# hinge, slide  q - zero, its rate
# ball          quaternion, w last; angular velocity in the frame that it turns
# free          place, quaternion, w last; velocity of the place in that frame, angular velocity
#
# Those of `galvi.Multibody.to_mujoco` have w first, and a free joint's velocity in space.

OLDEST_PINOCCHIO = 3  # major version; earlier ones leave armatures out of accelerations


def missing() -> str:
    """One sentence saying why Pinocchio cannot be used here; empty when it can."""
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
def compiled(system: Multibody) -> PinocchioTree:
    """The tree in Pinocchio, cached for each system."""
    return PinocchioTree.of(system)


@dataclass(frozen=True, eq=False)
class PinocchioTree:
    """Pinocchio's model of a tree, with springs and damping, which Pinocchio does not model.

    Attributes
    ----------
    order : array, shape (nq,)
        indices of qpos in Pinocchio's order
    zeros : array, shape (nq,)
        values that are subtracted from qpos
    scalars
        of hinges and slides: indices in qpos and in qvel, stiffness, rest
    turning
        of balls and free joints: joint, indices of its first entries of qpos and of qvel
    damping : array, shape (nv,)
        coefficients
    """

    model: Any
    pin_data: Any
    order: Array
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
            carried.append(_added(model, link, *parent))
        armature, damping, zeros = np.zeros(model.nv), np.zeros(model.nv), np.zeros(model.nq)
        order: list[int] = []
        scalars: list[tuple[float, ...]] = []
        turning = []
        for joint, at, dof in joints_of(system):
            armature[dof : dof + joint.dimension] = joint.armature
            damping[dof : dof + joint.dimension] = joint.damping
            if joint.type in SCALAR:
                order, zeros[at] = [*order, at], joint.zero
                scalars.append((at, dof, joint.stiffness, joint.rest))
                continue
            first = at + 3 * (joint.type == "free")
            order += [*range(at, first), first + 1, first + 2, first + 3, first]
            turning.append((joint, at, dof))
        model.armature = armature
        table = np.array(scalars).reshape(-1, 4).T
        split = (table[0].astype(int), table[1].astype(int), table[2], table[3])
        return cls(
            model, model.createData(), np.array(order), zeros, split, tuple(turning), damping
        )

    def accelerations(self, qpos: Array, qvel: Array) -> Array:
        """qvel' (nv,) by the algorithm of articulated bodies, for quaternions of any length."""
        import pinocchio
        from scipy.spatial.transform import Rotation

        coordinates, rates = qpos[self.order] - self.zeros, qvel.copy()
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
                back = Rotation.from_matrix(joint.rest[:3, :3].T @ R).as_rotvec()
                forces[spin] -= joint.stiffness * back
            if free:
                drift = slice(dof, dof + 3)
                pull = forces[drift] - joint.stiffness * (qpos[at : at + 3] - joint.rest[:3, 3])
                rates[drift] = R.T @ qvel[drift]
                # The armature acts on the velocity in space, whose rate has this further term.
                turned = np.cross(qvel[spin], rates[drift])
                forces[drift] = R.T @ pull - joint.armature * turned
                floating.append((R, drift, turned))
        accelerations = np.array(
            pinocchio.aba(self.model, self.pin_data, coordinates, rates, forces)
        )
        for R, drift, turned in floating:
            accelerations[drift] = R @ (accelerations[drift] + turned)
        return accelerations


def _added(model: Any, link: Link, joint: int, placement: Any) -> tuple[int, Any]:
    """The joint that carries the link, and the link's frame in that joint's.

    Parameters
    ----------
    joint, placement
        of its parent
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
    """Setting and steps as in `references.tree_ivp.integrated`."""

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
        """Trees, their springs and damping included."""
        system = problem.system
        return isinstance(system, Multibody) and system.given_force[0] is None

    def run(self, problem: Problem, duration: float, setting: Mapping[str, Any]) -> Trajectory:
        """Adaptive steps; see `Contender`."""
        require(self, problem)
        tree = compiled(problem.system)
        return integrated(self.name, version(), tree.accelerations, problem, duration, setting)


PINOCCHIO_ACCELERATIONS = PinocchioAccelerations()
