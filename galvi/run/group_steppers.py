"""The kernels for steps on a group: a general one, and those for laws."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np
import numpy.typing as npt

from galvi.kernels.compile.interpreted import interpreted
from galvi.kernels.forces.lagrangian_derivatives import Law
from galvi.kernels.nystrom.solve import DIVERGED, NEWTON_STREAK
from galvi.kernels.on_group.advance import STREAK, advance_group, compiled_advance_group
from galvi.kernels.on_group.stages import Basis
from galvi.method import Galerkin
from galvi.problem import Problem
from galvi.run.coupling import coupled_layout
from galvi.run.group_system import group_system
from galvi.run.law_stepper import group_law_stepper, has_group_law, has_law, law_stepper
from galvi.run.nystrom_steppers import kernel_tableau
from galvi.run.plan import Call, Run
from galvi.run.run_arrays import LEFT_OVER, RunArrays, run_plan
from galvi.symbolic.tracing import Traces, traces
from galvi.systems.system import LagrangianKernel
from galvi.tableau import Tableau

FINEST = 2.0**-55  # half the rounding unit of a rotation matrix; changes are in radians
# In lanes less is left: a free body (degree 6, 6 points, h = 0.2) loses 3.6e-18 of its energy a
# step with 2^-55, and 1.2e-18 with 2^-58.
FINEST_IN_LANES = 2.0**-58
# On R^d less is left for the energy to drift by: an elastic pendulum (degree 8, 9 points, h = 0.03)
# loses 5e-19 of it a step with 2^-55, and at most 2e-20 with 2^-60.
FINEST_ON_RN = 2.0**-60


def general_stepper(run: Run, work: RunArrays) -> Call:
    """A `Call` of the general kernel: does n more steps and returns its code."""
    problem, method = run.problem, run.method
    system: Any = group_system(problem, method)
    field, law = _law(system, traces(system))
    kernel = compiled_advance_group() if field.compiled else interpreted(advance_group)
    layout, chart = coupled_layout(system, problem), method.group_chart
    basis = _basis(method.table, degrees_of(method, system.group.dimension))
    plan, progress, kept = run_plan(run, work, max(run.start.tolerance, FINEST))

    def call(todo: int) -> int:
        return int(kernel(
            law, layout, chart.number, chart.farthest, basis, plan, todo, progress,
            work.step_angle, kept,
        ))  # fmt: skip

    return call


@lru_cache(maxsize=32)
def _law(system: Any, found: Traces) -> tuple[LagrangianKernel, tuple[Any, ...]]:
    """The Lagrangian of a system, which owns the functions, and as the kernel takes it.

    found  the system's traces, on which it depends
    """
    field = system.lagrangian_kernel()
    return field, tuple(Law(
        field.functions, field.kind, field.time_dependent, field.matrix_rows, field.constants,
        field.force_kind, field.force_constants,
    ))  # fmt: skip


@lru_cache(maxsize=32)
def _basis(table: Tableau, degrees: tuple[int, ...]) -> tuple[Any, ...]:
    tableau = kernel_tableau(table)
    return tuple(Basis(
        table.psi, table.slope, table.end, table.b, table.c, first_unknowns(degrees),
        table.projection, tableau.analysis, tableau.extrapolation, tableau.growth,
    ))  # fmt: skip


def degrees_of(method: Galerkin, dimension: int) -> tuple[int, ...]:
    """(d,) number of unknowns of each component."""
    return tuple(getattr(method.space, "degrees", (method.space.dimension - 1,) * dimension))


def first_unknowns(degrees: tuple[int, ...]) -> npt.NDArray[np.int64]:
    """(d + 1,) index of the first unknown of each component."""
    return np.concatenate([[0], np.cumsum(degrees)]).astype(np.int64)


def solves_by_iteration(problem: Problem, method: Galerkin) -> bool:
    """Whether a kernel in lanes applies; on groups only these have fixed-point iteration."""
    one_space = not hasattr(method.space, "degrees")
    on_group = one_space and float(np.min(method.table.b)) > 0.0 and has_group_law(problem)
    return on_group or has_law(problem, method)


def stepper_after_failure(run: Run, work: RunArrays) -> Call:
    """As ``general_stepper``, counting its steps where fixed-point iteration would do them."""
    call = general_stepper(run, work)
    if run.start.solver == "newton" or not solves_by_iteration(run.problem, run.method):
        return call

    def counted(todo: int) -> int:
        before = work.done
        code = call(todo)
        work.counts[LEFT_OVER] += work.done - before
        return code

    return counted


def compiled_stepper(run: Run, work: RunArrays) -> Call:
    """As ``general_stepper``, with a packed kernel where one applies."""
    solver = run.start.solver
    if not solves_by_iteration(run.problem, run.method) or solver == "newton":
        return general_stepper(run, work)
    stepper = law_stepper if has_law(run.problem, run.method) else group_law_stepper
    packed = stepper(run, work, FINEST_ON_RN if stepper is law_stepper else FINEST_IN_LANES)
    general: list[Call] = []  # created when first needed: compiling it takes long

    def by_newton(todo: int) -> int:
        general[:] = general or [stepper_after_failure(run, work)]
        return general[0](todo)

    def call(todo: int) -> int:
        if work.solver_state[STREAK]:
            before = work.done
            code = by_newton(min(todo, int(work.solver_state[STREAK])))
            work.solver_state[STREAK] -= work.done - before
            return code
        try:
            code = packed(todo)
        except Exception:  # of a function called where the iteration strayed, or raised again below
            if solver == "fixed_point":
                raise
            code = DIVERGED
        if code and solver == "fixed_point":
            return code
        if code:
            work.solver_state[STREAK] = NEWTON_STREAK - 1
            code = by_newton(1)
        return code

    return call
