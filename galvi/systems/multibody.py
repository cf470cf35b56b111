"""Trees of rigid bodies on joints."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any, ClassVar, cast

import numpy as np

from galvi import input_checks
from galvi.arrays import Array
from galvi.charts.chart import place
from galvi.groups.group import Group
from galvi.input_checks import shown
from galvi.systems.forces.external_force import check_force, force_at
from galvi.systems.lagrangian import CHART, Lagrangian
from galvi.systems.trees import mujoco_states
from galvi.systems.trees.joint import JointDamping, Link
from galvi.systems.trees.joint_forces import (
    Drive,
    JointForces,
    Pull,
    with_damping,
    without_damping,
)
from galvi.systems.trees.rigid_tree import RigidTree
from galvi.systems.user_functions import Function

OF_JOINTS = ("damping", "stiffness", "armature")
LIMIT_STATES = 9  # states of a step at which limits of actuators are checked
CONTROLS = "ctrl"
VARIED = ("gravity", "masses", *OF_JOINTS, CONTROLS)


@dataclass(frozen=True, eq=False)
class Multibody(Lagrangian):
    """Trees of rigid bodies on hinges, slides, ball and free joints, as a Lagrangian.

    Parameters
    ----------
    links
        `Link` values, each after its parent; any number of them on the world
    gravity : array, shape (3,)
        acceleration
    force
        of the user's, besides damping: (q, v), or (q, v, t) with ``timed_force``, -> (d,) torques
        and forces along the velocities. The field has the damping too: ``given_force`` has not

    Raises
    ------
    ValueError
        For trees in which nothing moves, or for links out of order.

    Notes
    -----
    Configurations q are elements of ``group``, the product of the joints' groups in their order:
    angles and lengths, rotation matrices, and of a free joint R^3 x SO(3). Velocities (d,) are
    rates of angles and lengths, angular velocities in the link's frame, and of a free joint that of
    its origin in space, then w: those of MuJoCo. The energy has that of the springs of tendons and
    of weights held up, and not the work of other forces.

    Examples
    --------
    >>> hinge = galvi.Joint("hinge", axis=(0, 1, 0))
    >>> rod = dict(mass=1.0, centre=(0, 0, -0.5), inertia=(1 / 12, 1 / 12, 0))
    >>> upper = galvi.Link((hinge,), **rod)
    >>> lower = galvi.Link((hinge,), **rod, parent=0, place=(0, 0, -1))
    >>> galvi.Multibody((upper, lower)).group.dimension
    2
    """

    stored_with: ClassVar[Any] = (JointDamping, JointForces, Pull, Drive)

    function: Function = field(init=False, repr=False, compare=False)
    group: Group = field(init=False, repr=False, compare=False)
    slopes: Function | None = field(default=None, init=False, repr=False, compare=False)
    explicit_time: bool = field(default=False, init=False, repr=False, compare=False)
    check: bool = field(default=True, init=False, repr=False, compare=False)
    links: Any = ()
    gravity: Any = (0.0, 0.0, -9.81)
    force: Any = field(default=None, kw_only=True)
    timed_force: bool = field(default=False, kw_only=True)

    def __post_init__(self) -> None:
        links = input_checks.several(self.links)
        if not all(isinstance(link, Link) for link in links):
            raise TypeError(f"links must be galvi.Link values; received {shown(self.links)}.")
        tree = RigidTree(links, self.gravity)
        object.__setattr__(self, "links", links)
        object.__setattr__(self, "gravity", tree.gravity)
        object.__setattr__(self, "function", tree)
        object.__setattr__(self, "group", tree.group)
        check_force(self)
        self._damp(tree, varied=False)
        super().__post_init__()

    def __repr__(self) -> str:
        return f"Multibody(links={len(self.links)}, velocities={self.group.dimension})"

    def __reduce__(self) -> tuple[Any, ...]:
        force, timed = self.given_force
        return partial(Multibody, force=force, timed_force=timed), (self.links, self.gravity)

    @property
    def given_force(self) -> tuple[Any, bool]:
        """The force without the damping of joints, and whether it takes the time; (None, False)
        for none."""
        return without_damping(self.force, self.timed_force)

    def _damp(self, tree: RigidTree, varied: bool) -> None:
        """The given force with the damping of the joints, for ``force`` and ``timed_force``."""
        damping = np.concatenate([np.full(joint.dimension, joint.damping) for joint in tree.joints])
        force, timed = with_damping(*self.given_force, tree, damping, varied)
        object.__setattr__(self, "force", force)
        object.__setattr__(self, "timed_force", timed)

    @property
    def working_force(self) -> Any:
        """The force but for those parts whose energy is known; None for none."""
        return self.force.without_potential if isinstance(self.force, JointForces) else self.force

    @property
    def is_damped_alone(self) -> bool:
        """Whether dampers of joints and tendons are all the forces without a potential."""
        force = self.working_force
        if isinstance(force, JointForces):
            return not (force.pushes or force.wet or any(pull.actuator for pull in force.pulls))
        return isinstance(force, JointDamping)

    def potential_of_forces(self, q: Array) -> Array:
        """The energy (...) of the others, such as springs of tendons, at configurations q."""
        lead = q.shape[: q.ndim - len(self.group.shape)]
        if not isinstance(self.force, JointForces):
            return np.zeros(lead)
        return self.force.potential(q.reshape(-1, *self.group.shape)).reshape(lead)

    def energy(self, q: Array, v: Array, t: Any) -> Array:
        """v . dL/dv - L, and the energy of those forces that have one, (...)."""
        return super().energy(q, v, t) + self.potential_of_forces(q)

    @property
    def tree(self) -> RigidTree:
        """The Lagrangian as a function, with its exact mass and slopes."""
        return cast(RigidTree, self.function)

    def with_numbers(self, **numbers: Any) -> Multibody:
        """The same trees with other numbers, by the names of VARIED: gravity (3,), masses (links,),
        damping, stiffness and armature (joints,), in the order of ``tree.joints``, and ctrl (nu,),
        constant controls of a MuJoCo model's actuators, within their ranges.

        Inertias about the centres of mass stay as they are.

        Raises
        ------
        ValueError
            For another name or shape, and as `Link` and `Joint` do.
        """
        new_numbers = {name: input_checks.array(name, values) for name, values in numbers.items()}
        for name, values in new_numbers.items():
            shape = self.shape_of(name)
            if values.shape != shape:
                raise ValueError(f"{name} must have shape {shape}; received shape {values.shape}.")
        force, timed = self.given_force
        if CONTROLS in new_numbers:
            force = force.with_controls(new_numbers[CONTROLS])
            if len(new_numbers) == 1 and CONTROLS in self.tree.varied:
                return self._with_force(force)
        joints, links = iter(range(len(self.tree.joints))), []
        for k, link in enumerate(self.links):
            link_joints = [
                replace(
                    joint,
                    **{
                        name: float(new_numbers[name][j])
                        for name in OF_JOINTS
                        if name in new_numbers
                    },
                )
                for joint, j in zip(link.joints, joints, strict=False)
            ]
            mass = float(new_numbers["masses"][k]) if "masses" in new_numbers else link.mass
            links.append(replace(link, joints=link_joints, mass=mass))
        multibody = Multibody(
            links, new_numbers.get("gravity", self.gravity), force=force, timed_force=timed
        )
        varied = tuple(name for name in VARIED if name in {*self.tree.varied, *new_numbers})
        object.__setattr__(multibody, "function", replace(multibody.tree, varied=varied))
        multibody._damp(
            multibody.tree, "damping" in new_numbers or getattr(self.force, "varied", False)
        )
        return multibody

    def _with_force(self, force: JointForces) -> Multibody:
        """The same trees with other controls, without repeating the checks."""
        multibody = object.__new__(Multibody)
        vars(multibody).update(vars(self), force=force)
        return multibody

    @property
    def varied_names(self) -> tuple[str, ...]:
        """Those of VARIED that it has."""
        force, _ = self.given_force
        driven = isinstance(force, JointForces) and bool(force.drives)
        return tuple(name for name in VARIED if driven or name != CONTROLS)

    def shape_of(self, name: str) -> tuple[int, ...]:
        """That of one of VARIED; ValueError for another name, and for ctrl without actuators."""
        if name == CONTROLS and CONTROLS not in self.varied_names:
            raise ValueError(
                "ctrl is of the actuators of a MuJoCo model; received it for a tree without. Read "
                "a model that has them, with galvi.from_mujoco."
            )
        if name not in VARIED:
            names = ", ".join(self.varied_names)
            raise ValueError(f"name must be one of {names}; received {shown(name)}.")
        sizes = {"gravity": 3, "masses": len(self.links)}
        if name == CONTROLS:
            return (len(self.given_force[0].controls),)
        return (sizes.get(name, len(self.tree.joints)),)

    def check_functions(self, q: Array, v: Array, t: float) -> None:
        """As that of a Lagrangian; ValueError also where an actuator starts beyond a limit."""
        if beyond := self.beyond_limits(q, v, 0.0):
            raise ValueError(f"{beyond} at the start. Start elsewhere, or choose other controls.")
        super().check_functions(q, v, t)

    def beyond_limits(self, q: Array, v: Array, step: float) -> str:
        """Which actuator is beyond its limits at a state or, approximately, in a step from there;
        "" for none."""
        force, _ = self.given_force
        if not isinstance(force, JointForces) or not force.has_limits:
            return ""
        free = force.on(self.tree, force.damping, force.varied, limited=False)
        pull = self.tree.forces(q, v) + free(q, v, 0.0)
        rate = np.linalg.solve(self.tree.mass(q), pull)
        for elapsed in step * np.linspace(0.0, 1.0, LIMIT_STATES if step else 1):
            configuration = place(CHART, self.group, q, elapsed * (v + 0.5 * elapsed * rate))
            if beyond := force.beyond(configuration, v + elapsed * rate):
                return beyond
        return ""

    def acceleration(self, q: Any, v: Any, t: float = 0.0) -> Array:
        """v' at one state, (d,), by Newton's and Euler's equations apart from L; NaN beyond the
        limits of actuators."""
        q, v = (np.array(x, dtype=np.float64) for x in (q, v))
        total = self.tree.forces(q, v) + force_at(self, q, v, t)
        return np.asarray(np.linalg.solve(self.tree.mass(q), total), dtype=np.float64)

    def from_mujoco(self, qpos: Any, qvel: Any) -> tuple[Array, Array]:
        """(q, v) of MuJoCo's states (..., nq) and (..., nv), of a model with these joints.

        Raises
        ------
        ValueError
            For wrong shapes and for a quaternion of no length.
        """
        return mujoco_states.from_mujoco(self.tree.joints, self.group, qpos, qvel)

    def to_mujoco(self, q: Any, v: Any) -> tuple[Array, Array]:
        """(qpos, qvel) of states, NaN where they are not finite; ValueError for wrong shapes."""
        return mujoco_states.to_mujoco(self.tree.joints, self.group, q, v)
