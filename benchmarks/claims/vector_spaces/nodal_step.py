"""Lagrange bases on given points of a step: their conditioning, and the step that they induce.

A basis of n polynomials of degree n - 1 on points t_0 = 0 < ... < t_{n-1} = 1. The matrix A of H
(2.6)-(2.8) at h = 1 has the initial value as its first row, and below it the Gram matrix of slopes
without the row of the last function.
"""

from __future__ import annotations

from fractions import Fraction

from benchmarks.claims.kit import *
from benchmarks.measures.independent_space import all_of_degree, gauss_points, slopes, values

SAMPLES = 4001  # times at which a Lebesgue constant is looked for


def chebyshev_points(n: int) -> Array:
    """H's points, from 0 to 1."""
    return np.asarray(0.5 * (1.0 - np.cos(np.pi * np.arange(n) / (n - 1))))


def equispaced_points(n: int) -> Array:
    """From 0 to 1."""
    return np.linspace(0.0, 1.0, n)


def condition(points: Array) -> float:
    """|A| |A^-1| in the norm of the largest row sum, in double precision from Legendre series."""
    n = len(points)
    basis = np.linalg.inv(values(all_of_degree(n - 1), points)).copy()
    t, b = gauss_points(n)
    du = slopes(basis, t)
    A = np.vstack([np.eye(1, n), ((du * b) @ du.T)[:-1]])
    return float(np.linalg.norm(A, np.inf) * np.linalg.norm(np.linalg.inv(A), np.inf))


def lebesgue(points: Array) -> float:
    """The largest sum of |l_i(t)| over t in [0, 1], by barycentric weights."""
    apart = points[:, None] - points
    np.fill_diagonal(apart, 1.0)
    weights = 1.0 / np.prod(apart, axis=1)
    middle = np.setdiff1d(np.linspace(0.0, 1.0, SAMPLES), points)
    parts = weights / (middle[:, None] - points)
    return float(np.max(np.sum(abs(parts), axis=1) / abs(np.sum(parts, axis=1))))


def exact_condition(points: Array) -> float:
    """The same as `condition`, in rational arithmetic from monomials, rounded once."""
    stiff, _ = _grams(points)
    n = len(points)
    A = [[Fraction(int(k == 0)) for k in range(n)], *stiff[:-1]]
    units = [[Fraction(int(i == k)) for i in range(n)] for k in range(n)]
    inverse = list(zip(*(_solved(A, unit) for unit in units), strict=True))
    return float(_row_sum(A) * _row_sum(inverse))


def oscillator_step(points: Array, h: Fraction) -> list[list[Fraction]]:
    """The matrix (q0, p0) -> (q1, p1) of a step of q'' = -q with exact integrals, not rounded.

    H (2.3), (2.4): sum_l (K_il / h - h M_il) q_l is -p0 for i = 0, p1 for the last i, else 0.
    """
    stiff, mass = _grams(points)
    last = len(points) - 1
    rows = [
        [k / h - h * m for k, m in zip(*pair, strict=True)]
        for pair in zip(stiff, mass, strict=True)
    ]
    inner = [row[1:] for row in rows[:last]]
    columns = []
    for q0, p0 in ((Fraction(1), Fraction(0)), (Fraction(0), Fraction(1))):
        right = [-row[0] * q0 - (p0 if i == 0 else 0) for i, row in enumerate(rows[:last])]
        q = [q0, *_solved(inner, right)]
        columns.append([q[-1], _dot(rows[last], q)])
    return [list(row) for row in zip(*columns, strict=True)]


def _grams(points: Array) -> tuple[list[list[Fraction]], list[list[Fraction]]]:
    """Gram matrices of slopes and of values on [0, 1]; points are taken as exact numbers."""
    basis = [_lagrange(points, i) for i in range(len(points))]
    slopes_of = [[k * c for k, c in enumerate(p)][1:] for p in basis]
    return _gram(slopes_of), _gram(basis)


def _lagrange(points: Array, i: int) -> list[Fraction]:
    """Coefficients of l_i by powers of t."""
    here, product = Fraction(float(points[i])), [Fraction(1)]
    for t in (Fraction(float(x)) for k, x in enumerate(points) if k != i):
        up, down = [Fraction(0), *product], [*product, Fraction(0)]
        product = [(a - t * b) / (here - t) for a, b in zip(up, down, strict=True)]
    return product


def _gram(polynomials: Sequence[Sequence[Fraction]]) -> list[list[Fraction]]:
    """Integrals of the products over [0, 1]."""
    n = len(polynomials[0])
    moments = [[Fraction(1, i + k + 1) for k in range(n)] for i in range(n)]
    against = [[_dot(row, p) for row in moments] for p in polynomials]
    return [[_dot(p, r) for r in against] for p in polynomials]


def _solved(matrix: Sequence[Sequence[Fraction]], right: Sequence[Fraction]) -> list[Fraction]:
    """The solution of a regular system, by elimination."""
    rows = [[*row, r] for row, r in zip(matrix, right, strict=True)]
    n = len(rows)
    for k in range(n):
        pivot = next(i for i in range(k, n) if rows[i][k])
        rows[k], rows[pivot] = rows[pivot], rows[k]
        rows[k] = [x / rows[k][k] for x in rows[k]]
        for i in range(n):
            if i != k and rows[i][k]:
                rows[i] = [x - rows[i][k] * y for x, y in zip(rows[i], rows[k], strict=True)]
    return [row[n] for row in rows]


def _dot(a: Iterable[Fraction], b: Iterable[Fraction]) -> Fraction:
    return sum((x * y for x, y in zip(a, b, strict=True)), Fraction(0))


def _row_sum(matrix: Iterable[Sequence[Fraction]]) -> Fraction:
    return max(sum((abs(x) for x in row), Fraction(0)) for row in matrix)
