"""The table of a Galerkin method: everything a step needs, computed once.

With psi_i = phi_i - phi_i(0), e_i = psi_i(1), Psi_ki = psi_i(c_k) and
K_il = sum_j b_j psi_i'(c_j) psi_l'(c_j), the discrete Euler-Lagrange equations (H 2.3, 2.4) of
L = v.M v / 2 - V with one space for all components are the Nystrom method

    Q_k = q0 + alpha_k h v0 + h^2 sum_j A_kj a(Q_j)
    q1  = q0 + beta_p  h v0 + h^2 sum_j beta_j a(Q_j)
    v1  = v0                + h   sum_j b_j a(Q_j)

alpha = Psi K^-1 e, A = Psi C, C = K^-1 (e 1^T - Psi^T) diag(b), beta_p = e^T K^-1 e,
beta_j = b_j (beta_p - alpha_j); the curve is q0 + sum_i psi_i x_i, x = h v0 K^-1 e + h^2 C a.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from galvi.arrays import Array
from galvi.extended_precision import decimals, extended_precision, rounded
from galvi.rules.rule import Rule
from galvi.spaces.polynomials import legendre
from galvi.spaces.space import Space, checked

CONSISTENT = 1e-13  # largest defect of a consistent pair
# Pivots of K below this share of its largest entry count as 0: float64's rounding of a parameter
# such as 2 pi, squared.
BLIND_PIVOT = 1e-24
# Largest number of extrapolated Legendre polynomials: one step ahead, the next one amplifies
# round-off by over 1e18.
MOST_EXTRAPOLATED = 26


@dataclass(frozen=True, eq=False)
class Tableau:
    """s stages (the rule's points), m = dimension - 1 basis functions that vanish at 0.

    Attributes
    ----------
    c, b : array, shape (s,)
        nodes and weights of the rule
    A : array, shape (s, s)
        stages from accelerations
    beta : array, shape (s,)
        end point from accelerations
    psi : array, shape (s, m)
        basis at the stages
    end : array, shape (m,)
        basis at 1
    K : array, shape (m, m)
        stiffness, symmetric positive definite
    velocity_coefficients : array, shape (m,)
        K^-1 e, curve coefficients from the velocity
    C : array, shape (m, s)
        curve coefficients from accelerations
    analysis : array, shape (s, s)
        Legendre coefficients from values at the stages
    extrapolation : array, shape (s, l)
        Legendre polynomials at the next step's stages, 1 + c; l = min(s, MOST_EXTRAPOLATED)
    growth : array, shape (l,)
        Legendre polynomials at the next step's end
    slope : array, shape (s, m)
        derivative of the basis at the stages
    projection : array, shape (m, s)
        K^-1 slope^T diag(b), coefficients of the curve nearest to given slopes
    integral : array, shape (s, s)
        curve at the stages from its slopes there, psi projection
    low_parts
        rounding errors of c, b, beta, A, integral, psi, C and velocity_coefficients, in their
        shapes
    """

    c: Array
    b: Array
    A: Array
    beta: Array
    psi: Array
    end: Array
    K: Array
    velocity_coefficients: Array
    C: Array
    analysis: Array
    extrapolation: Array
    growth: Array
    slope: Array
    projection: Array
    integral: Array
    low_parts: tuple[Array, ...]


@dataclass(frozen=True, eq=False)
class Assembled:
    """The table of a space and a rule, also where these are no method (claim V19).

    Attributes
    ----------
    table
        None when the pair is ill-posed
    defect
        deviation of a free particle from a straight line, the largest of |alpha_k - c_k| and
        |beta_p - 1|; infinite when the pair is ill-posed
    """

    table: Tableau | None
    defect: float

    @property
    def well_posed(self) -> bool:
        """Whether a free particle has a unique motion (M lemma 1)."""
        return self.table is not None

    @property
    def consistent(self) -> bool:
        """Whether that motion is a straight line."""
        return self.defect <= CONSISTENT


class IllPosed(ValueError):
    """A free particle has no unique motion (M lemma 1)."""


def tabulate(space: Space, rule: Rule) -> Tableau:
    """The table of a pair; `IllPosed`, or ValueError when it is inconsistent (claim V19)."""
    assembled = assemble(checked(space), rule)
    if assembled.table is None:
        raise IllPosed(_ill_posed(space, rule))
    if not assembled.consistent:
        raise ValueError(_inconsistent(space, rule, assembled.defect))
    return assembled.table


@lru_cache(maxsize=512)
def assemble(space: Space, rule: Rule) -> Assembled:
    """The table of a pair and its defect; ValueError for an object that is not a space."""
    with extended_precision():
        c, b = decimals(rule.exact_nodes), decimals(rule.exact_weights)
        start, psi, end = (_basis(space, t) for t in (decimals([0.0]), c, decimals([1.0])))
        _check_constant(start, psi)
        psi, end = (psi - start)[:, 1:], (end - start)[0, 1:]
        slope = _derivative(space, c)[:, 1:]
        K = slope.T @ (b[:, None] * slope)
        gap = (end[:, None] - psi.T) * b
        solved = _solve(K, np.column_stack([end, gap, slope.T * b]), space)
        if solved is None:
            return Assembled(None, float("inf"))
        lead, C, projection = solved[:, 0], solved[:, 1 : 1 + len(c)], solved[:, 1 + len(c) :]
        alpha, beta_p = psi @ lead, end @ lead
        defect = float(np.max(np.abs(rounded(np.append(alpha - c, beta_p - 1)))))
        A = psi @ C
        analysis = np.linalg.inv(legendre(2.0 * rule.nodes - 1.0, rule.points - 1))
        highest = min(rule.points, MOST_EXTRAPOLATED) - 1
        extrapolation = legendre(2.0 * rule.nodes + 1.0, highest)
        growth = legendre(np.array([3.0]), highest)[0]
        beta = b * (1 - c)  # b (beta_p - alpha) of a consistent pair
        integral = psi @ projection
        numbers = (
            c, b, A, beta, psi, end, K, lead, C, analysis, extrapolation, growth, slope,
            projection, integral,
        )  # fmt: skip
        low_parts = tuple(
            rounded(exact - decimals(rounded(exact)))
            for exact in (c, b, beta, A, integral, psi, C, lead)
        )
    arrays: list[Any] = [*(rounded(number) for number in numbers), low_parts]
    return Assembled(Tableau(*arrays), defect)


def _basis(space: Space, t: Any) -> Any:
    return space.basis(t) if space.exact else decimals(space.basis(t.astype(np.float64)))


def _derivative(space: Space, t: Any) -> Any:
    return space.derivative(t) if space.exact else decimals(space.derivative(t.astype(np.float64)))


def _check_constant(start: Any, values: Any) -> None:
    if any(abs(x - 1) > 1e-14 for x in (*start[:, 0], *values[:, 0])):
        raise ValueError(
            "the first basis function of a space must be the constant 1; received one that takes "
            f"the value {float(values[0, 0]):.6g}. Put the constant first."
        )


def _solve(K: Any, rhs: Any, space: Space) -> Any:
    """K^-1 rhs by elimination without pivoting, since K is positive semidefinite; None if K is
    singular."""
    tiny, blind = (1e-40, BLIND_PIVOT) if space.exact else (1e-12, 1e-12)
    work = np.column_stack([K, rhs])
    scale = [abs(K[i, i]) for i in range(len(K))]
    for i in range(len(K)):
        if work[i, i] <= decimals(blind) * max(scale):
            return None
        work[i] = work[i] / work[i, i]
        for k in range(len(K)):
            if k != i and abs(work[k, i]) > decimals(tiny) * scale[k]:
                work[k] = work[k] - work[k, i] * work[i]
    return work[:, len(K) :]


def _ill_posed(space: Space, rule: Rule) -> str:
    pieces = getattr(space, "pieces", 1)
    remedy = "a rule with more points or a smaller space"
    if pieces > 1:
        remedy = (
            f"a rule repeated on each piece, galvi.composite(rule, {pieces}), with enough points "
            f"before the piece's end (at a joint slopes are those of the later piece), or fewer "
            f"pieces"
        )
    return (
        f"{space} with {rule.name} is ill-posed: a free particle has no unique motion, "
        f"because the rule cannot see some function of the space. Expected at least "
        f"{space.dimension - 1} useful points; received {rule.points}. Use {remedy}."
    )


def _inconsistent(space: Space, rule: Rule, defect: float) -> str:
    pieces = getattr(space, "pieces", 1)
    if space.degree < 1:
        remedy = (
            "a space that contains linear functions, e.g. galvi.PolynomialFourier(1, harmonics) "
            "instead of galvi.Fourier(harmonics)"
        )
    elif pieces > 1:
        remedy = (
            f"a rule repeated on each piece, galvi.composite(rule, {pieces}), with a rule such as "
            f"galvi.gauss({space.degree}) that has no points at the joints"
        )
    else:
        remedy = (
            "a rule with more points, one that integrates the derivative of every basis function "
            "exactly"
        )
    return (
        f"{space} with {rule.name} is inconsistent: a free particle does not move in a "
        f"straight line (off by {defect:.1e} of a step; expected at most {CONSISTENT:g}). Use "
        f"{remedy}."
    )
