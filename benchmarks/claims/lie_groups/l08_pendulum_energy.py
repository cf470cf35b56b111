"""L8: the 3D pendulum near its equilibrium, energy over 5000 long steps (H figure 3.7)."""

from __future__ import annotations

from benchmarks.claims.kit import *
from benchmarks.claims.lie_groups.pendulum_motion import METHOD, MOTION, TRUTH, problem
from benchmarks.claims.short_runs import PLACES, SHORT, short_runs
from benchmarks.claims.short_runs import STEPS as FEW
from benchmarks.measures.errors import energy_errors
from benchmarks.measures.refinement import history
from references.scipy.ivp import TIGHT
from references.scipy.rigid_ivp import RIGID_DOP853

N, STEP, STEPS = 8, 1.5, 5000
QUANTITY = "energy error"
REFINED = "h-refinement"
ORDER = f"order of the largest {QUANTITY}, n = {N}"
DURATION = 300.0  # of the refinement: 200 steps of 1.5, some 70 swings
NUMBERS = tuple(round(200 * 2.0 ** (j / 4)) for j in range(7))  # of steps
FLOOR = 5e-15  # round-off; 1e-15 was measured at h = 0.375
SECOND = f"{RIGID_DOP853.name}, rtol {TIGHT['rtol']:g}"
SETUP = f"{MOTION}; {METHOD}, n = {N}; h = {STEP:g}, {STEPS} steps; relative, at step ends"


def study(make_method: MakeMethod, quick: bool, report: Report) -> DataFrame:
    """Series 'history' of the relative energy error at step ends, from (R, p); 'h-refinement' of
    its largest value; short runs from all over the motion; how far apart it is by two oracles."""
    report(f"n = {N}, {STEPS} steps of {STEP:g}")
    measures = {QUANTITY: energy_errors}
    case = Case(N, STEP, STEPS)
    rows = history("history", problem(), case, measures, make_method, method_on_group)
    cases = at_fixed_time([N], DURATION, NUMBERS)
    options = (make_method, report, method_on_group)
    rows += refine(REFINED, problem(), TRUTH, cases, [QUANTITY], *options)
    method = method_on_group(make_method, N)
    rows += short_runs(QUANTITY, problem(), TRUTH, DURATION, method, STEP)
    report(ORACLES)
    samples = {"samples": PLACES}
    second = RIGID_DOP853.run(problem(), DURATION, {**samples, **TIGHT})
    away = float(np.max(np.abs(TRUTH.run(problem(), DURATION, samples).q - second.q)))
    return frame([*rows, row(study=ORACLES, quantity=ORACLES, value=away)])


def judge(table: DataFrame) -> list[Row]:
    """Small, of the method's order, and without drift."""
    drift = readings.drift(table, study="history", quantity=QUANTITY)
    limit = readings.largest_of(table, study=SHORT, quantity=QUANTITY)
    return [
        L8.row(
            f"{QUANTITY}, n = {N}",
            NoGrowth(limit),
            drift,
            setup=f"{SETUP}; limit: the largest error of {FEW} steps from any of {PLACES} places "
            f"on the motion by {TRUTH.name}",
            reference=f"initial energy; the motion by {TRUTH.name}, and by {SECOND}",
        ),
        L8.row(
            ORDER,
            Finding(AtLeast(2.0 * (N - 1), uncertainty=0.0)),
            readings.order(table, FLOOR, study=REFINED, quantity=QUANTITY),
            setup=f"{MOTION}; {METHOD}, n = {N}; T = {DURATION:g}, h = T / k, k = "
            f"{', '.join(map(str, NUMBERS))}; relative, the largest at step ends",
            claimed="small",
            reason="Its size is the method's, not a mistake's: the modified energy differs from "
            "the energy by a term of order 2 (n - 1) and by those above, seen at these steps.",
        ),
        L8.row(
            ORACLES,
            Finding(AtMost(1e-6)),
            number(table, quantity=ORACLES),
            setup=f"{MOTION}; to t = {DURATION:g}, largest entry of R at {PLACES} places",
            claimed="no claim: check of the reference",
            reason="Short runs that start this far off the motion have errors that differ by such "
            "a share, and so does the limit of the first row.",
            reference=f"{TRUTH.name}; {SECOND}",
        ),
    ]


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
    statement="H fig. 3.7: the energy error is small and oscillates without growing.",
    caught=(
        of_table(
            "order of the largest energy error, n = 8",
            integral=1.0 + 1e-4,
            wrong={
                f"{__name__}.STEPS": always(20),
                f"{__name__}.short_runs": always(lambda *given: []),
            },
        ),
    ),
)
