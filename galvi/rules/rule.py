"""A quadrature rule on [0, 1]."""

from __future__ import annotations

from dataclasses import dataclass
from decimal import Decimal
from functools import cached_property
from typing import Any

import numpy as np

from galvi.arrays import Array
from galvi.decimals import decimals, many_digits, rounded


@dataclass(frozen=True)
class Rule:
    """sum_j weights_j f(nodes_j), exact for polynomials of at most ``degree``.

    name           e.g. "Gauss 4"
    degree         degree of exactness
    exact_nodes    decimals in [0, 1], increasing (floats are taken as they are)
    exact_weights  decimals, positive, with sum 1 to 1e-13

    Raises ValueError, naming the identity, when the numbers are not a rule.
    """

    name: str
    degree: int
    exact_nodes: tuple[Decimal, ...]
    exact_weights: tuple[Decimal, ...]

    def __post_init__(self) -> None:
        for field in ("exact_nodes", "exact_weights"):
            numbers = np.asarray(getattr(self, field))
            if numbers.ndim != 1 or not np.all(np.isfinite(numbers.astype(np.float64))):
                raise ValueError(f"{field} of a rule must be finite numbers in one row.")
            object.__setattr__(self, field, tuple(decimals(numbers)))
        self._check()

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
        with many_digits():
            total = sum(self.exact_weights, Decimal(0))
        if abs(total - 1) > Decimal("1e-13"):
            raise ValueError(f"weights of a rule on [0, 1] must sum to 1; received {total:.16f}.")


def from_interval(name: str, degree: int, x: Any, w: Any) -> Rule:
    """The rule on [0, 1] from decimal nodes x and weights w on [-1, 1]."""
    return Rule(name, degree, tuple((1 + x) / 2), tuple(w / 2))
