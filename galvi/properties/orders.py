"""The orders of convergence that a space and a rule can have."""

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
    """Of a consistent method, on smooth problems at a fixed final time; 0 for any other pair.

    at_steps  of positions and momenta at step ends
    on_curve  of positions between them
    limit     what keeps at_steps from being higher: "space", "rule for the force" or "rule for
              the kinetic energy", the first of these when several do; "" when the order is 0
    """

    at_steps: int
    on_curve: int
    limit: str


@lru_cache(maxsize=256)
def orders(space: Space, rule: Rule) -> Orders:
    """With s the space's degree and g the rule's on each of its smooth pieces:

    at steps      min(2 s, g + 1, 2 (g - s) + 4): what the space can do, what the rule can do for
                  the force (Ober-Blobaum and Saake, Adv. Comput. Math. 41 (2015), section 4.2;
                  claims V6, V17, V22), and for the kinetic energy, whose degree is 2 s - 2. The
                  last is ours. A symmetric method has an even order: an odd bound is one too low.
    on the curve  min(order at steps, s + 1, g - s + 3): the coefficient of degree s + 1 is missing
                  and those above degree g - s + 2 are wrong; ours.

    Functions beyond the polynomials of degree s change the constants, not the orders. Components
    of different degrees have the order of the worst. tests/galvi/test_theory_orders.py measures
    both, from either side.
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
