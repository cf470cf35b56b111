"""The two ways to advance a run on a group: the general kernel, and the packed one for bodies."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, cast

import numpy as np
import numpy.typing as npt

from galvi.checkpoint import Checkpoint
from galvi.kernels.compile.interpreted import interpreted
from galvi.kernels.forces.lagrangian_derivatives import Law
from galvi.kernels.lanes import body as packed_body
from galvi.kernels.nystrom.solve import DIVERGED, NEWTON_STREAK
from galvi.kernels.on_group.advance import STREAK, advance_group, compiled_advance_group
from galvi.kernels.on_group.stages import Basis
from galvi.kernels.run_record import Kept, Plan, Progress
from galvi.method import Galerkin
from galvi.problem import Problem
from galvi.run.engines import aligned, collocation_tables, kernel_tableau
from galvi.run.group_system import group_system
from galvi.run.run_arrays_on_group import GroupWorkspace
from galvi.systems.potentials.uniform_gravity import UniformGravity
from galvi.systems.rigid_body import RigidBody
from galvi.systems.system import GroupSystem

FINEST = 2.0**-55  # half of the rounding of a rotation; changes are relative to a radian


def general_on_group(
    problem: Problem, method: Galerkin, step: float, steps: int, every: int, start: Checkpoint,
    work: GroupWorkspace,
) -> Callable[[int], int]:  # fmt: skip
    """A function that does so many more steps in the general kernel and returns its code."""
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
        table.psi, table.slope, table.end, table.b, table.c, unknowns, table.fit, tableau.analysis,
        tableau.ahead, tableau.growth,
    ))  # fmt: skip
    plan = _plan(problem, step, start, steps, every)
    progress, kept = _arrays(work)

    def call(todo: int) -> int:
        return int(kernel(
            law, layout, chart.number, chart.farthest, basis, plan, todo, progress, work.turned,
            kept,
        ))  # fmt: skip

    return call


def _plan(
    problem: Problem, step: float, start: Checkpoint, steps: int, every: int
) -> tuple[Any, ...]:
    tolerance = max(start.tolerance, FINEST)
    return tuple(Plan(float(problem.t0), step, tolerance, start.first, steps, every))


def _arrays(work: GroupWorkspace) -> tuple[tuple[Any, ...], tuple[Any, ...]]:
    return (
        tuple(Progress(work.state, work.stages, work.memo, work.counts)),
        tuple(Kept(work.saved_g, work.saved_mu, work.bases, work.coefficients)),
    )


def first_unknowns(method: Galerkin, dimension: int) -> npt.NDArray[np.int64]:
    """(d + 1,) where those of each component start: as many as its basis functions, less one."""
    degrees = getattr(method.space, "degrees", (method.space.dimension - 1,) * dimension)
    return np.concatenate([[0], np.cumsum(degrees)]).astype(np.int64)


def by_fixed_point(problem: Problem, method: Galerkin) -> bool:
    """Whether the packed kernel serves, the only one on groups with fixed-point iteration."""
    system, table = problem.system, method.table
    square = table.psi.shape[0] == table.psi.shape[1] and float(np.min(table.b)) > 0.0
    one_space = not hasattr(method.space, "degrees")
    return (
        isinstance(system, RigidBody) and system.gradient is None and system.force is None
        and square and one_space
        and isinstance(system.potential, UniformGravity | None)
    )  # fmt: skip


def fastest_on_group(
    problem: Problem, method: Galerkin, step: float, steps: int, every: int, start: Checkpoint,
    work: GroupWorkspace,
) -> Callable[[int], int]:  # fmt: skip
    """As ``general_on_group``, by way of the packed kernel where that one serves."""
    arguments = (problem, method, step, steps, every, start, work)
    if not by_fixed_point(problem, method) or start.solver == "newton":
        return general_on_group(*arguments)
    system, table = cast(RigidBody, problem.system), method.table
    weight = cast(UniformGravity | None, system.potential)
    chart, J = method.chart.number, system.inertia
    force = np.zeros(6) if weight is None else weight.numbers
    body = np.concatenate([np.linalg.inv(J).ravel(), J.ravel(), force[3:], np.zeros(12)])
    kernel = packed_body.compiled_advance_body(chart, int(weight is not None))
    charts, weights = (0,) * (1 + chart), (0,) * (1 + int(weight is not None))
    tables = collocation_tables(table, step)
    width, weights_in_space = tables[0].shape[1], force[:3].copy()
    scratch, spare = aligned(36, width), aligned(6, width)
    plan = _plan(problem, step, start, steps, every)
    progress, kept = _arrays(work)
    general = general_on_group(*arguments)

    def call(todo: int) -> int:
        if work.memo[STREAK]:
            before = work.done
            code = general(min(todo, int(work.memo[STREAK])))
            work.memo[STREAK] -= work.done - before
            return code
        code = int(kernel(
            charts, weights, tables, body, weights_in_space, plan, todo, progress, scratch, spare,
            kept,
        ))  # fmt: skip
        if code and start.solver == "fixed_point":
            return DIVERGED  # its forces are finite
        if code:
            work.memo[STREAK] = NEWTON_STREAK - 1
            code = general(1)
        return code

    return call
