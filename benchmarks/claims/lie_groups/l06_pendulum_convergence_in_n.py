"""L6: the 3D pendulum near its equilibrium, n-refinement (H figure 3.5)."""

from __future__ import annotations

from benchmarks.claims.kit import *
from benchmarks.claims.lie_groups.curves_and_ends import (
    DURATIONS,
    between,
    rows_of,
    scan,
)
from benchmarks.claims.lie_groups.pendulum_motion import (
    BODY,
    DURATION,
    FLOOR,
    METHOD,
    MOTION,
    OTHER_MOTIONS,
    START,
    STEP,
    TRUTH,
    WEIGHT,
    problem,
    refinement,
)
from references.scipy.ivp import TIGHT
from references.scipy.rigid_ivp import RIGID_DOP853

REACHED = 1e-14
# To n = 5 this small swing is nearly a sum of sines, entire functions, for which errors fall faster
# than geometrically: of one a hundredth as large by 75, 150, 340, 440 and 1300 times from n = 2 on.
# The rate that is left is slower, and a window from n = 2 would see it as an end of the decay.
FROM = 4
WEIGHTS = (WEIGHT, 22.0)  # H gives none; 22 is one for which its figures 3.8 and 3.9 hold
LEAST = 1e-9  # a tenth of the one-step error at n = 6, T = 500
SETUP = f"{MOTION}; {METHOD}; h = {STEP:g}, T = {DURATION:g}; entries of R"


def study(make_method: MakeMethod, quick: bool, report: Report) -> DataFrame:
    """Series 'n-refinement' of the one-step and the curve error."""
    cases = [Case(n, STEP, round(DURATION / STEP)) for n in range(2, 15 if quick else 19)]
    rows = refinement("n-refinement", cases, make_method, report)
    for weight in WEIGHTS:
        heavy = galvi.problems.pendulum_3d(weight=weight)
        rows += scan(heavy, make_method, report, _what(weight))
    away = between(problem(), DURATIONS[1], RIGID_DOP853, **TIGHT)
    return frame([*rows, row(study=ORACLES, quantity=ORACLES, value=away)])


def judge(table: DataFrame) -> list[Row]:
    """For each quantity: whether it decays geometrically, and whether it reaches round-off."""
    rows = []
    for quantity in ENDS_AND_CURVE:
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
                Finding(AtMost(REACHED)),
                decay.smallest,
                claimed="very high accuracy",
            ),
        ]
    return [*rows, *_curves_and_ends(table)]


def _curves_and_ends(table: DataFrame) -> list[Row]:
    """H: once again, the curves have the same error as the steps."""
    return [
        *(
            row
            for weight in WEIGHTS
            for row in rows_of(
                L6,
                table,
                f"{BODY}, m g = {weight:g} (H prints none); {START}; {METHOD}; h = {STEP:g}, T = "
                "%s",
                _what(weight),
            )
        ),
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
    statement="H fig. 3.5: errors fall geometrically with n, and the curve is as accurate as "
    "the steps. Measured: so up to an n*(T) that grows with the logarithm of T, which H does not "
    "print; beyond it the curve is behind.",
    caught=(
        of_table("smallest one-step error", b=1.0 + 1e-9),
        of_table("base of the one-step error", "base of the curve error", integral=1.0 + 1e-4),
        *OTHER_MOTIONS,
    ),
)
