"""Runs on Lie groups, and on vector spaces with any Lagrangian, force or component degrees."""

from __future__ import annotations

from functools import lru_cache
from typing import Any, cast

import numpy as np

from galvi.arrays import Array
from galvi.charts import CHARTS
from galvi.charts.chart import Exponential, coordinates, tangent, unwrapped
from galvi.checkpoint import Checkpoint
from galvi.curves.curves import Curves, GroupChart, IdentityChart, LocalChart
from galvi.groups.group import Group, Rn
from galvi.kernels.compile.function_pointers import interpreted
from galvi.kernels.constants import LARGEST_SQUARED
from galvi.kernels.forces.lagrangian_derivatives import Law
from galvi.kernels.lie import product
from galvi.kernels.nystrom.advance import GUESS
from galvi.kernels.nystrom.solve import NOT_FINITE, SOLVED
from galvi.kernels.on_group.advance import LEFT_CHART, RATES, advance_group, compiled_advance_group
from galvi.kernels.on_group.stages import Basis
from galvi.method import Galerkin
from galvi.problem import Problem
from galvi.run.gimbal_lock import BALL_JOINT, LOCKED, is_locked_ahead
from galvi.run.group_system import coupled_layout, group_system
from galvi.run.point_masses.encounters import encounter
from galvi.run.request import RunRequest
from galvi.run.run_arrays import SECOND_KERNEL_STEPS, RunArrays, State, fixed, run_plan
from galvi.run.stepper import NEWTON_STEPS_NOTE, Substeps, curves_in
from galvi.run.vector_space import kernel_tableau
from galvi.systems.lagrangian import Lagrangian
from galvi.systems.multibody import Multibody
from galvi.systems.nbody import NBody
from galvi.systems.system import GroupSystem, LagrangianKernel, WithLimits
from galvi.systems.traces import Traces, traces
from galvi.tableau import Tableau

# Of changes of an angle in radians: half the error, 2^-54, of rounding the entries of a rotation
# matrix that are just below 1.
ROTATION_TOLERANCE = 2.0**-55
SUBSTEP_COUNTS = (4, 16, 64)  # tried one after the other
SUBSTEP_TOLERANCE = 1e-8  # of substeps, which only give a guess
PATH_POINTS = 33  # times in a step at which its rotation is tracked
NEAR_LIMIT = 0.8  # share of a chart's limit from which a failed step's message names the chart


class GeneralGroupKernel:
    """Steps by the general kernel, by Newton's method."""

    def __init__(self, request: RunRequest, work: RunArrays) -> None:
        problem, method, self._work = request.problem, request.method, work
        system: Any = group_system(problem, method)
        kernel, law = _law(system, traces(system))
        self._kernel = compiled_advance_group() if kernel.compiled else interpreted(advance_group)
        layout, chart = coupled_layout(system, problem), method.group_chart
        equal_degrees = (method.space.dimension - 1,) * system.group.dimension
        basis = _basis(method.table, tuple(getattr(method.space, "degrees", equal_degrees)))
        tolerance = max(request.checkpoint.tolerance, ROTATION_TOLERANCE)
        plan, self._progress, self._saved = run_plan(request, work, tolerance)
        self._arguments = law, layout, chart.number, chart.farthest, basis, plan

    def advance(self, n: int) -> int:
        """See `galvi.run.stepper.Kernel`."""
        return int(
            self._kernel(*self._arguments, n, self._progress, self._work.step_angle, self._saved)
        )


class NewtonFallback:
    """The general kernel for steps on which fixed-point iteration failed: counts[LEFT_OVER]."""

    def __init__(self, request: RunRequest, work: RunArrays) -> None:
        self._kernel, self._work = GeneralGroupKernel(request, work), work

    def advance(self, n: int) -> int:
        """See `galvi.run.stepper.Kernel`."""
        before = self._work.steps_done
        code = self._kernel.advance(n)
        self._work.counts[SECOND_KERNEL_STEPS] += self._work.steps_done - before
        return code


@lru_cache(maxsize=32)
def _law(system: Any, system_traces: Traces) -> tuple[LagrangianKernel, tuple[Any, ...]]:
    """The system's kernel, which keeps its functions alive, and its ``Law`` as a tuple; cached
    with the system's traces."""
    kernel = system.lagrangian_kernel()
    return kernel, tuple(
        Law(
            kernel.functions,
            kernel.kind,
            kernel.time_dependent,
            kernel.matrix_rows,
            kernel.constants,
            kernel.force_kind,
            kernel.force_constants,
        )
    )


