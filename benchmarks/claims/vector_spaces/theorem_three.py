"""The terms of M's theorem 3 for one step of a method from an exact state, by numpy.

|u|_X^2 = |u'|^2 + |u(h)|^2 / h; F = grad V - f, with K, m and M as in M section 2.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.linalg import eigvalsh

import galvi
from benchmarks.claims.kit import Array, Problem
from benchmarks.claims.vector_spaces.solution_map import POINTS, eta, nodes, swings
from benchmarks.measures.best_approximation import step_error
from benchmarks.measures.independent_space import (
    all_of_degree,
    friedrichs,
    gauss_points,
    grams,
    kernels,
    slopes,
    values,
    z0,
)
from benchmarks.test_problems.oscillators import FREQUENCY, GROWING_MASS, GROWTH, PENDULUM

FLOOR = 1e-12  # |u - u_N|_X below which the error is mostly round-off


@dataclass(frozen=True, eq=False)
class Comparison:
    """A motion u whose steps are compared from an exact state.

    Attributes
    ----------
    mass, slope
        t -> mu, and (t, u) -> F
    motion
        t -> (u, u'), for increasing t from t0 on
    problem
        () -> the problem from the exact state at t0
    constants
        h -> K, m, M on [t0, t0 + h]
    """

    name: str
    t0: float
    mass: Callable[[Array], Array]
    slope: Callable[[Array, Array], Array]
    motion: Callable[[Array], tuple[Array, Array]]
    problem: Callable[[], Problem]
    constants: Callable[[float], tuple[float, float, float]] = lambda h: (1.0, 1.0, 1.0)


def _swing(t: Array) -> tuple[Array, Array]:
    u, v = swings(np.ones(1), np.ones(1), np.asarray(t))
    return u[0], v[0]


def _growing(h: float) -> tuple[float, float, float]:
    lightest, heaviest = math.exp(GROWTH), math.exp(GROWTH * (1.0 + h))
    return FREQUENCY**2 * heaviest, lightest, heaviest


COMPARISONS = (
    Comparison(
        "oscillator",
        1.0,
        np.ones_like,
        lambda t, u: u,
        lambda t: (np.cos(t), -np.sin(t)),
        lambda: Problem(
            galvi.problems.harmonic_oscillator().system, np.cos([1.0]), -np.sin([1.0]), 1.0
        ),
    ),
    Comparison("pendulum", 0.0, np.ones_like, lambda t, u: np.sin(u), _swing, PENDULUM.problem),
    Comparison(
        GROWING_MASS.name,
        1.0,
        GROWING_MASS.mass,
        GROWING_MASS.slope,
        GROWING_MASS.motion,
        lambda: GROWING_MASS.problem(1.0),
        _growing,
    ),
)


def dual(functions: Array, energy: Array) -> Array:
    """The matrix onto coordinates whose norm is the dual norm of a functional of z with z(h) = 0:
    its supremum over |z|_X."""
    _, ends = kernels(functions)
    return np.linalg.inv(np.linalg.cholesky(ends.T @ energy @ ends)) @ ends.T


def consistency(case: Comparison, rule: tuple[Array, Array], degree: int, h: float) -> Any:
    """The terms I_2 and Q of theorem 3.

    I_2 is the minimum over v_N in X_N of the root of |u - v_N|_X^2 + (sup_z (a - a_N)(v_N, z) /
    |z|_X)^2, which is at most the printed I, the minimum of the sum of both; Q is the supremum with
    F.
    """
    functions = all_of_degree(degree)
    (s, w), (t, b) = gauss_points(POINTS), rule
    slope, at_nodes = slopes(functions, s), slopes(functions, t)
    onto = dual(functions, (slope * w) @ slope.T)
    mass_error = (slope * (w * case.mass(case.t0 + h * s))) @ slope.T
    mass_error -= (at_nodes * (b * case.mass(case.t0 + h * t))) @ at_nodes.T
    (u, rate), end = case.motion(case.t0 + h * s), case.motion(np.array([case.t0 + h]))[0]
    last = values(functions, np.ones(1)).T
    left = np.vstack([np.sqrt(w)[:, None] * slope.T, last, onto @ mass_error]) / math.sqrt(h)
    right = np.concatenate([np.sqrt(h * w) * rate, end / math.sqrt(h), np.zeros(degree)])
    best = np.linalg.lstsq(left, right, rcond=None)[0]
    by_rule, exact = (
        (values(functions, x) * weights) @ case.slope(case.t0 + h * x, positions)
        for x, weights, positions in ((t, b, case.motion(case.t0 + h * t)[0]), (s, w, u))
    )
    forced = h**1.5 * np.linalg.norm(onto @ (by_rule - exact))
    return float(np.linalg.norm(left @ best - right)), float(forced)


def terms(case: Comparison, method: Any, degree: int, h: float) -> tuple[float, ...] | None:
    """Four ratios of theorem 3 for one step; None if its error is round-off, NaN if it fails:

    (1 - Lambda_N C_N^2 eta) |u - u_N|_X as printed, and (1 - C_N z0 eta / (sqrt(2) lambda_N))
    |u - u_N|_X as proved, over (1 + sqrt(2) + 3 M / (m lambda_N^2)) I_2 + 3 / (m lambda_N^2) Q;
    sup_z sum_k (F_(u_N) - F_u) . z w_k / |z|_(X,N), z in K_1, over its bound in the proof,
    C_N^2 (K h^2 / z0^2) |u - u_N|_(X,N); and |u - u_N|_(0,N) / (h |u - u_N|_X).
    """
    run = galvi.integrate(case.problem(), method, h, 1)
    if not run.success:
        return (math.nan,) * 4
    error = step_error(run, case.motion)
    if error <= FLOOR:
        return None
    functions, (t, b) = all_of_degree(degree), nodes(method.rule)
    lipschitz, lightest, heaviest = case.constants(h)
    by_rule, exact = grams(functions, t, b), grams(functions, *gauss_points(POINTS))
    lower, *_, upper = np.sqrt(eigvalsh(by_rule.energy, exact.energy))  # lambda_N and Lambda_N
    constant, onto = friedrichs(by_rule), 3.0 / (lightest * lower**2)
    best, forced = consistency(case, (t, b), degree, h)
    ratio = error / ((1.0 + math.sqrt(2.0) + onto * heaviest) * best + onto * forced)
    share = lipschitz / lightest * eta(h)
    times, end = case.t0 + h * t, case.motion(np.array([case.t0 + h]))[0][0]
    (u, rate), u_N = case.motion(times), run(times)[:, 0]
    gap = run.velocity(times)[:, 0] - rate
    size = math.sqrt(h * b @ gap**2 + (run.q[1, 0] - end) ** 2 / h)
    pulled = (values(functions, t) * b) @ (case.slope(times, u_N) - case.slope(times, u))
    force = h**1.5 * float(np.linalg.norm(dual(functions, by_rule.energy) @ pulled))
    return (
        (1.0 - upper * constant**2 * share) * ratio,
        (1.0 - constant * z0() * share / (math.sqrt(2.0) * lower)) * ratio,
        force / ((constant * h / z0()) ** 2 * lipschitz * size),
        math.sqrt(h * b @ (u_N - u) ** 2) / (h * error),
    )
