"""REBOUND's JANUS: leapfrog compositions in integers, reversible to the bit (Rein, Tamayo 2018).

Options: order (2, 4, 6, 8 or 10), scale_pos and scale_vel, the units that positions and velocities
are counted in. Both must be small against what moves, and numbers above 2^63 of them wrap around
without a word: BEST suits au and days, where REBOUND's 1e-16 leaves velocities 14 digits.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from galvi import Problem
from references.rebound.fixed_steps import ReboundSteps

DEFAULT: Mapping[str, Any] = {"order": 6, "scale_pos": 1e-16, "scale_vel": 1e-16}
BEST: Mapping[str, Any] = {"order": 8, "scale_pos": 1e-17, "scale_vel": 1e-19}
LARGEST = 2.0**63


def objection(problem: Problem, options: Mapping[str, Any]) -> str:
    """Why the start does not fit into JANUS's integers; '' if it does."""
    for key, start in (("scale_pos", problem.q0), ("scale_vel", problem.v0)):
        unit, size = {**DEFAULT, **options}[key], float(np.max(np.abs(start)))
        if not (isinstance(unit, float) and unit * LARGEST > size):
            return (
                f"{key} must be a number above {size / LARGEST:.1e}, so that {size:g} fits into 63 "
                f"bits with room to move; received {unit!r}."
            )
    return ""


JANUS = ReboundSteps(
    "REBOUND JANUS",
    integrator="janus",
    options=("order", "scale_pos", "scale_vel"),
    order=6,
    objection=objection,
)
