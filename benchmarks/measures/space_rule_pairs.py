"""Every kind of space with every family of rules, as far as they make methods.

A space with a degree for each component is left out: with equal degrees it is `Polynomials`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from typing import Any

from galvi.rules import RULES
from galvi.rules.composite import composite
from galvi.rules.rule import Rule
from galvi.spaces import SPACES
from galvi.spaces.space import Space

OF_ONE_DEGREE = tuple(make for make in SPACES if not hasattr(make(1), "degrees"))
MANY = 24  # points that integrate the waves of the kinds in SPACES to 1e-13


@dataclass(frozen=True)
class Pair:
    """A space of one of the kinds in SPACES and a rule of one of the families in RULES.

    kind    the space's, in words, e.g. "PiecewisePolynomials, pieces=3"
    number  that the space is made from
    family  the rule's, in words, e.g. "Gauss"
    points  that it is made from; on each piece, where the space has pieces
    """

    kind: str
    number: int
    space: Space
    family: str
    points: int
    rule: Rule


def kind_of(make_space: Any) -> str:
    """The name of one of SPACES, with what it is bound to."""
    bound = getattr(make_space, "keywords", {})
    words = (f"{name}={value:g}" for name, value in bound.items())
    return ", ".join((type(make_space(1)).__name__, *words))


def family_of(make_rule: Callable[[int], Rule]) -> str:
    """The name of one of RULES: that of its rules, without their number."""
    return make_rule(2).name.rsplit(" ", 1)[0]


def pairs(numbers: Iterable[int], points: Iterable[int]) -> Iterator[Pair]:
    """One for each space and rule that there is; a rule is repeated on a space's pieces."""
    points = tuple(points)
    for make_space in OF_ONE_DEGREE:
        for number in numbers:
            space = make_space(number)
            for make_rule in RULES:
                for many in points:
                    try:
                        rule = make_rule(many)
                    except ValueError:  # no such rule: one point with both ends, or a weight < 0
                        continue
                    whole = composite(rule, getattr(space, "pieces", 1))
                    yield Pair(
                        kind_of(make_space), number, space, family_of(make_rule), many, whole
                    )


def kinds() -> tuple[str, ...]:
    """Of spaces that contain linear functions: others make no method."""
    return tuple(kind_of(make_space) for make_space in OF_ONE_DEGREE if make_space(1).degree >= 1)
