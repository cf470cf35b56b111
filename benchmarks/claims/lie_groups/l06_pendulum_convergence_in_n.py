"""L6: the 3D pendulum near its equilibrium, n-refinement (H figure 3.5)."""

from __future__ import annotations

import pandas as pd

from benchmarks.checks.bounds import CONTRADICTED, AtMost, FactorPerN
from benchmarks.checks.claim import Claim, MakeMethod, Report, Row
from benchmarks.claims.lie_groups.pendulum_motion import (
    DURATION,
    FLOOR,
    METHOD,
    MOTION,
    QUANTITIES,
    STEP,
    TRUTH,
    refinement,
)
from benchmarks.measures.refinement import Case
from benchmarks.statistics import readings
from benchmarks.store.frames import frame, number

REACHED, GAIN = 1e-14, 0.15
SETUP = f"{MOTION}; {METHOD}; h = {STEP:g}, T = {DURATION:g}; entries of R"


def study(make_method: MakeMethod, quick: bool, report: Report) -> pd.DataFrame:
    """Series 'n-refinement' of the one-step and the curve error."""
    cases = [Case(n, STEP, round(DURATION / STEP)) for n in range(2, 15 if quick else 19)]
    return frame(refinement("n-refinement", cases, make_method, report))


def judge(table: pd.DataFrame) -> list[Row]:
    """For each quantity: whether it decays geometrically, and whether it reaches round-off."""
    rows = []
    for quantity in QUANTITIES:
        decay = readings.decay(table, FLOOR, study="n-refinement", quantity=quantity)
        rows += [
            L6.row(
                f"base of the {quantity}", FactorPerN(GAIN), decay, claimed="geometric convergence"
            ),
            L6.row(
                f"smallest {quantity}",
                AtMost(REACHED),
                decay.smallest,
                claimed="very high accuracy",
            ),
        ]
    ends, curve = (
        number(table, study="n-refinement", quantity=quantity, n=8) for quantity in QUANTITIES
    )
    return [
        *rows,
        L6.row(
            "curve error over one-step error, n = 8",
            AtMost(10.0),
            curve / ends,
            claimed="the curves have the same error as the one-step map",
            expected=CONTRADICTED,
            reason="A curve of degree n - 1 has the error of the best polynomial, and step ends "
            "about its square; over T = 5 the ends accumulate too little to hide that.",
        ),
    ]


L6 = Claim(
    "L6",
    "3D pendulum at h = 0.5: errors fall geometrically with n",
    study,
    judge,
    ("H fig. 3.5",),
    setup=SETUP,
    reason="The motion is analytic in t, with singularities off the real axis: polynomials "
    "converge to it geometrically, and step ends with the square of their base.",
    reference=TRUTH.name,
)
