"""A Galerkin variational integrator as a value."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from galvi.charts.cayley import Cayley
from galvi.charts.chart import Chart
from galvi.classical import classical_name
from galvi.rules.rule import Rule
from galvi.spaces.space import Space
from galvi.table import Table, tabulate


@dataclass(frozen=True)
class Galerkin:
    """The variational integrator of a space and a rule (H eq. 2.3, 2.4; M section 3).

    space  e.g. ``Polynomials(8)``
    rule   e.g. ``gauss(8)``
    chart  of the groups that a problem lives on; on vector spaces it changes nothing

    Raises ValueError for an ill-posed pair (the free particle has no unique motion, M lemma 1) and,
    with another sentence, for an inconsistent one (it does not move in a straight line).
    """

    space: Space
    rule: Rule
    chart: Chart = field(default_factory=Cayley)

    def __post_init__(self) -> None:
        for name, kind, example in (
            ("space", "basis", "Polynomials(8)"),
            ("rule", "exact_nodes", "gauss(8)"),
            ("chart", "farthest", "Cayley()"),
        ):
            value = getattr(self, name)
            if isinstance(value, type) or not hasattr(value, kind):
                raise TypeError(
                    f"{name} must be a {name} such as galvi.{example}; received {value!r}."
                )
        tabulate(self.space, self.rule)

    @cached_property
    def table(self) -> Table:
        """The tabulated pair."""
        return tabulate(self.space, self.rule)

    @property
    def stages(self) -> int:
        """Force evaluations of one pass over a step."""
        return self.rule.points

    @property
    def order(self) -> int:
        """Order of convergence at step ends, for polynomials of degree s and a rule of degree g.

        min(2 s, g + 1, 2 (g - s) + 4): what the space can do, what the rule can do for the force
        (Ober-Blobaum and Saake, Adv. Comput. Math. 41 (2015), section 4.2; claims V6, V17, V22),
        and what it can do for the kinetic energy, whose degree is 2 s - 2. The last is ours; it
        is measured in tests/galvi/test_order.py.
        """
        s, g = self.space.degree, self.rule.degree
        return min(2 * s, g + 1, 2 * (g - s) + 4)

    @cached_property
    def symmetric(self) -> bool:
        """Whether a step forward and a step backward cancel, on vector spaces.

        Not so on groups, where a chart has its base at a step's start: what is left is of order
        2 s + 1, and nothing for degree 1 with the exponential chart.

        A*_kj = A_kj - beta_j + (1 - c_k) b_j of the adjoint equals A with its stages reversed.
        """
        table = self.table
        adjoint = table.A - table.beta + np.outer(1.0 - table.c, table.b)
        mirrored = np.allclose(adjoint, table.A[::-1, ::-1], rtol=0.0, atol=1e-13)
        return bool(mirrored and self.rule.symmetric)

    @cached_property
    def name(self) -> str:
        """The classical name when the tableau is a known one, else the space and the rule."""
        known = classical_name(self.table)
        return known or f"Galerkin degree {self.space.degree}, {self.rule.name}"
