"""Forces on a tree of rigid bodies: motors, servos, tendons, compensated weights, a medium."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numba import njit
from numba.extending import is_jitted

from galvi.arrays import Array, read_only
from galvi.input_checks import shown
from galvi.kernels.trees import joint_forces as kernel
from galvi.systems.forces.external_force import BuiltinForce
from galvi.systems.trees.drag import drag_coefficients
from galvi.systems.trees.joint import JointDamping
from galvi.systems.trees.rigid_tree import RigidTree

UNLIMITED = (-math.inf, math.inf)
# Controls, in turn, at which the forces read from a MuJoCo model are compared with MuJoCo's.
TRIAL_CONTROLS = (0.8, -0.6, 0.4)


@dataclass(frozen=True, eq=False)
class Pull:
    """A force along a length l: F = constant - x (k + k_1 x + k_2 x^2) - l' (b + b_1 |l'| + b_2
    l'^2).

    Attributes
    ----------
    name
        for messages
    arms
        (index of a velocity, index of an entry of q or -1, ratio) of each joint: it adds ratio
        times the entry to l, and ratio times the velocity to l'
    points
        (link, None for the world, point (3,), share) of each point of a path: share times the
        distance from the point before is added to l; share is 0 where a branch begins
    offset
        added to l
    spring
        k, k_1, k_2
    slack
        (low, high): x is the length beyond this interval
    damper
        b, b_1, b_2
    limits
        smallest and largest F; beyond them F is NaN
    actuator
        whether an actuator exerts it: F then counts in `JointForces.bounds`, and has no potential
    """

    name: str
    arms: tuple[tuple[int, int, float], ...] = ()
    points: tuple[tuple[int | None, Any, float], ...] = ()
    constant: float = 0.0
    offset: float = 0.0
    spring: tuple[float, float, float] = (0.0, 0.0, 0.0)
    slack: tuple[float, float] = (0.0, 0.0)
    damper: tuple[float, float, float] = (0.0, 0.0, 0.0)
    limits: tuple[float, float] = UNLIMITED
    actuator: bool = False

    def with_coefficients(self, constant: float, spring: float, damper: float) -> Pull:
        """The pull with another constant, k and b, the other coefficients 0; without checks."""
        pull = object.__new__(Pull)
        vars(pull).update(
            vars(self), constant=constant, spring=(spring, 0.0, 0.0), damper=(damper, 0.0, 0.0)
        )
        return pull


@dataclass(frozen=True, eq=False)
class Drive:
    """The force of an actuator with the control u: F = u (g + g_1 l + g_2 l') + b + b_1 l + b_2 l'.

    Attributes
    ----------
    control
        index of u among the controls
    part
        index of the pull that it exerts, or of the push if ``thrust`` is given
    gain
        g, g_1, g_2
    bias
        b, b_1, b_2
    range
        smallest and largest u
    thrust
        (force (3,) and moment (3,) of the push with F = 1, limits to which F is clipped)
    """

    control: int
    part: int
    gain: tuple[float, float, float]
    bias: tuple[float, float, float]
    range: tuple[float, float] = UNLIMITED
    thrust: tuple[Any, Any, tuple[float, float]] | None = None

    def force_coefficients(self, u: float) -> tuple[float, float, float]:
        """F at l = l' = 0, dF/dl and dF/dl'."""
        a, b, c = (u * g + x for g, x in zip(self.gain, self.bias, strict=True))
        return a, b, c


class ForceConstants(NamedTuple):
    """The constants of forces on a tree, for galvi.kernels.trees.joint_forces.

    Attributes
    ----------
    numbers
        the constants of the tree, then those of the forces
    integers
        index -> value of the constants that are counts, indices and flags
    of_masses, of_controls
        indices of the constants that depend on masses, and on controls
    rows
        index of the first constant of each pull, then of each push
    """

    numbers: Array
    integers: dict[int, float]
    of_masses: set[int]
    of_controls: set[int]
    rows: tuple[int, ...]


class ConstantsRow(NamedTuple):
    """The constants of one part of the forces, such as a pull, an arm or a weight.

    Attributes
    ----------
    values
        the constants
    of_structure
        indices in ``values`` of counts, indices and flags
    of_mass, of_control
        indices in ``values`` of constants that depend on a mass, and on a control
    begins
        whether this is the first row of a pull or a push
    """

    values: Array
    of_structure: Iterable[int]
    of_mass: Iterable[int]
    of_control: Iterable[int]
    begins: bool

    @classmethod
    def of(
        cls,
        parts: Iterable[Any],
        of_structure: Iterable[int],
        *,
        of_mass: Iterable[int] = (),
        of_control: Iterable[int] = (),
        begins: bool = False,
    ) -> ConstantsRow:
        """The row whose values are the flattened parts, concatenated."""
        values = np.concatenate([np.ravel(part) for part in parts])
        return cls(values, of_structure, of_mass, of_control, begins)


@dataclass(frozen=True, eq=False)
class JointForces:
    """f(q, v, t) on a tree: the sum of the forces below and of the damping of joints.

    Attributes
    ----------
    pulls
        `Pull` values
    bounds
        (index of a velocity, low, high, name): limits of the sum of actuators' forces along it
    weights
        (link, share): share of the link's weight that is compensated
    pushes
        (link, None for the world, point (3,), force (3,), moment (3,)), constant in the link's
        frame
    wet
        (link, axes (3, 3), medium (2,)) of each body in a medium, as in galvi.systems.trees.drag
    wind
        velocity of the medium (3,) in space
    drives
        `Drive` of each actuator
    controls
        present controls of the actuators, (nu,)
    tree, damping, varied
        `RigidTree`, damping (d,) of its joints, and whether the law has damping that is 0; set by
        `Multibody`
    limited
        whether the force is NaN beyond a limit; False leaves all limits out
    """

    pulls: tuple[Pull, ...] = ()
    bounds: tuple[tuple[int, float, float, str], ...] = ()
    weights: tuple[tuple[int, float], ...] = ()
    pushes: tuple[tuple[int, Any, Any, Any], ...] = ()
    wet: tuple[tuple[int, Any, Any], ...] = ()
    wind: Any = (0.0, 0.0, 0.0)
    drives: tuple[Drive, ...] = ()
    controls: Any = ()
    tree: Any = field(default=None, repr=False, compare=False)
    damping: Any = field(default=(), repr=False, compare=False)
    varied: bool = field(default=False, compare=False)
    limited: bool = True

    def on(
        self, tree_: RigidTree, damping: Array, varied: bool, limited: bool = True
    ) -> JointForces:
        """These forces on a tree, with the damping (d,) of its joints."""
        return replace(
            self, tree=tree_, damping=read_only(np.array(damping)), varied=varied, limited=limited
        )

    def sample_controls(self) -> Array:
        """Controls (nu,): those of `TRIAL_CONTROLS`, clipped to the ranges of the actuators."""
        controls = np.array(self.controls)
        for drive in self.drives:
            size = TRIAL_CONTROLS[drive.control % len(TRIAL_CONTROLS)]
            controls[drive.control] = min(max(size, drive.range[0]), drive.range[1])
        return controls

    def with_controls(self, controls: Array) -> JointForces:
        """The forces with other controls (nu,); ValueError for one that is out of its range."""
        pulls, pushes = list(self.pulls), list(self.pushes)
        for drive in self.drives:
            u, (low, high) = float(controls[drive.control]), drive.range
            if not low <= u <= high:
                raise ValueError(
                    f"ctrl[{drive.control}] must be within its range, from {low:g} to {high:g}; "
                    f"received {u:g}."
                )
            constant, by_length, by_rate = drive.force_coefficients(u)
            if drive.thrust is not None:
                force, moment, limits = drive.thrust
                size = min(max(constant, limits[0]), limits[1])
                link, point, _, _ = pushes[drive.part]
                pushes[drive.part] = link, point, size * force, size * moment
                continue
            pull = pulls[drive.part]
            pulls[drive.part] = pull.with_coefficients(constant, -by_length, -by_rate)
        forces = replace(
            self, pulls=tuple(pulls), pushes=tuple(pushes), controls=read_only(np.array(controls))
        )
        if self.tree is not None and "ctrl" in self.tree.varied:  # the law stays the same
            vars(forces).update(_written=self._rewritten(forces), structure=self.structure)
        return forces

    def _rewritten(self, driven: JointForces) -> ForceConstants:
        """The constants of ``driven``, which differs from these forces in its controls alone."""
        numbers, (*_, rows) = self.numbers.copy(), self._written
        for drive in self.drives:
            if drive.thrust is None:
                at, pull = rows[drive.part], driven.pulls[drive.part]
                numbers[at + kernel.CONSTANT] = pull.constant
                numbers[at + kernel.SPRING] = pull.spring[0]
                numbers[at + kernel.DAMPER] = pull.damper[0]
            else:
                link, _, force, moment = driven.pushes[drive.part]
                at, C = rows[len(self.pulls) + drive.part] + 4, self._frame(link)[2]
                numbers[at : at + 6] = np.concatenate([C @ force, C @ moment])
        return self._written._replace(numbers=read_only(numbers))

    def _frame(self, link: int | None) -> tuple[int, Array, Array]:
        """The entry of `RigidTree.frames` of a link; for None that of the world."""
        return (0, np.zeros(3), np.eye(3)) if link is None else self.tree.frames[link]

    @property
    def has_limits(self) -> bool:
        """Whether a pull, or the sum of actuators' forces on a joint, has limits."""
        return bool(self.bounds) or any(pull.limits != UNLIMITED for pull in self.pulls)

    def __call__(self, q: Array, v: Array, t: float) -> Array:
        out = np.zeros((2, v.size))
        flat = np.array(q, dtype=np.float64).ravel()
        kernel.tree_joint_forces(flat, np.array(v, dtype=np.float64), t, self.numbers.copy(), out)
        return out[1]

    def compiled(self) -> tuple[Callable[..., Any], Array]:
        return kernel.tree_joint_forces, self.numbers.copy()

    def potential(self, q: Array) -> Array:
        """The potential energy (n,) at n configurations (n, ...): that of compensated weights, and
        of the springs and constants of pulls that no actuator exerts."""
        potentials, numbers = np.empty(len(q)), self.numbers.copy()
        flat = np.array(q, dtype=np.float64).reshape(len(q), -1)
        kernel.tree_force_potentials(flat, len(self.damping), numbers, potentials)
        return potentials

    @cached_property
    def without_potential(self) -> JointForces | None:
        """The forces without those of `potential`; None where none remain."""
        pulls = tuple(
            pull if pull.actuator else replace(pull, constant=0.0, spring=(0.0, 0.0, 0.0))
            for pull in self.pulls
            if pull.actuator or any(pull.damper)
        )
        if not (pulls or self.pushes or self.wet or np.any(self.damping)):
            return None
        return replace(self, pulls=pulls, weights=(), drives=())

    @property
    def numbers(self) -> Array:
        """The constants of galvi.kernels.trees.joint_forces."""
        return self._written[0]

    @cached_property
    def structure(self) -> dict[int, float]:
        """Index -> value of the constants of the forces that are written into the compiled law:
        counts, indices, flags and zeros, without the zeros that ``varied`` numbers may change."""
        first, (numbers, structure, of_masses, of_controls, _) = self.first, self._written
        varied_indices = of_masses if "masses" in self.tree.varied else set()
        varied_indices = varied_indices | (of_controls if "ctrl" in self.tree.varied else set())
        structure = dict(structure)
        for k, number in enumerate(numbers[first:].tolist(), first):
            if number == 0.0 and k not in varied_indices:
                structure[k] = 0.0
        if self.varied:
            for k in range(len(self.damping)):
                structure.pop(first + kernel.FORCES_HEAD + k, None)
        return structure

    @property
    def first(self) -> int:
        """Index of the first constant after the tree's."""
        return int(self.tree.numbers.size)

    @cached_property
    def _written(self) -> ForceConstants:
        rows = [
            *self._rows_of_pulls(),
            *self._rows_of_weights(),
            *self._rows_of_pushes(),
            *self._rows_in_a_medium(),
        ]
        wet, bounds = len(self.wet), self.bounds if self.limited else ()
        with_points = any(pull.points for pull in self.pulls)
        head = [
            bool(self.weights or self.pushes or wet or with_points),
            len(self.pulls),
            len(bounds),
            len(self.weights),
            len(self.pushes),
            wet,
            *self.wind,
        ]
        integers = {self.first + k: float(head[k]) for k in range(kernel.WIND)}
        of_masses, of_controls, begins = set[int](), set[int](), list[int]()
        index = self.first + kernel.FORCES_HEAD + len(self.damping)
        for row in rows:
            if row.begins:
                begins.append(index)
            integers.update((index + k, float(row.values[k])) for k in row.of_structure)
            of_masses.update(index + k for k in row.of_mass)
            of_controls.update(index + k for k in row.of_control)
            index += row.values.size
        numbers = [self.tree.numbers, np.array(head, dtype=np.float64), np.asarray(self.damping)]
        numbers += [row.values for row in rows]
        return ForceConstants(
            read_only(np.concatenate(numbers)), integers, of_masses, of_controls, tuple(begins)
        )

    def _rows_of_pulls(self) -> Iterator[ConstantsRow]:
        """The rows of each pull, of its arms and of its points; then those of the bounds."""
        coefficients = kernel.CONSTANT, kernel.SPRING, kernel.DAMPER
        driven = {
            drive.part: [coefficients[k] for k, gain in enumerate(drive.gain) if gain]
            for drive in self.drives
            if drive.thrust is None
        }
        for number, pull in enumerate(self.pulls):
            has_limits = self.limited and pull.limits != UNLIMITED
            counts = [
                len(pull.arms),
                len(pull.points),
                pull.actuator,
                pull.slack[0] < pull.slack[1],
                has_limits,
            ]
            limits = pull.limits if has_limits else (0.0, 0.0)
            numbers = [pull.constant, *pull.slack, *limits, pull.offset, *pull.spring, *pull.damper]
            of_control = driven.get(number, ())
            yield ConstantsRow.of([counts, numbers], range(5), of_control=of_control, begins=True)
            for arm in pull.arms:
                yield ConstantsRow.of([arm], (0, 1))
            for link, point, share in pull.points:
                frame, r, C = self._frame(link)
                yield ConstantsRow.of([[frame], r + C @ point, [share]], (0,))
        for velocity, low, high, _ in self.bounds if self.limited else ():
            yield ConstantsRow.of([[velocity, low, high]], (0,))

    def _rows_of_weights(self) -> Iterator[ConstantsRow]:
        """The rows of compensated weights."""
        for link, share in self.weights:
            (frame, r, C), body = self._frame(link), self.tree.links[link]
            numbers = [[frame, share * body.mass], r + C @ body.centre]
            yield ConstantsRow.of(numbers, (0,), of_mass=(1,))

    def _rows_of_pushes(self) -> Iterator[ConstantsRow]:
        thrust = {drive.part for drive in self.drives if drive.thrust is not None}
        for number, (link, point, force, moment) in enumerate(self.pushes):
            frame, r, C = self._frame(link)
            of_control = range(4, kernel.PUSH) if number in thrust else ()
            numbers = [[frame], r + C @ point, C @ force, C @ moment]
            yield ConstantsRow.of(numbers, (0,), of_control=of_control, begins=True)

    def _rows_in_a_medium(self) -> Iterator[ConstantsRow]:
        for link, axes, medium in self.wet:
            (frame, r, C), body = self._frame(link), self.tree.links[link]
            drag = drag_coefficients(body, axes, medium)
            numbers = [[frame], r + C @ body.centre, C @ axes, drag]
            yield ConstantsRow.of(numbers, (0,), of_mass=range(13, kernel.WET_BODY))

    def beyond(self, q: Array, v: Array) -> str:
        """The first force beyond its limits at a state, as a clause; "" where all are within."""
        for pull in self.pulls:
            if np.any(np.isnan(self._with_only(pulls=(pull,))(q, v, 0.0))):
                return f"the force of {pull.name} is beyond its limits {list(pull.limits)}"
        for bound in self.bounds:
            pulls = tuple(replace(pull, limits=UNLIMITED) for pull in self.pulls)
            if np.any(np.isnan(self._with_only(pulls=pulls, bounds=(bound,))(q, v, 0.0))):
                return f"actuators push {bound[3]} beyond its limits {[*bound[1:3]]}"
        return ""

    def _with_only(self, **parts: Any) -> JointForces:
        return replace(
            self, **{"bounds": (), "weights": (), "pushes": (), "wet": (), "drives": (), **parts}
        )


def with_damping(
    force: Any, timed: bool, tree: RigidTree, damping: Array, varied: bool
) -> tuple[Any, bool]:
    """The sum of a force on a tree and of the damping of its joints, and whether it takes the time.

    Parameters
    ----------
    force
        the force, or None
    timed
        whether the force takes the time
    damping : array, shape (d,)
        coefficients of the joints
    varied
        whether the law also has the terms of coefficients that are 0

    Raises
    ------
    TypeError
        For a built-in force other than `JointForces`, which damping cannot be added to.
    """
    if isinstance(force, JointForces):
        return force.on(tree, damping, varied), True
    if not varied and not np.any(damping):
        return force, timed
    if force is None:
        return JointDamping(damping, varied), True
    if isinstance(force, BuiltinForce):
        raise TypeError(
            f"on joints with damping, force must be a function; received {shown(force)}. "
            f"Write the force as a function, or give the joints no damping."
        )
    damping = np.array(damping)

    def damped_in_time(q, v, t):  # type: ignore[no-untyped-def]
        return force(q, v, t) - damping * v

    def damped(q, v):  # type: ignore[no-untyped-def]
        return force(q, v) - damping * v

    total: Any = damped_in_time if timed else damped
    if is_jitted(force):
        total = njit(total)
    total.undamped = force, timed
    return total, timed


def without_damping(force: Any, timed: bool) -> tuple[Any, bool]:
    """The arguments ``force`` and ``timed`` of the `with_damping` that returned this force; for
    `JointForces`, which hold their damping themselves, the force as it is."""
    if isinstance(force, JointDamping):
        return None, False
    return getattr(force, "undamped", (force, timed))
