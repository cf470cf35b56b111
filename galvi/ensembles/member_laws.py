"""The law of a system for lanes of members, as text and numbers that can be pickled, and the kernel
and tables of a law and a method."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from galvi.arrays import Array
from galvi.environment import FAST
from galvi.kernels.lie import product
from galvi.lanes.collocation import V, law_fields, rows_of_work
from galvi.lanes.group_collocation import VELOCITY, group_fields, rows_of_group_work
from galvi.lanes.layouts import Fields
from galvi.method import Galerkin
from galvi.problem import Problem
from galvi.run.group_system import coupled_layout
from galvi.run.in_lanes.lagrangian import (
    LEAST_TOLERANCE_ON_GROUP,
    LEAST_TOLERANCE_ON_RN,
    component_degrees,
    group_law,
    lane_law,
)
from galvi.run.in_lanes.nystrom import LANE_TOLERANCE
from galvi.run.in_lanes.tables import LawTables, nystrom_tables, tables_on_group, tables_on_space
from galvi.systems.canonical import Canonical
from galvi.systems.nbody import NBody
from galvi.tracing.lane_law import (
    built_in,
    compiled_law,
    coupled_components,
    function_of,
    unit_mass_law,
)
from galvi.tracing.laws_of_systems import force_of, slopes_of

MAX_COORDINATES = 32  # coordinates up to which a law is written out for members


@dataclass(frozen=True)
class Law:
    """The force law of many members.

    Attributes
    ----------
    lines
        the lines that define ``law``, see galvi.tracing.lane_law
    dimension
        number d of entries of a velocity
    entries
        number r of entries of a configuration
    in_velocity
        whether the momenta of the law are velocities v, where those of the system are M v
    of_positions
        whether forces besides do not depend on velocities
    layout
        layout of a group with rotations, see galvi.kernels.lie.product; () on R^d
    """

    lines: str
    dimension: int
    entries: int
    in_velocity: bool = False
    of_positions: bool = False
    layout: tuple[tuple[int, ...], ...] = ()

    def momenta(self, q: Array, v: Array, t: float, constants: Array) -> Array:
        """The law's dL/dv (n, d) at n states, q (n, r), v (n, d), constants (1 or n, c)."""
        with np.errstate(all="ignore"):  # of forces
            columns = function_of(self.lines)(q.T, v.T, t, constants.T)[1]
        momenta = np.empty(v.shape)
        for i, row in enumerate(columns):
            momenta[:, i] = row
        return momenta


@dataclass(frozen=True, eq=False)
class LawNumbers:
    """The numbers of a law for each member, or one row for all members.

    Attributes
    ----------
    constants : array, shape (1 or n, c)
        constants of the law
    mass : array, shape (1 or n, d) or (1 or n, d, d)
        masses M for a law in velocities; else None
    """

    constants: Array
    mass: Array | None = None

    def rows(self, members: slice) -> LawNumbers:
        """The numbers of some members."""
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


