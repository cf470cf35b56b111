"""Runs on vector spaces with velocity-independent forces: Nystrom methods."""

from __future__ import annotations

from functools import lru_cache
from typing import cast

import numpy as np

from galvi.arrays import Array
from galvi.checkpoint import Checkpoint
from galvi.curves.curves import IdentityChart
from galvi.kernels.nystrom.advance import GUESS, NOTHING
from galvi.kernels.nystrom.solve import NOT_FINITE
from galvi.method import Galerkin
from galvi.problem import Problem
from galvi.run.nystrom_steppers import stepper
from galvi.run.plan import Engine, Run, Start, Substeps, curves_in, fixed
from galvi.run.point_masses.encounters import encounter
from galvi.run.run_arrays import RunArrays
from galvi.systems.nbody import NBody
from galvi.systems.system import VectorSystem

SUBSTEPS = (4, 16, 64, 256)
TRIED = {
    "auto": "neither fixed-point iteration nor Newton's method solved",
    "fixed_point": "fixed-point iteration did not solve",
    "newton": "Newton's method did not solve",
}


@lru_cache(maxsize=32)
def nystrom_start(problem: Problem, stages: int) -> Start:
    """The state's rows are q, its low part, v and its low part; no accelerations are known yet."""
    d = problem.q0.size
    state = np.zeros((4, d))
    state[0], state[2] = problem.q0.ravel(), problem.v0.ravel()
    blocks = d // problem.q0.shape[-1]
    return fixed(
        state, np.zeros((d, stages)), np.array([NOTHING, 0, 0] + [0] * blocks, dtype=np.int64)
    )


def accelerations_from_substeps(substeps: Substeps, run: Run, work: RunArrays) -> Array | None:
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
        fine = substeps(Run(here, method, step / parts, parts, begin))
        work.counts[:2] += fine.counts["iterations"], fine.counts["force_evaluations"]
        if fine.success:
            times = t + method.table.c * step
            path = fine(times)
            work.counts[1] += len(times)
            system = cast(VectorSystem, problem.system)
            rows = [system.acceleration(q, s) for q, s in zip(path, times, strict=True)]
            return np.ascontiguousarray(np.stack(rows).reshape(len(times), -1).T)
    return None


def _failure(run: Run, code: int, work: RunArrays) -> str:
    problem, solver = run.problem, run.start.solver
    if isinstance(problem.system, NBody) and problem.system.masses.size > 1:
        return encounter(problem, problem.system, run.method.stages, run.step, work.state)
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


def _momenta(problem: Problem, velocities: Array) -> Array:
    return problem.system.momentum(velocities.reshape(-1, *problem.q0.shape))


NYSTROM = Engine(
    start=lambda problem, method: nystrom_start(problem, method.stages),
    velocity_row=2,
    solves_by_iteration=lambda problem, method: True,
    is_compiled=_is_compiled,
    stepper=stepper,
    stepper_from_guess=stepper,
    guess_from_substeps=accelerations_from_substeps,
    guess_kind=GUESS,
    momenta=_momenta,
    curves=curves_in(lambda problem, method: IdentityChart(problem.q0.shape)),
    failure=_failure,
)
