"""Degree of exactness of a rule on each smooth piece of a space's functions."""

from __future__ import annotations

from decimal import Decimal
from fractions import Fraction
from functools import lru_cache

from galvi.extended_precision import extended_precision
from galvi.rules.rule import Rule
from galvi.spaces.space import Space

CLOSE = Decimal("1e-13")


@lru_cache(maxsize=256)
def exactness(space: Space, rule: Rule) -> int:
    """The highest degree to which the rule is exact for piecewise polynomials; -1 for none.

    For a space of one piece it is the rule's degree. Integrands of a space that is smooth only on
    each of ``pieces`` equal parts of [0, 1] are smooth there too, so moments are computed on each
    part; the weight of a node at a joint is divided such that both sides have the correct sum.
    """
    pieces = getattr(space, "pieces", 1)
    if pieces == 1:
        return rule.degree
    parts = _parts(rule, pieces)
    degree = -1
    with extended_precision():
        while degree < rule.degree and all(_integrates(part, degree + 1) for part in parts):
            degree += 1
    return degree


def _parts(rule: Rule, pieces: int) -> list[list[tuple[Decimal, Decimal]]]:
    """(position in [0, 1], weight) of the nodes on each piece; the weights sum to about 1."""
    parts: list[list[tuple[Decimal, Decimal]]] = [[] for _ in range(pieces)]
    with extended_precision():
        for node, weight in zip(rule.exact_nodes, rule.exact_weights, strict=True):
            place, share = node * pieces, weight * pieces
            joint = int(place.to_integral_value())
            if abs(place - joint) > CLOSE or joint in (0, pieces):
                k = min(int(place), pieces - 1)
                parts[k].append((place - k, share))
                continue
            left = 1 - sum((w for _, w in parts[joint - 1]), Decimal(0))
            parts[joint - 1].append((Decimal(1), left))
            parts[joint].append((Decimal(0), share - left))
    return parts


def _integrates(part: list[tuple[Decimal, Decimal]], degree: int) -> bool:
    terms = (weight * place**degree if degree else weight for place, weight in part)
    moment = sum(terms, Decimal(0))
    exact = Fraction(1, degree + 1)
    return abs(moment - Decimal(exact.numerator) / Decimal(exact.denominator)) < CLOSE
