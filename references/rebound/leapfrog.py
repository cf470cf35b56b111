"""REBOUND's leapfrog and its compositions: order 2, 4 (Yoshida), 6 or 8 (Blanes and Casas).

For any N bodies: nothing is assumed of the masses. Option: order.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from references.rebound.fixed_steps import ReboundSteps

DEFAULT: Mapping[str, Any] = {"order": 2}
BEST: Mapping[str, Any] = {"order": 8}

LEAPFROG = ReboundSteps("REBOUND leapfrog", integrator="leapfrog", options=("order",), order=2)
