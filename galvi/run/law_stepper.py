"""Steps of a Lagrangian on R^d in vector instructions."""

from __future__ import annotations

from typing import cast

import numpy as np

from galvi.arrays import read_only
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
from galvi.systems.lagrangian import Lagrangian


def has_law(problem: Problem) -> bool:
    """Whether the problem's system has a law for lanes."""
    system = problem.system
    return (
        isinstance(system, Lagrangian)
        and isinstance(system.group, Rn)
        and system.lane_law is not None
    )


def law_stepper(
    problem: Problem, method: Galerkin, step: float, steps: int, start: Checkpoint, work: RunArrays,
    finest: float,
) -> Call:  # fmt: skip
    """A `Call` of the kernel for laws: does n more steps and returns its code."""
    found = cast(Lagrangian, problem.system).lane_law
    assert found is not None
    law, constants = addresses((compiled_law(found[0]), PASS_TYPE)), np.array(found[1])
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
