"""Rotations by scaled charts, and free bodies by H's equations (3.51) with two momentum matchings.

As printed (3.2.2, 3.4.3), D_1 L_d is (3.51) at i = 1 in the chart about R_k, times d xi / d lambda:
the derivative by the first point of the curve while the centre of its chart stays where it is. L_d
is a function of R_k alone, with the centre in R_k: the centre moves with it.
"""

from __future__ import annotations

from typing import ClassVar

from benchmarks.claims.kit import *
from benchmarks.claims.lie_groups.printed_formulas import TINY, change_of_chart, stage_terms
from benchmarks.measures.independent_space import gauss_points
from references.textbook.galerkin import Galerkin, Rotations

PASSES = 30
ENOUGH = 1e-13  # a change of xi, of size 1, below which Newton's method is at round-off


@dataclass(frozen=True)
class ScaledRotations:
    """SO(3) with Phi(s x), for `references.textbook.galerkin.Galerkin`."""

    scale: float
    unscaled: ClassVar[Rotations] = Rotations()

    def place(self, q_k: Array, x: Array) -> Array:
        """R = R_k Phi(s x), (3, 3)."""
        return self.unscaled.place(q_k, self.scale * x)

    def moved(self, q_k: Array, eta: Array) -> Array:
        """The centre turned by an infinitesimal eta about the body's axes."""
        return self.unscaled.moved(q_k, eta)

    def carried(self, x: Array, p: Array) -> Array:
        """Phi(s x) p."""
        return self.unscaled.carried(self.scale * x, p)

    def velocity(self, x: Array, rate: Array) -> Array:
        """The angular velocity in the body, (3,)."""
        return self.unscaled.velocity(self.scale * x, self.scale * rate)

    def tangent(self, x: Array) -> Array:
        """s T(s x), (3, 3)."""
        return self.scale * self.unscaled.tangent(self.scale * x)


class BodySteps:
    """Steps of length h with n basis functions and Gauss's rule of m points.

    printed  whether D_1 L_d is taken as printed
    """

    def __init__(self, moments: Array, n: int, m: int, h: float, printed: bool) -> None:
        c, b = gauss_points(m)
        self.moments, self.h, self.printed = moments, h, printed
        self.table = Galerkin(n, c, b, Rotations())

    def stage_sums(self, x: Array) -> Array:
        """h sum_j b_j (3.51) for every i, (n, 3): the derivatives of the action."""
        values, slopes = self.table.phi, self.table.rates / self.h
        terms = stage_terms(self.moments, values.T @ x, slopes.T @ x, values, slopes)
        return np.asarray(self.h * np.einsum("j,ijk->ik", self.table.b, terms))

    def after(self, x: Array, sums: Array) -> Array:
        """The body's momentum at the end, (3,): D_2 L_d in left trivialisation."""
        return np.asarray(np.linalg.solve(self.table.chart.tangent(x[-1]).T, sums[-1]))

    def matched(self, x: Array, sums: Array, p: Array, first: Array) -> Array:
        """D_2 L_d of the step before plus D_1 L_d of this one, (3,): p the momentum, and first the
        last coordinates, of the step before."""
        chart = self.table.chart
        if self.printed:
            before = chart.tangent(first).T @ p
            return np.asarray(before + sums[0] @ change_of_chart(first, first))
        return np.asarray(p - chart.carried(x[-1], self.after(x, sums)))

    def step(self, p: Array, first: Array) -> Array:
        """x (n, 3) of the step from momentum p by Newton's method; ArithmeticError without one."""
        x = np.outer(self.table.nodes, -0.5 * self.h * p / self.moments)

        def residual(x: Array) -> Array:
            sums = self.stage_sums(x)
            return np.concatenate([sums[1:-1].ravel(), self.matched(x, sums, p, first)])

        for _ in range(PASSES):
            columns = []
            for i in np.ndindex(x[1:].shape):
                moved = x.astype(complex)
                moved[1:][i] += 1j * TINY
                columns.append(residual(moved).imag / TINY)
            change = np.linalg.solve(np.stack(columns, axis=1), residual(x)).reshape(-1, 3)
            x[1:] -= change
            if np.max(np.abs(change)) < ENOUGH:
                return x
        raise ArithmeticError(f"no step of {self.h:g}")

    def run(self, p0: Array, steps: int) -> tuple[Array, Array]:
        """R (steps + 1, 3, 3) from the unit and body momenta (steps + 1, 3)."""
        R, p, first = [np.eye(3)], [p0], np.zeros(3)
        for _ in range(steps):
            x = self.step(p[-1], first)
            p.append(self.after(x, self.stage_sums(x)))
            R.append(self.table.chart.place(R[-1], x[-1]))
            first = x[-1]
        return np.stack(R), np.stack(p)
