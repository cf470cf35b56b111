"""Runs in a moving frame: the third engine, for methods whose chart is a frame."""

from __future__ import annotations

import numpy as np

from galvi.arrays import Array
from galvi.curves.frame_curves import FrameCurves
from galvi.fast.in_frame.fallback import allowed, inertial_curves, inertial_stepper
from galvi.fast.in_frame.stepper import Path, frame_of, frame_start, frame_stepper, motion_of
from galvi.kernels.nystrom.solve import NOT_FINITE
from galvi.method import Galerkin
from galvi.problem import Problem
from galvi.run.plan import Engine, Run
from galvi.run.point_masses.encounters import encounter
from galvi.run.run_arrays import RunArrays
from galvi.systems.nbody import NBody

ELSEWHERE = (
    "{left} of {steps} steps were done in the inertial frame, in parts, since what the moving "
    "frame leaves was too strong there."
)


def refuse(problem: Problem, method: Galerkin) -> None:
    """ValueError where the method's frame does not apply to the problem."""
    refusal = frame_of(method).refusal(problem)
    if refusal:
        raise ValueError(refusal)


def _failure(run: Run, code: int, work: RunArrays) -> str:
    problem, method, step = run.problem, run.method, run.step
    frame = frame_of(method)
    q, v = (work.state[row, : problem.q0.size].reshape(problem.q0.shape) for row in (0, 2))
    outside = ""
    if np.all(np.isfinite([q, v])):
        outside = frame.leaves(problem.with_initial_state(q, v), step)
    if outside:
        return outside
    name = frame.name
    why = (
        f"the state became infinite or NaN in the {name}"
        if code == NOT_FINITE
        else f"the passes did not converge: what the {name} leaves is too strong for this step"
    )
    if isinstance(problem.system, NBody):
        where = encounter(
            problem,
            problem.system,
            method.stages,
            step,
            work.state[:4, : problem.q0.size],
            framed=True,
        )
        return f"{why}. In the inertial frame, {where}"
    return f"{why}. Use a smaller step, or another chart."


def _curves(
    problem: Problem, method: Galerkin, step: float, t0: float, bases: Array, coefficients: Array
) -> FrameCurves:
    motion = motion_of(problem, method, step)
    path = Path(problem, method, step, motion.clock, motion.stretch, inertial_curves)
    first = round((t0 - problem.t0) / step)
    bases = bases.reshape(len(bases), -1, frame_start(problem, method)[0].shape[1])
    return FrameCurves(method.space, t0, step, bases, coefficients, first, path)


def _curve_size(problem: Problem, method: Galerkin) -> tuple[int, int]:
    start = frame_start(problem, method)[0]
    return 4 * start.shape[1], 2 * frame_of(method).rows(problem)


IN_FRAME = Engine(
    start=frame_start,
    velocity_row=2,
    solves_by_iteration=lambda problem, method: True,
    is_compiled=lambda problem, method: True,
    stepper=frame_stepper,
    stepper_from_guess=inertial_stepper,
    guess_from_substeps=allowed,
    guess_kind=0,
    momenta=lambda problem, v: problem.system.momentum(v.reshape(-1, *problem.q0.shape)),
    curves=_curves,
    failure=_failure,
    solvers=("auto", "fixed_point"),
    exceptions=("inertial_steps", ELSEWHERE),
    curve_size=_curve_size,
    name="frame",
)


def frame_engine(problem: Problem, method: Galerkin) -> Engine:
    """The engine; ValueError where the method's frame does not apply to the problem."""
    refuse(problem, method)
    return IN_FRAME
