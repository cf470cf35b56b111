"""Steps of point masses and canonical systems in vector instructions, and the tables of lanes."""

from __future__ import annotations

import math
from functools import cached_property, lru_cache, partial
from typing import Any

import numpy as np

from galvi.arrays import Array, read_only
from galvi.extended_precision import decimals, extended_precision, rounded, scaled
from galvi.kernels.compile.function_pointers import addresses
from galvi.kernels.nystrom.advance import STREAK
from galvi.kernels.nystrom.solve import DIVERGED, FORCES
from galvi.lanes.law import PASS_TYPE, compiled_advance_law
from galvi.lanes.law_pass import rows_of_work
from galvi.lanes.nbody import compiled_advance
from galvi.lanes.vectors import LANES, lanes_for
from galvi.run.request import ROUND_OFF, RunRequest
from galvi.run.run_arrays import FORCES_IN_LANES, RunArrays, run_plan
from galvi.run.stepper import Kernel, MakeKernel
from galvi.run.vector_space import GeneralVectorKernel, kernel_tableau
from galvi.systems.canonical import Canonical
from galvi.systems.nbody import NBody
from galvi.systems.traces import Traces, traces
from galvi.tableau import Tableau
from galvi.tracing.lane_law import PASS, compiled_law, fits, unit_mass_law
from galvi.tracing.laws_of_systems import slopes_of

# What the iteration leaves is not random for one body: 16 runs of a pendulum over 1e6 steps (degree
# 8, h = 0.2) have 15 standard errors of drift with a tolerance of 2^-64, and 0.3 with 2^-68, for
# 3 % more time (tests/galvi/test_canonical_lanes.py).
LANE_TOLERANCE = 2.0**-68


def vector_kernel(request: RunRequest) -> MakeKernel | str:
    """What makes the kernel in lanes of a run on a vector space; else why there is none."""
    system: Any = request.problem.system
    if isinstance(system, Canonical):
        if (
            _lane_force(system, request.problem.q0.size, request.method.stages, traces(system))
            is None
        ):
            why = f" ({system.untraced})" if system.untraced else ""
            return f"its force is not known as a short expression{why}"
        return partial(WithGeneral, CanonicalKernel)
    if not isinstance(system, NBody) or system.masses.size < 2:
        return "there is no force between bodies"
    if not system.acting.conserve:
        return "its forces depend on velocities"
    return partial(WithGeneral, PointMassKernel)


class WithGeneral:
    """Steps in lanes; those whose iteration does not converge there, by the general kernel."""

    def __init__(self, kernel: MakeKernel, request: RunRequest, work: RunArrays) -> None:
        self._in_lanes, self._request, self._work = kernel(request, work), request, work

    @cached_property
    def _general(self) -> Kernel:
        return GeneralVectorKernel(self._request, self._work)

    def advance(self, n: int) -> int:
        """See `galvi.run.stepper.Kernel`."""
        work, code = self._work, DIVERGED
        before = work.counts[FORCES]
        if not work.solver_state[STREAK]:
            code = self._in_lanes.advance(n)
        work.counts[FORCES_IN_LANES] += work.counts[FORCES] - before
        return self._general.advance(1) if code else code


class PointMassKernel:
    """Steps of point masses, by galvi.lanes.nbody."""

    def __init__(self, request: RunRequest, work: RunArrays) -> None:
        problem, table = request.problem, request.method.table
        axes, d = (0,) * problem.q0.shape[-1], problem.q0.size
        self._kernel = compiled_advance(len(axes))
        tables, tableau = packed_tables(table, request.step), tuple(kernel_tableau(table))
        plan, self._progress, self._saved = run_plan(request, work, request.checkpoint.tolerance)
        width = tables[1].shape[1]
        self._scratch, self._spare = aligned((6, d, width), (8, max(d, width)))
        system: Any = problem.system
        acting = system.acting
        self._arguments = (
            axes,
            *_masses(system),
            acting.terms,
            acting.poles,
            tableau,
            tables,
            plan,
        )

    def advance(self, n: int) -> int:
        """See `galvi.run.stepper.Kernel`."""
        arrays = self._progress, self._scratch, self._spare, self._saved
        return int(self._kernel(*self._arguments, n, *arrays))


