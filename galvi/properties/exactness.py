"""How exact a rule is on each smooth piece of a space's functions."""

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
    """The highest degree of polynomials on each piece that the rule integrates; -1 for none.

    The rule's degree for a space of one piece. A space that is smooth only on ``pieces`` equal
    parts of [0, 1] has integrands that are, so moments are taken on each part; the weight of a
    node at a joint is shared so that both sides have the right sum of weights.
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
    """(place in [0, 1], weight) of the nodes on each piece, with the weights' sum near 1."""
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
