"""The free rigid body of H 3.5.1, shared by L1 to L5, L13, L17 and L18; faults of rigid bodies."""

from __future__ import annotations

from functools import partial

import galvi
from benchmarks.claims.kit import heavier, method_on_group, of_motion, reversed_clock
from galvi.charts import CHARTS

STEP, DURATION = 0.5, 5.0
FLOOR = 2e-14  # round-off of matrix entries; 3e-15 was measured at n = 15
METHODS = {chart.name: partial(method_on_group, chart=chart) for chart in CHARTS}
OTHER_MOTIONS = {
    "clock reversed": of_motion(reversed_clock),
    "another body": of_motion(heavier),
}
problem = galvi.problems.free_rigid_body