class CanonicalKernel:
    """Steps of a canonical system with a force law, by galvi.lanes.law in positions alone.

    It owns what the address of the law and the words of its argument point to.
    """

    def __init__(self, request: RunRequest, work: RunArrays) -> None:
        problem, table, tolerance = (
            request.problem,
            request.method.table,
            request.checkpoint.tolerance,
        )
        system: Any = problem.system
        d, s = problem.q0.size, table.c.size
        law = _lane_force(system, d, s, traces(system))
        assert law is not None  # see `vector_kernel`
        self._address, self._function, self._constants, lanes, rows = law
        self._tables = nystrom_tables(table, request.step, lanes)
        padded = self._tables[3].shape[1]
        self._scratch, self._spare = aligned((rows, padded), (6, max(padded, d, s)))
        self._numbers = np.zeros(4 * d + 4)
        self._words = words_of(
            self._scratch, self._tables[3], self._tables[4], self._constants, self._numbers, padded,
            s, 0,
        )  # fmt: skip
        self._kernel = compiled_advance_law()
        finer = LANE_TOLERANCE if tolerance == ROUND_OFF else tolerance
        self._plan, self._progress, self._saved = run_plan(request, work, finer)

    def advance(self, n: int) -> int:
        """See `galvi.run.stepper.Kernel`."""
        return int(self._kernel(
            self._address, self._words.ctypes.data, self._tables, True, self._plan, n,
            self._progress, self._scratch, self._numbers, self._spare, self._saved,
        ))  # fmt: skip


@lru_cache(maxsize=32)
def _lane_force(
    system: Canonical, d: int, s: int, found: Traces
) -> tuple[int, Any, Array, int, int] | None:
    """The law of unit mass or None: its address, the function, which must exist as long, constants,
    the lanes of a vector, and the rows of work.

    found  the system's traces, on which they depend
    """
    inverse_mass, slopes = system.inverse_mass(d), slopes_of(system)
    coupled = inverse_mass.shape[1] > 1
    if slopes is None or not fits(d, coupled):
        return None
    lanes = lanes_for(s)
    law = unit_mass_law(slopes[0], "", d, coupled, 0)
    function = compiled_law(PASS, law, d=d, lanes=lanes, one=s <= lanes, alone=True)
    address = int(addresses((function, PASS_TYPE))[0])
    constants = np.concatenate([inverse_mass.ravel(), slopes[1]])
    return address, function, constants, lanes, rows_of_work(d)


@lru_cache(maxsize=32)
def _masses(system: NBody) -> tuple[Array, Any, Any]:
    """G m, the bodies with a mass and the massless ones, as galvi.lanes.nbody takes it."""
    heavy, light = (np.flatnonzero(kind) for kind in (system.masses > 0.0, system.masses == 0.0))
    for bodies in (heavy, light):
        bodies.setflags(write=False)
    return read_only(system.G * system.masses), heavy, light


@lru_cache(maxsize=32)
def packed_tables(table: Tableau, step: float) -> tuple[Array, ...]:
    """A table, multiplied by the step, in the layout of galvi.lanes.nbody."""
    moves, columns, c = _nystrom_parts(table, step, LANES)
    numbers = (
        np.concatenate(moves),
        table.analysis.T[:, stages_in_lanes(table.c.size)],
        table.growth,
        columns,
        c,
    )
    return tuple(read_only(np.array(number)) for number in numbers)


@lru_cache(maxsize=32)
def nystrom_tables(table: Tableau, step: float, lanes: int) -> tuple[Array, ...]:
    """A table, multiplied by the step, in the layout of galvi.lanes.law for places alone.

    lanes  of a vector
    """
    moves, kicks, c = _nystrom_parts(table, step, lanes)
    stages = stages_in_lanes(table.c.size, lanes)
    P, ahead = stages.size, np.zeros((0, stages.size))
    tables, complement = aligned_copies(np.concatenate([c, in_blocks(moves, P)]), ahead)
    with np.errstate(over="ignore"):
        fit = step * step * table.C
    numbers = (
        kicks, ahead, table.analysis.T[:, stages], table.growth, fit, table.c[stages],
        step * table.velocity_coefficients,
    )  # fmt: skip
    fixed = [read_only(np.array(number)) for number in numbers]
    return *fixed[:3], tables, complement, *fixed[3:]


