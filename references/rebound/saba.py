"""REBOUND's SABA family: symplectic methods for a dominant mass and small perturbations.

Laskar and Robutel (2001), Blanes et al. (2013). Options: type, one of TYPES by its name in REBOUND,
safe_mode, keep_unsynchronized. "SABA 4" is type "4", with its modified kick corrector "CM_4", with
the lazy one "CL_4"; SABA(10,6,4) is "10_6_4", in heliocentric splitting "H_10_6_4".
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from references.rebound.fixed_steps import ReboundSteps

TYPES = (
    *("1", "2", "3", "4", "CM_1", "CM_2", "CM_3", "CM_4", "CL_1", "CL_2", "CL_3", "CL_4"),
    *("10_4", "8_6_4", "10_6_4", "H_8_4_4", "H_8_6_4", "H_10_6_4"),
)
DEFAULT: Mapping[str, Any] = {"type": "10_6_4", "safe_mode": 1}
BEST: Mapping[str, Any] = {"type": "10_6_4", "safe_mode": 0}

SABA = ReboundSteps(
    "REBOUND SABA",
    integrator="saba",
    options=("type", "safe_mode", "keep_unsynchronized"),
    order=4,
)
