"""Lagrange bases on given points of a step: their conditioning, and the step that they define.

A basis has n polynomials of degree n - 1 on points t_0 = 0 < ... < t_{n-1} = 1. The first row of
the matrix A of H (2.6)-(2.8) at h = 1 is that of the initial value; the others are the Gram matrix
of slopes without the row of the last function.
"""

from __future__ import annotations

from fractions import Fraction
from typing import Any

import numpy as np

from benchmarks.claims.kit import Array
from benchmarks.measures.independent_space import all_of_degree, gauss_points, slopes, values

SAMPLES = 4001  # times over which a Lebesgue constant is the maximum


def chebyshev_points(n: int) -> Array:
    """H's n points, the extrema of Chebyshev's polynomial, from 0 to 1."""
    return np.asarray(0.5 * (1.0 - np.cos(np.pi * np.arange(n) / (n - 1))))


def equispaced_points(n: int) -> Array:
    """n equispaced points from 0 to 1."""
    return np.linspace(0.0, 1.0, n)


def condition(points: Array) -> float:
    """The condition |A| |A^-1| in the infinity norm, in double precision from Legendre series."""
    n = len(points)
    t, b = gauss_points(n)
    du = slopes(np.asarray(np.linalg.inv(values(all_of_degree(n - 1), points))), t)
    A = np.vstack([np.eye(1, n), ((du * b) @ du.T)[:-1]])
    return float(np.linalg.norm(A, np.inf) * np.linalg.norm(np.linalg.inv(A), np.inf))


def lebesgue(points: Array) -> float:
    """The Lebesgue constant: the largest sum of |l_i(t)| over SAMPLES times in [0, 1], by
    barycentric weights."""
    differences = points[:, None] - points
    np.fill_diagonal(differences, 1.0)
    middle = np.setdiff1d(np.linspace(0.0, 1.0, SAMPLES), points)
    parts = 1.0 / np.prod(differences, axis=1) / (middle[:, None] - points)
    return float(np.max(np.sum(abs(parts), axis=1) / abs(np.sum(parts, axis=1))))


# The functions below use rational arithmetic, arrays of Fractions; points are exact numbers.


def exact_condition(points: Array) -> float:
    """As `condition`, from monomials in rational arithmetic, with a single rounding."""
    A = np.vstack([np.eye(1, len(points), dtype=int), grams(points)[0][:-1]])
    norm, of_inverse = (np.max(np.sum(abs(matrix), axis=1)) for matrix in (A, inverse(A)))
    return float(norm * of_inverse)


def oscillator_step(points: Array, h: Fraction) -> Any:
    """The matrix (q0, p0) -> (q1, p1) of a step of q'' = -q with exact integrals, as Fractions.

    H (2.3), (2.4): sum_l (K_il / h - h M_il) q_l is -p0 for i = 0, p1 for the last i, else 0.
    """
    stiffness, mass = grams(points)
    rows = stiffness / h - h * mass
    of_p0 = np.eye(len(points) - 1, 1, dtype=int)
    inner = -inverse(rows[:-1, 1:]) @ np.hstack([rows[:-1, :1], of_p0])
    q = np.vstack([[1, 0], inner])
    return np.vstack([q[-1], rows[-1] @ q])


def grams(points: Array) -> tuple[Any, Any]:
    """The Gram matrices of slopes and of values of Lagrange's polynomials on [0, 1]."""
    n = len(points)
    basis = inverse(np.array([[Fraction(t) ** k for k in range(n)] for t in points.tolist()]))
    of_values = np.array([[Fraction(1, i + k + 1) for k in range(n)] for i in range(n)])
    of_slopes = np.array([[Fraction(i * k, max(i + k - 1, 1)) for k in range(n)] for i in range(n)])
    return basis.T @ of_slopes @ basis, basis.T @ of_values @ basis


def inverse(matrix: Any) -> Any:
    """The inverse of a matrix of Fractions, by elimination."""
    n = len(matrix)
    rows = np.hstack([matrix * Fraction(1), np.eye(n, dtype=int)])
    for k in range(n):
        pivot = k + np.flatnonzero(rows[k:, k])[0]
        rows[[k, pivot]] = rows[[pivot, k]]
        rows[k] = rows[k] / rows[k, k]
        other_rows = np.arange(n) != k
        rows[other_rows] = rows[other_rows] - np.outer(rows[other_rows, k], rows[k])
    return rows[:, n:]
