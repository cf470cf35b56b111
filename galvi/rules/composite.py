"""A rule repeated on equal pieces."""

from __future__ import annotations

from decimal import Decimal
from functools import lru_cache

from galvi import input_checks
from galvi.extended_precision import extended_precision
from galvi.input_checks import shown
from galvi.rules.rule import Rule

MOST = 10_000  # pieces, which take seconds in extended precision


def composite(rule: Rule, pieces: int) -> Rule:
    """``rule`` on each of ``pieces`` equal parts of [0, 1], with the same degree.

    A rule with both end points has pieces * (points - 1) + 1 nodes: at a joint the last node of one
    piece is the first of the next, and their weights are added. One piece is the rule itself.

    Raises TypeError when rule is not a `Rule`, ValueError unless pieces is a whole number from 1 to
    MOST.
    """
    if not isinstance(rule, Rule):
        raise TypeError(f"rule must be a rule such as galvi.gauss(8); received {shown(rule)}.")
    number = input_checks.whole("pieces", pieces, 1, MOST)
    return rule if number == 1 else _composite(rule, number)


@lru_cache(maxsize=256)
def _composite(rule: Rule, pieces: int) -> Rule:
    nodes: list[Decimal] = []
    weights: list[Decimal] = []
    closed = rule.exact_nodes[0] == 0 and rule.exact_nodes[-1] == 1
    with extended_precision():
        share = tuple(weight / pieces for weight in rule.exact_weights)
        for piece in range(pieces):
            first = 1 if closed and piece > 0 else 0
            if first:
                weights[-1] += share[0]
            nodes += [(piece + node) / pieces for node in rule.exact_nodes[first:]]
            weights += share[first:]
    name = f"{rule.name} on {pieces} pieces"
    return Rule(name, rule.degree, tuple(nodes), tuple(weights))
