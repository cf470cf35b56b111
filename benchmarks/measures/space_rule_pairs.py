"""All pairs of a kind of space and a family of rules.

`ComponentPolynomials` is left out: with equal degrees it is `Polynomials`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

from galvi.rules import RULES
from galvi.rules.rule import Rule, composite
from galvi.spaces import SPACES
from galvi.spaces.space import Space

ONE_DEGREE_SPACES = tuple(make for make in SPACES if not hasattr(make(1), "degrees"))
SUFFICIENT_POINTS = 24  # points sufficient to integrate the waves of SPACES to 1e-13


@dataclass(frozen=True)
class Pair:
    """A space of a kind in SPACES and a rule of a family in RULES.

    Attributes
    ----------
    kind
        kind of the space in words, e.g. "PiecewisePolynomials, pieces=3"
    number
        argument of the space's constructor
    family
        family of the rule in words, e.g. "Gauss"
    points
        argument of the rule's constructor; the rule is repeated on each piece of the space
    """

    kind: str
    number: int
    space: Space
    family: str
    points: int
    rule: Rule


def kind_of(make_space: Any) -> str:
    """The name of a kind of space in SPACES, with its bound arguments."""
    bound = getattr(make_space, "keywords", {})
    arguments = (f"{name}={value:g}" for name, value in bound.items())
    return ", ".join((type(make_space(1)).__name__, *arguments))


def family_of(make_rule: Callable[[int], Rule]) -> str:
    """The name of a family in RULES: the name of its rules without the number of points."""
    return make_rule(2).name.rsplit(" ", 1)[0]


def pairs(numbers: Iterable[int], points: Iterable[int]) -> Iterator[Pair]:
    """A pair for each space and rule that exist; a rule is repeated on a space's pieces."""
    points = tuple(points)
    for make_space in ONE_DEGREE_SPACES:
        for number in numbers:
            space = make_space(number)
            for make_rule in RULES:
                for point_count in points:
                    try:
                        rule = make_rule(point_count)
                    except ValueError:  # no such rule: one point with both ends, or a weight < 0
                        continue
                    composite_rule = composite(rule, getattr(space, "pieces", 1))
                    yield Pair(
                        kind_of(make_space),
                        number,
                        space,
                        family_of(make_rule),
                        point_count,
                        composite_rule,
                    )


def methods(
    make_method: Callable[[Space, Rule], Any], numbers: Iterable[int], points: Iterable[int]
) -> Iterator[tuple[Pair, Any]]:
    """Each pair with its method, without pairs that are refused as ill-posed or inconsistent."""
    for pair in pairs(numbers, points):
        with suppress(ValueError):
            yield pair, make_method(pair.space, pair.rule)


def kinds() -> tuple[str, ...]:
    """Kinds of spaces that contain linear functions; only these give methods."""
    return tuple(
        kind_of(make_space) for make_space in ONE_DEGREE_SPACES if make_space(1).degree >= 1
    )
