"""REBOUND's BS: Gragg, Bulirsch and Stoer's extrapolation, adaptive in step and order.

After Hairer, Norsett and Wanner, section II.9. Options: eps_abs and eps_rel, or tolerance for both;
max_dt. REBOUND's default of 1e-8 is for medium accuracy. Below 1e-14 its steps collapse. Its min_dt
is not offered: where bodies meet, REBOUND 5.2.2 repeats a step of that size for ever.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from references.rebound.adaptive import ReboundAdaptive

DEFAULT: Mapping[str, Any] = {"eps_abs": 1e-8, "eps_rel": 1e-8}
BEST: Mapping[str, Any] = {"eps_abs": 1e-13, "eps_rel": 1e-13}

BULIRSCH_STOER = ReboundAdaptive(
    "REBOUND BS",
    integrator="bs",
    defaults=DEFAULT,
    options=("max_dt",),
    tolerances=("eps_abs", "eps_rel"),
)
