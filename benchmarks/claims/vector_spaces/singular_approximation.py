"""Best polynomials for motions with u'' ~ |t - t*|^-b, in closed form and by quadrature.

M (section 2): |u|_X^2 = int |u'|^2 dt + |u(h)|^2 / h on a subinterval of length h. The best
polynomial of degree N has u's value at the end, and as derivative the orthogonal projection of u'
on degree N - 1, so that the error is that of Legendre's series of u' in L^2.

With X in [-1, 1], y the place of the singularity there, and a > -1 (Bateman's integral),
z = (1 - y) / 2,

    int_y^1 (X - y)^a P_k(X) dX = 2^(a+1) z^(a+1) / (a + 1) F(-k, k + 1; a + 2; z),

where F = k! / (a + 2)_k P_k^(a+1, -a-1)(y) is a Jacobi polynomial.
"""

from __future__ import annotations

from functools import lru_cache

from numpy.polynomial.legendre import legvander
from scipy.special import eval_jacobi, gammaln

from benchmarks.claims.kit import *
from benchmarks.measures.best_approximation import Motion
from benchmarks.measures.independent_space import gauss_points

LEAST = 1e-9
GRADE = 4  # nodes at t* + L s^4 make powers of |t - t*| smoother in s


def closed_errors(
    place: float, b: float, start: float, stop: float, degrees: Sequence[int]
) -> Array:
    """inf |u - v|_X over polynomials v of each degree on [start, stop], for u'' = |t - t*|^-b.

    place  t*, in this interval, where u' = 0

    |u'|^2 less the squares of its Legendre coefficients. NaN where this difference, of which about
    1e-15 of |u'|^2 is rounding, is below LEAST of it.
    """
    power = 1.0 - b
    half, y = 0.5 * (stop - start), (2.0 * place - start - stop) / (stop - start)
    k = np.arange(max(degrees))
    sides = _side(k, power, y) - (-1.0) ** k * _side(k, power, -y)
    squares = half * (k + 0.5) * (half**power / power * sides) ** 2
    twice = 2.0 * power + 1.0
    whole = ((stop - place) ** twice + (place - start) ** twice) / (twice * power**2)
    left = whole - np.cumsum(squares)[np.asarray(degrees) - 1]
    return np.sqrt(np.where(left > LEAST * whole, left, np.nan))


def _side(k: Array, a: float, y: float) -> Array:
    """int_y^1 (X - y)^a P_k(X) dX."""
    z = 0.5 * (1.0 - y)
    if z == 0.0:
        return np.zeros(len(k))
    scale = np.exp(gammaln(k + 1.0) + gammaln(a + 2.0) - gammaln(k + a + 2.0))
    return np.asarray(
        (2.0 * z) ** (a + 1.0) / (a + 1.0) * scale * eval_jacobi(k, a + 1.0, -a - 1.0, y)
    )


def quadrature_error(motion: Motion, place: float, start: float, stop: float, degree: int) -> float:
    """The same of one degree and any motion, by projection in quadrature graded towards t*."""
    t, w = graded_nodes(place, start, stop, GRADE * degree + 60)
    slope, h = motion(t)[1], stop - start
    P = legvander(2.0 * (t - start) / h - 1.0, degree - 1)
    scale = (2.0 * np.arange(degree) + 1.0) / h
    for _ in range(2):  # the second pass removes the rounding errors of the first
        slope = slope - P @ (scale * (P.T @ (w * slope)))
    return float(np.sqrt(np.sum(w * slope**2)))


def path_error(run: Trajectory, motion: Motion, place: float) -> float:
    """|u - u_N|_X of the first step of a run."""
    start, stop = float(run.t[0]), float(run.t[1])
    t, w = graded_nodes(place, start, stop, 40)
    gap = motion(t)[1] - run.velocity(t)[:, 0]
    end = float(motion(run.t[1:2])[0][0]) - run.q[1, 0]
    return float(np.sqrt(np.sum(w * gap**2) + end**2 / (stop - start)))


def graded_nodes(place: float, start: float, stop: float, points: int) -> tuple[Array, Array]:
    """Nodes and weights on [start, stop], graded towards t* where it is inside or at an end."""
    s, b = _gauss(points)
    if not start <= place <= stop:
        return start + (stop - start) * s, (stop - start) * b
    grown, weights = s**GRADE, GRADE * s ** (GRADE - 1) * b
    parts = [end - place for end in (start, stop) if end != place]
    t = np.concatenate([place + length * grown for length in parts])
    return t, np.concatenate([abs(length) * weights for length in parts])


@lru_cache(maxsize=64)
def _gauss(points: int) -> tuple[Array, Array]:
    return gauss_points(points)
