"""L3: the free rigid body, order under h-refinement (H figure 3.2, theorem 3.3.1)."""

from __future__ import annotations

import math

import pandas as pd

import galvi
from benchmarks.checks.bounds import CONTRADICTED, EXCEEDS, ORDER_RESOLUTION, Near, Order
from benchmarks.checks.claim import Claim, MakeMethod, Report, Row
from benchmarks.claims.lie_groups.free_body import BODY, DURATION, FLOOR, METHOD, problem
from benchmarks.measures.refinement import at_fixed_time, method_on_group, refine, refine_at_end
from benchmarks.statistics import readings
from benchmarks.statistics.convergence_fits import Fit
from benchmarks.statistics.estimate import Estimate
from benchmarks.store.frames import frame
from references.closed_forms.free_top import FREE_TOP
from references.scipy.ivp import TIGHT
from references.scipy.rigid_ivp import RIGID_DOP853

NS = (3, 4, 5, 6)
QUANTITY, AT_END = "one-step error", "error at the end"
BODY_STUDY, PENDULUM = "h-refinement, T = 5", "h-refinement, pendulum"
WEIGHT = 98.1
END_FLOOR = 3e-13  # ten times the error of DOP853 at these tolerances
PENDULUM_SETUP = (
    f"3D pendulum of H 3.5.2 with m g = {WEIGHT:g}, swinging by 0.1 rad in 1 s; {METHOD}; Cayley; "
    f"T = {DURATION:g}, error at the end, h = T / (4 round(2^(j/2))), j = 3, 4, ..."
)


def study(make_method: MakeMethod, quick: bool, report: Report) -> pd.DataFrame:
    """Series 'h-refinement, T = 5' of H's body, and 'h-refinement, pendulum', whose errors reach
    the asymptotic order before round-off, for n = 3 to 6."""
    counts = [round(2.0 ** (j / 2)) for j in range(6, 15 if quick else 17)]
    cases, options = at_fixed_time(NS, DURATION, counts), (make_method, report, method_on_group)
    rows = refine(BODY_STUDY, problem(), FREE_TOP, cases, [QUANTITY], *options)
    pendulum = galvi.problems.pendulum_3d(WEIGHT)
    exact = RIGID_DOP853.run(pendulum, DURATION, {"samples": 1, **TIGHT}).q[-1]
    counts = [4 * round(2.0 ** (j / 2)) for j in range(3, 11 if quick else 17)]
    cases = at_fixed_time(NS, DURATION, counts)
    return frame(rows + refine_at_end(PENDULUM, AT_END, pendulum, exact, cases, *options))


def claimed_order(n: int) -> int:
    """The order observed in H: n for even n, n - 1 for odd."""
    return 2 * math.floor(n / 2)


def judge(table: pd.DataFrame) -> list[Row]:
    """Against H's orders; H's parity; and both sides of 2 (n - 1)."""
    known = {n: readings.order(table, FLOOR, study=BODY_STUDY, quantity=QUANTITY, n=n) for n in NS}
    return [
        *(_against_h(n, known[n]) for n in NS),
        _parity(known[4], known[5]),
        *(_both_sides(table, n) for n in NS),
    ]


def _against_h(n: int, fit: Fit) -> Row:
    claimed = claimed_order(n)
    reason = (
        f"Polynomials of degree {n - 1} with Gauss's rule of {n} points have order 2 (n - 1) = "
        f"{2 * (n - 1)}, on groups as on vector spaces."
    )
    if n == 6:
        reason += (
            " Here the error is at round-off before the terms of higher order are small beside "
            "it, and falls faster than that."
        )
    return L3.row(
        f"order of the one-step error, n = {n}",
        Order(claimed),
        fit,
        setup=f"{BODY}; {METHOD}, n = {n}; Cayley; T = {DURATION:g}, h = T / round(2^(j/2)), "
        "j = 6, 7, ...",
        claimed=f"optimal for even n, n - 1 for odd: order {claimed}",
        expected=EXCEEDS,
        reason=reason,
    )


def _parity(four: Fit, five: Fit) -> Row:
    uncertainty = math.hypot(five.uncertainty, four.uncertainty)
    return L3.row(
        "order for n = 5 less that for n = 4",
        Near(0.0, ORDER_RESOLUTION, uncertainty=0.0),
        Estimate(five.rate - four.rate, uncertainty),
        setup=f"{BODY}; {METHOD}; Cayley; T = {DURATION:g}",
        claimed="n - 1 = 4 for n = 5, as for n = 4: no gain",
        expected=CONTRADICTED,
        reason="Each basis function gains two orders, whatever its parity. H has no explanation "
        "for the parity either; it could not be reproduced, with this rule or in the exponential "
        "chart.",
    )


def _both_sides(table: pd.DataFrame, n: int) -> Row:
    order = 2 * (n - 1)
    return L3.row(
        f"order from both sides, n = {n}",
        Order(order),
        readings.order(table, END_FLOOR, study=PENDULUM, quantity=AT_END, n=n),
        setup=f"{PENDULUM_SETUP}; n = {n}",
        claimed=f"order-optimal; we say 2 (n - 1) = {order}, no less and no more",
        reason="A motion of small turns, whose chart is nearly flat: the leading term of the error "
        "is all that is left of it well above round-off.",
        reference=f"{RIGID_DOP853.name}, rtol {TIGHT['rtol']:g}",
    )


L3 = Claim(
    "L3",
    "Free rigid body: one-step error of order n, or n - 1 for odd n, in h",
    study,
    judge,
    ("H fig. 3.2",),
    source="H fig. 3.2, thm. 3.3.1",
    reference=FREE_TOP.name,
)
