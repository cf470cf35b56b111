"""L2: the free rigid body, n-refinement (H figure 3.1)."""

from __future__ import annotations

from benchmarks.claims.kit import *
from benchmarks.claims.lie_groups.curves_and_ends import (
    CURVE,
    DURATIONS,
    ENDS,
    between,
    rows_of,
    scan,
)
from benchmarks.claims.lie_groups.free_body import (
    BODY,
    CAYLEY,
    DURATION,
    FLOOR,
    METHOD,
    METHODS,
    OTHER_MOTIONS,
    STEP,
    problem,
)
from benchmarks.measures.rigid_invariants import has_pole
from galvi.charts import CHARTS
from references.closed_forms.top_motion import FREE_TOP

STUDIES = {chart: f"n-refinement, {chart}" for chart in METHODS}
REACHED_AT, REACHED = 12, 1e-12
FROM = {chart: 7 if chart == CAYLEY else 5 for chart in METHODS}  # from there the curve's own
# error exceeds that of its ends
# A turn by pi is infinitely far in Cayley's chart: xi = 2 tan(|Omega| t / 2) has its nearest pole
# at pi / |Omega| = 1.071 after the start of a step. Seen from the middle of [0, h] it is 3.28 half
# steps away: polynomials converge like r^-n, r = 3.28 + sqrt(3.28^2 - 1) (Bernstein's ellipse).
# That of modified Rodrigues parameters, 4 tan(|Omega| t / 4), is at 2 pi / |Omega|: r = 15.1.
AWAY = {
    chart.name: 2.0 * chart.limit / (STEP * math.hypot(2.0, -1.9, 1.0)) - 1.0
    for chart in CHARTS
    if has_pole(chart)
}
POLES = {chart: 1.0 / (away + math.sqrt(away**2 - 1.0)) for chart, away in AWAY.items()}
RESOLUTION = 0.005
LEAST = 2e-10  # a tenth of the one-step error at n = 10, T = 500
CLAIMED = "geometric convergence"
SECOND = f"DOP853 on quaternions, compiled; {FREE_TOP.name} agrees to 1e-11 at T = 500"
COMPARED = 6
OTHER = "not in H: other charts would be interesting further work"
REASONS = {
    ENDS: "The motion and the chart are analytic: the best polynomial converges geometrically, and "
    "the step ends with it, at twice the rate.",
    CURVE: "The best polynomial's own rate, half that of the step ends; for fewer n the ends' "
    "error dominates, as in V4. In Cayley's chart the rate is that of its pole at a turn by pi, in "
    "modified Rodrigues parameters that of theirs at 2 pi.",
}
STRAIGHT = (
    "A free body turns almost steadily, and a steady turning is a straight line in the "
    "exponential chart, which every space holds; in Cayley's it is a tangent."
)
FARTHER = (
    "A free body turns almost steadily: xi is nearly k tan(angle / k), k = 2 for Cayley and 4 for "
    "modified Rodrigues parameters, whose pole is at 2 pi instead of pi. The rate of polynomials "
    "is that of the distance to the pole, and that of the step ends its square."
)
OF_CHART = {
    chart: {
        "source": "H fig. 3.1" if chart == CAYLEY else "H 3.4.2, 3.6.1",
        "setup": f"{BODY}; {METHOD}; {chart} chart; h = {STEP:g}, T = {DURATION:g}; largest entry "
        "of R - R_exact",
    }
    for chart in METHODS
}


def study(make_method: MakeMethod, quick: bool, report: Report) -> DataFrame:
    """Series 'n-refinement, Cayley' and so on of the one-step and the curve error."""
    steps = round(DURATION / STEP)
    cases = [Case(n, STEP, steps) for n in range(3, 16)]
    rows = []
    for chart, method in METHODS.items():
        options = (make_method, report, method)
        rows += refine(STUDIES[chart], problem(), FREE_TOP, cases, (ENDS, CURVE), *options)
    rows += scan(problem(), make_method, report)
    away = between(problem(), DURATIONS[-1], FREE_TOP)
    return frame([*rows, row(study=ORACLES, quantity=ORACLES, value=away)])


