"""L8: the 3D pendulum near its equilibrium, energy over 1000 long steps (H figure 3.7)."""

from __future__ import annotations

import pandas as pd

from benchmarks.checks.bounds import NoGrowth
from benchmarks.checks.claim import Claim, MakeMethod, Report, Row
from benchmarks.claims.lie_groups.pendulum_motion import METHOD, MOTION, problem
from benchmarks.measures.errors import energy_errors
from benchmarks.measures.refinement import Case, history, method_on_group
from benchmarks.statistics import readings
from benchmarks.store.frames import frame

N, STEP, STEPS = 8, 1.5, 1000
QUANTITY = "energy error"
LIMIT = 1e-7
SETUP = f"{MOTION}; {METHOD}, n = {N}; h = {STEP:g}, {STEPS} steps; relative, at step ends"


def study(make_method: MakeMethod, quick: bool, report: Report) -> pd.DataFrame:
    """Series 'history' of the relative energy error at step ends, from (R, p)."""
    report(f"n = {N}, {STEPS} steps of {STEP:g}")
    measures = {QUANTITY: energy_errors}
    case = Case(N, STEP, STEPS)
    return frame(history("history", problem(), case, measures, make_method, method_on_group))


def judge(table: pd.DataFrame) -> list[Row]:
    """Small, and without drift."""
    drift = readings.drift(table, study="history", quantity=QUANTITY)
    return [L8.row(f"{QUANTITY}, n = {N}", NoGrowth(LIMIT), drift)]


L8 = Claim(
    "L8",
    "3D pendulum at h = 1.5: the energy error does not grow",
    study,
    judge,
    ("H fig. 3.7",),
    setup=SETUP,
    claimed="small and oscillating, not increasing",
    reason="The method is symplectic and the step is constant: it conserves a modified energy, "
    "which is near the energy although a step is a third of a swing.",
    reference="initial energy",
)
