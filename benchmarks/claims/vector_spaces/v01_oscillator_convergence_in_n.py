"""V1: the harmonic oscillator, n-refinement at a step of three periods (H figure 2.3)."""

from __future__ import annotations

from benchmarks.claims.kit import *
from references.closed_forms.oscillator import OSCILLATOR

STEP, STEPS = 20.0, 100
FLOOR = 1e-11  # round-off of a phase of 2000 radians; 5e-12 in a prototype
REACHED = 1e-10
SETUP = (
    "harmonic oscillator m = k = 1, q0 = 1, v0 = 0; Polynomials(n - 1), gauss(2 n); "
    f"h = {STEP:g}, {STEPS} steps"
)


def study(make_method: MakeMethod, quick: bool, report: Report) -> DataFrame:
    """Series 'n-refinement' of the one-step and the curve error."""
    cases = [Case(n, STEP, STEPS) for n in (range(14, 31) if quick else range(8, 31))]
    problem = galvi.problems.harmonic_oscillator()
    return frame(
        refine("n-refinement", problem, OSCILLATOR, cases, ENDS_AND_CURVE, make_method, report)
    )


def judge(table: DataFrame) -> list[Row]:
    """For each quantity: whether it decays geometrically, and whether it reaches round-off."""
    rows = []
    for quantity in ENDS_AND_CURVE:
        decay = readings.decay(table, FLOOR, study="n-refinement", quantity=quantity)
        rows += [
            V1.row(f"base of the {quantity}", Geometric(), decay, claimed="geometric convergence"),
            V1.row(
                f"smallest {quantity}",
                Finding(AtMost(REACHED)),
                decay.smallest,
                claimed="attains very high accuracy",
            ),
        ]
    return rows


V1 = Claim(
    "V1",
    "Oscillator at h = 20: errors fall geometrically with n",
    study,
    judge,
    ("H fig. 2.3",),
    setup=SETUP,
    reason="The solution is entire, so the best polynomial, and with it the method, converges "
    "faster than any geometric rate once a step of three periods is resolved. Of the n below 12 "
    "some are unstable at this step (n = 3, 4, 5, 7, 10), the others err by the size of the "
    "motion; so do n = 12 to 14, by their phase (1.17 after 100 steps at n = 14): none is fitted.",
    reference=f"{OSCILLATOR.name}; SciPy DOP853 (A9)",
    statement="H fig. 2.3: at a step of three periods the errors of steps and curve fall "
    "geometrically with n, to very high accuracy.",
    caught=(of_table("base of the one-step error", "smallest one-step error", beta=1.0 + 1e-6),),
)
