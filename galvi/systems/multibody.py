"""Trees of rigid bodies on joints."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any, cast

import numpy as np

from galvi import input_checks
from galvi.arrays import Array
from galvi.groups.group import Group
from galvi.input_checks import shown
from galvi.systems.forces.external_force import force_at
from galvi.systems.lagrangian import Function, Lagrangian
from galvi.systems.trees import mujoco_states
from galvi.systems.trees.joint import JointDamping, Link
from galvi.systems.trees.rigid_tree import RigidTree

OF_JOINTS = ("damping", "stiffness", "armature")
VARIED = ("gravity", "masses", *OF_JOINTS)


@dataclass(frozen=True, eq=False)
class Multibody(Lagrangian):
    """Trees of rigid bodies on hinges, slides, ball and free joints, as a Lagrangian.

    links    `Link` values, each after its parent; any number of them on the world
    gravity  (3,) acceleration

    Configurations q are elements of ``group``, the product of the joints' groups in their order:
    angles and lengths, rotation matrices, and of a free joint R^3 x SO(3). Velocities (d,) are
    rates of angles and lengths, angular velocities in the link's frame, and of a free joint that of
    its origin in space, then w: those of MuJoCo. Damping is the ``force``. Raises ValueError for
    trees in which nothing moves, or for links out of order.
    """

    function: Function = field(init=False, repr=False, compare=False)
    group: Group = field(init=False, repr=False, compare=False)
    slopes: Function | None = field(default=None, init=False, repr=False, compare=False)
    force: Function | None = field(default=None, init=False, repr=False, compare=False)
    explicit_time: bool = field(default=False, init=False, repr=False, compare=False)
    timed_force: bool = field(default=False, init=False, repr=False, compare=False)
    check: bool = field(default=True, init=False, repr=False, compare=False)
    links: Any = ()
    gravity: Any = (0.0, 0.0, -9.81)

    def __post_init__(self) -> None:
        links = input_checks.several(self.links)
        if not all(isinstance(link, Link) for link in links):
            raise TypeError(f"links must be galvi.Link values; received {shown(self.links)}.")
        tree = RigidTree(links, self.gravity)
        damping = [np.full(joint.dimension, joint.damping) for joint in tree.joints]
        object.__setattr__(self, "links", links)
        object.__setattr__(self, "gravity", tree.gravity)
        object.__setattr__(self, "function", tree)
        object.__setattr__(self, "group", tree.group)
        if np.any(np.concatenate(damping)):
            object.__setattr__(self, "force", JointDamping(np.concatenate(damping)))
            object.__setattr__(self, "timed_force", True)
        super().__post_init__()

    def __repr__(self) -> str:
        return f"Multibody(links={len(self.links)}, velocities={self.group.dimension})"

    def __reduce__(self) -> tuple[Any, ...]:
        return Multibody, (self.links, self.gravity)

    @property
    def tree(self) -> RigidTree:
        """The Lagrangian as a function, with its exact mass and slopes."""
        return cast(RigidTree, self.function)

    def with_numbers(self, **numbers: Any) -> Multibody:
        """The same trees with other numbers, by the names of VARIED: gravity (3,), masses (links,),
        and damping, stiffness and armature (joints,), in the order of ``tree.joints``.

        Inertias about the centres of mass stay as they are. Raises ValueError for another name or
        shape, and as `Link` and `Joint` do.
        """
        given = {name: input_checks.array(name, values) for name, values in numbers.items()}
        for name, values in given.items():
            shape = self.shape_of(name)
            if values.shape != shape:
                raise ValueError(f"{name} must have shape {shape}; received shape {values.shape}.")
        joints, links = iter(range(len(self.tree.joints))), []
        for k, link in enumerate(self.links):
            own = [
                replace(joint, **{
                    name: float(given[name][j]) for name in OF_JOINTS if name in given
                })
                for joint, j in zip(link.joints, joints, strict=False)
            ]  # fmt: skip
            mass = float(given["masses"][k]) if "masses" in given else link.mass
            links.append(replace(link, joints=own, mass=mass))
        made = Multibody(links, given.get("gravity", self.gravity))
        varied = tuple(name for name in VARIED if name in {*self.tree.varied, *given})
        object.__setattr__(made, "function", replace(made.tree, varied=varied))
        damped = isinstance(self.force, JointDamping) and self.force.varied
        if "damping" in given or damped:
            whole = np.concatenate([
                np.full(joint.dimension, joint.damping) for joint in made.tree.joints
            ])  # fmt: skip
            object.__setattr__(made, "force", JointDamping(whole, varied=True))
            object.__setattr__(made, "timed_force", True)
        return made

    def shape_of(self, name: str) -> tuple[int, ...]:
        """That of one of VARIED; ValueError for another name."""
        if name not in VARIED:
            raise ValueError(f"name must be one of {', '.join(VARIED)}; received {shown(name)}.")
        sizes = {"gravity": 3, "masses": len(self.links)}
        return (sizes.get(name, len(self.tree.joints)),)

    def acceleration(self, q: Any, v: Any, t: float = 0.0) -> Array:
        """v' at one state, (d,), by Newton's and Euler's equations apart from L."""
        q, v = (np.array(x, dtype=np.float64) for x in (q, v))
        total = self.tree.forces(q, v) + force_at(self, q, v, t)
        return np.asarray(np.linalg.solve(self.tree.mass(q), total), dtype=np.float64)

    def from_mujoco(self, qpos: Any, qvel: Any) -> tuple[Array, Array]:
        """(q, v) of MuJoCo's states (..., nq) and (..., nv), of a model with these joints.

        Raises ValueError for wrong shapes and for a quaternion of no length.
        """
        return mujoco_states.from_mujoco(self.tree.joints, self.group, qpos, qvel)

    def to_mujoco(self, q: Any, v: Any) -> tuple[Array, Array]:
        """(qpos, qvel) of states, NaN where they are not finite; ValueError for wrong shapes."""
        return mujoco_states.to_mujoco(self.tree.joints, self.group, q, v)