def _nystrom_parts(table: Tableau, step: float, lanes: int) -> tuple[Array, Array, Array]:
    """h^2 A^T, then the same after extrapolation by 1, ..., l Legendre polynomials, then its low
    part, (l + 2, s, P); columns h b, h^2 beta, their low parts (s, P); c, its low part (2, P)."""
    stages = stages_in_lanes(table.c.size, lanes)
    high = table.c, table.b, table.beta, table.A
    c, b, beta, A = map(np.stack, zip(high, table.low_parts[:4], strict=True))
    moves = scaled(A, step, 2)[:, stages].swapaxes(1, 2)
    with np.errstate(all="ignore"):  # a step whose square overflows is reported by the status
        moves = np.concatenate([moves[:1], _extrapolated(table, moves[0]), moves[1:]])
    columns = np.zeros((table.c.size, stages.size))
    columns[:, :4] = np.stack([*scaled(b, step), *scaled(beta, step, 2)])[[0, 2, 1, 3]].T
    return moves, columns, c[:, stages]


def in_blocks(matrices: Any, rows: int) -> Array:
    """Matrices one after another, each with so many rows, the last ones 0."""
    found = [np.pad(matrix, ((0, rows - len(matrix)), (0, 0))) for matrix in matrices]
    return np.concatenate(found)


def words_of(
    work: Array, tables: Array, complement: Array, constants: Array, numbers: Array, padded: int,
    stages: int, extra: int,
) -> Any:  # fmt: skip
    """The argument of a pass, see galvi.lanes.law_pass; it must exist as long as the arrays.

    extra  rows of the complement, or functions Y of a group's
    """
    return np.array([
        work.ctypes.data, tables.ctypes.data, complement.ctypes.data, constants.ctypes.data,
        numbers.ctypes.data, padded, stages, extra,
    ])  # fmt: skip


@lru_cache(maxsize=32)
def collocation_tables(table: Tableau, step: float, lanes: int = LANES) -> tuple[Array, ...]:
    """h A^T, h B^T and h b with their low parts, and more of galvi.lanes.law.

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
    return np.cumsum(table.analysis[: len(terms), :, None] * terms[:, None, :], axis=0)


@lru_cache(maxsize=32)
def integrals_of(table: Tableau) -> tuple[Array, Array]:
    """The integrals of slopes, A, and of their dual, B, each with its low part: (2, s, s)."""
    with extended_precision():
        b = decimals(table.b) + decimals(table.low_parts[1])
        A = decimals(table.integral) + decimals(table.low_parts[4])
        return with_low_part(A), with_low_part(b - (A.T * b) / b[:, None])


def stages_in_lanes(s: int, lanes: int = LANES) -> Any:
    """The stage in each lane, (P,), for vectors of ``lanes``; the last stage is repeated."""
    return np.minimum(np.arange(-(-s // lanes) * lanes), s - 1)


def with_low_part(exact: Any) -> Array:
    """The nearest float64 numbers and their rounding errors."""
    kept = rounded(exact)
    return np.stack([kept, rounded(exact - decimals(kept))])


def aligned(*shapes: tuple[int, ...]) -> list[Array]:
    """Zeros, the first entry at the start of a cache line, and so for whole lines after it."""
    room = np.zeros(sum(map(math.prod, shapes)) + LANES)
    place, found = (-room.ctypes.data // 8) % LANES, []
    for shape in shapes:
        end = place + math.prod(shape)
        found.append(room[place:end].reshape(shape))
        place = end
    return found


def aligned_copies(*given: Array) -> list[Array]:
    """Copies that start at cache lines."""
    copies = aligned(*(array.shape for array in given))
    for copy, array in zip(copies, given, strict=True):
        copy[:] = array
    return copies
