"""Runs in a moving frame: the third engine, for methods whose chart is a frame."""

from __future__ import annotations

from typing import cast

import numpy as np

from galvi.arrays import Array
from galvi.curves.frame_curves import FrameCurves
from galvi.fast.frames.frame import Frame, matrix_of
from galvi.fast.in_frame.fallback import allowed, inertial_curves, inertial_stepper
from galvi.fast.in_frame.stepper import Path, frame_of, frame_start, frame_stepper, motion_of
from galvi.kernels.nystrom.solve import NOT_FINITE
from galvi.method import Galerkin
from galvi.problem import Problem
from galvi.run.integrate import integrate
from galvi.run.interruption import uninterrupted
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


def frame_step_derivative(problem: Problem, method: Galerkin, step: float) -> Array:
    """D(q1, v1)/D(q0, v0) of one step whose passes have converged, with its nodes held, (2 d, 2 d).

    With w the state at the step's centre and F_j = omega_j w' at the stages W_j:
    dW_j = dw + sum_l A_jl DF_l dW_l, and the step is phi_(h/2) (w + sum_j b_j F_j) after
    w = phi_(h/2). Raises ValueError when the step fails, or was done in the inertial frame.
    """
    frame, table, d = cast(Frame, method.chart), method.table, problem.q0.size
    run = uninterrupted(integrate(problem, method, step, 1, curves=True))
    if not run.success or run.counts.get("inertial_steps"):
        raise ValueError(f"the step has no derivative in its frame. {run.status}")
    curves = cast(FrameCurves, run.curves)
    times, weights = cast(Path, curves.path).times(0, table.c)
    weights = weights * (step / (table.b @ weights))
    stages, after = _states(curves, table.c)
    slopes = np.stack([
        weight * frame.derivatives(problem, w, float(t))[1]
        for weight, w, t in zip(weights, stages, times, strict=True)
    ])  # fmt: skip
    s, unit = len(times), np.eye(2 * d)
    coupled = np.einsum("jl,lab->jalb", table.integral, slopes).reshape(s * 2 * d, s * 2 * d)
    lines = np.tile(unit, (s, 1))
    dW = np.linalg.solve(np.eye(s * 2 * d) - coupled, lines).reshape(s, 2 * d, 2 * d)
    kick = unit + np.einsum("j,jab,jbc->ac", table.b, slopes, dW)
    start = frame.enter(problem, problem.q0, problem.v0)[[4, 6]]
    first, last = (frame.derivatives(problem, w, 0.5 * step)[0] for w in (start, after))
    into = np.kron(np.eye(2), matrix_of(frame, problem))
    return np.linalg.solve(into, last @ kick @ first @ into)


def _states(curves: FrameCurves, c: Array) -> tuple[Array, Array]:
    """w at the stages (s, 2, m), and after the step at its centre (2, m)."""
    base = curves.bases[0, :2]
    basis = curves.space.basis(np.concatenate([c, [0.0, 1.0]]))[:, 1:]
    ways = (basis - basis[-2]) @ curves.coefficients[0].T
    n = ways.shape[1] // 2
    states = np.tile(base, (len(ways), 1, 1))
    states[:, :, :n] += ways.reshape(-1, 2, n)
    return states[:-2], states[-1]
