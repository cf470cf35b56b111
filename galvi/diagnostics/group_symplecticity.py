"""Symplecticity of a step on a Lie group, from its derivative in left trivialisation."""

from __future__ import annotations

from typing import cast

import numpy as np

from galvi.arrays import Array
from galvi.charts.exponential import Exponential
from galvi.charts.maps import coordinates, place
from galvi.groups.group import Group
from galvi.method import Galerkin
from galvi.problem import Problem
from galvi.run.group_system import group_system
from galvi.run.integrate import integrate
from galvi.run.interruption import uninterrupted
from galvi.systems.finite_differences import WEIGHTS
from galvi.systems.system import GroupSystem
from galvi.systems.velocities import velocity_at

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
    end = uninterrupted(integrate(problem, method, step, 1))
    DF = group_step_derivative(problem, method, step)
    W0, W1 = (_form(group, mu) for mu in (problem.p0, end.p[-1]))
    scale = max(1.0, np.linalg.norm(DF, 2) ** 2)
    return float(np.max(np.abs(DF.T @ W1 @ DF - W0)) / scale)


def _form(group: Group, mu: Array) -> Array:
    d = group.dimension
    unit = np.eye(d)
    turning = np.array([[mu @ group.bracket(v, w) for w in unit] for v in unit])
    return np.block([[turning, unit], [-unit, np.zeros((d, d))]])
