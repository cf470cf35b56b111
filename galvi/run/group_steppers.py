"""The general kernel for steps on a group, and what is tried before it."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import Any

import numpy as np
import numpy.typing as npt

from galvi.kernels.compile.function_pointers import interpreted
from galvi.kernels.forces.lagrangian_derivatives import Law
from galvi.kernels.on_group.advance import advance_group, compiled_advance_group
from galvi.kernels.on_group.stages import Basis
from galvi.method import Galerkin
from galvi.problem import Problem
from galvi.run.group_system import coupled_layout, group_system
from galvi.run.nystrom_steppers import kernel_tableau
from galvi.run.plan import Call, Run
from galvi.run.run_arrays import LEFT_OVER, RunArrays, run_plan
from galvi.systems.system import LagrangianKernel
from galvi.systems.traces import Traces, traces
from galvi.tableau import Tableau

FINEST = 2.0**-55  # half the rounding unit of a rotation matrix; changes are in radians
FAST: list[Callable[[Run, RunArrays], Call | None]] = []  # tried first; galvi.fast registers them
ITERATES: list[Callable[[Problem, Galerkin], bool]] = []  # whether one of them does such runs


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
    """Whether fixed-point iteration is available: the general kernel has none."""
    return any(applies(problem, method) for applies in ITERATES)


def stepper(run: Run, work: RunArrays) -> Call:
    """A `Call` of the first kernel that does such a run; the general one does all."""
    if run.start.solver != "newton":
        for fast in FAST:
            call = fast(run, work)
            if call is not None:
                return call
    return general_stepper(run, work)


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
