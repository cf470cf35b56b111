"""Runs on vector spaces with velocity-independent forces: Nystrom methods."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache, partial
from typing import Any, cast

import numpy as np

from galvi.arrays import Array, read_only
from galvi.checkpoint import Checkpoint
from galvi.curves.curves import IdentityChart
from galvi.environment import FAST
from galvi.kernels.compile.function_pointers import interpreted
from galvi.kernels.nystrom import advance
from galvi.kernels.nystrom.advance import GUESS, NOTHING, compiled_reach, reach
from galvi.kernels.nystrom.solve import AUTO, FIXED_POINT, NEWTON, NOT_FINITE, Force
from galvi.kernels.nystrom.step import NystromTableau
from galvi.method import Galerkin
from galvi.problem import Problem
from galvi.run import plan as runs
from galvi.run.point_masses.encounters import encounter
from galvi.systems.canonical import Canonical
from galvi.systems.nbody import NBody
from galvi.systems.system import ForceKernel, VectorSystem
from galvi.tableau import Tableau

# Far below the rounding unit 2^-53: the error left by an iteration is not random and makes the
# energy drift. 32 runs of the outer solar system over 1e6 years (benchmarks/studies/round_off.py,
# degree 8): 23 standard errors of drift with 2^-60, 1.6 with 2^-64, for 3 % more time.
ROUND_OFF = 2.0**-64
NOISY = 1e-11  # of a force, relative: above it the iteration may not settle, see solve.FLOOR
SOLVERS = {"auto": AUTO, "fixed_point": FIXED_POINT, "newton": NEWTON}


def general_stepper(run: runs.Run, work: runs.RunArrays) -> runs.Call:
    """A `Call` of the general kernel: does n more steps and returns its code."""
    system: Any = run.problem.system
    field, force = _force(system, run.problem.q0.shape[-1])
    kernel = advance.compiled_advance() if field.compiled else interpreted(advance.advance)
    tableau, solver = tuple(kernel_tableau(run.method.table)), SOLVERS[run.start.solver]
    plan, progress, kept = runs.run_plan(run, work, run.start.tolerance)

    def call(todo: int) -> int:
        return int(kernel(force, tableau, plan, solver, todo, progress, kept))

    return call


def stepper(run: runs.Run, work: runs.RunArrays) -> runs.Call:
    """A `Call` in lanes, or of the general kernel."""
    if FAST and run.start.solver != "newton":
        from galvi.run.in_lanes.nystrom import lane_stepper

        call = lane_stepper(run, work)
        if call is not None:
            return call
    return general_stepper(run, work)


def reaching(run: runs.Run) -> Callable[..., None]:
    """The kernel of galvi.kernels.nystrom.advance for a run, called with what comes after step."""
    system: Any = run.problem.system
    field, force = _force(system, run.problem.q0.shape[-1])
    kernel = compiled_reach() if field.compiled else interpreted(reach)
    tableau, solver = tuple(kernel_tableau(run.method.table)), SOLVERS[run.start.solver]
    return partial(kernel, force, tableau, solver, run.start.tolerance, run.step)


@lru_cache(maxsize=32)
def _force(system: Any, dimension: int) -> tuple[ForceKernel, tuple[Any, ...]]:
    """The force of a system, which owns the functions, and as the kernel takes it."""
    field = system.force_kernel(dimension)
    return field, tuple(Force(
        field.kind, field.functions, field.slope is not None, field.constants, field.inverse_mass,
        field.width,
    ))  # fmt: skip


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


SUBSTEPS = (4, 16, 64, 256)
TRIED = {
    "auto": "neither fixed-point iteration nor Newton's method solved",
    "fixed_point": "fixed-point iteration did not solve",
    "newton": "Newton's method did not solve",
}


@lru_cache(maxsize=32)
def nystrom_start(problem: Problem, stages: int) -> runs.Start:
    """The state's rows are q, its low part, v and its low part; no accelerations are known yet."""
    d = problem.q0.size
    state = np.zeros((4, d))
    state[0], state[2] = problem.q0.ravel(), problem.v0.ravel()
    blocks = d // problem.q0.shape[-1]
    return runs.fixed(
        state, np.zeros((d, stages)), np.array([NOTHING, 0, 0] + [0] * blocks, dtype=np.int64)
    )


def accelerations_from_substeps(
    substeps: runs.Substeps, run: runs.Run, work: runs.RunArrays
) -> Array | None:
    """Accelerations (d, s) along the next step computed with 4, 16, 64 or 256 substeps, or None.

    None if none of these runs can be solved by fixed-point iteration, and for the solver
    fixed_point. Adds the cost to the counts.
    """
    problem, method, step = run.problem, run.method, run.step
    if run.start.solver == "fixed_point":
        return None
    t, shape = problem.t0 + (run.start.first + work.done) * step, problem.q0.shape
    q, _, v, _ = work.state
    here = Problem(problem.system, q.reshape(shape), v.reshape(shape), t)
    for parts in SUBSTEPS:
        begin = Checkpoint(0, *nystrom_start(here, method.stages), "fixed_point", 1e-8)
        fine = substeps(runs.Run(here, method, step / parts, parts, begin))
        work.counts[:2] += fine.counts["iterations"], fine.counts["force_evaluations"]
        if fine.success:
            times = t + method.table.c * step
            path = fine(times)
            work.counts[1] += len(times)
            system = cast(VectorSystem, problem.system)
            rows = [system.acceleration(q, s) for q, s in zip(path, times, strict=True)]
            return np.ascontiguousarray(np.stack(rows).reshape(len(times), -1).T)
    return None


def _failure(run: runs.Run, code: int, work: runs.RunArrays) -> str:
    problem, solver = run.problem, run.start.solver
    if isinstance(problem.system, NBody) and problem.system.masses.size > 1:
        return encounter(problem, problem.system, run.method.stages, run.step, work.state)
    if isinstance(problem.system, Canonical):
        t = problem.t0 + (run.start.first + work.done) * run.step
        with np.errstate(all="ignore"):
            noise = problem.system.noise_of_differences(work.state[0], t)
        if noise > NOISY:
            known = f"known to {noise:.1g} of itself" if noise < 1.0 else "not known"
            return (
                f"the gradient of the potential is differenced, and {known} there, so that the "
                "stage equations cannot be solved. Give the potential's gradient, or write the "
                "potential so that its terms do not cancel."
            )
    if code == NOT_FINITE:
        return (
            "the force or the state became infinite or NaN. Use a smaller step, or keep away from "
            "the force's singularity."
        )
    return (
        f"{TRIED[solver]} the stage equations. Use a smaller step or a higher degree"
        f"{'' if solver == 'auto' else ', or the solver auto'}."
    )


def _is_compiled(problem: Problem, method: Galerkin) -> bool:
    return cast(VectorSystem, problem.system).force_kernel(problem.q0.shape[-1]).compiled


NYSTROM = runs.Engine(
    start=lambda problem, method: nystrom_start(problem, method.stages),
    velocity_row=2,
    solves_by_iteration=lambda problem, method: True,
    is_compiled=_is_compiled,
    stepper=stepper,
    stepper_from_guess=stepper,
    guess_from_substeps=accelerations_from_substeps,
    guess_kind=GUESS,
    momenta=lambda problem, v: problem.system.momentum(v.reshape(-1, *problem.q0.shape)),
    curves=runs.curves_in(lambda problem, method: IdentityChart(problem.q0.shape)),
    failure=_failure,
)
