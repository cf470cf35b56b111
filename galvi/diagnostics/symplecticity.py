"""Derivatives of a step, and how far it is from symplectic and reversible."""

from __future__ import annotations

from collections.abc import Callable
from typing import cast

import numpy as np

from galvi import input_checks
from galvi.arrays import Array
from galvi.charts.chart import Exponential, coordinates, place
from galvi.curves.clock_curves import ClockCurves
from galvi.curves.curves import FrameCurves
from galvi.diagnostics.clock_symplecticity import clock_round_trip_error, clock_symplecticity_defect
from galvi.groups.group import Group
from galvi.method import Galerkin
from galvi.problem import Problem
from galvi.run.group_system import group_system
from galvi.run.integrate import check_types, integrate
from galvi.run.interruption import uninterrupted
from galvi.systems.finite_differences import WEIGHTS
from galvi.systems.nbody import NBody
from galvi.systems.system import GroupSystem, VectorSystem
from galvi.systems.velocities import velocity_at
from galvi.trajectory import Trajectory

OF_VELOCITY = (
    "the derivative of a step is not known with forces of velocity on point masses, which are not "
    "symplectic. Leave them out."
)
MASSLESS = (
    "symplecticity is a property of (q, p), and the p of massless bodies is always 0; received "
    "some. Give them a small mass."
)
# (problem, method, step) -> the derivative of a step in a moving frame; see galvi.fast.
IN_FRAME: list[Callable[[Problem, Galerkin, float], Array]] = []


def stage_states(run: Trajectory) -> tuple[Array, Array, Array, Array]:
    """Times (steps, s), q (steps, s, ...), velocities (steps, s, ...) and h times the weights (s,).

    Raises ValueError for a run without curves, such as one by a reference, or in a moving frame.
    """
    curves, step = run.curves, run.step
    if isinstance(curves, FrameCurves | ClockCurves):
        raise ValueError(
            "this needs curves between stages of one rule in time; a run in a moving frame or in a "
            "clock has others. Integrate with another chart, and without a clock."
        )
    if curves is None or step is None:
        raise ValueError(
            "this needs the Galerkin curves of a run; integrate with curves=True or save_every=1 "
            "(references keep none)."
        )
    table = run.method.table
    coefficients = curves.coefficients
    xi = np.einsum("kdi,si->ksd", coefficients, table.psi)
    rate = np.einsum("kdi,si->ksd", coefficients, table.slope) / step
    t = curves.t0 + (np.arange(len(xi))[:, None] + table.c) * step
    bases = np.repeat(curves.bases[:, None], table.c.size, axis=1)
    return t, curves.chart.place(bases, xi), curves.chart.velocity(lambda: xi, rate), step * table.b


