"""Correct integrators of somebody else's, compiled and independent of galvi's: compositions of
leapfrog, Runge and Kutta's method, Gauss's collocation by iteration, and SciPy's DOP853."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numba import njit
from scipy.integrate import solve_ivp

import galvi

KEPLER, SPRING, DRIVEN, PENDULUM, STAR, BODIES = range(6)
KINDS = {
    "kepler": KEPLER, "harmonic": SPRING, "driven": DRIVEN, "planar pendulum": PENDULUM,
    "henon": STAR,
}  # fmt: skip
# Composition of leapfrog: Yoshida, Phys. Lett. A 150 (1990) 262; of order 6 his solution A, of
# order 8 the triple jump.
SIX = (0.784513610477560, 0.235573213359357, -1.17767998417887)


def triple_jump(order: int) -> list[float]:
    """Steps of leapfrog that make one of this order."""
    if order == 2:
        return [1.0]
    inner = triple_jump(order - 2)
    outside = 1.0 / (2.0 - 2.0 ** (1.0 / (order - 1)))
    return [w * x for w in (outside, 1.0 - 2.0 * outside, outside) for x in inner]


@njit(cache=True)
def acceleration(kind, masses, q, t, out):
    """Accelerations (n, d) of all bodies, those of one point as of one body."""
    out[:] = 0.0
    if kind == STAR:
        x, y = q[0]
        out[0, 0], out[0, 1] = -x - 2.0 * x * y, -y - x * x + y * y
    elif kind == BODIES:
        for i in range(len(masses)):
            for j in range(i):
                pull(q[i], q[j], masses[j], out[i])
                pull(q[j], q[i], masses[i], out[j])
    elif kind == KEPLER:
        pull(q[0], np.zeros(q.shape[1]), 1.0, out[0])
    elif kind == PENDULUM:
        out[0, 0] = -math.sin(q[0, 0])
    else:
        for k in range(q.shape[1]):
            out[0, k] = -q[0, k]
        if kind == DRIVEN:
            out[0, 0] += math.sin(1.5 * t) - q[0, 0] ** 3


@njit(cache=True)
def pull(q, other, mass, out):
    """out <- out + acceleration of the body at q by that at other."""
    square = 0.0
    for k in range(len(q)):
        square += (other[k] - q[k]) ** 2
    for k in range(len(q)):
        out[k] += mass * (other[k] - q[k]) / (square * math.sqrt(square))


@njit(cache=True)
def move(q, v, h):
    """q <- q + h v."""
    for i in range(q.shape[0]):
        for k in range(q.shape[1]):
            q[i, k] += h * v[i, k]


@njit(cache=True)
def composed(kind, masses, q, v, t0, h, steps, every, weights, saved):
    q, v, a = q.copy(), v.copy(), np.empty_like(q)
    for k in range(steps):
        t = t0 + k * h
        for w in weights:
            move(q, v, 0.5 * w * h)
            t += 0.5 * w * h
            acceleration(kind, masses, q, t, a)
            move(v, a, w * h)
            move(q, v, 0.5 * w * h)
            t += 0.5 * w * h
        if (k + 1) % every == 0:
            saved[0, (k + 1) // every], saved[1, (k + 1) // every] = q, v


@njit(cache=True)
def implicit(kind, masses, q, v, t0, h, steps, every, table, saved):
    """A Runge-Kutta method, its stages by iteration, of which one of an explicit method ends."""
    A, b, c = table
    stages = len(b)
    force, speed = np.zeros((stages, *q.shape)), np.zeros((stages, *q.shape))
    for k in range(steps):
        t = t0 + k * h
        for i in range(stages):
            acceleration(kind, masses, q, t + c[i] * h, force[i])
            speed[i] = v
        before = np.inf
        for _ in range(100):
            moved = 0.0
            for i in range(stages):
                place, fast = np.zeros_like(q), np.zeros_like(q)
                for j in range(stages):
                    place += A[i, j] * speed[j]
                    fast += A[i, j] * force[j]
                fast = v + h * fast
                moved = max(moved, np.max(np.abs(fast - speed[i])))
                speed[i] = fast
                acceleration(kind, masses, q + h * place, t + c[i] * h, force[i])
            if moved == 0.0 or (moved < 1e-12 and moved >= before):
                break
            before = moved
        for i in range(stages):
            q = q + h * b[i] * speed[i]
            v = v + h * b[i] * force[i]
        if (k + 1) % every == 0:
            saved[0, (k + 1) // every], saved[1, (k + 1) // every] = q, v


def gauss(stages: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """A, b and c of Gauss's collocation."""
    x, w = np.polynomial.legendre.leggauss(stages)
    c, powers = (x + 1.0) / 2.0, np.arange(stages)
    moments = c[:, None] ** (powers + 1) / (powers + 1)
    return moments @ np.linalg.inv(c[:, None] ** powers), w / 2.0, c


