"""Steps of a Lagrangian on R^d or on a Lie group in vector instructions."""

from __future__ import annotations

from functools import lru_cache
from typing import Any, cast

import numpy as np

from galvi.arrays import Array, read_only
from galvi.checkpoint import Checkpoint
from galvi.groups.rn import Rn
from galvi.kernels.compile.function_pointers import addresses
from galvi.kernels.lanes.group_law import compiled_advance_group_law
from galvi.kernels.lanes.group_pass import rows_of_group_work
from galvi.kernels.lanes.law import PASS_TYPE, compiled_advance_law
from galvi.kernels.lanes.law_pass import rows_of_work
from galvi.method import Galerkin
from galvi.problem import Problem
from galvi.run.engine import Call
from galvi.run.nystrom_steppers import aligned, collocation_tables
from galvi.run.run_arrays import RunArrays, run_plan
from galvi.symbolic.lane_law import compiled_law, group_law_source
from galvi.systems.builtin_lagrangian import BuiltinLagrangian
from galvi.systems.lagrangian import Lagrangian
from galvi.systems.system import GroupSystem
from galvi.tableau import Tableau


def has_law(problem: Problem) -> bool:
    """Whether the problem's system has a law for lanes."""
    system = problem.system
    return (
        isinstance(system, Lagrangian)
        and isinstance(system.group, Rn)
        and system.slopes is None
        and system.force is None
        and isinstance(system.function, BuiltinLagrangian)
        and bool(system.function.law)
    )


def law_stepper(
    problem: Problem, method: Galerkin, step: float, steps: int, start: Checkpoint, work: RunArrays,
    finest: float,
) -> Call:  # fmt: skip
    """A `Call` of the kernel for laws: does n more steps and returns its code."""
    function = cast(BuiltinLagrangian, cast(Lagrangian, problem.system).function)
    law = addresses((compiled_law(function.law), PASS_TYPE))
    constants = np.array(function.compiled()[1])
    d, s = problem.q0.size, method.stages
    moves, turns, kicks, ahead, series, growth, fit = collocation_tables(method.table, step)
    width = moves.shape[1]
    c = read_only(np.append(method.table.c, np.full(width - s, method.table.c[-1])))
    tables = np.concatenate([moves, turns])
    given = kicks, ahead, series, tables, growth, fit, c
    scratch, spare = aligned(rows_of_work(d), width), aligned(6, max(width, d, s))
    numbers = np.zeros(2 * d + 3)
    kernel = compiled_advance_law()
    plan = run_plan(problem, step, steps, start, work, max(start.tolerance, finest))

    def call(todo: int) -> int:
        return int(kernel(
            law, constants, given, plan, todo, work.progress, scratch, numbers, spare, work.kept,
        ))  # fmt: skip

    return call


def has_group_law(problem: Problem) -> bool:
    """Whether the problem's system has a law for lanes on its group, which has rotations."""
    return getattr(problem.system, "group_law", None) is not None


def group_law_stepper(
    problem: Problem, method: Galerkin, step: float, steps: int, start: Checkpoint, work: RunArrays,
    finest: float,
) -> Call:  # fmt: skip
    """A `Call` of the kernel for laws on groups: does n more steps and returns its code."""
    system: Any = problem.system
    lines, constants = system.group_law
    layout, chart = cast(GroupSystem, system).group.layout, method.chart.number
    law = addresses((compiled_law(group_law_source(lines, layout, chart)), PASS_TYPE))
    moves, turns, kicks, ahead, series, growth, fit = collocation_tables(method.table, step)
    Y = complement(method.table)
    d, s, width, entries = problem.v0.size, method.stages, moves.shape[1], problem.q0.size
    lanes = np.minimum(np.arange(width), s - 1)
    low = np.zeros((Y.shape[0], width - s))
    tables = np.concatenate(
        [moves, turns, Y[:, lanes], np.concatenate([Y * method.table.b, low], axis=1)]
    )
    sums = np.zeros((s, width))
    sums[:, :2] = kicks.T
    given = read_only(sums), ahead, series, tables, growth, fit, read_only(method.table.c[lanes])
    scratch = aligned(rows_of_group_work(d), width)
    spare = aligned(14, max(width, s, *work.state.shape))
    numbers = np.zeros(3 * d + 4 + entries)
    numbers[3 * d + 2 : 3 * d + 4] = s, Y.shape[0]
    kernel = compiled_advance_group_law()
    plan = run_plan(problem, step, steps, start, work, max(start.tolerance, finest))

    def call(todo: int) -> int:
        return int(kernel(
            law, layout, chart, constants, given, plan, todo, work.progress, scratch, numbers,
            spare, work.kept,
        ))  # fmt: skip

    return call


@lru_cache(maxsize=32)
def complement(table: Tableau) -> Array:
    """(s - m, s) functions at the stages, orthonormal in the rule's inner product, and orthogonal
    there to the slopes of all curves."""
    root = np.sqrt(table.b)
    whole = np.linalg.qr(root[:, None] * table.slope, mode="complete")[0]
    return read_only(whole[:, table.slope.shape[1] :].T / root)