def step_derivative(problem: Problem, method: Galerkin, step: float) -> Array:
    """D(q1, v1)/D(q0, v0) of one step from the problem's start, (2 d, 2 d).

    On a Lie group D(eta1, mu1)/D(eta0, mu0), see `galvi.diagnostics.symplecticity`.

    At the converged stages Q, (I - h^2 A x da/dq) dQ = dq + c h dv, and the updates are linear in
    da/dq dQ. In a moving frame see `galvi.fast.in_frame.engine`. Raises ValueError when the
    step itself fails, or has no derivative.
    """
    check_types(problem, method, "step_derivative(problem, method, step)")
    if method.clock is not None:
        raise ValueError(
            "a step in a clock has its derivative in the phase space of (q, t): see "
            "galvi.symplecticity_defect, or leave the clock out."
        )
    if method.in_frame:
        if not IN_FRAME:
            raise ValueError("moving frames need galvi.fast, which GALVI_FAST=0 leaves out.")
        return IN_FRAME[0](problem, method, step)
    if group_system(problem, method) is not None:
        if isinstance(problem.system, NBody):
            raise ValueError(OF_VELOCITY)
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
    about 1e-12. With a clock in the phase space of (q, t) and (p, -E), for a whole step in tau, to
    about 1e-11. Raises as `step_derivative`.
    """
    check_types(problem, method, "symplecticity_defect(problem, method, step)")
    if method.clock is not None:
        if isinstance(problem.system, NBody) and problem.system.has_massless:
            raise ValueError(MASSLESS)
        return clock_symplecticity_defect(problem, method, step)
    if not method.in_frame and group_system(problem, method) is not None:
        return group_symplecticity_defect(problem, method, step)
    d, shape = problem.q0.size, problem.q0.shape
    units = np.eye(d).reshape(d, *shape)
    mass = problem.system.momentum(units).reshape(d, d).T
    inverse = problem.system.velocity(units).reshape(d, d).T
    if not np.all(np.isfinite(inverse)):
        raise ValueError(MASSLESS)
    zero = np.zeros((d, d))
    to_momentum = np.block([[np.eye(d), zero], [zero, mass]])
    to_velocity = np.block([[np.eye(d), zero], [zero, inverse]])
    DF = to_momentum @ step_derivative(problem, method, step) @ to_velocity
    J = np.block([[zero, np.eye(d)], [-np.eye(d), zero]])
    return float(np.max(np.abs(DF.T @ J @ DF - J)) / max(1.0, np.linalg.norm(DF, 2) ** 2))


NUDGE = 2.0**-6
CHART = Exponential()


def group_step_derivative(problem: Problem, method: Galerkin, step: float) -> Array:
    """D(eta1, mu1)/D(eta0, mu0), (2 d, 2 d), for g moved to g exp(hat(eta)) at both ends.

    By central differences of order eight, accurate to about 1e-12. Raises ValueError when the step
    itself fails.
    """
    system = cast(GroupSystem, group_system(problem, method))
    group, d = system.group, system.group.dimension

    def end(eta: Array, shift: Array) -> tuple[Array, Array]:
        g = place(CHART, group, problem.q0, eta)
        v = velocity_at(system, g, problem.p0 + shift, problem.t0)
        start = Problem(problem.system, g, v, problem.t0)
        run = uninterrupted(integrate(start, method, step, 1))
        if not run.success:
            raise ValueError(f"the step has no derivative, because it failed. {run.status}")
        return run.q[-1], run.p[-1]

    zero = np.zeros(d)
    here, _ = end(zero, zero)
    size = float(np.max(np.abs(problem.p0))) or 1.0
    columns = np.zeros((2 * d, 2 * d))
    for column, unit in enumerate(np.vstack([np.eye(d), np.eye(d)])):
        turning = column < d
        nudge = NUDGE if turning else NUDGE * size
        for k, weight in enumerate(WEIGHTS, start=1):
            sides = []
            for sign in (1.0, -1.0):
                moved = sign * k * nudge * unit
                g, mu = end(moved, zero) if turning else end(zero, moved)
                sides.append(np.concatenate([coordinates(CHART, group, here, g), mu]))
            columns[column] += weight * (sides[0] - sides[1]) / nudge
    return columns.T


def group_symplecticity_defect(problem: Problem, method: Galerkin, step: float) -> float:
    """Largest entry of DF^T W1 DF - W0 over |DF|^2 (H 3.1.1, claim L16).

    W(mu) is the matrix of <d mu2, eta1> - <d mu1, eta2> + <mu, [eta1, eta2]>.
    """
    group = cast(GroupSystem, group_system(problem, method)).group
    DF = step_derivative(problem, method, step)
    end = uninterrupted(integrate(problem, method, step, 1))
    W0, W1 = (_form(group, mu) for mu in (problem.p0, end.p[-1]))
    scale = max(1.0, np.linalg.norm(DF, 2) ** 2)
    return float(np.max(np.abs(DF.T @ W1 @ DF - W0)) / scale)


def _form(group: Group, mu: Array) -> Array:
    d = group.dimension
    unit = np.eye(d)
    turning = np.array([[mu @ group.bracket(v, w) for w in unit] for v in unit])
    return np.block([[turning, unit], [-unit, np.zeros((d, d))]])


def round_trip_error(problem: Problem, method: Galerkin, step: float, steps: int) -> float:
    """Largest component of |q - q0| after ``steps`` steps forwards and as many backwards.

    A symmetric method returns to round-off; others, a `KeplerFrame` whose nodes an orbit places,
    and on groups all but degree 1 with the exponential chart, only to their order. With a clock
    both ways have the energy of the start. Raises ValueError when a run fails, what
    `galvi.integrate` raises, and KeyboardInterrupt on Ctrl-C.
    """
    step = input_checks.real("step", step)
    if method.clock is not None:
        return clock_round_trip_error(problem, method, step, steps)
    there = uninterrupted(integrate(problem, method, step, steps, save_every=steps))
    _check(there)
    end, t = there.q[-1], float(there.t[-1])
    reversed_start = Problem(problem.system, end, there.v[-1], t)
    back = uninterrupted(integrate(reversed_start, method, -step, steps, save_every=steps))
    _check(back)
    return float(np.max(np.abs(back.q[-1] - problem.q0)))


def _check(run: Trajectory) -> None:
    if not run.success:
        raise ValueError(f"both ways must be completed; received a run of which: {run.status}")
