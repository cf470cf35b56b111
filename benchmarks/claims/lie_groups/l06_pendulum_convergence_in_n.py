"""L6: the 3D pendulum near its equilibrium, n-refinement (H figure 3.5)."""

from __future__ import annotations

import pandas as pd

from benchmarks.checks import bounds
from benchmarks.checks.claim import Claim, MakeMethod, Report, Row
from benchmarks.claims.lie_groups.pendulum_motion import (
    DURATION,
    FLOOR,
    METHOD,
    MOTION,
    STEP,
    TRUTH,
    problem,
)
from benchmarks.measures.refinement import Case, method_on_group, refine
from benchmarks.statistics import convergence_fits
from benchmarks.store.frames import frame, series

QUANTITIES = ("one-step error", "curve error")
REACHED, GAIN = 1e-14, 0.15
SETUP = f"{MOTION}; {METHOD}; h = {STEP:g}, T = {DURATION:g}; entries of R"


def study(make_method: MakeMethod, quick: bool, report: Report) -> pd.DataFrame:
    """Series 'n-refinement' of the one-step and the curve error."""
    cases = [Case(n, STEP, round(DURATION / STEP)) for n in range(2, 15 if quick else 19)]
    rows = refine(
        "n-refinement", problem(), TRUTH, cases, QUANTITIES, make_method, report, method_on_group
    )
    return frame(rows)


def judge(table: pd.DataFrame) -> list[Row]:
    """For each quantity: is the fall geometric, and does it reach round-off?"""
    rows = []
    for quantity in QUANTITIES:
        n, errors = series(table, "n", study="n-refinement", quantity=quantity)
        fit = convergence_fits.geometric(n, errors, floor=FLOOR)
        worst = convergence_fits.worst_ratio(errors, floor=FLOOR)
        smallest = float(errors.min()) if errors.size else float("nan")
        rows += [
            _row(
                quantity=f"base of the {quantity}",
                claimed="geometric convergence",
                bound=f"each n multiplies the error by at most {GAIN:g}, down to {FLOOR:g}",
                measured=fit.rate,
                uncertainty=fit.uncertainty,
                verdict=bounds.every_n_gains(fit, worst, GAIN),
            ),
            _row(
                quantity=f"smallest {quantity}",
                claimed="very high accuracy",
                bound=f"at most {REACHED:g}",
                measured=smallest,
                uncertainty=None,
                verdict=bounds.bound(smallest, REACHED),
            ),
        ]
    return [*rows, _apart(table)]


def _apart(table: pd.DataFrame) -> Row:
    """H sees the same error on curves and at steps; an integrator without its error shows two."""
    n, ends = series(table, "n", study="n-refinement", quantity="one-step error")
    _, curve = series(table, "n", study="n-refinement", quantity="curve error")
    ratio = float(curve[n == 8][0] / ends[n == 8][0]) if 8 in n else float("nan")
    return _row(
        quantity="curve error over one-step error, n = 8",
        claimed="the curves have the same error as the one-step map",
        bound="at most 10",
        measured=ratio,
        uncertainty=None,
        verdict=bounds.bound(ratio, 10.0),
        expected=bounds.CONTRADICTED,
        reason="A curve of degree n - 1 has the error of the best polynomial, and step ends about "
        "its square; over T = 5 the ends accumulate too little to hide that.",
    )


def _row(**measured: object) -> Row:
    told = {
        "expected": bounds.HOLDS,
        "reason": "The motion is analytic in t, with singularities off the real axis: polynomials "
        "converge to it geometrically, and step ends with the square of their base.",
        **measured,
    }
    return Row(id="L6", source="H fig. 3.5", setup=SETUP, reference=TRUTH.name, **told)


L6 = Claim(
    "L6", "3D pendulum at h = 0.5: errors fall geometrically with n", study, judge, ("H fig. 3.5",)
)
