"""L6: the 3D pendulum near its equilibrium, n-refinement (H figure 3.5)."""

from __future__ import annotations

import pandas as pd

import galvi
from benchmarks.checks.bounds import Above, AtMost, Finding, Geometric, Near
from benchmarks.checks.claim import Claim, MakeMethod, Report, Row
from benchmarks.claims.lie_groups.curves_and_ends import (
    BOTH,
    DURATIONS,
    ORACLES,
    POWER,
    SAME,
    WHY,
    between,
    largest_ratio,
    listed,
    power,
    ratio,
    scan,
)
from benchmarks.claims.lie_groups.pendulum_motion import (
    BODY,
    DURATION,
    FLOOR,
    METHOD,
    MOTION,
    QUANTITIES,
    START,
    STEP,
    TRUTH,
    WEIGHT,
    problem,
    refinement,
)
from benchmarks.measures.refinement import Case
from benchmarks.statistics import readings
from benchmarks.store.frames import frame, number, row
from references.scipy.ivp import TIGHT
from references.scipy.rigid_ivp import RIGID_DOP853

REACHED = 1e-14
# To n = 5 this small swing is nearly a sum of sines, entire functions, for which errors fall faster
# than geometrically: of one a hundredth as large by 75, 150, 340, 440 and 1300 times from n = 2 on.
# The rate that is left is slower, and a window from n = 2 would see it as an end of the decay.
FROM = 4
WEIGHTS = (WEIGHT, 22.0)  # H gives none; 22 is one for which its figures 3.8 and 3.9 hold
# (m g, T): the n up to which the curves are as good as the steps
UP_TO = {(WEIGHT, 50.0): 3, (WEIGHT, 500.0): 4, (22.0, 50.0): 4, (22.0, 500.0): 5}
BEHIND = 6  # n for which they are not, for any of these
LEAST = 1e-9  # a tenth of the one-step error at n = 6, T = 500
SETUP = f"{MOTION}; {METHOD}; h = {STEP:g}, T = {DURATION:g}; entries of R"


def study(make_method: MakeMethod, quick: bool, report: Report) -> pd.DataFrame:
    """Series 'n-refinement' of the one-step and the curve error."""
    cases = [Case(n, STEP, round(DURATION / STEP)) for n in range(2, 15 if quick else 19)]
    rows = refinement("n-refinement", cases, make_method, report)
    for weight in WEIGHTS:
        heavy = galvi.problems.pendulum_3d(weight=weight)
        rows += scan(heavy, make_method, report, _what(weight))
    away = between(problem(), DURATIONS[1], RIGID_DOP853, **TIGHT)
    return frame([*rows, row(study=ORACLES, quantity=ORACLES, value=away)])


def judge(table: pd.DataFrame) -> list[Row]:
    """For each quantity: whether it decays geometrically, and whether it reaches round-off."""
    rows = []
    for quantity in QUANTITIES:
        decay = readings.decay(table, FLOOR, FROM, study="n-refinement", quantity=quantity)
        rows += [
            L6.row(
                f"base of the {quantity}",
                Geometric(),
                decay,
                setup=f"{SETUP}; from n = {FROM} on",
                claimed="geometric convergence",
            ),
            L6.row(
                f"smallest {quantity}",
                AtMost(REACHED),
                decay.smallest,
                claimed="very high accuracy",
            ),
        ]
    return [*rows, *_curves_and_ends(table)]


def _curves_and_ends(table: pd.DataFrame) -> list[Row]:
    """H: once again, the curves have the same error as the steps."""
    scanned = f"m g = {listed(WEIGHTS)}, T = {listed()} (H gives neither)"
    found = [
        L6.row(
            f"largest ratio of curve to one-step error, n <= {n}, m g = {weight:g}, "
            f"T = {duration:g}",
            AtMost(SAME),
            largest_ratio(table, duration, n, _what(weight)),
            setup=_setup(f"{weight:g}", f"{duration:g}, of {scanned}"),
            claimed=BOTH,
            reason=WHY,
        )
        for (weight, duration), n in UP_TO.items()
    ]
    for weight in WEIGHTS:
        found += [
            L6.row(
                f"ratio of curve to one-step error, n = {BEHIND}, m g = {weight:g}, "
                f"T = {DURATIONS[-1]:g}",
                Finding(Above(SAME)),
                ratio(table, DURATIONS[-1], BEHIND, _what(weight)),
                setup=_setup(f"{weight:g}", f"{DURATIONS[-1]:g}, of {scanned}"),
                claimed="not in H: it prints neither T nor n",
                reason="For every T there is an n from which on the curve is behind: a curve of "
                "degree n - 1 has the error of the best polynomial, and step ends about its "
                "square.",
            ),
            L6.row(
                f"power of 1 / T in the ratio of curve to one-step error, n = {BEHIND}, "
                f"m g = {weight:g}",
                Finding(Near(1.0, 0.25)),
                power(table, BEHIND, _what(weight)),
                setup=_setup(f"{weight:g}", listed()),
                claimed="not in H",
                reason=POWER,
            ),
        ]
    return [
        *found,
        L6.row(
            ORACLES,
            Finding(AtMost(LEAST)),
            number(table, quantity=ORACLES),
            setup=f"{MOTION}; T = {DURATIONS[1]:g}, 100 samples",
            claimed="no claim: check of the reference",
            reason="A tenth of the smallest error on which a row of the scan rests.",
        ),
    ]


def _what(weight: float) -> str:
    return f"m g = {weight:g}, "


def _setup(weight: str, duration: str) -> str:
    return f"{BODY}, m g = {weight}; {START}; {METHOD}; h = {STEP:g}, T = {duration}"


L6 = Claim(
    "L6",
    "3D pendulum at h = 0.5: errors fall geometrically with n",
    study,
    judge,
    ("H fig. 3.5",),
    setup=SETUP,
    reason="The motion is analytic in t, with singularities off the real axis: polynomials "
    "converge to it geometrically, and step ends with the square of their base.",
    reference=f"{TRUTH.name}; SciPy's agrees to 1e-12 at T = 50",
    statement="H fig. 3.5: errors fall geometrically with n, and the curve is as accurate as the "
    "steps. Measured: so up to an n that depends on T; beyond it the curve is behind.",
)
