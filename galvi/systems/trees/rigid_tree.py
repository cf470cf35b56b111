"""The Lagrangian of a tree of rigid bodies."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from itertools import groupby
from typing import Any

import numpy as np

from galvi import input_checks
from galvi.arrays import Array, read_only
from galvi.groups.group import Group, Rn
from galvi.groups.product import Product
from galvi.kernels.trees import tree
from galvi.systems.trees.joint import Joint, Link

# Relative size below which the distance of a geometric number from 0, 1 or -1 is rounding.
GEOMETRY_ROUNDING = 2.0**-50


@dataclass(frozen=True, eq=False)
class RigidTree:
    """L(q, v) of links, on the product of their joints' groups.

    Attributes
    ----------
    links
        `Link` values, each after its parent
    gravity : array, shape (3,)
        acceleration of gravity
    varied
        names in galvi.systems.multibody.VARIED whose numbers are not written into the compiled law,
        even where they are 0: trees that differ in these alone share one law

    Notes
    -----
    q and v hold the coordinates and velocities of all joints in their order; those of hinges and
    slides that follow each other are one ``Rn``. Formulas: galvi.kernels.trees.tree.
    """

    links: tuple[Link, ...]
    gravity: Any
    varied: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        for k, link in enumerate(self.links):
            if link.parent is not None and link.parent >= k:
                raise ValueError(
                    f"the parent of link {k} must be a link before it; received {link.parent}."
                )
            if link.parent is not None and any(joint.type == "free" for joint in link.joints):
                raise ValueError(
                    f"a free joint must be between a link and the world; link {k} has a free joint "
                    f"and the parent {link.parent}."
                )
        if not self.joints:
            raise ValueError(
                "nothing can move: no link has a joint. Give one a galvi.Joint, such as a hinge."
            )
        object.__setattr__(self, "gravity", input_checks.array("gravity", self.gravity, (3,)))
        self._check_masses()

    def _check_masses(self) -> None:
        """ValueError for a link with a joint without armature, if no mass moves with the link."""
        carried = [link.mass for link in self.links]
        for k in range(len(self.links) - 1, -1, -1):
            link = self.links[k]
            if not carried[k] > 0.0 and not all(joint.armature > 0.0 for joint in link.joints):
                raise ValueError(
                    f"link {link.name or k} has joints, and neither the link nor those that it "
                    f"carries have a mass above 0; received mass {link.mass}. Give it a mass or "
                    f"each of its joints an armature."
                )
            if link.parent is not None:
                carried[link.parent] += carried[k]

    @cached_property
    def joints(self) -> tuple[Joint, ...]:
        """All joints, in the order of their coordinates."""
        return tuple(joint for link in self.links for joint in link.joints)

    @cached_property
    def group(self) -> Group:
        """The configuration space: one group, or a Product."""
        factors: list[Group] = []
        for scalar, joints in groupby(self.joints, lambda joint: joint.number <= tree.SLIDE):
            consecutive = list(joints)
            factors += (
                [Rn(len(consecutive))]
                if scalar
                else [factor for joint in consecutive for factor in joint.groups]
            )
        return factors[0] if len(factors) == 1 else Product(tuple(factors))

    @property
    def numbers(self) -> Array:
        """The constants of galvi.kernels.trees.tree."""
        return self._written[0]

    @property
    def frames(self) -> list[tuple[int, Array, Array]]:
        """For each link: the index of the frame of galvi.kernels.trees.tree that it is fixed to,
        the place (3,) and the attitude (3, 3) of the link in that frame."""
        return self._written[1]

    @cached_property
    def _written(self) -> tuple[Array, list[tuple[int, Array, Array]]]:
        rows, carried = (
            np.zeros((len(self.joints), tree.JOINT)),
            np.zeros((len(self.joints) + 1, 10)),
        )
        frames: list[tuple[int, Array, Array]] = []
        node, dof, entry = 0, 0, 0
        for link in self.links:
            frame_index, r, C = (
                (0, np.zeros(3), np.eye(3)) if link.parent is None else frames[link.parent]
            )
            r, C = r + C @ link.place, C @ link.attitude
            for joint in link.joints:
                row, joint_kind = rows[node], joint.number
                node += 1
                row[[tree.KIND, tree.UP, tree.DOF, tree.ENTRY]] = (
                    joint_kind,
                    frame_index,
                    dof,
                    entry,
                )
                anchor, frame = joint.anchor, joint.frame
                row[tree.TURN : tree.TURN + 9] = np.eye(3).ravel()
                if joint_kind == tree.FREE:
                    anchor = np.zeros(3)
                else:
                    row[tree.SHIFT : tree.SHIFT + 3] = _without_rounding(r + C @ anchor, r, anchor)
                    row[tree.TURN : tree.TURN + 9] = _without_rounding(C @ frame, 1.0).ravel()
                row[tree.ARMATURE], row[tree.STIFFNESS] = joint.armature, joint.stiffness
                row[tree.ZERO] = joint.zero
                row[tree.REST : tree.REST + 12] = joint.rest_numbers
                frame_index, r, C = node, -frame.T @ anchor, frame.T
                dof, entry = dof + tree.DOFS[joint_kind], entry + tree.ENTRIES[joint_kind]
            frames.append((frame_index, r, C))
            carried[frame_index] += _inertia(link, r, C)
        rows[:, tree.MASS : tree.MASS + 10] = carried[1:]
        fixed = carried[0, 1:4]
        numbers = np.concatenate([[len(rows)], self.gravity, fixed, rows.ravel()])
        return read_only(numbers), frames

    @cached_property
    def dimension(self) -> int:
        """Number of velocities."""
        return self.group.dimension

    def __call__(self, q: Array, v: Array, *t: Any) -> float:
        mass, potential = self.mass_and_potential(q)
        return float(0.5 * v @ mass @ v - potential)

    def mass_and_potential(self, q: Array) -> tuple[Array, float]:
        """d2L/dv2 (d, d) and the potential energy at one configuration."""
        mass = np.empty((self.dimension, self.dimension))
        return mass, float(tree.tree_mass(_copied(q).ravel(), _copied(self.numbers), mass))

    def mass(self, q: Array) -> Array:
        """d2L/dv2 (d, d) at one configuration."""
        return self.mass_and_potential(q)[0]

    def forces(self, q: Array, v: Array) -> Array:
        """Bias force: the right-hand side of M v' = c(q, v), (d,)."""
        forces = np.zeros(self.dimension)
        tree.tree_forces(_copied(q).ravel(), _copied(v), _copied(self.numbers), forces)
        return forces

    def left_slopes(self, q: Array, v: Array) -> Array:
        """dL/dv and the left-trivialised dL/dq, (2, d)."""
        out = np.empty((2, self.dimension))
        tree.tree_slopes(_copied(q).ravel(), _copied(v), 0.0, _copied(self.numbers), out)
        return out

    def slopes(self, q: Array, v: Array, *t: Any) -> Array:
        """As `BuiltinLagrangian.slopes`; the Euclidean derivative by a rotation R is R hat(x) / 2,
        with x the left-trivialised one."""
        momentum, left = self.left_slopes(q, v)
        flat, slopes, dof, entry = np.ravel(q), np.zeros(np.size(q)), 0, 0
        for joint in self.joints:
            scalars = {"ball": 0, "free": 3}.get(joint.type, 1)
            slopes[entry : entry + scalars] = left[dof : dof + scalars]
            dof, entry = dof + scalars, entry + scalars
            if joint.number > tree.SLIDE:
                R = flat[entry : entry + 9].reshape(3, 3)
                slopes[entry : entry + 9] = 0.5 * np.cross(R, left[dof : dof + 3]).ravel()
                dof, entry = dof + 3, entry + 9
        return np.concatenate([momentum, slopes])

    def momenta(self, q: Array, v: Array) -> Array:
        """Angular momentum about the origin of space and momentum of all bodies, (n, 6), at n
        states, without the contributions of armatures."""
        return self._at_states(q, v)[3]

    def at_states(self, q: Array, v: Array, t: Array) -> tuple[Array, Array, Array]:
        return self._at_states(q, v)[:3]

    def _at_states(self, q: Array, v: Array) -> tuple[Array, Array, Array, Array]:
        configurations = _copied(q).reshape(len(v), math.prod(q.shape[1:]))
        out = np.empty(len(v)), np.empty(len(v)), np.empty(v.shape), np.empty((len(v), 6))
        tree.tree_states(configurations, _copied(v), _copied(self.numbers), *out)
        return out

    def compiled(self) -> tuple[Callable[..., Any], Array]:
        """As `BuiltinLagrangian.compiled`, with `numbers` for constants."""
        return tree.tree_slopes, _copied(self.numbers)


