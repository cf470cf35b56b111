"""Orders of polynomials with a rule of little exactness: candidate readings of H's figures."""

from __future__ import annotations

WHY_ORDER = (
    "Degree s with a rule exact to degree d has order min(d + 1, 2 (d - s + 2), 2 s): the accuracy "
    "of the rule on the exact curve, the square of what it adds to the gradient of the action, and "
    "the polynomials."
)


def order_with(degree: int, exactness: int) -> int:
    """Order with polynomials of this degree s and a rule exact to degree d.

    With delta the distance of the best polynomial, h^s in the velocity, and E the rule's error, the
    discrete action at its stationary curve differs from the exact action by E(L) = O(h^(d + 2)) on
    the exact curve, by the second variation, O(h^(2 s + 1)), and by the square of the gradient that
    E adds. That is E((p e)') for p = dL/dv on the exact curve and e a polynomial of degree s that
    vanishes at both ends: exact for the part of p of degree below k = d - s + 2, hence
    O(h^(k + 1/2)) in the norm of e', and its square O(h^(2 k + 1)).
    """
    return min(exactness + 1, 2 * (exactness - degree + 2), 2 * degree)


def order_with_clenshaw_curtis(degree: int, points: int) -> int:
    """Order with polynomials of this degree and Clenshaw-Curtis of so many points, exact to degree
    points - 1, or to the next where that is even."""
    return order_with(degree, points - 1 + points % 2)