RUNGE_KUTTA = (
    np.array([[0.0, 0, 0, 0], [0.5, 0, 0, 0], [0, 0.5, 0, 0], [0, 0, 1.0, 0]]),
    np.array([1.0, 2.0, 2.0, 1.0]) / 6.0,
    np.array([0.0, 0.5, 0.5, 1.0]),
)


class Compiled:
    """Of this order, with settings of duration / n; points and bodies without external forces."""

    def __init__(
        self, name: str, order: float, symplectic: bool, numbers: Any, weights: Any = (),
        table: Any = (),
    ) -> None:  # fmt: skip
        self.name, self.order, self.numbers = name, order, numbers
        self.weights, self.table = np.array(weights), table
        self.conserves: dict[str, float] = {}
        if symplectic:
            self.conserves = {"energy": 0.1, "angular momentum": 1e-10}

    def supports(self, problem: galvi.Problem) -> bool:
        return isinstance(problem.system, galvi.Canonical | galvi.NBody)

    def settings(self, problem: galvi.Problem, duration: float) -> list[dict[str, Any]]:
        return [{"step": duration / n, "save_every": n} for n in self.numbers]

    def run(self, problem: galvi.Problem, duration: float, setting: Any) -> galvi.Trajectory:
        h, every = setting["step"], setting["save_every"]
        steps = round(duration / h)
        bodies = isinstance(problem.system, galvi.NBody)
        kind = BODIES if bodies else KINDS[next(x for x in KINDS if problem.name.startswith(x))]
        masses = problem.system.masses * problem.system.G if bodies else np.ones(1)
        shape = problem.q0.shape if bodies else (1, problem.q0.size)
        q, v = (np.array(x).reshape(shape) for x in (problem.q0, problem.v0))
        saved = np.empty((2, steps // every + 1, *shape))
        saved[:, 0] = q, v
        parts = kind, np.array(masses), q, v, problem.t0, h, steps, every
        if len(self.weights):
            composed(*parts, self.weights, saved)
        else:
            implicit(*parts, self.table, saved)
        q, v = saved.reshape((2, -1, *problem.q0.shape))
        t = problem.t0 + h * every * np.arange(len(q))
        return galvi.Trajectory(problem, t, q, problem.system.momentum(v), counts={"steps": steps})


FOUR = triple_jump(4)
OUTSIDE = (*SIX, 1.0 - 2.0 * sum(SIX), *SIX[::-1])
METHODS: dict[str, dict[str, Any]] = {
    "leapfrog": {"order": 2, "symplectic": True, "weights": [1.0]},
    "Yoshida 4": {"order": 4, "symplectic": True, "weights": FOUR},
    "Yoshida 6": {"order": 6, "symplectic": True, "weights": OUTSIDE},
    "Yoshida 8": {"order": 8, "symplectic": True, "weights": triple_jump(8)},
    "Runge-Kutta 4": {"order": 4, "symplectic": False, "table": RUNGE_KUTTA},
    **{
        f"Gauss {2 * s}": {"order": 2 * s, "symplectic": True, "table": gauss(s)}
        for s in (1, 2, 3, 4)
    },
}
SETTINGS = {
    "10 times coarser": (100, 400, 1600), "of the page": (1000, 4000, 16000),
    "10 times finer": (10_000, 40_000, 160_000),
}  # fmt: skip


class Adaptive:
    """DOP853 as on the page, with these tolerances."""

    name, order, tolerances = "DOP853", 8, (6, 9, 12)

    def supports(self, problem: galvi.Problem) -> bool:
        return type(problem.system) is galvi.Canonical and problem.system.force is None

    def settings(self, problem: galvi.Problem, duration: float) -> list[dict[str, Any]]:
        return [{"tolerance": 10.0**-k} for k in self.tolerances]

    def run(self, problem: galvi.Problem, duration: float, setting: Any) -> galvi.Trajectory:
        d, times = problem.q0.size, np.linspace(0.0, duration, setting["samples"] + 1)

        def rates(t: float, y: np.ndarray) -> np.ndarray:
            return np.append(y[d:], problem.system.acceleration(y[:d], problem.t0 + t))

        tolerance = setting["tolerance"]
        start = np.append(problem.q0, problem.v0)
        solved = solve_ivp(
            rates, (0.0, duration), start, "DOP853", times, rtol=tolerance, atol=tolerance
        )
        q, v = solved.y.T[:, :d], solved.y.T[:, d:]
        return galvi.Trajectory(problem, problem.t0 + times, q, problem.system.momentum(v))
