"""H's formulas of 3.4 for the free body in coordinates, as printed, and their values by matrices.

xi, rate  coordinates of Phi(xi) = (I - X)(I + X)^-1, X = hat(xi), and their time derivatives, (3,)
          or (..., 3), where a, b, c are axes 1, 2, 3; complex ones, too, for derivatives

The free body's steps are by H's equations (3.51) with two momentum matchings. As printed (3.2.2,
3.4.3), D_1 L_d is (3.51) at i = 1 in the chart about R_k, times d xi / d lambda: the derivative by
the first point of the curve while the centre of its chart stays where it is. L_d is a function of
R_k alone, with the centre in R_k: the centre moves with it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import permutations
from typing import Any

import numpy as np

from benchmarks.claims.kit import Array, Problem
from benchmarks.measures.independent_space import gauss_points
from references.textbook.galerkin import Galerkin, Rotations, cayley, hat, vector

MOMENTS, J_D = np.array([3.3, 2.5, 3.4]), np.diag([1.3, 2.1, 1.2])  # J = tr(J_d) I - J_d
AS_PRINTED, IN_ORDER = (2, 1, 0), (0, 1, 2)  # the phi that I_1, I_2, I_3 multiply in (3.50)
MISPRINTED_INDEX = 2  # c, printed for b in the last line of dL_d / dlambda
COMPLEX_STEP = 1e-200
MAX_ITERATIONS = 30
# Change of xi, whose size is about 1, below which Newton's method has converged:
CONVERGED_CHANGE = 1e-13


def phi(xi: Array, rate: Array) -> Array:
    """The array of phi(xi_a, xi_b, xi_c), phi(xi_b, xi_c, xi_a) and phi(xi_c, xi_a, xi_b), (...,
    3)."""
    (a, b, c), (a1, b1, c1) = np.moveaxis(xi, -1, 0), np.moveaxis(rate, -1, 0)
    return np.stack([a1 + b * c1 - c * b1, b1 + c * a1 - a * c1, c1 + a * b1 - b * a1], axis=-1)


def lagrangian(xi: Array, rate: Array, pairs: tuple[int, ...] = IN_ORDER) -> Any:
    """The Lagrangian (3.50) in coordinates, in which I_i multiplies the phi with index pairs[i]."""
    squares = phi(xi, rate)[..., pairs] ** 2
    return 2.0 / (1.0 + np.sum(xi * xi, axis=-1)) ** 2 * np.sum(MOMENTS * squares, axis=-1)


def hat_velocity(xi: Array, rate: Array) -> Any:
    """R^T R' = hat(w), where R (I + X) = I - X, so that R' = -(I + R) X' (I + X)^-1."""
    unit = np.eye(3)
    R: Any = cayley(xi)
    return -R.T @ (unit + R) @ hat(rate) @ np.linalg.inv(unit + hat(xi))


def stage_terms(xi: Array, rate: Array, value: Any, slope: Any) -> Array:
    """The terms of (3.51), before the sum over j, for phi_i = value and phi_i' = slope, (..., 3).

    `value` and `slope` are numbers, or have further leading axes. The text at hand lacks the dots,
    and lines of (3.51b, c); here (3.51a) has its dots, and the others follow by the exchange
    a -> b -> c -> a.
    """
    I, p = MOMENTS, phi(xi, rate)
    size = 1.0 + np.sum(xi * xi, axis=-1)
    terms = []
    for a, b, c in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        shared = -2.0 / size * xi[..., a] * value
        third = I[c] * p[..., c] * (shared * p[..., c] + rate[..., b] * value - xi[..., b] * slope)
        second = I[b] * p[..., b] * (shared * p[..., b] + xi[..., c] * slope - rate[..., c] * value)
        first = I[a] * p[..., a] * (shared * p[..., a] + slope)
        terms.append(4.0 / size**2 * (third + second + first))
    return np.stack(terms, axis=-1)


def composed(first: Any, xi: Any) -> Any:
    """lambda of 3.4.3, for which Phi(lambda) = Phi(xi^0) Phi(xi), (3,)."""
    (a0, b0, c0), (a, b, c) = first, xi
    above = [-a - a0 + c * b0 - b * c0, -b - b0 + a * c0 - c * a0, -c - c0 + b * a0 - a * b0]
    return np.array(above) / (-1.0 + a0 * a + b0 * b + c0 * c)


