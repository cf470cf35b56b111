"""L7: the 3D pendulum near its equilibrium, order under h-refinement (H figure 3.6)."""

from __future__ import annotations

import pandas as pd

from benchmarks.checks import bounds
from benchmarks.checks.claim import Claim, MakeMethod, Report, Row
from benchmarks.claims.lie_groups.pendulum_motion import DURATION, METHOD, MOTION, TRUTH, problem
from benchmarks.measures.refinement import at_fixed_time, method_on_group, refine
from benchmarks.statistics import convergence_fits
from benchmarks.store.frames import frame, series

NS = (3, 4, 5, 6)
FLOOR = 2e-14  # entries of R; 1.2e-14 was measured after 256 steps
QUANTITIES = ("one-step error", "curve error")
FIXED_TIME = "h-refinement, T = 5"
SETUP = f"{MOTION}; {METHOD}, n = %d; T = {DURATION:g}, h = T / round(2^(j/4)), j = 10, 11, ..."


def step_counts(quick: bool) -> list[int]:
    """Steps to T = 5, growing by the fourth root of 2."""
    return [round(2.0 ** (j / 4)) for j in range(10, 28 if quick else 31)]


def study(make_method: MakeMethod, quick: bool, report: Report) -> pd.DataFrame:
    """Series 'h-refinement, T = 5' of the one-step and the curve error for n = 3 to 6."""
    rows = []
    for n in NS:
        cases = at_fixed_time(n, DURATION, step_counts(quick))
        rows += refine(
            FIXED_TIME, problem(), TRUTH, cases, QUANTITIES, make_method, report, method_on_group
        )
    return frame(rows)


def judge(table: pd.DataFrame) -> list[Row]:
    """For each n the order against H's n, and against 2 (n - 1); that of the curve against n."""
    rows = []
    for n in NS:
        fit = _fit(table, n, "one-step error")
        rows += [
            _row(
                n, "order of the one-step error", f"optimal order, n = {n}", n, fit,
                bounds.EXCEEDS,
                "Polynomials of degree n - 1 approximate to order n, which H calls optimal; step "
                f"ends of a variational method converge with 2 (n - 1) = {2 * (n - 1)}.",
            ),
            _row(
                n, "order of the one-step error against 2 (n - 1)",
                f"no number in H; superconvergence, order 2 (n - 1) = {2 * (n - 1)}", 2 * (n - 1),
                fit, bounds.HOLDS,
                "As on vector spaces (V6), the order of Gauss collocation with n - 1 points.",
            ),
            _row(
                n, "order of the curve error", f"optimal order, n = {n}", n,
                _fit(table, n, "curve error"), bounds.HOLDS,
                "The error of the best polynomial of degree n - 1.",
            ),
        ]  # fmt: skip
    return rows


def _fit(table: pd.DataFrame, n: int, quantity: str) -> convergence_fits.Fit:
    h, errors = series(table, "step", study=FIXED_TIME, quantity=quantity, n=n)
    return convergence_fits.algebraic(h, errors, floor=FLOOR)


def _row(
    n: int,
    quantity: str,
    claimed: str,
    order: float,
    fit: convergence_fits.Fit,
    expected: str,
    reason: str,
) -> Row:
    return Row(
        id="L7",
        quantity=f"{quantity}, n = {n}",
        source="H fig. 3.6",
        setup=SETUP % n,
        claimed=claimed,
        bound=f"order {order:g} -+ {bounds.ORDER_RESOLUTION} -+ 2 standard errors",
        measured=fit.rate,
        uncertainty=fit.uncertainty,
        expected=expected,
        reason=reason,
        reference=TRUTH.name,
        verdict=bounds.order(fit, order),
    )


L7 = Claim("L7", "3D pendulum: one-step error of optimal order in h", study, judge, ("H fig. 3.6",))
