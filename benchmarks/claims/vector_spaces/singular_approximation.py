"""Best polynomials for motions with u'' ~ |t - t*|^-b, in closed form and by quadrature.

M (section 2): |u|_X^2 = int |u'|^2 dt + |u(h)|^2 / h on a subinterval of length h. The best
polynomial of degree N equals u at the end, and its derivative is the orthogonal projection of u'
onto degree N - 1, so that the error is that of the Legendre series of u' in L^2.

For X in [-1, 1], the singularity y there, a > -1 and z = (1 - y) / 2 (Bateman's integral),

    int_y^1 (X - y)^a P_k(X) dX = 2^(a+1) z^(a+1) / (a + 1) F(-k, k + 1; a + 2; z),

where F = k! / (a + 2)_k P_k^(a+1, -a-1)(y) is a Jacobi polynomial.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from typing import Any

import numpy as np
from scipy.special import eval_jacobi, gammaln

from benchmarks.claims.kit import Array, Trajectory
from benchmarks.measures.best_approximation import Motion, error_at, residual_norms
from benchmarks.measures.independent_space import gauss_points

gauss_once = lru_cache(maxsize=64)(gauss_points)
RESOLUTION = 1e-9
GRADING_POWER = 4  # nodes at t* + L s^4 make powers of |t - t*| smoother in s


def closed_errors(
    singularity: float, b: float, start: float, stop: float, degrees: Sequence[int]
) -> Array:
    """inf |u - v|_X over polynomials v of each degree on [start, stop], for u'' = |t - t*|^-b.

    Parameters
    ----------
    singularity
        t*, in this interval, where u' = 0

    Notes
    -----
    It is the root of |u'|^2 minus the squares of its Legendre coefficients. NaN if this difference,
    whose rounding error is about 1e-15 |u'|^2, is below RESOLUTION |u'|^2.
    """
    power = 1.0 - b
    half, y = 0.5 * (stop - start), (2.0 * singularity - start - stop) / (stop - start)
    k = np.arange(max(degrees))
    sides = _side(k, power, y) - (-1.0) ** k * _side(k, power, -y)
    squares = half * (k + 0.5) * (half**power / power * sides) ** 2
    exponent = 2.0 * power + 1.0
    total = ((stop - singularity) ** exponent + (singularity - start) ** exponent) / (
        exponent * power**2
    )
    squared_errors = total - np.cumsum(squares)[np.asarray(degrees) - 1]
    return np.sqrt(np.where(squared_errors > RESOLUTION * total, squared_errors, np.nan))


def _side(k: Any, a: float, y: float) -> Array:
    """int_y^1 (X - y)^a P_k(X) dX."""
    scale = np.exp(gammaln(k + 1.0) + gammaln(a + 2.0) - gammaln(k + a + 2.0))
    return np.asarray(
        (1.0 - y) ** (a + 1.0) / (a + 1.0) * scale * eval_jacobi(k, a + 1.0, -a - 1.0, y)
    )


def quadrature_error(
    motion: Motion, singularity: float, start: float, stop: float, degree: int
) -> float:
    """The error of the best polynomial of one degree to any motion, by quadrature that is graded
    towards t*."""
    t, w = graded_nodes(singularity, start, stop, GRADING_POWER * degree + 60)
    return float(
        residual_norms(motion, t[None], w[None], np.array([start]), np.array([stop]), degree)[0]
    )


def path_error(run: Trajectory, motion: Motion, singularity: float) -> float:
    """|u - u_N|_X of the first step of a run."""
    return error_at(run, motion, *graded_nodes(singularity, run.t[0], run.t[1], 40))


def graded_nodes(singularity: float, start: float, stop: float, points: int) -> tuple[Array, Array]:
    """Nodes and weights on [start, stop], graded towards t* if it is inside or at an end."""
    s, b = gauss_once(points)
    if not start <= singularity <= stop:
        return start + (stop - start) * s, (stop - start) * b
    grown, weights = s**GRADING_POWER, GRADING_POWER * s ** (GRADING_POWER - 1) * b
    parts = [end - singularity for end in (start, stop) if end != singularity]
    t = np.concatenate([singularity + length * grown for length in parts])
    return t, np.concatenate([abs(length) * weights for length in parts])
