"""The two kernels for steps on a vector space: a general one, and one for point masses."""

from __future__ import annotations

from functools import lru_cache
from typing import Any, cast

import numpy as np

from galvi.arrays import Array, read_only
from galvi.checkpoint import Checkpoint
from galvi.extended_precision import decimals, extended_precision, rounded
from galvi.kernels.compile.interpreted import interpreted
from galvi.kernels.lanes import nbody as packed
from galvi.kernels.lanes.gravity import LANES
from galvi.kernels.nystrom import advance
from galvi.kernels.nystrom.solve import AUTO, FIXED_POINT, NEWTON, Force
from galvi.kernels.nystrom.step import NystromTableau
from galvi.method import Galerkin
from galvi.problem import Problem
from galvi.run.engine import Call
from galvi.run.run_arrays import RunArrays, run_plan
from galvi.systems.nbody import NBody
from galvi.systems.system import VectorSystem
from galvi.tableau import Tableau

SOLVERS = {"auto": AUTO, "fixed_point": FIXED_POINT, "newton": NEWTON}


def general_stepper(
    problem: Problem, method: Galerkin, step: float, steps: int, start: Checkpoint, work: RunArrays
) -> Call:
    """A `Call` of the general kernel: does n more steps and returns its code."""
    field = cast(VectorSystem, problem.system).force_kernel(problem.q0.shape[-1])
    kernel = advance.compiled_advance() if field.compiled else interpreted(advance.advance)
    force = tuple(Force(
        field.kind, field.functions, field.slope is not None, field.constants, field.inverse_mass,
        field.width,
    ))  # fmt: skip
    tableau, solver = tuple(kernel_tableau(method.table)), SOLVERS[start.solver]
    plan = run_plan(problem, step, steps, start, work, start.tolerance)

    def call(todo: int) -> int:
        return int(kernel(force, tableau, plan, solver, todo, work.progress, work.kept))

    return call


def compiled_stepper(
    problem: Problem, method: Galerkin, step: float, steps: int, start: Checkpoint, work: RunArrays
) -> Call:
    """As ``general_stepper``, with the packed kernel where it applies."""
    arguments = (problem, method, step, steps, start, work)
    system = problem.system
    if not isinstance(system, NBody) or start.solver == "newton" or system.masses.size < 2:
        return general_stepper(*arguments)
    axes = (0,) * problem.q0.shape[1]
    masses = read_only(system.G * system.masses)
    kernel = packed.compiled_advance(len(axes))
    tables, tableau = packed_tables(method.table, step), tuple(kernel_tableau(method.table))
    plan = run_plan(problem, step, steps, start, work, start.tolerance)
    scratch = aligned(6, problem.q0.size, tables[1].shape[1])
    spare = aligned(8, max(problem.q0.size, tables[1].shape[1]))
    slow: list[Call] = []

    def call(todo: int) -> int:
        code = int(kernel(
            axes, masses, tableau, tables, plan, todo, work.progress, scratch, spare, work.kept,
        ))  # fmt: skip
        if code:
            slow[:] = slow or [general_stepper(*arguments)]
            code = slow[0](1)
        return code

    return call


@lru_cache(maxsize=32)
def kernel_tableau(table: Tableau) -> NystromTableau:
    """A table in the layout of galvi.kernels.nystrom.step."""

    def transposed(matrix: Array) -> Array:
        return read_only(matrix.T)

    c_low, b_low, beta_low = table.low_parts[:3]
    beta_low = read_only(beta_low + table.b * c_low)
    return NystromTableau(
        table.c, table.b, table.beta, b_low, beta_low, transposed(table.A),
        transposed(table.psi), table.velocity_coefficients, table.C, transposed(table.C),
        transposed(table.analysis), transposed(table.extrapolation), table.growth,
    )  # fmt: skip


@lru_cache(maxsize=32)
def packed_tables(table: Tableau, step: float) -> tuple[Array, ...]:
    """A table, multiplied by the step, in the layout of galvi.kernels.lanes.nbody."""
    s = table.c.size
    lanes = np.minimum(np.arange(-(-s // LANES) * LANES), s - 1)  # the last stage is repeated
    with extended_precision():
        h = decimals(step)
        c, b, beta, A = (
            decimals(kept) + decimals(lost)
            for kept, lost in zip(
                (table.c, table.b, table.beta, table.A), table.low_parts[:4], strict=True
            )
        )
        moves = _with_low_part((h * h * A)[lanes].T)
        sums = np.stack([*_with_low_part(h * b), *_with_low_part(h * h * beta)], axis=1)
        nodes = _with_low_part(c[lanes])
    ahead = [*moves]
    with np.errstate(all="ignore"):  # a step whose square overflows is reported by the status
        for r in range(1, table.growth.size + 1):
            extrapolated = table.analysis[:r].T @ table.extrapolation[:, :r].T
            ahead += [extrapolated @ kept for kept in moves]
    columns = np.zeros((s, lanes.size))
    columns[:, [0, 2, 1, 3]] = sums
    numbers = (
        np.concatenate(ahead),
        table.analysis.T[:, lanes],
        table.growth,
        columns,
        nodes,
    )
    return tuple(read_only(np.array(number)) for number in numbers)


@lru_cache(maxsize=32)
def collocation_tables(table: Tableau, step: float) -> tuple[Array, ...]:
    """A table, multiplied by the step, in the layout of galvi.kernels.lanes.body."""
    s = table.c.size
    lanes = np.minimum(np.arange(-(-s // LANES) * LANES), s - 1)
    with extended_precision():
        h, b = decimals(step), decimals(table.b) + decimals(table.low_parts[1])
        A = decimals(table.integral) + decimals(table.low_parts[4])
        B = b - (A.T * b) / b[:, None]
        moves, turns = (np.concatenate(_with_low_part((h * M)[lanes].T)) for M in (A, B))
        kicks = _with_low_part(h * b)
    ahead = [
        table.analysis[:r].T @ table.extrapolation[lanes, :r].T
        for r in range(1, table.growth.size + 1)
    ]
    numbers = (
        moves, turns, kicks, np.concatenate(ahead), table.analysis.T[:, lanes], table.growth,
        step * table.projection,
    )  # fmt: skip
    return tuple(read_only(np.array(number)) for number in numbers)


def _with_low_part(exact: Any) -> Array:
    """The nearest float64 numbers and their rounding errors."""
    kept = rounded(exact)
    return np.stack([kept, rounded(exact - decimals(kept))])


def aligned(*shape: int) -> Array:
    """Zeros whose first entry is at the start of a cache line."""
    size = int(np.prod(shape))
    room = np.zeros(size + LANES)
    skipped = (-room.ctypes.data // 8) % LANES
    return room[skipped : skipped + size].reshape(shape)
