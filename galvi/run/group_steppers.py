"""The kernels for steps on a group: a general one, and those for laws in lanes."""

from __future__ import annotations

from typing import cast

import numpy as np
import numpy.typing as npt

from galvi.checkpoint import Checkpoint
from galvi.kernels.compile.interpreted import interpreted
from galvi.kernels.forces.lagrangian_derivatives import Law
from galvi.kernels.nystrom.solve import NEWTON_STREAK
from galvi.kernels.on_group.advance import STREAK, advance_group, compiled_advance_group
from galvi.kernels.on_group.stages import Basis
from galvi.method import Galerkin
from galvi.problem import Problem
from galvi.run.engine import Call
from galvi.run.group_system import group_system
from galvi.run.law_stepper import group_law_stepper, has_group_law, has_law, law_stepper
from galvi.run.nystrom_steppers import kernel_tableau
from galvi.run.run_arrays import RunArrays, run_plan
from galvi.systems.system import GroupSystem

FINEST = 2.0**-55  # half the rounding unit of a rotation matrix; changes are in radians


def general_stepper(
    problem: Problem, method: Galerkin, step: float, steps: int, start: Checkpoint, work: RunArrays
) -> Call:
    """A `Call` of the general kernel: does n more steps and returns its code."""
    system = cast(GroupSystem, group_system(problem, method))
    field = system.lagrangian_kernel()
    unknowns = first_unknowns(method, system.group.dimension)
    kernel = compiled_advance_group() if field.compiled else interpreted(advance_group)
    layout, chart = system.group.layout, method.chart
    law = tuple(Law(
        field.functions, field.kind, field.time_dependent, field.matrix_rows, field.constants,
        field.force_kind, field.force_constants,
    ))  # fmt: skip
    table, tableau = method.table, kernel_tableau(method.table)
    basis = tuple(Basis(
        table.psi, table.slope, table.end, table.b, table.c, unknowns, table.projection,
        tableau.analysis, tableau.extrapolation, tableau.growth,
    ))  # fmt: skip
    plan = run_plan(problem, step, steps, start, work, max(start.tolerance, FINEST))

    def call(todo: int) -> int:
        return int(kernel(
            law, layout, chart.number, chart.farthest, basis, plan, todo, work.progress,
            work.step_angle, work.kept,
        ))  # fmt: skip

    return call


def first_unknowns(method: Galerkin, dimension: int) -> npt.NDArray[np.int64]:
    """(d + 1,) index of the first unknown of each component, which has its degree of unknowns."""
    degrees = getattr(method.space, "degrees", (method.space.dimension - 1,) * dimension)
    return np.concatenate([[0], np.cumsum(degrees)]).astype(np.int64)


def solves_by_iteration(problem: Problem, method: Galerkin) -> bool:
    """Whether a kernel in lanes applies; on groups only these have fixed-point iteration."""
    table = method.table
    if hasattr(method.space, "degrees") or float(np.min(table.b)) <= 0.0:
        return False
    square = table.psi.shape[0] == table.psi.shape[1]
    return has_group_law(problem) or (square and has_law(problem))


def compiled_stepper(
    problem: Problem, method: Galerkin, step: float, steps: int, start: Checkpoint, work: RunArrays
) -> Call:
    """As ``general_stepper``, with a packed kernel where one applies."""
    arguments = (problem, method, step, steps, start, work)
    if not solves_by_iteration(problem, method) or start.solver == "newton":
        return general_stepper(*arguments)
    packed = (group_law_stepper if has_group_law(problem) else law_stepper)(*arguments, FINEST)
    general: list[Call] = []  # created when first needed: compiling it takes long

    def by_newton(todo: int) -> int:
        general[:] = general or [general_stepper(*arguments)]
        return general[0](todo)

    def call(todo: int) -> int:
        if work.solver_state[STREAK]:
            before = work.done
            code = by_newton(min(todo, int(work.solver_state[STREAK])))
            work.solver_state[STREAK] -= work.done - before
            return code
        code = packed(todo)
        if code and start.solver == "fixed_point":
            return code
        if code:
            work.solver_state[STREAK] = NEWTON_STREAK - 1
            code = by_newton(1)
        return code

    return call
