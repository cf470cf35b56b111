"""Symplecticity of a step, from its derivative by the implicit function theorem."""

from __future__ import annotations

from typing import cast

import numpy as np

from galvi.arrays import Array
from galvi.diagnostics.frame_derivative import frame_step_derivative
from galvi.diagnostics.group_symplecticity import group_step_derivative, group_symplecticity_defect
from galvi.method import Galerkin
from galvi.problem import Problem
from galvi.run.group_system import group_system
from galvi.run.integrate import check_types, integrate
from galvi.run.interruption import uninterrupted
from galvi.systems.system import VectorSystem


def step_derivative(problem: Problem, method: Galerkin, step: float) -> Array:
    """D(q1, v1)/D(q0, v0) of one step from the problem's start, (2 d, 2 d).

    On a Lie group D(eta1, mu1)/D(eta0, mu0), see `galvi.diagnostics.group_symplecticity`.

    At the converged stages Q, (I - h^2 A x da/dq) dQ = dq + c h dv, and the updates are linear in
    da/dq dQ. In a moving frame see `galvi.diagnostics.frame_derivative`. Raises ValueError when the
    step itself fails, or has no derivative.
    """
    check_types(problem, method, "step_derivative(problem, method, step)")
    if method.in_frame:
        return frame_step_derivative(problem, method, step)
    if group_system(problem, method) is not None:
        return group_step_derivative(problem, method, step)
    run = uninterrupted(integrate(problem, method, step, 1))
    h, table, d = float(step), method.table, problem.q0.size
    if not run.success:
        raise ValueError(f"the step has no derivative, because it failed. {run.status}")
    times = problem.t0 + table.c * h
    path = run(times)
    system = cast(VectorSystem, problem.system)
    slopes = np.stack(
        [system.acceleration_jacobian(q, t) for q, t in zip(path, times, strict=True)]
    )
    stages, unit = len(times), np.eye(d)
    coupled = np.einsum("kj,jab->kajb", h * h * table.A, slopes).reshape(stages * d, stages * d)
    lines = np.concatenate(
        [np.tile(unit, (stages, 1)), np.kron(h * table.c[:, None], unit)], axis=1
    )
    try:
        dQ = np.linalg.solve(np.eye(stages * d) - coupled, lines).reshape(stages, d, 2 * d)
    except np.linalg.LinAlgError:
        raise ValueError(
            f"the step has no derivative, because the stage equations are singular at step {h!r}. "
            f"Use a smaller step."
        ) from None
    da = np.einsum("jab,jbc->jac", slopes, dQ)
    position = np.concatenate([unit, h * unit], axis=1) + h * h * np.tensordot(table.beta, da, 1)
    velocity = np.concatenate([0.0 * unit, unit], axis=1) + h * np.tensordot(table.b, da, 1)
    return np.concatenate([position, velocity])


def symplecticity_defect(problem: Problem, method: Galerkin, step: float) -> float:
    """Largest entry of DF^T J DF - J over |DF|^2, for F: (q0, p0) -> (q1, p1) (H 1.2).

    Round-off for a symplectic method. On a Lie group, the form in left trivialisation (H 3.1.1), to
    about 1e-12. Raises as `step_derivative`.
    """
    check_types(problem, method, "symplecticity_defect(problem, method, step)")
    if not method.in_frame and group_system(problem, method) is not None:
        return group_symplecticity_defect(problem, method, step)
    d, shape = problem.q0.size, problem.q0.shape
    units = np.eye(d).reshape(d, *shape)
    mass = problem.system.momentum(units).reshape(d, d).T
    inverse = problem.system.velocity(units).reshape(d, d).T
    if not np.all(np.isfinite(inverse)):
        raise ValueError(
            "symplecticity is a property of (q, p), and the p of massless bodies is always 0; "
            "received some. Give them a small mass."
        )
    zero = np.zeros((d, d))
    to_momentum = np.block([[np.eye(d), zero], [zero, mass]])
    to_velocity = np.block([[np.eye(d), zero], [zero, inverse]])
    DF = to_momentum @ step_derivative(problem, method, step) @ to_velocity
    J = np.block([[zero, np.eye(d)], [-np.eye(d), zero]])
    return float(np.max(np.abs(DF.T @ J @ DF - J)) / max(1.0, np.linalg.norm(DF, 2) ** 2))