def relative(first: Any, point: Any) -> Any:
    """xi_k of 3.4.3, for which Phi(xi_k) = Phi(xi^0)^-1 Phi(lambda), (3,)."""
    (a0, b0, c0), (a, b, c) = first, point
    above = [a - a0 + c * b0 - b * c0, b - b0 + a * c0 - c * a0, c - c0 + b * a0 - a * b0]
    return np.array(above) / (1.0 + a * a0 + b * b0 + c * c0)


def inverse_cayley(R: Any) -> Any:
    """xi with R = Phi(xi), (3,): Cayley's transform is its own inverse."""
    return vector((np.eye(3) - R) @ np.linalg.inv(np.eye(3) + R))


def change_of_chart(first: Array, point: Array) -> Array:
    """d xi_k / d lambda of `relative`, (3, 3), by complex steps."""
    return gradient(lambda e: relative(first, point + e)).T


def gradient(function: Callable[[Any], Any]) -> Array:
    """The derivatives of a function of x (3,) at x = 0, (3, ...), by complex steps."""
    return np.array([np.imag(function(1j * COMPLEX_STEP * e)) / COMPLEX_STEP for e in np.eye(3)])


def departures(rng: np.random.Generator) -> dict[str, Any]:
    """Name -> relative departure of a formula from its truth at a random state.

    For (3.50) as printed, there are also the departures with a, b, c as the axes in any order, and
    with either sign ("reading ...").
    """
    xi, first, rate = rng.standard_normal((3, 3)) * [[0.5], [0.5], [1.0]]
    value, change = rng.standard_normal(2)
    point = composed(first, xi)
    turned = inverse_cayley(cayley(first) @ cayley(xi))
    back = inverse_cayley(cayley(first).T @ cayley(turned))
    turning = hat_velocity(xi, rate)
    energy = 0.5 * np.sum(MOMENTS * vector(turning) ** 2)
    trace = np.trace(turning.T @ J_D @ turning)  # tr(R'^T R J_d R^T R')
    terms = stage_terms(xi, rate, value, change)

    def slopes(pairs: tuple[int, ...]) -> Array:
        return gradient(lambda e: lagrangian(xi + value * e, rate + change * e, pairs))

    by_point = gradient(lambda e: lagrangian(relative(first, point + e), rate))
    by_xi = stage_terms(xi, rate, 1.0, 0.0)
    chart = change_of_chart(first, point)
    slip = (by_xi[MISPRINTED_INDEX] - by_xi[1]) * chart[1, 2] * np.eye(3)[2]
    pairs = {
        "Phi(Phi(X)) - X": (inverse_cayley(cayley(xi)), xi),
        "lambda as printed": (point, turned),
        "xi_k as printed": (relative(first, turned), back),
        "(3.32) beside (3.50) in order": (trace, lagrangian(xi, rate)),
        "half of (3.32)": (0.5 * trace, energy),
        "(3.50) as printed": (lagrangian(xi, rate, AS_PRINTED), energy),
        "(3.50) with I_1 at phi_a, I_3 at phi_c": (lagrangian(xi, rate), energy),
        "(3.51) beside the printed (3.50)": (terms, slopes(AS_PRINTED)),
        "(3.51) beside (3.50) in order": (terms, slopes(IN_ORDER)),
        "dL_d / dlambda as printed": (by_xi @ chart + slip, by_point),
        "dL_d / dlambda with b in the last line": (by_xi @ chart, by_point),
    }
    pairs |= {
        f"reading {axes}, {sign:+g}": (
            lagrangian(sign * xi[list(axes)], sign * rate[list(axes)], AS_PRINTED),
            energy,
        )
        for axes in permutations(range(3))
        for sign in (1.0, -1.0)
    }
    return {
        name: np.linalg.norm(np.subtract(*pair)) / np.linalg.norm(pair[1])
        for name, pair in pairs.items()
    }


