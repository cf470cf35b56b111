"""A quadrature rule on [0, 1]."""

from __future__ import annotations

from dataclasses import dataclass
from decimal import Decimal
from functools import cached_property
from typing import Any

import numpy as np

from galvi import input_checks
from galvi.arrays import Array
from galvi.extended_precision import decimals, extended_precision, rounded
from galvi.input_checks import shown
from galvi.spaces.legendre import legendre

MOST = 1000  # points of a rule made in extended precision, which takes 10 s
EXACT = 1e-12  # largest error of a Legendre polynomial's integral; 2e-15 for up to 200 points


@dataclass(frozen=True)
class Rule:
    """sum_j weights_j f(nodes_j), exact for polynomials of at most ``degree``.

    name           e.g. "Gauss 4"
    degree         degree of exactness, at least 0; checked to 1e-12
    exact_nodes    decimals in [0, 1], increasing (floats are converted exactly)
    exact_weights  decimals, positive, with sum 1 to 1e-13

    Raises ValueError naming the violated identity when the numbers are not a rule of this degree.
    """

    name: str
    degree: int
    exact_nodes: tuple[Decimal, ...]
    exact_weights: tuple[Decimal, ...]

    def __post_init__(self) -> None:
        if not isinstance(self.name, str):
            raise ValueError(f"name of a rule must be a text; received {shown(self.name)}.")
        object.__setattr__(self, "degree", input_checks.whole("degree of a rule", self.degree, 0))
        for field in ("exact_nodes", "exact_weights"):
            object.__setattr__(self, field, _row(field, getattr(self, field)))
        self._check()
        self._check_degree()

    @property
    def points(self) -> int:
        """Number of nodes."""
        return len(self.exact_nodes)

    @cached_property
    def nodes(self) -> Array:
        """(points,) float64, in [0, 1]."""
        return rounded(self.exact_nodes)

    @cached_property
    def weights(self) -> Array:
        """(points,) float64."""
        return rounded(self.exact_weights)

    @property
    def symmetric(self) -> bool:
        """Whether nodes and weights are mirrored about 1/2."""
        mirrored = np.allclose(self.nodes, 1.0 - self.nodes[::-1], rtol=0.0, atol=1e-15)
        return bool(mirrored and np.allclose(self.weights, self.weights[::-1], atol=1e-15))

    def __repr__(self) -> str:
        return f"Rule({self.name!r})"

    def _check(self) -> None:
        nodes, weights = self.nodes, self.weights
        if nodes.size == 0 or nodes.size != weights.size:
            raise ValueError(
                f"a rule must have one weight for each node, and at least one; received "
                f"{nodes.size} nodes and {weights.size} weights."
            )
        if np.any(np.diff(nodes) <= 0.0) or nodes[0] < 0.0 or nodes[-1] > 1.0:
            raise ValueError(
                f"nodes of a rule must increase inside [0, 1]; received {nodes.tolist()}."
            )
        if np.any(weights <= 0.0):
            raise ValueError(
                f"weights of a rule must be positive; received {float(weights.min())}. "
                f"Choose a rule of another family or with fewer points."
            )
        with extended_precision():
            total = sum(self.exact_weights, Decimal(0))
        if abs(total - 1) > Decimal("1e-13"):
            raise ValueError(f"weights of a rule on [0, 1] must sum to 1; received {total:.16f}.")

    def _check_degree(self) -> None:
        most = 2 * self.points - 1
        if self.degree > most:
            raise ValueError(
                f"degree of a rule with {self.points} points must be at most {most}, which "
                f"Gauss's rule has; received {self.degree}."
            )
        defects = np.abs(self.weights @ legendre(2.0 * self.nodes - 1.0, self.degree)[:, 1:])
        wrong = np.flatnonzero(defects > EXACT)
        if wrong.size:
            first = int(wrong[0]) + 1
            raise ValueError(
                f"a rule must integrate all polynomials of its degree, {self.degree}; {self.name} "
                f"misses one of degree {first} by {defects[first - 1]:.1e}. Say degree = "
                f"{first - 1}, or correct the nodes and weights."
            )


def _row(field: str, values: Any) -> tuple[Decimal, ...]:
    """The values as decimals, or ValueError unless they are finite numbers in one row."""
    try:
        numbers = np.asarray(values)
        real = numbers.dtype.kind in "iufO"  # O: decimals
        finite = real and bool(np.all(np.isfinite(numbers.astype(np.float64))))
        row = tuple(decimals(numbers)) if finite and numbers.ndim == 1 else None
    except (TypeError, ValueError, OverflowError):  # also of a date, which numpy takes for a number
        row = None
    if row is None:
        raise ValueError(
            f"{field} of a rule must be finite numbers in one row; received {shown(values)}."
        )
    return row


def number_of_points(value: Any, at_least: int = 1) -> int:
    """A number of points as an int; ValueError unless a whole number up to 1000."""
    number = input_checks.whole("points", value, at_least)
    if number > MOST:
        raise ValueError(
            f"points must be a whole number from {at_least} to {MOST}; "
            f"received {shown(value)}. For "
            f"more points use galvi.composite(galvi.gauss(8), pieces)."
        )
    return number


def from_interval(name: str, degree: int, x: Any, w: Any) -> Rule:
    """The rule on [0, 1] from decimal nodes x and weights w on [-1, 1]."""
    return Rule(name, degree, tuple((1 + x) / 2), tuple(w / 2))
