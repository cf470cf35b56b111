"""Runs on vector spaces with velocity-independent forces: Nystrom methods."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache, partial
from typing import Any, cast

import numpy as np

from galvi.arrays import Array, read_only
from galvi.curves.curves import Curves, IdentityChart
from galvi.kernels.compile.function_pointers import interpreted
from galvi.kernels.nystrom import advance
from galvi.kernels.nystrom.advance import GUESS, NOTHING, advance_states, compiled_advance_states
from galvi.kernels.nystrom.solve import AUTO, FIXED_POINT, NEWTON, NOT_FINITE, SOLVED, Force
from galvi.kernels.nystrom.step import NystromTableau
from galvi.method import Galerkin
from galvi.problem import Problem
from galvi.run.point_masses.encounters import encounter
from galvi.run.request import RunRequest, from_start
from galvi.run.run_arrays import RunArrays, State, fixed, run_plan
from galvi.run.stepper import NEWTON_STEPS_NOTE, Substeps, curves_in
from galvi.systems.canonical import Canonical
from galvi.systems.nbody import NBody
from galvi.systems.system import ForceKernel, VectorSystem
from galvi.tableau import Tableau

# Relative error of a force above which the iteration may not settle, see solve.ROUND_OFF_CHANGE.
NOISY_FORCE = 1e-11
SOLVER_CODES = {"auto": AUTO, "fixed_point": FIXED_POINT, "newton": NEWTON}
SUBSTEPS = (4, 16, 64, 256)  # numbers of smaller steps from which a failed step gets its guess
FAILED_SOLVERS = {
    "auto": "neither fixed-point iteration nor Newton's method solved",
    "fixed_point": "fixed-point iteration did not solve",
    "newton": "Newton's method did not solve",
}


class GeneralVectorKernel:
    """Steps by the general kernel."""

    def __init__(self, request: RunRequest, work: RunArrays) -> None:
        force_kernel, force = _force(request.problem.system, request.problem.q0.shape[-1])
        self._kernel = (
            advance.compiled_advance() if force_kernel.compiled else interpreted(advance.advance)
        )
        tableau, solver = (
            tuple(kernel_tableau(request.method.table)),
            SOLVER_CODES[request.checkpoint.solver],
        )
        plan, self._progress, self._saved = run_plan(request, work, request.checkpoint.tolerance)
        self._arguments = force, tableau, plan, solver

    def advance(self, n: int) -> int:
        """See `galvi.run.stepper.Kernel`."""
        return int(self._kernel(*self._arguments, n, self._progress, self._saved))


def reach_kernel(request: RunRequest) -> Callable[..., None]:
    """The kernel `galvi.kernels.nystrom.advance.reach` with its arguments up to the step bound to
    those of a run."""
    field, force = _force(request.problem.system, request.problem.q0.shape[-1])
    kernel = compiled_advance_states() if field.compiled else interpreted(advance_states)
    tableau, solver = (
        tuple(kernel_tableau(request.method.table)),
        SOLVER_CODES[request.checkpoint.solver],
    )
    return partial(kernel, force, tableau, solver, request.checkpoint.tolerance, request.step)


@lru_cache(maxsize=32)
def _force(system: Any, dimension: int) -> tuple[ForceKernel, tuple[Any, ...]]:
    """The force of a system, which owns the compiled functions, and the tuple that kernels take."""
    field = system.force_kernel(dimension)
    return field, tuple(
        Force(
            field.kind,
            field.functions,
            field.slope is not None,
            field.constants,
            field.inverse_mass,
            field.width,
        )
    )


@lru_cache(maxsize=32)
def kernel_tableau(table: Tableau) -> NystromTableau:
    """A table in the layout of galvi.kernels.nystrom.step."""

    def transposed(matrix: Array) -> Array:
        return read_only(matrix.T)

    c_low, b_low, beta_low, *_, psi_low, C_low, line_low = table.low_parts
    beta_low = read_only(beta_low + table.b * c_low)
    return NystromTableau(
        table.c, table.b, table.beta, b_low, beta_low, transposed(table.A),
        transposed(table.psi), table.velocity_coefficients, table.C, transposed(table.C),
        transposed(table.analysis), transposed(table.extrapolation), table.growth,
        transposed(psi_low), C_low, line_low, c_low,
    )  # fmt: skip


@lru_cache(maxsize=32)
def nystrom_start(problem: Problem, stages: int) -> State:
    """The state before the first step: rows q, its low part, v and its low part, and stages 0."""
    d = problem.q0.size
    state = np.zeros((4, d))
    state[0], state[2] = problem.q0.ravel(), problem.v0.ravel()
    blocks = d // problem.q0.shape[-1]
    return fixed(
        state, np.zeros((d, stages)), np.array([NOTHING, 0, 0] + [0] * blocks, dtype=np.int64)
    )


class VectorSpace:
    """`Formulation` on a vector space; the rows of the state are q, its low part, v and its low
    part."""

    velocity_row, guess_kind = 2, GUESS
    in_other_way = "newton_steps", NEWTON_STEPS_NOTE

    def initial_state(self, problem: Problem, method: Galerkin) -> State:
        """See `Formulation`."""
        return nystrom_start(problem, method.stages)

    def is_compiled(self, problem: Problem, method: Galerkin) -> bool:
        """See `Formulation`."""
        return cast(VectorSystem, problem.system).force_kernel(problem.q0.shape[-1]).compiled

    def momenta(self, problem: Problem, saved_moving: Array) -> Array:
        """See `Formulation`."""
        return problem.system.momentum(saved_moving.reshape(-1, *problem.q0.shape))

    def curve_size(self, problem: Problem, method: Galerkin) -> tuple[int, int]:
        """See `Formulation`."""
        return problem.q0.size, problem.v0.size

    def curves(
        self, problem: Problem, method: Galerkin, step: float, t0: float, bases: Array, x: Array
    ) -> Curves:
        """See `Formulation`."""
        return curves_in(IdentityChart(problem.q0.shape), problem, method, step, t0, bases, x)

    def guess(self, substeps: Substeps, request: RunRequest, work: RunArrays) -> Array | None:
        """Accelerations (d, s) at the next step's stages, from the first number of SUBSTEPS that
        fixed-point iteration can solve; None if there is none, and for the solver fixed_point.

        Adds the cost to ``work.counts``.
        """
        problem, method, step = request.problem, request.method, request.step
        if request.checkpoint.solver == "fixed_point":
            return None
        t, shape = (
            problem.t0 + (request.checkpoint.first + work.steps_done) * step,
            problem.q0.shape,
        )
        q, _, v, _ = work.state
        moved = Problem(problem.system, q.reshape(shape), v.reshape(shape), t)
        for parts in SUBSTEPS:
            begin = from_start("fixed_point", 1e-8)
            fine_stepper, code = substeps(RunRequest(moved, method, step / parts, parts, begin))
            work.counts[:2] += fine_stepper.work.counts[:2]
            if code == SOLVED:
                times = t + method.table.c * step
                stage_positions = fine_stepper.curves.position(times)
                work.counts[1] += len(times)
                system = cast(VectorSystem, problem.system)
                rows = [
                    system.acceleration(q, s) for q, s in zip(stage_positions, times, strict=True)
                ]
                return np.ascontiguousarray(np.stack(rows).reshape(len(times), -1).T)
        return None

    def failure(self, request: RunRequest, code: int, work: RunArrays) -> str:
        """See `Formulation`."""
        problem, solver = request.problem, request.checkpoint.solver
        if isinstance(problem.system, NBody) and problem.system.masses.size > 1:
            return encounter(
                problem, problem.system, request.method.stages, request.step, work.state
            )
        if isinstance(problem.system, Canonical):
            t = problem.t0 + (request.checkpoint.first + work.steps_done) * request.step
            with np.errstate(all="ignore"):
                relative_error = problem.system.noise_of_differences(work.state[0], t)
            if relative_error > NOISY_FORCE:
                accuracy = (
                    f"known to {relative_error:.1g} of itself"
                    if relative_error < 1.0
                    else "not known"
                )
                return (
                    f"the gradient of the potential is differenced, and {accuracy} there, so that "
                    "the stage equations cannot be solved. Give the potential's gradient, or write "
                    "the potential so that its terms do not cancel."
                )
        if code == NOT_FINITE:
            return (
                "the force or the state became infinite or NaN. Use a smaller step, or keep away "
                "from the force's singularity."
            )
        return (
            f"{FAILED_SOLVERS[solver]} the stage equations. Use a smaller step or a higher degree"
            f"{'' if solver == 'auto' else ', or the solver auto'}."
        )


VECTOR_SPACE = VectorSpace()
