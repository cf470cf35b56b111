"""Galerkin steps of a plane pendulum whose kinetic and potential parts have rules of their own.

From numpy alone: polynomials of degree s for the angle, q(t) = q0 + psi(t) x, psi the Legendre
polynomials of degree 1 to s less their values at 0. Stationary x of

    sum_j b_j |q'(c_j)|^2 / 2  -  sum_k B_k V(q(C_k)),   V = -cos q.
"""

from __future__ import annotations

from numpy.polynomial import legendre

from benchmarks.claims.kit import *
from benchmarks.measures.independent_space import all_of_degree, slopes, values

Rule = tuple[Array, Array]
PASSES = 200
ENOUGH = 2e-16


def clenshaw_curtis_points(n: int) -> Rule:
    """Nodes and weights of the interpolatory rule on n extrema of Chebyshev's polynomial, n > 1."""
    t = 0.5 * (1.0 - np.cos(np.pi * np.arange(n) / (n - 1)))
    return t, np.linalg.solve(legendre.legvander(2.0 * t - 1.0, n - 1).T, np.eye(n)[0])


@dataclass(frozen=True)
class PlanePendulum:
    """Steps with polynomials of this degree; kinetic and potential (nodes, weights) on [0, 1]."""

    degree: int
    kinetic: Rule
    potential: Rule

    def run(self, q: float, p: float, step: float, steps: int) -> tuple[float, float]:
        """(q, p) after `steps` steps from (q, p); NaN where passes do not converge."""
        functions = all_of_degree(self.degree)[1:]
        t, b = self.kinetic
        du = slopes(functions, t)
        stiff = (du * b) @ du.T
        start = values(functions, np.zeros(1))
        psi, end = ((values(functions, s) - start).T for s in (self.potential[0], np.ones(1)))
        weights = self.potential[1]
        onto = np.linalg.solve(stiff, (end - psi).T * weights)  # of forces, over step^2
        along = np.linalg.solve(stiff, end[0])  # of the momentum, over step
        for _ in range(steps):
            x, change = step * p * along, np.inf
            for _ in range(PASSES):
                force = -np.sin(q + psi @ x)
                after = step * p * along + step**2 * (onto @ force)
                change, x = float(np.max(abs(after - x))), after
                if change <= ENOUGH:
                    break
            else:
                return float("nan"), float("nan")
            p += step * float(weights @ -np.sin(q + psi @ x))
            q += float(end[0] @ x)
        return q, p
