"""The engines of equal steps in the inertial frame, for runs within other runs.

A moving frame does the steps that it cannot resolve by these engines, and a clock without lanes
does all its steps by them, in transformed time.
"""

from __future__ import annotations

from galvi.environment import FAST
from galvi.run.general import GENERAL_EQUAL_STEPS
from galvi.run.in_lanes.engine import LANES
from galvi.run.stepper import Engine

# In the order in which they are asked for a stepper.
EQUAL_STEPS: tuple[Engine, ...] = (LANES, GENERAL_EQUAL_STEPS) if FAST else (GENERAL_EQUAL_STEPS,)