def _without_rounding(values: Array, *sizes: Any) -> Array:
    """The values; those that differ by rounding alone, relative to the sum of the largest entries
    of ``sizes``, from a whole number are replaced by it."""
    size = sum(float(np.max(np.abs(x))) for x in sizes)
    return np.where(
        np.abs(values - np.round(values)) <= GEOMETRY_ROUNDING * size, np.round(values), values
    )


def _inertia(link: Link, r: Array, C: Array) -> Array:
    """Mass, mass times centre (3,) and the upper triangle of the inertia about the origin (6,) of a
    link, in the frame in which it has the place r and the attitude C; (10,)."""
    m, c = link.mass, r + C @ link.centre
    J = C @ link.inertia @ C.T + m * (c @ c * np.eye(3) - np.outer(c, c))
    J = np.where(np.abs(J) <= GEOMETRY_ROUNDING * np.max(np.abs(J)), 0.0, J)
    h = np.where(np.abs(c) <= GEOMETRY_ROUNDING * np.max(np.abs(c)), 0.0, m * c)
    return np.concatenate([[m], h, J[np.triu_indices(3)]])


def _copied(values: Array) -> Array:
    """A writable copy: numba compiles a function once more for read-only arrays."""
    return np.array(values, dtype=np.float64, order="C")
