"""Steps of point masses and canonical systems in vector instructions, and the tables of lanes."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Any

import numpy as np

from galvi.arrays import Array, read_only
from galvi.extended_precision import decimals, extended_precision, rounded, scaled
from galvi.fast.lanes import nbody as packed
from galvi.fast.lanes.canonical import compiled_advance_canonical
from galvi.fast.lanes.vectors import LANES
from galvi.fast.laws import slopes_of
from galvi.fast.symbolic.lane_law import compiled_force, fits, force_source
from galvi.kernels.compile.function_pointers import addresses
from galvi.kernels.forces.force_kinds import BUILT_IN, SIGNATURES
from galvi.kernels.nystrom.solve import FORCES
from galvi.run.nystrom_steppers import ROUND_OFF, general_stepper, kernel_tableau
from galvi.run.plan import Call, Run
from galvi.run.run_arrays import FORCES_IN_LANES, RunArrays, run_plan
from galvi.systems.canonical import Canonical
from galvi.systems.nbody import NBody
from galvi.systems.traces import Traces, traces
from galvi.tableau import Tableau

# What the iteration leaves is not random for one body: 16 runs of a pendulum over 1e6 steps (degree
# 8, h = 0.2) have 15 standard errors of drift with a tolerance of 2^-64, and 0.3 with 2^-68, for
# 3 % more time (tests/galvi/test_canonical_lanes.py).
FINER = 2.0**-68


def lane_stepper(run: Run, work: RunArrays) -> Call | None:
    """A `Call` of a kernel in vector instructions; None where none of these applies."""
    problem, start = run.problem, run.start
    system: Any = problem.system
    point_masses = isinstance(system, NBody) and system.masses.size > 1
    law = None
    if isinstance(system, Canonical):
        law = _lane_force(system, problem.q0.size, traces(system))
    if not (point_masses or law):
        return None
    axes = (0,) * problem.q0.shape[-1]
    kernel = packed.compiled_advance(len(axes)) if point_masses else compiled_advance_canonical()
    force = law[:2] if law else (axes, *_masses(system))
    table = run.method.table
    tables, tableau = packed_tables(table, run.step), tuple(kernel_tableau(table))
    tolerance = FINER if law and start.tolerance == ROUND_OFF else start.tolerance
    plan, progress, kept = run_plan(run, work, tolerance)
    d, width = problem.q0.size, tables[1].shape[1]
    scratch, spare = aligned((6, d, width), (8, max(d, width)))
    slow: list[Call] = []

    def call(todo: int) -> int:
        before = work.counts[FORCES]
        code = int(kernel(
            *force, tableau, tables, plan, todo, progress, scratch, spare, kept,
        ))  # fmt: skip
        work.counts[FORCES_IN_LANES] += work.counts[FORCES] - before
        if code:
            slow[:] = slow or [general_stepper(run, work)]
            code = slow[0](1)
        return code

    return call


@lru_cache(maxsize=32)
def _lane_force(system: Canonical, d: int, found: Traces) -> tuple[Any, Array, Any] | None:
    """The accelerations in lanes or None: their address, constants, and the function, which must
    exist as long.

    found  the system's traces, on which they depend
    """
    inverse_mass, slopes = system.inverse_mass(d), slopes_of(system)
    coupled = inverse_mass.shape[1] > 1
    if slopes is None or not fits(d, coupled):
        return None
    lines, constants = slopes
    function = compiled_force(force_source(lines, d, coupled))
    address = addresses((function, SIGNATURES[BUILT_IN][0]))
    return address, np.concatenate([inverse_mass.ravel(), constants]), function


@lru_cache(maxsize=32)
def _masses(system: NBody) -> tuple[Array, Any, Any]:
    """G m, the bodies with a mass and the massless ones, as galvi.fast.lanes.nbody takes it."""
    heavy, light = (np.flatnonzero(kind) for kind in (system.masses > 0.0, system.masses == 0.0))
    for bodies in (heavy, light):
        bodies.setflags(write=False)
    return read_only(system.G * system.masses), heavy, light


@lru_cache(maxsize=32)
def packed_tables(table: Tableau, step: float) -> tuple[Array, ...]:
    """A table, multiplied by the step, in the layout of galvi.fast.lanes.nbody."""
    s = table.c.size
    lanes = stages_in_lanes(s)
    c, b, beta, A = map(np.stack, zip(_high_parts(table), table.low_parts[:4], strict=True))
    moves = scaled(A, step, 2)[:, lanes].swapaxes(1, 2)
    columns = np.zeros((s, lanes.size))
    columns[:, :4] = np.stack([*scaled(b, step), *scaled(beta, step, 2)])[[0, 2, 1, 3]].T
    with np.errstate(all="ignore"):  # a step whose square overflows is reported by the status
        ahead = np.stack([_extrapolated(table, kept) for kept in moves], axis=1)
    numbers = (
        np.concatenate([moves[None], ahead]).reshape(-1, lanes.size),
        table.analysis.T[:, lanes],
        table.growth,
        columns,
        c[:, lanes],
    )
    return tuple(read_only(np.array(number)) for number in numbers)


@lru_cache(maxsize=32)
def collocation_tables(table: Tableau, step: float, lanes: int = LANES) -> tuple[Array, ...]:
    """h A^T, h B^T and h b with their low parts, and more of galvi.fast.lanes.law.

    lanes  of a vector
    """
    s = table.c.size
    stages = stages_in_lanes(s, lanes)
    moves, turns = (
        np.concatenate(scaled(M, step)[:, stages].swapaxes(1, 2)) for M in integrals_of(table)
    )
    kicks = scaled(np.stack([table.b, table.low_parts[1]]), step)
    ahead = np.concatenate(_extrapolated(table, np.eye(s)[:, stages]))
    numbers = (
        moves, turns, kicks, ahead, table.analysis.T[:, stages], table.growth,
        step * table.projection,
    )  # fmt: skip
    return tuple(read_only(np.array(number)) for number in numbers)


def _extrapolated(table: Tableau, kept: Array) -> Array:
    """A matrix (s, P) after the extrapolation to the next step's stages by 1, ..., l Legendre
    polynomials: (l, s, P)."""
    terms = table.extrapolation.T @ kept
    sums: Array = np.cumsum(table.analysis[: len(terms), :, None] * terms[:, None, :], axis=0)
    return sums


def _high_parts(table: Tableau) -> tuple[Array, ...]:
    """High parts of c, b, beta, A."""
    return table.c, table.b, table.beta, table.A


@lru_cache(maxsize=32)
def integrals_of(table: Tableau) -> tuple[Array, Array]:
    """The integrals of slopes, A, and of their dual, B, each with its low part: (2, s, s)."""
    with extended_precision():
        b = decimals(table.b) + decimals(table.low_parts[1])
        A = decimals(table.integral) + decimals(table.low_parts[4])
        return _with_low_part(A), _with_low_part(b - (A.T * b) / b[:, None])


def stages_in_lanes(s: int, lanes: int = LANES) -> Any:
    """The stage in each lane, (P,), for vectors of ``lanes``; the last stage is repeated."""
    return np.minimum(np.arange(-(-s // lanes) * lanes), s - 1)


def _with_low_part(exact: Any) -> Array:
    """The nearest float64 numbers and their rounding errors."""
    kept = rounded(exact)
    return np.stack([kept, rounded(exact - decimals(kept))])


def aligned(*shapes: tuple[int, ...]) -> list[Array]:
    """Zeros, the first entry at the start of a cache line, and so for whole lines after it."""
    sizes = [math.prod(shape) for shape in shapes]
    room = np.zeros(sum(sizes) + LANES)
    place, found = (-room.ctypes.data // 8) % LANES, []
    for shape, size in zip(shapes, sizes, strict=True):
        found.append(room[place : place + size].reshape(shape))
        place += size
    return found
