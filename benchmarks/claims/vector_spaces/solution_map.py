"""M's solution maps, exact and discrete: differences of two solutions, and bounds on them.

|u|_X^2 = |u'|^2 + |u(h)|^2 / h; K is the Lipschitz constant of F = grad V - f, m the minimum of mu,
and eta = 3 K h^2 / (m z0^2). d is the difference of two solutions whose data differ by du and dp.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.polynomial import legendre, polynomial
from scipy.integrate import solve_ivp

import galvi
from benchmarks.claims.kit import Array, Problem
from benchmarks.measures.independent_space import (
    farthest,
    friedrichs,
    gauss_points,
    grams,
    inf_sup,
    lobatto_points,
    values,
    z0,
)
from benchmarks.test_problems.oscillators import PENDULUM
from references.scipy.ivp import TIGHT

POINTS = 40  # Gauss points for integrals that stand for exact ones
Motions = Callable[[Array, Array, Array], tuple[Array, Array]]


def nodes(rule: galvi.Rule) -> tuple[Array, Array]:
    """The points and weights of galvi's Gauss or Lobatto rule, by numpy."""
    points = lobatto_points if "Lobatto" in rule.name else gauss_points
    return points(rule.points)


def oscillations(u0: Array, v0: Array, t: Array) -> tuple[Array, Array]:
    """u and u' of u'' = -u from each of the starts (k,), at times t: (k, times)."""
    cosine, sine = np.cos(t), np.sin(t)
    u0, v0 = u0[:, None], v0[:, None]
    return u0 * cosine + v0 * sine, v0 * cosine - u0 * sine


def swings(u0: Array, v0: Array, t: Array) -> tuple[Array, Array]:
    """As `oscillations`, for u'' = -sin u, by DOP853; t increasing."""

    def rates(s: float, y: Array) -> Array:
        u, v = y.reshape(2, -1)
        return np.concatenate([v, -np.sin(u)])

    start = np.concatenate([u0, v0])
    y = solve_ivp(rates, (0.0, t[-1]), start, method="DOP853", t_eval=t, **TIGHT).y
    return y[: len(u0)], y[len(u0) :]


def eta(h: float, constant: float = 1.0) -> float:
    """eta C_N^2 for K = m = 1; C_N is 1 for the exact problem (2)."""
    return 3.0 * (h * constant / z0()) ** 2


def pull(h: float, constant: float) -> float:
    """C_N K h^(3/2) / z0, K = 1."""
    return constant * h**1.5 / z0()


def bounds(h: float, du: Array, dp: Array, constant: float = 1.0) -> tuple[Array, ...]:
    """Bounds on |d|_X, |dp_h| and their sum for K = m = 1, (count,) each.

    The first follows from v = d - d(h) in (2), proposition 1 with m / 3, and |du|_X = |du| /
    sqrt(h); the second from v = 1 and Friedrichs' inequality; the third is their sum in terms of
    |du| + |dp|.
    """
    root, left = math.sqrt(h), 1.0 - eta(h, constant)
    path = (abs(du) / root + 3.0 * root * abs(dp)) / left
    share = (1.0 + pull(h, constant)) / left
    both = max(share / root, 1.0 + 3.0 * share * root) * (abs(du) + abs(dp))
    return path, abs(dp) + pull(h, constant) * path, both


def differences(count: int) -> tuple[Array, ...]:
    """Random data u0, p0 and differences du, dp, (count,) each; the first pair has dp = 0, the
    second du = 0."""
    rng = np.random.default_rng(0)
    u0, p0 = rng.uniform(-2.0, 2.0, (2, count))
    du, dp = rng.normal(size=(2, count)) * 10.0 ** rng.uniform(-3.0, 0.0, count)
    dp[0] = du[1] = 0.0
    return u0, p0, du, dp


def exact_sizes(motions: Motions, h: float, pairs: tuple[Array, ...]) -> tuple[Array, Array]:
    """|d|_X and |dp_h| of exact solutions of mass 1."""
    u0, p0, du, dp = pairs
    s, w = gauss_points(POINTS)
    first, second = (
        np.array(motions(*start, h * np.append(s, 1.0))) for start in ((u0, p0), (u0 + du, p0 + dp))
    )
    gap, rate = second - first
    return np.sqrt(h * rate[:, :-1] ** 2 @ w + gap[:, -1] ** 2 / h), abs(rate[:, -1])


def discrete_sizes(method: Any, h: float, pairs: tuple[Array, ...]) -> tuple[Array, Array]:
    """|d_N|_(X,N) and |dp_h| of the method's steps of the pendulum."""
    (t, b), system, sizes = nodes(method.rule), PENDULUM.problem().system, []
    for u, p, du, dp in zip(*pairs, strict=True):
        first, second = (
            galvi.integrate(Problem(system, np.full(1, u0), np.full(1, p0)), method, h, 1)
            for u0, p0 in ((u, p), (u + du, p + dp))
        )
        rate = (second.velocity(h * t) - first.velocity(h * t))[:, 0]
        gap, last = (float(abs(y[1, 0])) for y in (second.q - first.q, second.p - first.p))
        sizes.append((math.sqrt(h * b @ rate**2 + gap**2 / h), last))
    path, momentum = np.array(sizes).T
    return path, momentum


def opposed(power: int) -> tuple[float, float, float, float]:
    """Constants of the space {1, (1 - t)^k} with the midpoint rule, for mu = h = 1.

    Returns the inf-sup constant; T_N; and, for the V = -K u^2 / 2 that makes (8) singular, with K
    from phi = 1 - (1 - t)^k in closed form, eta C_N^2 and the smallest singular value of (8) in
    (u, p_h) over the largest.
    """
    falling = legendre.poly2leg(polynomial.polypow([0.5, -0.5], power))
    functions = np.stack([np.eye(1, power + 1)[0], falling])
    by_rule, q = grams(functions, *gauss_points(1)), 2.0**-power
    steepness = (2.0 * power * q) ** 2 / (q * (1.0 - q))
    first, last = values(functions, np.array([0.0, 1.0])).T
    weak = np.column_stack([by_rule.slope + steepness * by_rule.values, -last])
    sizes = np.linalg.svd(np.vstack([weak, np.append(first, 0.0)]), compute_uv=False)
    return (
        inf_sup(functions, by_rule),
        farthest(functions, by_rule),
        steepness * eta(1.0, friedrichs(by_rule)),
        float(sizes[-1] / sizes[0]),
    )
