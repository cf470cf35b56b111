"""L15: Galerkin curves against exact motions with the same end points (H theorems 3.3.3, 3.3.4)."""

from __future__ import annotations

from benchmarks.claims.kit import *
from benchmarks.claims.lie_groups.pendulum_motion import (
    METHOD,
    MOTION,
    OTHER_MOTIONS,
    TRUTH,
    problem,
)
from benchmarks.measures.boundary_motion import CURVE, ENDS, IN_H, IN_N, distance

STEP = 1.0
NS = (3, 4, 5, 6)
FLOOR = {ENDS: 5e-15, CURVE: 1e-14}
# Factor n^-g of each: the motion's complex singularities have no closed form, so that g is not
# known; branch points and poles as in V14 and V26 have g between 0 and 1.
POWER = (0.5, 0.5)  # and its error
SETUP = (
    f"{MOTION}; {METHOD}; one step%s; the exact motion between the same attitudes by shooting; "
    "integral of |xi - xi_exact| + |xi' - xi_exact'| over the step"
)


def study(make_method: MakeMethod, quick: bool, report: Report) -> DataFrame:
    """Both quantities for one step, against n at h = 1 and against h for n = 3 to 6."""
    report(IN_N)
    found = _steps(IN_N, make_method, range(3, 14 if quick else 17), [STEP])
    for n in NS:
        report(f"{IN_H}, n = {n}")
        sizes = [2.0 ** (-j / 2) for j in range(9 if quick else 14)]
        found += _steps(IN_H, make_method, [n], sizes)
    return frame(found)


def _steps(
    study: str, make_method: MakeMethod, ns: Iterable[int], sizes: Iterable[float]
) -> list[dict[str, Any]]:
    found = []
    for n in ns:
        for h in sizes:
            run = galvi.integrate(problem(), method_on_group(make_method, n), h, 1)
            far = error = float("nan")
            if run.success:
                exact = TRUTH.run(problem(), h, {"samples": 1}).q[-1]
                error = float(np.max(np.abs(run.q[-1] - exact)))
                far = distance(run, TRUTH)
            where = {"study": study, "n": n, "step": h, "steps": 1, "status": failure(run)}
            found += rows({ENDS: error, CURVE: far}, **where)
    return found


def judge(table: DataFrame) -> list[Row]:
    """The curve's base against the square root of the step's; its order against half the step's."""
    ends = readings.decay(table, FLOOR[ENDS], study=IN_N, quantity=ENDS)
    steps = readings.base(table, FLOOR[ENDS], study=IN_N, quantity=ENDS, power=POWER)
    setup = SETUP % f" of h = {STEP:g}"
    root = math.sqrt(steps.rate) if steps.rate > 0.0 else math.nan
    return [
        L15.row(
            "base of the step's error",
            Geometric(),
            ends,
            source="H thm. 3.3.3",
            setup=setup,
            claimed="geometric convergence, O(K^n)",
            reason="The motion is analytic in t; this is the K of the next row.",
        ),
        L15.row(
            "base of the curve's distance",
            AtMost(root, uncertainty=0.5 * root * steps.uncertainty / steps.rate),
            readings.base(table, FLOOR[CURVE], study=IN_N, quantity=CURVE, power=POWER),
            source="H thm. 3.3.3",
            setup=f"{setup}; both times n^-g, g = 1/2 -+ 1/2",
            claimed=f"O(sqrt(K)^n), K the step's base, measured {steps.rate:.3g}",
            reason="The curve is the polynomial of degree n - 1 nearest in energy, and the error "
            "of a step end is the square of its distance.",
        ),
        *(_order(table, n) for n in NS),
    ]


def _order(table: DataFrame, n: int) -> Row:
    steps, curve = (
        readings.order(table, FLOOR[quantity], study=IN_H, quantity=quantity, n=n)
        for quantity in (ENDS, CURVE)
    )
    half = float(np.maximum(0.5 * steps.rate, n - 0.5))
    return L15.row(
        f"order of the curve's distance, n = {n}",
        AtLeast(half, uncertainty=0.5 * steps.uncertainty),
        curve,
        source="H thm. 3.3.4",
        setup=SETUP % f" of h = 2^(-j/2), j = 0, 1, ...; n = {n}",
        claimed="at least half the order of the step's error: the larger of 2 n - 1 and the "
        f"measured {steps.rate:.3g}",
        reason=f"Over one step the curve is of order n = {n}, the end of order 2 n - 1 = "
        f"{2 * n - 1}: half an order to spare.",
    )


L15 = Claim(
    "L15",
    "Galerkin curves on the group: at least half the rate of the steps",
    study,
    judge,
    ("H thm. 3.3.3", "H thm. 3.3.4"),
    reference=f"{TRUTH.name}; stored truth in quadruple precision (A9)",
    statement="H thm. 3.3.3, 3.3.4: on the group, too, the curve between exact ends converges at "
    "half the rate of the step at least.",
    caught=(
        of_table("base of the step's error", b=1.0 + 1e-6),
        of_table("order of the curve's distance, n = 6", integral=1.0 + 1e-4),
        *OTHER_MOTIONS,
    ),
)
