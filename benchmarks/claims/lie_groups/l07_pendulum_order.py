"""L7: the 3D pendulum near its equilibrium, order under h-refinement (H figure 3.6)."""

from __future__ import annotations

from benchmarks.claims.kit import *
from benchmarks.claims.lie_groups.pendulum_motion import (
    DURATION,
    METHOD,
    MOTION,
    OTHER_MOTIONS,
    TRUTH,
    refinement,
)

NS = (3, 4, 5, 6)
FLOOR = 2e-14  # entries of R; 1.2e-14 was measured after 256 steps
FIXED_TIME = "h-refinement, T = 5"
OPTIMAL = "almost exactly order optimal; H prints neither a number, nor T, nor m g"
SETUP = f"{MOTION}; {METHOD}, n = %d; T = {DURATION:g}, h = T / round(2^(j/4)), j = 10, 11, ..."


def step_counts(quick: bool) -> list[int]:
    """Steps to T = 5, growing by the fourth root of 2."""
    return [round(2.0 ** (j / 4)) for j in range(10, 28 if quick else 31)]


def study(make_method: MakeMethod, quick: bool, report: Report) -> DataFrame:
    """Series 'h-refinement, T = 5' of the one-step and the curve error for n = 3 to 6."""
    cases = at_fixed_time(NS, DURATION, step_counts(quick))
    return frame(refinement(FIXED_TIME, cases, make_method, report))


def judge(table: DataFrame) -> list[Row]:
    """For each n: the orders of step ends and of the curve."""
    return [row for n in NS for row in _orders(table, n)]


def _orders(table: DataFrame, n: int) -> list[Row]:
    ends, curve = (
        readings.order(table, FLOOR, study=FIXED_TIME, quantity=quantity, n=n)
        for quantity in ENDS_AND_CURVE
    )
    setup, order = SETUP % n, 2 * (n - 1)
    return [
        L7.row(
            f"order of the one-step error, n = {n}",
            Finding(Order(order)),
            ends,
            setup=setup,
            claimed=OPTIMAL,
            reason="Polynomials of degree n - 1 approximate to order n; step ends of a variational "
            f"method converge with 2 (n - 1) = {order}, as on vector spaces (V6), the order of "
            "Gauss collocation with n - 1 points. H's figure may show the curves: see their rows.",
        ),
        L7.row(
            f"order of the curve error, n = {n}",
            Finding(Order(n)),
            curve,
            setup=setup,
            claimed=OPTIMAL,
            reason="The error of the best polynomial of degree n - 1: this is optimal, too.",
        ),
    ]


L7 = Claim(
    "L7",
    "3D pendulum: almost exactly optimal order in h",
    study,
    judge,
    ("H fig. 3.6",),
    reference=f"{TRUTH.name}; stored truth in quadruple precision (A9)",
    statement="H fig. 3.6: errors have almost exactly optimal order in h, without a number. "
    "Measured: n along the curve, that of the best approximation, and 2 (n - 1) at the ends of "
    "steps.",
    caught=(
        of_table("order of the one-step error, n = 5", b=1.0 + 1e-4),
        of_table("order of the one-step error, n = 4", b=1.0 + 1e-6),
        of_table("order of the curve error, n = 4", integral=1.0 + 1e-4),
        *OTHER_MOTIONS,
    ),
)
