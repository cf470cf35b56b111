"""Constants of a space and a rule, and steps up to which theorems hold."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from galvi.arrays import Array
from galvi.rules.rule import Rule, gauss
from galvi.spaces.polynomials import Polynomials
from galvi.spaces.space import Space
from galvi.tableau import assemble

Z0 = 0.860333589019379762
"""The smallest positive root of 1 = z tan z, 0.860: the integral of |u|^2 over a step of h is at
most (h / z0)^2 times that of |u'|^2 plus |u(h)|^2 / h, with equality for cos(z0 t / h) (M section
2)."""
INTEGRATION_POINTS = 64  # Gauss points on each part of a step for M's exact integrals: degree 127
PARTS_PER_PIECE = 4  # parts of each smooth piece of a basis
MAX_CONDITION = 1e11  # largest condition number of a normalised basis that has constants
ZERO_EIGENVALUE = 1e-12  # eigenvalues below this share of the largest count as 0


@dataclass(frozen=True)
class Norms:
    """Constants of the norm |u|_X^2 = integral of |u'|^2 + |u(h)|^2 / h on a step of length h.

    A subscript N marks the same norm with the integral by the rule.

    Attributes
    ----------
    unseen
        number of independent functions with |u|_{X,N} = 0; 0 iff well posed (M lemma 1)
    C
        C_N, the least constant with |u|_{0,N} <= C_N (h / z0) |u|_{X,N} (M 11)
    lowest
        lambda_N, least |u|_{X,N} / |u|_X (M 12)
    highest
        Lambda_N, largest |u|_{X,N} / |u|_X (M 12)

    Notes
    -----
    C is infinite for an ill-posed pair. None depends on h.
    """

    unseen: int
    C: float
    lowest: float
    highest: float


@lru_cache(maxsize=128)
def norms(space: Space, rule: Rule) -> Norms | None:
    """The constants of a space and a rule; for a space with several degrees, the worst over these.

    None where the basis functions are too nearly dependent for float64.
    """
    degrees: Sequence[int] = getattr(space, "degrees", (space.dimension - 1,))
    per_degree = [_norms(space, rule, degree + 1) for degree in sorted(set(degrees))]
    constants = [constant for constant in per_degree if constant is not None]
    if len(constants) < len(per_degree):
        return None
    return Norms(
        max(constant.unseen for constant in constants),
        max(constant.C for constant in constants),
        min(constant.lowest for constant in constants),
        max(constant.highest for constant in constants),
    )


def _norms(space: Space, rule: Rule, functions: int) -> Norms | None:
    """The constants for the span of the first ``functions`` basis functions."""
    from scipy.linalg import eigh  # with SciPy's other parts, a quarter of galvi's import

    fine = _fine_rule(getattr(space, "pieces", 1))
    phi, end = (space.basis(t)[:, :functions] for t in (rule.nodes, np.ones(1)))
    slope, fine_slopes = (space.derivative(t)[:, :functions] for t in (rule.nodes, fine[0]))
    last = end.T @ end
    exact = fine_slopes.T @ (fine[1][:, None] * fine_slopes) + last
    norm = np.sqrt(np.diagonal(exact))
    exact, by_rule, values = (
        gram / np.outer(norm, norm)
        for gram in (
            exact,
            slope.T @ (rule.weights[:, None] * slope) + last,
            phi.T @ (rule.weights[:, None] * phi),
        )
    )
    if not np.linalg.cond(exact) < MAX_CONDITION:
        return None
    ratios = eigh(by_rule, exact, eigvals_only=True)
    unseen = int(np.sum(ratios <= ZERO_EIGENVALUE * ratios[-1]))
    C = Z0 * np.sqrt(eigh(values, by_rule, eigvals_only=True)[-1]) if not unseen else np.inf
    low, high = np.sqrt(np.clip([ratios[0], ratios[-1]], 0, None))
    return Norms(unseen, float(C), 0.0 if unseen else float(low), float(high))


def _fine_rule(pieces: int) -> tuple[Array, Array]:
    """Nodes and weights of Gauss's rule on every part of every piece of [0, 1]."""
    rule, parts = gauss(INTEGRATION_POINTS), pieces * PARTS_PER_PIECE
    nodes = (np.arange(parts)[:, None] + rule.nodes) / parts
    return nodes.ravel(), np.tile(rule.weights / parts, parts)


M_FACTOR = 3.0  # one over the constant of M proposition 1; claim V20 measures sqrt(2)


def unique_step(friedrichs: float | None, square: float) -> float | None:
    """The bound of M theorem 2 on h: a step has exactly one solution, to which M's iteration
    converges, while eta C_N^2 = 3 (h omega C_N / z0)^2 < 1.

    Parameters
    ----------
    friedrichs
        C_N; None where it is not known, and so is the bound
    square
        omega^2, of the largest frequency
    """
    if friedrichs is None:
        return None
    largest = friedrichs * math.sqrt(M_FACTOR * square)
    return Z0 / largest if largest > 0.0 else math.inf


def contracting_step(space: Space, rule: Rule, square: float) -> float | None:
    """The bound on h below which fixed-point iteration contracts near a solution,
    h^2 rho(A) omega^2 < 1; None without a tableau, and for components of different degrees.
    ``square`` is omega^2."""
    table = assemble(space, rule).table
    if table is None or len(set(getattr(space, "degrees", (space.degree,)))) > 1:
        return None
    radius = float(np.max(np.abs(np.linalg.eigvals(table.A))))
    largest = math.sqrt(radius * square)
    return 1.0 / largest if largest > 0.0 else math.inf


def stage_iteration_step(space: Space, rule: Rule, square: float) -> float | None:
    """The bound of H theorem 2.3.1 on h, 1 / (|A_1^-1| C_L max_j |phi(c_j)|_1 |phi_p(c_j)|) in the
    maximum norm; at most 1, since lemma 2.3.2 requires h < 1 in the unit of time. None for spaces
    other than `Polynomials`, and for an ill-posed pair."""
    if not isinstance(space, Polynomials) or not assemble(space, rule).well_posed:
        return None
    inverse, basis_bound = lagrange_constants(space, rule)
    product = inverse * square * basis_bound  # 0 with one point, at the step's end
    return 1.0 if product <= 1.0 else 1.0 / product


def lagrange_constants(space: Polynomials, rule: Rule) -> tuple[float, float]:
    """|A_1^-1| of H (2.6)-(2.8) with M = 1, and max_j |phi(c_j)|_1 max_p |phi_p(c_j)|.

    Row 0 is the start; rows i = 1 .. n - 1 test with the basis functions 0 .. n - 2 of the
    Chebyshev points, p over the same (the last gives the momentum at the end).
    """
    nodal: Any = np.linalg.inv(space.basis(space.nodes))
    phi, slope = space.basis(rule.nodes) @ nodal, space.derivative(rule.nodes) @ nodal
    stiff = slope.T @ (rule.weights[:, None] * slope)
    A = np.vstack([np.eye(1, space.dimension), stiff[:-1]])
    inverse = float(np.linalg.norm(np.linalg.inv(A), np.inf))
    sums, largest = np.sum(np.abs(phi), axis=1), np.max(np.abs(phi[:, :-1]), axis=1)
    return inverse, float(np.max(sums * largest))
