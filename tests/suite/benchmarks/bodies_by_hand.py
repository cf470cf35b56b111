"""Runs of rigid bodies without galvi: by Runge and Kutta, and by the Galerkin method by hand."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.polynomial import legendre
from scipy.optimize import fsolve

from benchmarks.measures.discrete_momenta import TINY, body_velocity, cayley
from galvi import Problem
from references.rigid_equations import RigidEquations


@dataclass
class Run:
    """What the claims ask of a trajectory."""

    problem: Problem
    t: Any
    q: Any
    p: Any
    pieces: list[Any] = field(default_factory=list)
    success: bool = True
    status: str = "Completed."

    def __call__(self, t: Any) -> Any:
        h = self.t[1] - self.t[0]
        index = np.clip((t // h).astype(int), 0, len(self.pieces) - 1)
        return np.array([
            self.q[k] @ cayley(trial(s / h - k, len(self.pieces[k])) @ self.pieces[k])
            for k, s in zip(index, t, strict=True)
        ])  # fmt: skip


def runge_kutta(problem: Problem, method: Any, h: float, steps: int, **more: Any) -> Run:
    """The classical one of order four, on the entries of the matrix."""
    equations = RigidEquations(problem, quaternions=False)
    slope, y = equations.slope(), equations.start
    states = [y]
    for k in range(steps):
        t = problem.t0 + k * h
        a = slope(t, y)
        b = slope(t + h / 2, y + h / 2 * a)
        c = slope(t + h / 2, y + h / 2 * b)
        y = y + h / 6 * (a + 2 * b + 2 * c + slope(t + h, y + h * c))
        states.append(y)
    saved = np.array(states)
    times = problem.t0 + h * np.arange(steps + 1)
    return Run(problem, times, equations.attitudes(saved), saved[:, -3:])


def trial(tau: Any, size: int) -> Any:
    """tau P_k(2 tau - 1), k = 0 .. size - 1: what vanishes at 0."""
    return np.asarray(tau)[..., None] * legendre.legvander(2.0 * np.asarray(tau) - 1.0, size - 1)


def variations_at(tau: Any, n: int) -> Any:
    """tau (1 - tau) P_k for n - 2 k's, then 1 - tau and tau, (..., n)."""
    tau = np.asarray(tau)[..., None]
    inner = tau * (1.0 - tau) * legendre.legvander(2.0 * tau[..., 0] - 1.0, n - 3)
    return np.concatenate([inner, 1.0 - tau, tau], axis=-1)


def slope_of(function: Callable[..., Any], tau: Any, size: int) -> Any:
    """By a complex step."""
    return function(tau + TINY * 1j, size).imag / TINY


def by_hand(
    problem: Problem, h: float, steps: int, moving: bool, n: int = 8, stages: int = 8
) -> Run:
    """The free body by n basis functions in Cayley's chart, the momentum at the start of a step

    moving  being -D1 L_d, with the base point of the chart moving along
    else    being -dL_d/dxi(0) at a base point that stays
    """
    J: Any = problem.system.inertia  # type: ignore[attr-defined]
    points, weights = legendre.leggauss(stages)
    tau, b = 0.5 * (points + 1.0), 0.5 * weights
    psi, dpsi = trial(tau, n - 1), slope_of(trial, tau, n - 1)
    along = TINY * 1j * np.eye(3)[:, None, :]  # (3, 1, 3)
    values = variations_at(tau, n).T[:, None, :, None] * along
    slopes = slope_of(variations_at, tau, n).T[:, None, :, None] * along

    def variations(x: Any) -> Any:
        """dL_d along each of the tests, (n, 3)."""
        w = body_velocity(psi @ x + values, (dpsi @ x + slopes) / h)
        return (0.5 * h * np.sum(w * (w @ J), axis=-1) @ b).imag / TINY

    def arrival(x: Any, found: Any) -> tuple[Any, Any]:
        """Phi(xi(1)) and D2 L_d."""
        end = (trial(np.ones(1), n - 1) @ x)[0]
        T = np.stack([body_velocity(end, e) for e in np.eye(3)], axis=-1)
        return cayley(end), np.linalg.solve(T.T, found[-1])

    q, p, pieces = [problem.q0], [problem.p0], []
    x = np.zeros((n - 1, 3))
    x[0] = h * problem.v0
    for _ in range(steps):

        def residual(flat: Any, mu: Any = p[-1]) -> Any:
            found = variations(flat.reshape(n - 1, 3))
            turn, after = arrival(flat.reshape(n - 1, 3), found)
            start = turn @ after - mu if moving else found[-2] + mu
            return np.vstack([found[:-2], start]).ravel()

        x = fsolve(residual, x.ravel(), xtol=1e-8)
        x = polished(residual, x, 2).reshape(n - 1, 3)  # down to round-off
        turn, after = arrival(x, variations(x))
        q.append(q[-1] @ turn)
        p.append(after)
        pieces.append(x)
    times = problem.t0 + h * np.arange(steps + 1)
    return Run(problem, times, np.array(q), np.array(p), pieces)


def polished(residual: Callable[[Any], Any], x: Any, steps: int) -> Any:
    """Steps of Newton's method with the derivative at the start."""
    nudge = 1e-6
    columns = [
        (residual(x + nudge * e) - residual(x - nudge * e)) / (2.0 * nudge) for e in np.eye(x.size)
    ]
    for _ in range(steps):
        x = x - np.linalg.solve(np.stack(columns, axis=1), residual(x))
    return x
