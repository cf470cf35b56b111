"""The law of a system for lanes of members, as text and numbers that can travel."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from galvi.arrays import Array
from galvi.fast.lanes.law_pass import filled
from galvi.fast.law_stepper import component_degrees, group_law, lane_law
from galvi.fast.laws import force_of, slopes_of
from galvi.fast.symbolic.lane_law import built_in, function_of, unit_mass_law
from galvi.groups.matrix_groups import Rn
from galvi.method import Galerkin
from galvi.systems.canonical import Canonical
from galvi.systems.nbody import NBody

WIDEST = 32  # coordinates up to which a law is written out for members


@dataclass(frozen=True)
class Law:
    """A law that many members run by; equal for equal laws.

    lines        that define ``law``, as in galvi.fast.symbolic.lane_law
    dimension    d of the velocities
    entries      of a configuration
    in_velocity  whether the law's momenta are velocities, and the system's M v
    of_places    whether its forces know no velocities, besides
    layout       of a group with rotations, as galvi.kernels.lie.product takes it; () on R^d
    """

    lines: str
    dimension: int
    entries: int
    in_velocity: bool = False
    of_places: bool = False
    layout: tuple[tuple[int, ...], ...] = ()

    def momenta(self, q: Array, v: Array, t: float, constants: Array) -> Array:
        """The law's dL/dv (n, d) at n states, q (n, r), v (n, d), constants (1 or n, c)."""
        found = function_of(self.lines)(q.T, v.T, t, constants.T)[1]
        result = np.empty(v.shape)
        for i, row in enumerate(found):
            result[:, i] = row
        return result


@dataclass(frozen=True, eq=False)
class LawNumbers:
    """Parameters of each member; one row where they share them.

    constants  (1 or n, c)
    mass       (1 or n, d) or (1 or n, d, d): M of a law in velocities; else None
    """

    constants: Array
    mass: Array | None = None

    def rows(self, members: slice) -> LawNumbers:
        """Those of some members."""
        mass = None if self.mass is None else _rows(self.mass, members)
        return LawNumbers(_rows(self.constants, members), mass)

    def momenta(self, momenta: Array) -> Array:
        """The conjugate momenta (n, d) from those of the law."""
        if self.mass is None:
            return momenta
        if self.mass.ndim == 3:
            return np.einsum(
                "nij,nj->ni",
                np.broadcast_to(self.mass, (len(momenta), *self.mass.shape[1:])),
                momenta,
            )
        return self.mass * momenta


def _rows(array: Array, members: slice) -> Array:
    return array if len(array) == 1 else array[members]


@lru_cache(maxsize=64)
def _coupled(law: Law) -> list[tuple[int, int]]:
    return filled(function_of(law.lines), law.dimension)


def law_of(system: Any, d: int) -> tuple[Law, LawNumbers] | None:
    """The law of a system whose velocities have d numbers, or None if lanes cannot run it."""
    if d > WIDEST:
        return None
    if isinstance(system, NBody):
        if system.forces:
            return None
        bodies = system.masses.size
        lines = built_in("point_masses", bodies, d // bodies)
        masses = np.repeat(system.masses, d // bodies)
        numbers = LawNumbers((system.G * system.masses)[None], masses[None])
        return Law(lines, d, d, in_velocity=True, of_places=True), numbers
    if isinstance(system, Canonical):
        return _of_canonical(system, d)
    on_group = group_law(system)
    if on_group is not None and on_group.calls is None:
        layout = tuple(tuple(map(int, row)) for row in system.group.layout)
        law = Law(on_group.lines, d, math.prod(system.group.shape), layout=layout)
        return law, LawNumbers(on_group.constants[None])
    found = lane_law(system, d)
    if found is None or found.calls is not None:
        return None
    return Law(found.lines, d, d), LawNumbers(found.constants[None])


def _of_canonical(system: Canonical, d: int) -> tuple[Law, LawNumbers] | None:
    found = slopes_of(system)
    if found is None:
        return None
    slopes, constants = found
    force: tuple[str, Array] | None = ("", np.zeros(0))
    if system.force is not None:
        force = force_of(system)
    if force is None:
        return None
    inverse = system.inverse_mass(d)
    coupled = inverse.shape[1] > 1
    lines = unit_mass_law(slopes, force[0], d, coupled, inverse.size + constants.size)
    mass = system.mass if coupled else np.broadcast_to(system.mass, (d,))
    all_constants = np.concatenate([inverse.ravel(), constants, force[1]])
    numbers = LawNumbers(all_constants[None], np.array(mass)[None])
    return Law(lines, d, d, in_velocity=True, of_places=system.force is None), numbers


def runs_in_lanes(law: Law, numbers: LawNumbers, method: Galerkin) -> bool:
    """Whether lanes iterate the law with a method: its weights are positive, it has no frame, and
    components that a mass couples have the same degree."""
    if method.in_frame or float(np.min(method.table.b)) <= 0.0:
        return False
    degrees = component_degrees(method)
    if degrees is None:
        return True
    if law.layout or len(degrees) != law.dimension:
        return False
    if numbers.mass is not None and numbers.mass.ndim == 3:
        return len(set(degrees)) == 1
    return all(degrees[i] == degrees[j] for i, j in _coupled(law))


def iterates_places(law: Law, method: Galerkin) -> bool:
    """Whether places alone are iterated."""
    return law.of_places and component_degrees(method) is None


def on_space(system: Any) -> bool:
    """Whether the configurations of a system are those of R^d."""
    return isinstance(getattr(system, "group", Rn(1)), Rn)
