"""Galerkin steps of a plane pendulum with separate rules for its kinetic and potential parts.

By numpy alone: the angle is a polynomial of degree s, q(t) = q0 + psi(t) x, where psi are the
Legendre polynomials of degrees 1 to s minus their values at 0, and x makes stationary

    sum_j b_j |q'(c_j)|^2 / 2  -  sum_k B_k V(q(C_k)),   V = -cos q.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.polynomial import legendre

from benchmarks.measures.independent_space import all_of_degree, slopes, values
from galvi.arrays import Array

Rule = tuple[Array, Array]


def clenshaw_curtis_points(n: int) -> Rule:
    """Nodes and weights of the interpolatory rule on n extrema of Chebyshev's polynomial, n > 1."""
    t = 0.5 * (1.0 - np.cos(np.pi * np.arange(n) / (n - 1)))
    return t, np.linalg.solve(legendre.legvander(2.0 * t - 1.0, n - 1).T, np.eye(n)[0])


def pendulum_after(
    q: float, p: float, step: float, steps: int, degree: int, kinetic: Rule, potential: Rule
) -> tuple[float, float]:
    """(q, p) after `steps` steps with polynomials of this degree; both rules are (nodes, weights)
    on [0, 1]. NaN if the 200 passes of a step do not converge."""
    functions = all_of_degree(degree)[1:]
    du = slopes(functions, kinetic[0])
    stiff = (du * kinetic[1]) @ du.T
    start = values(functions, np.zeros(1))
    psi, end = ((values(functions, s) - start).T for s in (potential[0], np.ones(1)))
    force_map = np.linalg.solve(stiff, (end - psi).T * potential[1])  # of forces, over step^2
    momentum_map = np.linalg.solve(stiff, end[0])  # of the momentum, over step
    for _ in range(steps):
        x, change, passes = step * p * momentum_map, math.inf, 0
        while change > 2e-16 and passes < 200:
            next_x = step * p * momentum_map + step**2 * (force_map @ -np.sin(q + psi @ x))
            x, change, passes = next_x, float(np.max(abs(next_x - x))), passes + 1
        if change > 2e-16:
            return math.nan, math.nan
        p += step * float(potential[1] @ -np.sin(q + psi @ x))
        q += float(end[0] @ x)
    return q, p