@lru_cache(maxsize=32)
def _basis(table: Tableau, degrees: tuple[int, ...]) -> tuple[Any, ...]:
    """The ``Basis`` of a tableau as a tuple; ``degrees``: unknowns of each component."""
    nystrom, first = kernel_tableau(table), np.concatenate([[0], np.cumsum(degrees)])
    return tuple(
        Basis(
            table.psi,
            table.slope,
            table.end,
            table.b,
            table.c,
            first.astype(np.int64),
            table.projection,
            nystrom.analysis,
            nystrom.extrapolation,
            nystrom.growth,
        )
    )


def _system(problem: Problem, method: Galerkin) -> GroupSystem:
    return cast(GroupSystem, group_system(problem, method))


@lru_cache(maxsize=32)
def _start_of(problem: Problem, stages: int, system_traces: Traces) -> State:
    """The state before the first step, with the rows of `galvi.kernels.on_group.advance`; cached
    with the system's traces."""
    p0, g = problem.p0.ravel(), problem.q0.ravel()
    layout = getattr(problem.system, "group", Rn(p0.size)).layout
    has_rotations = bool(np.any(layout[:, product.ROTATIONS]))
    state = np.zeros((4, max(3 * p0.size, g.size + p0.size) if has_rotations else p0.size))
    state[0, : g.size], state[1, : p0.size] = g, p0
    if has_rotations:
        nu = np.empty(p0.size)
        product.in_space(layout, g.copy(), p0.copy(), nu)
        state[1, 2 * p0.size : 3 * p0.size] = nu
    return fixed(state, *_guess(problem.v0.ravel(), stages))


def _guess(v: Array, stages: int) -> tuple[Array, np.ndarray]:
    """The same velocity at all stages, and the solver_state that marks it as a guess."""
    same = np.empty((v.size, stages))
    same[:] = v[:, None]
    return same, np.array([GUESS, 0, 0, 0], dtype=np.int64)


def largest_rotation(group: Group, xi: Array) -> float:
    """The largest rotation angle of exponential coordinates xi (d,), or angular speed of a velocity
    (d,)."""
    return float(product.largest_rotation(group.layout, np.ascontiguousarray(xi)))


def _largest_rotation_on(group: Group, path: Array) -> float:
    """The largest rotation angle on a path of exponential coordinates (k, d)."""
    start, largest = 0, 0.0
    for _, d, _, rotations in group.layout:
        sizes = np.sum(path[:, start : start + rotations] ** 2, axis=1)
        largest = max(largest, largest_rotation(group, path[int(np.argmax(sizes))]))
        start += d
    return largest


def _chart(problem: Problem, method: Galerkin) -> LocalChart:
    if problem.q0.shape == problem.v0.shape and problem.q0.ndim == 2:
        return IdentityChart(problem.q0.shape)  # point masses
    return GroupChart(_system(problem, method).group, method.group_chart)


