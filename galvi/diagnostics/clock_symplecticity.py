"""The derivative of a step in a clock, in the phase space of (q, t) and (p, -E)."""

from __future__ import annotations

from typing import Any

import numpy as np

from galvi import input_checks
from galvi.arrays import Array
from galvi.charts.chart import Exponential, coordinates, place
from galvi.kernels.nystrom.solve import SOLVED
from galvi.method import Galerkin
from galvi.problem import Problem
from galvi.run.clocked.general import lagrangian_of
from galvi.run.clocked.run import motion_of
from galvi.run.energies import start_energies
from galvi.run.nystrom_engine import ROUND_OFF
from galvi.systems.finite_differences import WEIGHTS
from galvi.systems.velocities import velocity_at

NUDGE = 2.0**-7
CHART = Exponential()


def clock_step_derivative(
    problem: Problem, method: Galerkin, step: float
) -> tuple[Array, Array, Array]:
    """D(eta1, t1, mu1, e1)/D(eta0, t0, mu0, e0) of a step, (2 d + 2, 2 d + 2), and mu0, mu1 (d,).

    q moves to q exp(hat(eta)) on a group, to q + eta else; e = -E is the momentum of the time, E
    the energy that the clock is told. By central differences of order eight, to about 1e-11. Raises
    ValueError when the step fails.
    """
    group = lagrangian_of(problem.system, problem).group
    d, energy = group.dimension, start_energies(problem).total
    rate = method.clock.rate(problem)
    q0, p0 = problem.q0.reshape(group.shape), problem.p0.ravel()

    def end(eta: Array, shift: Array, more: float) -> tuple[Array, Array, float]:
        q = place(CHART, group, q0, eta)
        shape = problem.v0.shape
        v: Any = velocity_at(
            problem.system, q.reshape(problem.q0.shape), (p0 + shift).reshape(shape), problem.t0,
            problem.v0,
        )  # fmt: skip
        motion = motion_of(problem, method, "auto", ROUND_OFF, energy + more)
        state = motion.at(q.reshape(problem.q0.shape), v, problem.t0)
        found = motion.advance(state, step, 1, None, False)
        if found.code != SOLVED:
            raise ValueError(f"the step has no derivative, because it failed: {found.reason}.")
        taken = found.taken
        return taken.q[0].reshape(group.shape), taken.p[0], float(taken.t[0] @ (1.0, 1.0))

    zero = np.zeros(d)
    here, mu1, _ = end(zero, zero, 0.0)
    size = float(np.max(np.abs(p0))) or 1.0
    far = min(1.0, abs(step) * float(np.max(np.abs(problem.v0))) * float(rate(problem.q0.ravel())))
    nudges = [NUDGE * (far or 1.0)] * d + [NUDGE * size] * d + [NUDGE * max(abs(energy), size)]
    columns = np.zeros((2 * d + 2, 2 * d + 2))
    columns[d, d] = columns[2 * d + 1, 2 * d + 1] = 1.0  # of t, which nothing depends on, and of e
    for column, nudge in enumerate(nudges):
        row = column + (column >= d)
        for k, weight in enumerate(WEIGHTS, start=1):
            sides = []
            for sign in (1.0, -1.0):
                moved = np.zeros(2 * d + 1)
                moved[column] = sign * k * nudge
                q, mu, t = end(moved[:d], moved[d : 2 * d], -float(moved[2 * d]))
                eta = coordinates(CHART, group, here, q)
                sides.append(np.concatenate([eta, [t], mu, [0.0]]))
            columns[row] += weight * (sides[0] - sides[1]) / nudge
    return columns.T, p0, mu1


def clock_symplecticity_defect(problem: Problem, method: Galerkin, step: float) -> float:
    """Largest entry of DF^T W1 DF - W0 over |DF|^2 in the extended phase space; see
    `galvi.symplecticity_defect`."""
    group = lagrangian_of(problem.system, problem).group
    DF, mu0, mu1 = clock_step_derivative(problem, method, step)
    W0, W1 = (_form(group, mu) for mu in (mu0, mu1))
    scale = max(1.0, float(np.linalg.norm(DF, 2)) ** 2)
    return float(np.max(np.abs(DF.T @ W1 @ DF - W0)) / scale)


def clock_round_trip_error(problem: Problem, method: Galerkin, step: float, steps: int) -> float:
    """As `galvi.round_trip_error`; both ways have the energy of the start."""
    motion = motion_of(problem, method, "auto", ROUND_OFF)
    state = motion.at(problem.q0, problem.v0, problem.t0)
    for h in (step, -step):
        found = motion.advance(state, h, input_checks.whole("steps", steps), None, False)
        if found.code != SOLVED:
            raise ValueError(
                f"both ways must be completed; a step failed: {found.reason.rstrip('.')}."
            )
        state = found.after
    return float(np.max(np.abs(found.taken.q[-1] - problem.q0.ravel())))


def _form(group: Any, mu: Array) -> Array:
    d = group.dimension
    unit, turning = np.eye(d + 1), np.zeros((d + 1, d + 1))
    turning[:d, :d] = [[mu @ group.bracket(v, w) for w in np.eye(d)] for v in np.eye(d)]
    return np.block([[turning, unit], [-unit, np.zeros((d + 1, d + 1))]])
