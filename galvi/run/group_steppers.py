"""The kernels for steps on a group: a general one, one for rigid bodies, and those for laws."""

from __future__ import annotations

from functools import lru_cache
from typing import Any, cast

import numpy as np
import numpy.typing as npt

from galvi.arrays import Array, read_only
from galvi.checkpoint import Checkpoint
from galvi.kernels.compile.interpreted import interpreted
from galvi.kernels.forces.lagrangian_derivatives import Law
from galvi.kernels.lanes import body as packed_body
from galvi.kernels.nystrom.solve import DIVERGED, NEWTON_STREAK
from galvi.kernels.on_group.advance import STREAK, advance_group, compiled_advance_group
from galvi.kernels.on_group.stages import Basis
from galvi.method import Galerkin
from galvi.problem import Problem
from galvi.run.engine import Call
from galvi.run.group_system import group_system
from galvi.run.law_stepper import group_law_stepper, has_group_law, has_law, law_stepper
from galvi.run.nystrom_steppers import aligned, collocation_tables, kernel_tableau
from galvi.run.run_arrays import LEFT_TO_NEWTON, RunArrays, run_plan
from galvi.symbolic.traces import Traces, traces
from galvi.systems.lagrangian_kernel import LagrangianKernel
from galvi.systems.potentials.uniform_gravity import UniformGravity
from galvi.systems.rigid_body import RigidBody
from galvi.tableau import Tableau

FINEST = 2.0**-55  # half the rounding unit of a rotation matrix; changes are in radians
# On R^d less is left for the energy to drift by: an elastic pendulum (degree 8, 9 points, h = 0.03)
# loses 5e-19 of it a step with 2^-55, and at most 2e-20 with 2^-60.
FINEST_ON_RN = 2.0**-60


def general_stepper(
    problem: Problem, method: Galerkin, step: float, steps: int, start: Checkpoint, work: RunArrays
) -> Call:
    """A `Call` of the general kernel: does n more steps and returns its code."""
    system: Any = group_system(problem, method)
    field, law = _law(system, traces(system))
    kernel = compiled_advance_group() if field.compiled else interpreted(advance_group)
    layout, chart = system.group.layout, method.group_chart
    basis = _basis(method.table, degrees_of(method, system.group.dimension))
    plan, progress, kept = run_plan(problem, step, steps, start, work, max(start.tolerance, FINEST))

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


def _is_packed_body(problem: Problem, method: Galerkin) -> bool:
    """Whether the kernel for rigid bodies applies, which is faster than that for their laws."""
    s, m = method.table.psi.shape
    system = problem.system
    return s == m and isinstance(system, RigidBody) and system.force is None


def stepper_after_failure(
    problem: Problem, method: Galerkin, step: float, steps: int, start: Checkpoint, work: RunArrays
) -> Call:
    """As ``general_stepper``, counting its steps where fixed-point iteration would do them."""
    call = general_stepper(problem, method, step, steps, start, work)
    if start.solver == "newton" or not solves_by_iteration(problem, method):
        return call

    def counted(todo: int) -> int:
        before = work.done
        code = call(todo)
        work.counts[LEFT_TO_NEWTON] += work.done - before
        return code

    return counted


def compiled_stepper(
    problem: Problem, method: Galerkin, step: float, steps: int, start: Checkpoint, work: RunArrays
) -> Call:
    """As ``general_stepper``, with a packed kernel where one applies."""
    arguments = (problem, method, step, steps, start, work)
    if not solves_by_iteration(problem, method) or start.solver == "newton":
        return general_stepper(*arguments)
    stepper = law_stepper if has_law(problem, method) else group_law_stepper
    if _is_packed_body(problem, method):
        stepper = body_stepper
    packed = stepper(*arguments, FINEST_ON_RN if stepper is law_stepper else FINEST)
    general: list[Call] = []  # created when first needed: compiling it takes long

    def by_newton(todo: int) -> int:
        general[:] = general or [stepper_after_failure(*arguments)]
        return general[0](todo)

    def call(todo: int) -> int:
        if work.solver_state[STREAK]:
            before = work.done
            code = by_newton(min(todo, int(work.solver_state[STREAK])))
            work.solver_state[STREAK] -= work.done - before
            return code
        code = packed(todo)
        if code and start.solver == "fixed_point":
            return DIVERGED if stepper is body_stepper else code  # a body's forces are finite
        if code:
            work.solver_state[STREAK] = NEWTON_STREAK - 1
            code = by_newton(1)
        return code

    return call


def body_stepper(
    problem: Problem, method: Galerkin, step: float, steps: int, start: Checkpoint, work: RunArrays,
    finest: float,
) -> Call:  # fmt: skip
    """A `Call` of the kernel for rigid bodies: does n more steps and returns its code."""
    system, chart = cast(RigidBody, problem.system), method.group_chart.number
    with_weight = int(system.potential is not None)
    numbers, force = _body(system)
    body = numbers.copy()
    kernel = packed_body.compiled_advance_body(chart, with_weight)
    charts, weights = (0,) * (1 + chart), (0,) * (1 + with_weight)
    tables = collocation_tables(method.table, step)
    width, weights_in_space = tables[0].shape[1], force.copy()
    scratch, spare = aligned((36, width), (6, width))
    plan, progress, kept = run_plan(problem, step, steps, start, work, max(start.tolerance, finest))

    def call(todo: int) -> int:
        return int(kernel(
            charts, weights, tables, body, weights_in_space, plan, todo, progress, scratch,
            spare, kept,
        ))  # fmt: skip

    return call


@lru_cache(maxsize=32)
def _body(system: RigidBody) -> tuple[Array, Array]:
    """J^-1, J, the centre of mass and room for 12 numbers, and the weight in space (3,)."""
    weight, J = cast(UniformGravity | None, system.potential), system.inertia
    force = np.zeros(6) if weight is None else weight.numbers
    body = np.concatenate([system.inverse_inertia.ravel(), J.ravel(), force[3:], np.zeros(12)])
    return read_only(body), read_only(force[:3].copy())
