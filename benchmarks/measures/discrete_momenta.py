"""The momenta of a free body at both ends of each step, by differentiating the discrete Lagrangian.

Only the curve R(t) of a run is used, not its momenta: from its values in a
step come xi(tau) = cay^-1(R_k^T R(t_k + tau h)) and its derivative, and from them
L_d = h sum_j b_j w_j . J w_j / 2. By H 3.2.2 the momenta are mu = -D1 L_d and mu1 = D2 L_d, in left
trivialisation. The curve is stationary, so that any variation with the right ends gives these
derivatives; here xi + tau delta. Derivatives are complex steps, exact to round-off.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.polynomial import legendre

from benchmarks.measures import matrix_group
from galvi import SO3, RigidBody, Trajectory
from galvi.arrays import Array

COMPLEX_STEP = 1e-30
ROTATIONS = matrix_group.MatrixGroup(SO3())


def discrete_momenta(run: Trajectory, n: int, stages: int) -> tuple[Array, Array]:
    """-D1 L_d and D2 L_d of every step, both (steps, 3), for n basis functions with Gauss's rule
    of `stages` points in the Cayley chart. TypeError for a run that is not of a free RigidBody."""
    system: Any = run.problem.system
    if not isinstance(system, RigidBody) or system.potential is not None:
        raise TypeError(f"these are formulas for a free RigidBody; received {system!r}.")
    h, steps = float(run.t[1] - run.t[0]), len(run.t) - 1
    nodes = 0.5 * (1.0 - np.cos(np.pi * (np.arange(n) + 0.5) / n))  # inside, so in one step each
    times = run.t[:-1, None] + h * nodes
    relative = np.swapaxes(run.q[:-1], -1, -2)[:, None] @ run(times.ravel()).reshape(steps, n, 3, 3)
    points, weights = legendre.leggauss(stages)
    tau, b = 0.5 * (points + 1.0), 0.5 * weights
    fit = np.linalg.inv(legendre.legvander(2.0 * nodes - 1.0, n - 1))
    xi = inverse_cayley(relative)
    basis, slope = (part @ fit for part in (_values(tau, n), _slopes(tau, n)))
    at_end = _values(np.ones(1), n) @ fit
    momentum = np.zeros((steps, 3))
    for a in range(3):
        delta = COMPLEX_STEP * 1j * np.eye(3)[a]
        varied = basis @ xi + tau[:, None] * delta
        rate = (slope @ xi + delta) / h
        w = body_velocity(varied, rate)
        action = h * np.sum(b * 0.5 * np.sum(w * (w @ system.inertia), axis=-1), axis=-1)
        momentum[:, a] = action.imag / COMPLEX_STEP
    end = (at_end @ xi)[:, 0]
    T = np.stack([body_velocity(end, np.broadcast_to(e, end.shape)) for e in np.eye(3)], axis=-1)
    after = np.linalg.solve(np.swapaxes(T, -1, -2), momentum[..., None])[..., 0]
    # Moving the base by eta with the end fixed rotates the end by -R^T eta relative to the base.
    before = np.einsum("kij,kj->ki", cayley(end), after)
    return before, after


def cayley(xi: Array) -> Array:
    """(I - X/2)^-1 (I + X/2), (..., 3, 3)."""
    return matrix_group.cayley(ROTATIONS.hat(xi))


def inverse_cayley(R: Array) -> Array:
    """xi with X/2 = (R - I)(R + I)^-1, (..., 3)."""
    half = np.swapaxes(
        np.linalg.solve(np.swapaxes(R + np.eye(3), -1, -2), np.swapaxes(R - np.eye(3), -1, -2)),
        -1,
        -2,
    )
    return _vee(2.0 * half)


def body_velocity(xi: Array, rate: Array) -> Array:
    """The axis of R^-1 R', R' = (I - X/2)^-1 (X'/2)(I + R), (..., 3); also for complex xi."""
    R = cayley(xi)
    half, rate = 0.5 * ROTATIONS.hat(xi), 0.5 * ROTATIONS.hat(rate)
    R_rate = np.linalg.solve(np.eye(3) - half, rate @ (np.eye(3) + R))
    return _vee(np.swapaxes(R, -1, -2) @ R_rate)


def _vee(X: Array) -> Array:
    return np.stack([X[..., 2, 1], X[..., 0, 2], X[..., 1, 0]], axis=-1)


def _values(tau: Array, n: int) -> Array:
    return np.asarray(legendre.legvander(2.0 * tau - 1.0, n - 1))


def _slopes(tau: Array, n: int) -> Array:
    columns = [2.0 * legendre.legval(2.0 * tau - 1.0, legendre.legder(e)) for e in np.eye(n)]
    return np.stack(columns, axis=-1)