def judge(table: DataFrame) -> list[Row]:
    """Geometric, small enough; are the curves as good as the steps; and the other charts."""
    return [
        *(row for chart in METHODS for row in _convergence(table, chart)),
        *_curves_and_ends(table),
        *(_over_cayley(table, chart) for chart in METHODS if chart != CAYLEY),
    ]


def _convergence(table: DataFrame, chart: str) -> list[Row]:
    where = {"study": STUDIES[chart]}
    ends = readings.decay(table, FLOOR, quantity=ENDS, **where)
    curve = readings.decay(table, FLOOR, FROM[chart], quantity=CURVE, **where)
    error = number(table, quantity=ENDS, n=REACHED_AT, **where)
    texts = OF_CHART[chart]
    return [
        L2.row(
            f"base of the {ENDS}, {chart} chart", Geometric(), ends, reason=REASONS[ENDS], **texts
        ),
        L2.row(
            f"base of the {CURVE}, {chart} chart",
            Finding(Base(POLES[chart], RESOLUTION)) if chart in POLES else Geometric(),
            curve,
            claimed=CLAIMED + (f"; our value: {POLES[chart]:.3f}" if chart in POLES else ""),
            reason=REASONS[CURVE],
            **texts,
        ),
        L2.row(
            f"{ENDS}, n = {REACHED_AT}, {chart} chart",
            Finding(AtMost(REACHED)),
            error,
            reason=REASONS[ENDS],
            claimed="attains high accuracy" if chart == CAYLEY else OTHER,
            **texts,
        ),
    ]


def _curves_and_ends(table: DataFrame) -> list[Row]:
    """H: the curves have the same error, although theory gives them a lower rate."""
    setup = f"{BODY}; {METHOD}; {CAYLEY} chart; h = {STEP:g}, T = %s"
    return [
        *rows_of(L2, table, setup, reference=SECOND),
        L2.row(
            ORACLES,
            Finding(AtMost(LEAST)),
            number(table, quantity=ORACLES),
            setup=f"{BODY}; T = {DURATIONS[-1]:g}, 100 samples",
            claimed="no claim: check of the reference",
            reason="A tenth of the smallest error on which a row of this T rests.",
            reference=SECOND,
        ),
    ]


def _over_cayley(table: DataFrame, chart: str) -> Row:
    """A finding: for a free body Cayley's chart is not the best one."""
    cayley, other = (
        number(table, study=STUDIES[name], quantity=ENDS, n=COMPARED) for name in (CAYLEY, chart)
    )
    return L2.row(
        f"one-step error over that with Cayley, n = {COMPARED}, {chart} chart",
        Finding(AtMost(1.0)),
        other / cayley,
        claimed=OTHER,
        reason=FARTHER if chart in POLES else STRAIGHT,
        **OF_CHART[chart],
    )


L2 = Claim(
    "L2",
    "Free rigid body at h = 0.5: errors fall geometrically with n",
    study,
    judge,
    ("H fig. 3.1",),
    claimed=CLAIMED,
    reference=f"{FREE_TOP.name}; SciPy DOP853 (A9)",
    statement="H fig. 3.1: errors fall geometrically with n, and the curve is as accurate as the "
    "steps. Measured: so up to an n*(T) that grows with the logarithm of T, which H does not "
    "print; beyond it the curve is behind.",
    caught=(
        of_table("one-step error, n = 12, Cayley chart", b=1.0 + 1e-9),
        of_table(
            "base of the one-step error, exponential chart",
            "base of the curve error, Cayley chart",
            integral=1.0 + 1e-4,
        ),
        *OTHER_MOTIONS,
    ),
)