class OnGroup:
    """The state is that of galvi.kernels.on_group.advance; stages are velocities."""

    velocity_row, guess_kind = 1, RATES
    in_other_way = "newton_steps", NEWTON_STEPS_NOTE

    def initial_state(self, problem: Problem, method: Galerkin) -> State:
        """See `Formulation`."""
        return _start_of(problem, method.stages, traces(problem.system))

    def is_compiled(self, problem: Problem, method: Galerkin) -> bool:
        """See `Formulation`."""
        return _system(problem, method).lagrangian_kernel().compiled

    def momenta(self, problem: Problem, saved_moving: Array) -> Array:
        """See `Formulation`."""
        return saved_moving.reshape(-1, *problem.v0.shape)

    def curve_size(self, problem: Problem, method: Galerkin) -> tuple[int, int]:
        """See `Formulation`."""
        return problem.q0.size, problem.v0.size

    def curves(
        self, problem: Problem, method: Galerkin, step: float, t0: float, bases: Array, x: Array
    ) -> Curves:
        """See `Formulation`."""
        return curves_in(_chart(problem, method), problem, method, step, t0, bases, x)

    def guess(self, substeps: Substeps, request: RunRequest, work: RunArrays) -> Array | None:
        """xi' (d, s) in the chart along the next step, from 4, 16 or 64 substeps.

        None for the solver fixed_point, and where no such run succeeds or its path leaves the
        chart. Adds the cost to the counts. ``work.step_angle`` becomes the largest rotation angle
        on the path or, where there is none, |h| times the last angular speed.
        """
        problem, method, step = request.problem, request.method, request.step
        group, chart = _system(problem, method).group, method.group_chart
        t, v = problem.t0 + (request.checkpoint.first + work.steps_done) * step, work.stages[:, -1]
        work.step_angle[0] = abs(step) * largest_rotation(group, v)
        if request.checkpoint.solver == "fixed_point":
            return None
        q = work.state[0, : problem.q0.size].reshape(group.shape)
        for parts in SUBSTEP_COUNTS:
            begin = Checkpoint(
                0, work.state, *_guess(v, method.stages), "newton", SUBSTEP_TOLERANCE
            )
            moved = problem.moved(q.reshape(problem.q0.shape), v.reshape(problem.v0.shape), t)
            fine, code = substeps(RunRequest(moved, method, step / parts, parts, begin))
            work.counts[:4] += fine.work.counts[:4]
            if code == SOLVED:
                fractions = np.union1d(np.linspace(0.0, 1.0, PATH_POINTS), method.table.c)
                path = fine.curves.position(t + step * fractions).reshape(-1, *group.shape)
                rotations = unwrapped(
                    Exponential(), group, coordinates(Exponential(), group, q, path)
                )
                work.step_angle[0] = _largest_rotation_on(group, rotations)
                if work.step_angle[0] > chart.limit:
                    return None
                xi = unwrapped(chart, group, coordinates(chart, group, q, path))
                xi = xi[np.searchsorted(fractions, method.table.c)]
                velocities = fine.curves.velocity(t + method.table.c * step).reshape(-1, v.size)
                rates = np.linalg.solve(tangent(chart, group, xi), velocities[..., None])[..., 0]
                return np.ascontiguousarray(rates.T)
        return None

    def failure(self, request: RunRequest, code: int, work: RunArrays) -> str:
        """See `Formulation`."""
        problem, method, step = request.problem, request.method, request.step
        solver = request.checkpoint.solver
        if isinstance(problem.system, NBody) and problem.system.masses.size > 1:
            q, p = work.state[:2]
            v = problem.system.velocity(p.reshape(problem.q0.shape)).ravel()
            return encounter(problem, problem.system, method.stages, step, np.array([q, p, v]))
        if isinstance(problem.system, WithLimits):
            q = work.state[0, : problem.q0.size].reshape(problem.q0.shape)
            if beyond := problem.system.beyond_limits(q, work.stages[:, -1], step):
                return f"{beyond}. The motion is valid up to there; choose other controls."
        if isinstance(problem.system, Multibody):
            q, v = work.state[0, : problem.q0.size].reshape(problem.q0.shape), work.stages[:, -1]
            if is_locked_ahead(problem, q, v, step):
                return f"{LOCKED}. {BALL_JOINT}."
        angle, limit = float(work.step_angle[0]), method.group_chart.limit
        if not angle < LARGEST_SQUARED:
            return (
                "the step's rotation is not a finite number of radians, or above 1e100. Use other "
                "units, or a smaller step."
            )
        solver_name = "fixed-point iteration" if solver == "fixed_point" else "Newton's method"
        if angle >= NEAR_LIMIT * limit or code == LEFT_CHART:
            widest = max(CHARTS, key=lambda chart: chart.limit)
            alternative = (
                ""
                if widest.limit <= limit
                else (
                    f", or chart=galvi.{type(widest).__name__}(), which ends at "
                    f"{widest.limit / np.pi:g} pi"
                )
            )
            clause = f"the step turns by {angle:.4g} radians, and "
            if code != LEFT_CHART and angle < limit:
                clause = (
                    f"{solver_name} did not solve a step that turns by {angle:.4g} radians, where "
                )
            return (
                f"{clause}the chart {type(method.chart).__name__} ends at {limit:.4g}. Use a step "
                f"of at most {0.5 * abs(step) * limit / angle:.2g}{alternative}."
            )
        if code == NOT_FINITE:
            return (
                "the force or the state became infinite or NaN, or the equations singular. Use a "
                "smaller step, or keep away from the force's singularity."
            )
        alternative = ""
        if solver == "fixed_point":
            alternative = ", or the solver auto"
        elif getattr(problem.system, "potential_calls_per_force", 0):
            argument = "slopes" if isinstance(problem.system, Lagrangian) else "gradient"
            alternative = f", or give the system its {argument}"
        return (
            f"{solver_name} did not solve the stage equations"
            f"{f' of a step that turns by {angle:.3g} radians' if angle else ''}. "
            f"Use a smaller step or a higher degree{alternative}."
        )


ON_GROUP = OnGroup()
