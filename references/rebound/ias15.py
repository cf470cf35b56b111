"""REBOUND's IAS15: adaptive Gauss-Radau of order 15 (Rein and Spiegel, MNRAS 446 (2015) 1424).

Options: adaptive_mode, the step criterion: PRS23 (REBOUND's default), GLOBAL (until January 2024),
INDIVIDUAL or AARSETH85; epsilon, also called tolerance; min_dt.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from references.rebound.adaptive import ReboundAdaptive

DEFAULT: Mapping[str, Any] = {"adaptive_mode": "PRS23", "epsilon": 1e-9}
GLOBAL: Mapping[str, Any] = {"adaptive_mode": "GLOBAL", "epsilon": 1e-9}
BEST = DEFAULT

IAS15 = ReboundAdaptive(
    "REBOUND IAS15",
    integrator="ias15",
    defaults=DEFAULT,
    options=("min_dt",),
    tolerances=("epsilon",),
    exact=True,
)