def law_of(system: Any, d: int) -> tuple[Law, LawNumbers] | None:
    """The law and numbers of a system whose velocities have d entries; None where lanes cannot run
    it."""
    if not FAST or d > MAX_COORDINATES:
        return None
    if isinstance(system, NBody):
        if system.forces:
            return None
        bodies = system.masses.size
        lines = built_in("point_masses", bodies, d // bodies)
        masses = np.repeat(system.masses, d // bodies)
        numbers = LawNumbers((system.G * system.masses)[None], masses[None])
        return Law(lines, d, d, in_velocity=True, of_positions=True), numbers
    if isinstance(system, Canonical):
        return _canonical_law(system, d)
    on_group = group_law(system)
    if on_group is not None:
        layout = tuple(tuple(map(int, row)) for row in system.group.layout)
        law = Law(on_group[0], d, math.prod(system.group.shape), layout=layout)
        return law, LawNumbers(on_group[1][None])
    law_code = lane_law(system, d)
    if law_code is None:
        return None
    return Law(law_code[0], d, d), LawNumbers(law_code[1][None])


def _canonical_law(system: Canonical, d: int) -> tuple[Law, LawNumbers] | None:
    slopes_and_constants = slopes_of(system)
    if slopes_and_constants is None:
        return None
    slopes, constants = slopes_and_constants
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
    return Law(lines, d, d, in_velocity=True, of_positions=system.force is None), numbers


def law_in_lanes(problem: Problem, method: Galerkin) -> tuple[Law, LawNumbers] | str:
    """The law of a problem's members for lanes, and its numbers; a clause on the reason where there
    is none."""
    if method.in_frame:
        return "methods in a frame run one member at a time"
    law_and_numbers = law_of(problem.system, problem.v0.size)
    if law_and_numbers is None:
        return "the system has no vector code"
    law, numbers = law_and_numbers
    if not can_iterate_in_lanes(law, numbers, method):
        return "vector code does not solve this system with the method's weights or degrees"
    if law.layout:
        layout = coupled_layout(problem.system, problem).tolist()
        law = replace(law, layout=tuple(map(tuple, layout)))
    return law, numbers


def can_iterate_in_lanes(law: Law, numbers: LawNumbers, method: Galerkin) -> bool:
    """Whether lanes can iterate the law with a method: the weights must be positive, and components
    that a mass couples must have the same degree."""
    if float(np.min(method.table.b)) <= 0.0:
        return False
    degrees = component_degrees(method)
    if degrees is None:
        return True
    if law.layout or len(degrees) != law.dimension:
        return False
    if numbers.mass is not None and numbers.mass.ndim == 3:
        return len(set(degrees)) == 1
    return all(degrees[i] == degrees[j] for i, j in coupled_components(law.lines, law.dimension))


def iterates_positions_only(law: Law, method: Galerkin) -> bool:
    """Whether positions alone are iterated."""
    return law.of_positions and component_degrees(method) is None


def least_tolerance(law: Law, method: Galerkin) -> float:
    """The relative change below which lanes do not iterate further."""
    if law.layout:
        return LEAST_TOLERANCE_ON_GROUP
    return LANE_TOLERANCE if iterates_positions_only(law, method) else LEAST_TOLERANCE_ON_RN


# Laws up to these numbers of coordinates and stages are compiled for each number of stages, which
# saves a quarter of the time.
FEW_COORDINATES, FEW_STAGES = 6, 12


@dataclass(frozen=True, eq=False)
class MemberKernel:
    """The kernel of members of a law with a method.

    Attributes
    ----------
    function
        address of the arguments of galvi.lanes.layouts -> None, compiled
    fields
        fields of a record
    rows
        number of rows of the work array
    tables
        tables of the method
    velocities
        first row of the work array for velocities, or accelerations, at the stages
    positions_only
        whether only positions are iterated
    memory
        (q (n, r), p (n, d)) -> further fields of the records at the start
    """

    function: Callable[[int], None]
    fields: Fields
    rows: int
    tables: LawTables
    velocities: int
    positions_only: bool
    memory: Callable[[Array, Array], dict[str, Array]]


def kernel_of(law: Law, method: Galerkin) -> MemberKernel:
    """The kernel of a law with a method."""
    d, table = law.dimension, method.table
    if not law.layout:
        positions_only = iterates_positions_only(law, method)
        tables = (
            nystrom_tables(table)
            if positions_only
            else tables_on_space(table, component_degrees(method))
        )
        stages = method.stages if d <= FEW_COORDINATES and method.stages <= FEW_STAGES else 0
        function = compiled_law("collocation", law.lines, d, positions_only, 0, False, stages)
        return MemberKernel(
            function, law_fields(d), rows_of_work(d), tables, V * d, positions_only, lambda q, p: {}
        )
    layout = np.array(law.layout)

    def memory(q: Array, p: Array) -> dict[str, Array]:
        memories, nu = np.zeros(q.shape), np.empty(p.shape)
        for k, g in enumerate(q):
            product.in_space(layout, g.copy(), p[k].copy(), nu[k])
            product.remember(layout, g.copy(), memories[k])
        return {"memory": memories, "nu": nu}

    chart = method.group_chart.number
    function = compiled_law("group_collocation", law.lines, law.layout, chart)
    tables = tables_on_group(table)
    return MemberKernel(
        function,
        group_fields(d, law.entries),
        rows_of_group_work(d, tables.extra),
        tables,
        VELOCITY * d,
        False,
        memory,
    )
