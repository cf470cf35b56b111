"""The derivative of a step in a moving frame."""

from __future__ import annotations

from typing import cast

import numpy as np

from galvi.arrays import Array
from galvi.curves.curves import FrameCurves
from galvi.frames.frame import Frame, matrix_of
from galvi.method import Galerkin
from galvi.problem import Problem
from galvi.run.in_frame.curves import FrameOfRun
from galvi.run.integrate import integrate
from galvi.run.interruption import uninterrupted


def frame_step_derivative(problem: Problem, method: Galerkin, step: float) -> Array:
    """D(q1, v1)/D(q0, v0), (2 d, 2 d), of one step whose passes have converged, for fixed nodes.

    With w the state at the step's centre and F_j = omega_j w' at the stages W_j: dW_j = dw + sum_l
    A_jl DF_l dW_l, and the step is phi_(h/2) (w + sum_j b_j F_j) after w = phi_(h/2).

    Raises
    ------
    ValueError
        When the step fails, or was done in the inertial frame.
    """
    frame, table, d = cast(Frame, method.chart), method.table, problem.q0.size
    run = uninterrupted(integrate(problem, method, step, 1, curves=True))
    if not run.success or run.counts.get("inertial_steps"):
        raise ValueError(f"the step has no derivative in its frame. {run.status}")
    curves = cast(FrameCurves, run.curves)
    times, weights = cast(FrameOfRun, curves.path).times(0, table.c)
    weights = weights * (step / (table.b @ weights))
    stages, after = _states(curves, table.c)
    slopes = np.stack(
        [
            weight * frame.derivatives(problem, w, float(t))[1]
            for weight, w, t in zip(weights, stages, times, strict=True)
        ]
    )
    s, unit = len(times), np.eye(2 * d)
    coupling = np.einsum("jl,lab->jalb", table.integral, slopes).reshape(s * 2 * d, s * 2 * d)
    right_sides = np.tile(unit, (s, 1))
    dW = np.linalg.solve(np.eye(s * 2 * d) - coupling, right_sides).reshape(s, 2 * d, 2 * d)
    centre_change = unit + np.einsum("j,jab,jbc->ac", table.b, slopes, dW)
    start = frame.enter(problem, problem.q0, problem.v0)[[4, 6]]
    derivative_before, derivative_after = (
        frame.derivatives(problem, w, 0.5 * step)[0] for w in (start, after)
    )
    into_frame = np.kron(np.eye(2), matrix_of(frame, problem))
    return np.linalg.solve(
        into_frame, derivative_after @ centre_change @ derivative_before @ into_frame
    )


def _states(curves: FrameCurves, c: Array) -> tuple[Array, Array]:
    """w at the stages (s, 2, m), and after the step at its centre (2, m)."""
    base = curves.bases[0, :2]
    basis = curves.space.basis(np.concatenate([c, [0.0, 1.0]]))[:, 1:]
    displacements = (basis - basis[-2]) @ curves.coefficients[0].T
    n = displacements.shape[1] // 2
    states = np.tile(base, (len(displacements), 1, 1))
    states[:, :, :n] += displacements.reshape(-1, 2, n)
    return states[:-2], states[-1]