def lagrangian_of(problem: Problem) -> Callable[[Array, Array], Any]:
    """The Lagrangian w . J w / 2 - V of a rigid body as a function of R and w, analytic in both; V
    is the potential of its weight, if any."""
    system: Any = problem.system
    weight = system.potential

    def value(R: Array, w: Array) -> Any:
        fall = weight.mass * (weight.g @ R @ weight.centre) if weight is not None else 0.0
        return 0.5 * (w @ system.inertia @ w) + fall

    return value


@dataclass(frozen=True)
class ScaledRotations(Rotations):
    """SO(3) in the scaled chart Phi(s x), for `references.textbook.galerkin.Galerkin`."""

    scale: float

    def place(self, q_k: Array, x: Array) -> Array:
        """R = R_k Phi(s x), (3, 3)."""
        return Rotations().place(q_k, self.scale * x)

    def carried(self, x: Array, p: Array) -> Array:
        """Phi(s x) p."""
        return Rotations().carried(self.scale * x, p)

    def velocity(self, x: Array, rate: Array) -> Array:
        """The angular velocity in the body at x with x' = rate, (3,)."""
        return Rotations().velocity(self.scale * x, self.scale * rate)

    def tangent(self, x: Array) -> Array:
        """s T(s x), (3, 3)."""
        return self.scale * Rotations().tangent(self.scale * x)


class BodySteps:
    """Steps of length h with n basis functions and Gauss's rule of m points.

    Parameters
    ----------
    printed
        whether to use D_1 L_d as printed
    """

    def __init__(self, n: int, m: int, h: float, printed: bool) -> None:
        self.h, self.printed = h, printed
        self.table = Galerkin(n, *gauss_points(m), Rotations())

    def stage_sums(self, x: Array) -> Array:
        """The derivatives of the action, h sum_j b_j (3.51) for every i, (n, 3)."""
        values, slopes = self.table.phi, self.table.rates / self.h
        terms = stage_terms(values.T @ x, slopes.T @ x, values, slopes)
        return self.h * np.einsum("j,ijk->ik", self.table.b, terms)

    def after(self, x: Array, sums: Array) -> Array:
        """The body's momentum at the end, (3,): D_2 L_d in left trivialisation."""
        return np.linalg.solve(self.table.chart.tangent(x[-1]).T, sums[-1])

    def matched(self, x: Array, sums: Array, p: Array, first: Array) -> Array:
        """D_2 L_d of the previous step plus D_1 L_d of this one, (3,).

        p is the momentum at the end of the previous step, and `first` its last coordinates.
        """
        chart = self.table.chart
        if self.printed:
            return chart.tangent(first).T @ p + sums[0] @ change_of_chart(first, first)
        return p - chart.carried(x[-1], self.after(x, sums))

    def step(self, p: Array, first: Array) -> Array:
        """x (n, 3) of the step from momentum p, by Newton's method.

        Raises ArithmeticError if that does not converge."""
        x = np.outer(self.table.nodes, -0.5 * self.h * p / MOMENTS)

        def residual(x: Array) -> Array:
            sums = self.stage_sums(x)
            return np.concatenate([sums[1:-1].ravel(), self.matched(x, sums, p, first)])

        units = np.eye(x.size)[3:].reshape(-1, *x.shape)
        for _ in range(MAX_ITERATIONS):
            columns = [residual(x + 1j * COMPLEX_STEP * unit).imag / COMPLEX_STEP for unit in units]
            change = np.linalg.solve(np.stack(columns, axis=1), residual(x)).reshape(-1, 3)
            x[1:] -= change
            if np.max(abs(change)) < CONVERGED_CHANGE:
                return x
        raise ArithmeticError(f"no step of {self.h:g}")

    def momenta(self, p0: Array, steps: int) -> Array:
        """The momenta in space, R p, of steps from R = I and p0, (steps + 1, 3)."""
        R, p, first = [np.eye(3)], [p0], np.zeros(3)
        for _ in range(steps):
            x = self.step(p[-1], first)
            p.append(self.after(x, self.stage_sums(x)))
            R.append(self.table.chart.place(R[-1], x[-1]))
            first = x[-1]
        return np.einsum("kab,kb->ka", np.stack(R), np.stack(p))
