"""REBOUND's WHFast: Wisdom-Holman with correctors and kernels (Rein, Tamayo and Brown 2019).

Meant for one dominant mass. Options: corrector (0, 3, 5, 7, 11 or 17), corrector2, kernel,
coordinates, safe_mode, keep_unsynchronized as in REBOUND. Add DEFAULT or BEST to a step.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from references.rebound.fixed_steps import ReboundSteps

DEFAULT: Mapping[str, Any] = {"corrector": 0, "kernel": "DEFAULT", "safe_mode": 1}
BEST: Mapping[str, Any] = {"corrector": 17, "kernel": "LAZY", "safe_mode": 0}

WHFAST = ReboundSteps(
    "REBOUND WHFast",
    integrator="whfast",
    options=(
        *("corrector", "corrector2", "kernel", "coordinates"),
        *("safe_mode", "keep_unsynchronized"),
    ),
    order=2,
)
