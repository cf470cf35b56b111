"""H's Galerkin Noether map on Kepler's problem with GM = 1: of a curve, and of exact motions.

I_d(q, q_k) = -(h sum_j b_j (L_q phi_1 + L_v phi_1')) . a(q_k), phi_1(0) = 1, phi_1(h) = 0 (H lemma
2.3.3), for rotations, a(q) = (-q_y, q_x). Functions are rows of `independent_space`.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from decimal import Decimal
from functools import cached_property
from typing import Any

import numpy as np
from numpy.polynomial import legendre

from benchmarks.claims.kit import Array, Problem, Trajectory
from benchmarks.measures.boundary_motion import BoundaryValueMotion
from benchmarks.measures.independent_space import gauss_points, slopes, values
from references.closed_forms.double_double import DoubleDouble
from references.closed_forms.kepler import KEPLER, flow, orbit

CURVE, LOCAL = "curve", "local motion"
FINE_POINTS = 60  # points of the rule that stands for the integral; 40 give the same to 1e-15

Motion = Callable[[Array], tuple[Array, Array]]  # t (k,) to q and q', (k, 2) each


def generator(q: Array) -> Array:
    """The generator a(q) of rotations, (..., 2)."""
    return np.stack([-q[..., 1], q[..., 0]], axis=-1)


def force(q: Array) -> Array:
    """The force L_q = -q / |q|^3, (..., 2)."""
    return np.asarray(-q / np.linalg.norm(q, axis=-1, keepdims=True) ** 3)


def exact_motion(q0: Array, v0: Array) -> Motion:
    """The motion on the ellipse through (q0, v0), from double-double arithmetic."""
    ellipse: Any = orbit(Decimal(1), *([Decimal(x) for x in y.tolist()] for y in (q0, v0)))
    position, velocity = (DoubleDouble(x, np.zeros_like(x)) for x in (q0, v0))

    def at(t: Array) -> tuple[Array, Array]:
        q, v = flow(ellipse, position, velocity, t)
        return q.hi, v.hi

    return at


def momentum(at: tuple[Array, Array], phi: Array, h: float) -> Array:
    """-h sum_j b_j (L_q phi + L_v phi'), (2,); `at` is (q, q') at the points of Gauss's rule."""
    q, v = at
    s, b = gauss_points(len(q))
    weak = force(q) * values(phi[None], s)[0][:, None] + v * slopes(phi[None], s)[0][:, None] / h
    return np.asarray(-h * (b @ weak))


@dataclass(frozen=True, eq=False)
class Step:
    """A step and the exact motion between the same two points.

    Attributes
    ----------
    run
        a run of one step
    points
        number of points of its Gauss rule
    exact
        the exact motion, with samples at the points of the fine rule
    """

    run: Trajectory
    points: int
    exact: Trajectory

    @property
    def h(self) -> float:
        return float(self.run.t[1] - self.run.t[0])

    @property
    def a(self) -> Array:
        """a(q_k)."""
        return generator(self.run.q[0])

    @cached_property
    def motions(self) -> dict[str, Motion]:
        """The Galerkin curve, and the exact motion between q_k and q_(k + 1)."""
        exact = exact_motion(self.exact.q[0], self.exact.p[0])
        return {CURVE: lambda t: (self.run(t), self.run.velocity(t)), LOCAL: exact}

    @cached_property
    def samples(self) -> dict[tuple[str, int], tuple[Array, Array]]:
        """(motion, number of points) -> q and q' of that motion at the points of that rule."""
        return {
            (name, points): motion(self.h * gauss_points(points)[0])
            for name, motion in self.motions.items()
            for points in (self.points, FINE_POINTS)
        }

    def noether(self, name: str, phi: Array) -> float:
        """The Noether map I_d of the CURVE or the LOCAL motion."""
        return float(momentum(self.samples[name, self.points], phi, self.h) @ self.a)

    def rule_error(self, name: str, phi: Array) -> Array:
        """The error e_q of the rule for the integral of L_q phi + L_v phi', (2,)."""
        few, many = (self.samples[name, points] for points in (self.points, FINE_POINTS))
        return momentum(many, phi, self.h) - momentum(few, phi, self.h)

    @cached_property
    def norms(self) -> dict[str, float]:
        """Norms of curve minus exact motion: L^1 and L^infinity of q and q', L^infinity of q''.

        L^infinity norms are maxima over samples, and so at most the true norms.
        """
        t, weights = self.exact.t, self.h * gauss_points(FINE_POINTS)[1]
        of_curve, of_motion = self.samples[CURVE, FINE_POINTS], self.samples[LOCAL, FINE_POINTS]
        distance, rate = (
            np.linalg.norm(x - y, axis=1) for x, y in zip(of_curve, of_motion, strict=True)
        )
        q, v = self.motions[CURVE](t)
        gaps = {
            "q": q - self.exact.q,
            "q'": v - self.exact.p,
            "q''": self._bend(t) - force(self.exact.q),
        }
        largest = {name: np.max(np.linalg.norm(gap, axis=1)) for name, gap in gaps.items()}
        return {"q in L^1": weights @ distance, "q' in L^1": weights @ rate, **largest}

    def _bend(self, t: Array) -> Array:
        """q'' of the curve, from its values."""
        x, _ = gauss_points(self.run.method.space.dimension)
        series = legendre.legfit(2.0 * x - 1.0, self.run(self.h * x), len(x) - 1)
        second = legendre.legder(series, 2) * (2.0 / self.h) ** 2
        return np.asarray(legendre.legval(2.0 * t / self.h - 1.0, second).T)

    @property
    def lipschitz(self) -> float:
        """A bound L_1 on |V''| = 2 / r^3 on all segments between curve and motion."""
        least_radius = np.min(np.linalg.norm(self.exact.q, axis=1)) - self.norms["q"]
        return float(2.0 / least_radius**3) if least_radius > 0.0 else math.inf

    def right_side(self, phi: Array) -> tuple[float, float]:
        """H's C = max(L_1 + L_3, 2 L_2) |phi_1| + 1, with L_2 = m = 1 and the L_3 = L_1 of motions,
        on which d/dt L_v = L_q; and the norms on the right of lemma 2.3.3."""
        largest = float(np.max(abs(values(phi[None], np.linspace(0.0, 1.0, 201)))))
        size = sum(self.norms[name] for name in ("q in L^1", "q' in L^1", "q", "q'"))
        return 2.0 * max(self.lipschitz, 1.0) * largest + 1.0, size


def step_of(problem: Problem, run: Trajectory, points: int) -> Step | None:
    """The step with its exact motion; None for a failed run, or if that motion is not found."""
    if not run.success:
        return None
    motions = BoundaryValueMotion(problem, float(run.t[1] - run.t[0]), KEPLER)
    exact = motions.arriving_at(run.q[1])
    return None if exact is None else Step(run, points, exact)
