"""Steps of a Lagrangian on R^d in vector instructions."""

from __future__ import annotations

from functools import lru_cache
from typing import Any, cast

import numpy as np

from galvi.arrays import Array, read_only
from galvi.checkpoint import Checkpoint
from galvi.groups.rn import Rn
from galvi.kernels.compile.function_pointers import addresses
from galvi.kernels.lanes.law import PASS_TYPE, compiled_advance_law
from galvi.kernels.lanes.law_pass import rows_of_work
from galvi.method import Galerkin
from galvi.problem import Problem
from galvi.run.engine import Call
from galvi.run.nystrom_steppers import aligned, collocation_tables
from galvi.run.run_arrays import RunArrays, run_plan
from galvi.symbolic.lane_law import compiled_law
from galvi.systems.builtin_lagrangian import BuiltinLagrangian
from galvi.systems.lagrangian import Lagrangian
from galvi.tableau import Tableau


def has_law(problem: Problem) -> bool:
    """Whether the problem's system has a law for lanes."""
    system = problem.system
    return (
        isinstance(system, Lagrangian)
        and isinstance(system.group, Rn)
        and system.slopes is None
        and system.force is None
        and system.builtin is not None
        and bool(system.builtin.law)
    )


@lru_cache(maxsize=32)
def _law(system: Lagrangian) -> tuple[Any, Array]:
    """The address of the system's law, and its constants."""
    function = cast(BuiltinLagrangian, system.builtin)
    return addresses((compiled_law(function.law), PASS_TYPE)), np.array(function.compiled()[1])


@lru_cache(maxsize=32)
def _tables(table: Tableau, step: float) -> tuple[Array, ...]:
    """A table, multiplied by the step, in the layout of galvi.kernels.lanes.law."""
    moves, turns, kicks, ahead, series, growth, fit = collocation_tables(table, step)
    c = np.append(table.c, np.full(moves.shape[1] - table.c.size, table.c[-1]))
    return kicks, ahead, series, np.concatenate([moves, turns]), growth, fit, read_only(c)


def law_stepper(
    problem: Problem, method: Galerkin, step: float, steps: int, start: Checkpoint, work: RunArrays,
    finest: float,
) -> Call:  # fmt: skip
    """A `Call` of the kernel for laws: does n more steps and returns its code."""
    law, constants = _law(cast(Lagrangian, problem.system))
    d, s = problem.q0.size, method.stages
    given = _tables(method.table, step)
    width = given[3].shape[1]
    scratch, spare = aligned((rows_of_work(d), width), (6, max(width, d, s)))
    numbers = np.zeros(2 * d + 3)
    kernel = compiled_advance_law()
    plan, progress, kept = run_plan(problem, step, steps, start, work, max(start.tolerance, finest))

    def call(todo: int) -> int:
        return int(kernel(
            law, constants, given, plan, todo, progress, scratch, numbers, spare, kept,
        ))  # fmt: skip

    return call
