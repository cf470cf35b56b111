"""L15: Galerkin curves against exact motions with the same end points (H theorems 3.3.3, 3.3.4)."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any

import numpy as np
import pandas as pd

import galvi
from benchmarks.checks import bounds
from benchmarks.checks.claim import Claim, MakeMethod, Report, Row
from benchmarks.claims.lie_groups.pendulum_motion import METHOD, MOTION, TRUTH, problem
from benchmarks.measures.curve_between_ends import distance
from benchmarks.measures.refinement import method_on_group
from benchmarks.statistics import convergence_fits
from benchmarks.statistics.convergence_fits import Fit
from benchmarks.store.frames import frame, row, series

IN_N, IN_H = "n-refinement, one step", "h-refinement, one step"
ENDS, CURVE = "error of one step", "distance of the curve in W^{1,1}"
STEP, GAIN = 1.0, 0.15
NS = (3, 4, 5, 6)
FLOOR = {ENDS: 5e-15, CURVE: 1e-14}
SETUP = (
    f"{MOTION}; {METHOD}; one step%s; the exact motion between the same attitudes by shooting; "
    "integral of |xi - xi_exact| + |xi' - xi_exact'| over the step"
)


def study(make_method: MakeMethod, quick: bool, report: Report) -> pd.DataFrame:
    """Both quantities for one step, against n at h = 1 and against h for n = 3 to 6."""
    report(IN_N)
    rows = _steps(IN_N, make_method, range(3, 14 if quick else 17), [STEP])
    for n in NS:
        report(f"{IN_H}, n = {n}")
        sizes = [2.0 ** (-j / 2) for j in range(9 if quick else 14)]
        rows += _steps(IN_H, make_method, [n], sizes)
    return frame(rows)


def _steps(
    study: str, make_method: MakeMethod, ns: Iterable[int], sizes: Iterable[float]
) -> list[dict[str, Any]]:
    rows = []
    for n in ns:
        for h in sizes:
            run = galvi.integrate(problem(), method_on_group(make_method, n), h, 1)
            far = error = float("nan")
            if run.success:
                exact = TRUTH.run(problem(), h, {"samples": 1}).q[-1]
                error = float(np.max(np.abs(run.q[-1] - exact)))
                far = distance(run, TRUTH)
            where = {"study": study, "n": n, "step": h, "steps": 1,
                     "status": "" if run.success else run.status}  # fmt: skip
            rows += [row(quantity=ENDS, value=error, **where),
                     row(quantity=CURVE, value=far, **where)]  # fmt: skip
    return rows


def judge(table: pd.DataFrame) -> list[Row]:
    """The curve's base against the square root of the step's; its order against half the step's."""
    n, ends = series(table, "n", study=IN_N, quantity=ENDS)
    _, curve = series(table, "n", study=IN_N, quantity=CURVE)
    steps = convergence_fits.geometric(n, ends, floor=FLOOR[ENDS])
    fit = convergence_fits.geometric(n, curve, floor=FLOOR[CURVE])
    root = math.sqrt(steps.rate) if steps.rate > 0.0 else math.nan
    slack = fit.uncertainty + 0.5 * root * steps.uncertainty / steps.rate
    worst = convergence_fits.worst_ratio(ends, floor=FLOOR[ENDS])
    rows = [
        Row(
            id="L15",
            quantity="base of the step's error",
            source="H thm. 3.3.3",
            setup=SETUP % f" of h = {STEP:g}",
            claimed="geometric convergence, O(K^n)",
            bound=f"each n multiplies the error by at most {GAIN:g}, down to {FLOOR[ENDS]:g}",
            measured=steps.rate,
            uncertainty=steps.uncertainty,
            expected=bounds.HOLDS,
            reason="The motion is analytic in t; this is the K of the next row.",
            reference=TRUTH.name,
            verdict=bounds.every_n_gains(steps, worst, GAIN),
        ),
        Row(
            id="L15",
            quantity="base of the curve's distance",
            source="H thm. 3.3.3",
            setup=SETUP % f" of h = {STEP:g}",
            claimed=f"O(sqrt(K)^n), K the step's base, measured {steps.rate:.3g}",
            bound=f"at most sqrt(K) = {root:.3g} + 2 standard errors of both",
            measured=fit.rate,
            uncertainty=fit.uncertainty,
            expected=bounds.HOLDS,
            reason="The curve is the polynomial of degree n - 1 nearest in energy, and the error "
            "of a step end is the square of its distance.",
            reference=TRUTH.name,
            verdict=bounds.bound(fit.rate, root + 2.0 * slack),
        ),
    ]
    return rows + [_order(table, n) for n in NS]


def _fit(table: pd.DataFrame, n: int, quantity: str) -> Fit:
    h, errors = series(table, "step", study=IN_H, quantity=quantity, n=n)
    return convergence_fits.algebraic(h, errors, floor=FLOOR[quantity])


def _order(table: pd.DataFrame, n: int) -> Row:
    steps, fit = _fit(table, n, ENDS), _fit(table, n, CURVE)
    half = float(np.maximum(0.5 * steps.rate, n - 0.5))
    slack = 2.0 * (fit.uncertainty + 0.5 * steps.uncertainty)
    return Row(
        id="L15",
        quantity=f"order of the curve's distance, n = {n}",
        source="H thm. 3.3.4",
        setup=SETUP % f" of h = 2^(-j/2), j = 0, 1, ...; n = {n}",
        claimed=f"at least half the order of the step's error, 2 n - 1, measured {steps.rate:.3g}",
        bound=f"at least {half:.3g}, the larger half of both, - 2 standard errors",
        measured=fit.rate,
        uncertainty=fit.uncertainty,
        expected=bounds.HOLDS,
        reason=f"Over one step the curve is of order n = {n}, the end of order 2 n - 1 = "
        f"{2 * n - 1}: half an order to spare.",
        reference=TRUTH.name,
        verdict=bounds.within(fit.rate, half - slack, math.inf),
    )


L15 = Claim(
    "L15",
    "Galerkin curves on the group: at least half the rate of the steps",
    study,
    judge,
    ("H thm. 3.3.3", "H thm. 3.3.4"),
)
