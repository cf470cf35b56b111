"""Orders of convergence of a space and a rule."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

from galvi.properties.exactness import exactness
from galvi.properties.symmetry import is_symmetric
from galvi.rules.rule import Rule
from galvi.spaces.space import Space
from galvi.tableau import assemble

SPACE, FORCE, KINETIC = "space", "rule for the force", "rule for the kinetic energy"


@dataclass(frozen=True)
class Orders:
    """Orders of a consistent method on smooth problems at a fixed final time; 0 for other pairs.

    at_steps  order of positions and momenta at step ends
    on_curve  order of positions between them
    limit     what limits at_steps: "space", "rule for the force" or "rule for the kinetic energy",
              the first of these if several do; "" when the order is 0
    """

    at_steps: int
    on_curve: int
    limit: str


@lru_cache(maxsize=256)
def orders(space: Space, rule: Rule) -> Orders:
    """With s the space's degree and g the rule's on each of its smooth pieces:

    at steps      min(2 s, g + 1, 2 (g - s) + 4): limits of the space, of the rule for the force
                  (Ober-Blobaum and Saake, Adv. Comput. Math. 41 (2015), section 4.2; claims V6,
                  V17, V22), and of the rule for the kinetic energy, whose degree is 2 s - 2; the
                  last is our own result. A symmetric method has an even order, so an odd bound is
                  raised by one.
    on the curve  min(order at steps, s + 1, g - s + 3): the coefficient of degree s + 1 is missing
                  and those above degree g - s + 2 are wrong; our own result.

    Functions beyond the polynomials of degree s change the constants, not the orders. With
    different degrees for components the order is that of the lowest. Both orders are tested from
    above and below in tests/galvi/test_theory_orders.py.
    """
    found = assemble(space, rule)
    if found.table is None or not found.consistent:
        return Orders(0, 0, "")
    g = exactness(space, rule)
    degrees: Sequence[int] = getattr(space, "degrees", (space.degree,))
    bounds = {
        SPACE: 2 * min(degrees),
        FORCE: g + 1,
        KINETIC: min(2 * (g - s) + 4 for s in degrees),
    }
    limit = min(bounds, key=lambda name: bounds[name])
    order = bounds[limit]
    if order % 2 and is_symmetric(found.table, rule):
        order += 1
    curve = min(order, *(min(s + 1, g - s + 3) for s in degrees))
    return Orders(order, curve, limit)
