"""V14: Galerkin curves against exact motions with the same end points (H thms. 2.3.6, 2.3.7)."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any

import numpy as np
import pandas as pd

import galvi
from benchmarks import fits, verdicts
from benchmarks.claim import Claim, MakeMethod, Report, Row
from benchmarks.claims.kepler_orbit import METHOD, ORBIT, problem
from benchmarks.fits import Fit
from benchmarks.refinement import method_of
from benchmarks.same_end_points import Shooting
from benchmarks.tidy import frame, row, series
from references.kepler import KEPLER

IN_N, IN_H = "n-refinement, one step", "h-refinement, one step"
ENDS, CURVE = "error of one step", "distance of the curve in W^{1,1}"
STEP, GAIN = 2.0, 0.4  # each n multiplies the error by 0.33 to 0.35
NS = (3, 4, 5, 6)
FLOOR = {ENDS: 5e-15, CURVE: 3e-14}
SETUP = (
    f"{ORBIT}; {METHOD}; one step%s; the exact motion between the same points by shooting; "
    "integral of |q - q_exact| + |q' - q'_exact| over the step"
)


def study(make_method: MakeMethod, quick: bool, report: Report) -> pd.DataFrame:
    """Both quantities for one step, against n at h = 2 and against h for n = 3 to 6."""
    ns = range(6, 31, 4) if quick else range(5, 34)
    report(IN_N)
    rows = _steps(IN_N, make_method, ns, STEP)
    for j in range(3, 10) if quick else range(15):
        h = 2.0 ** (-j / 2)
        report(f"{IN_H}, h = {h:.4g}")
        rows += _steps(IN_H, make_method, NS, h)
    return frame(rows)


def _steps(
    study: str, make_method: MakeMethod, ns: Iterable[int], h: float
) -> list[dict[str, Any]]:
    exact = Shooting(problem(), h, KEPLER)
    rows = []
    for n in ns:
        run = galvi.integrate(problem(), method_of(make_method, n), h, 1)
        where = {"study": study, "n": n, "step": h, "steps": 1,
                 "status": "" if run.success else run.status}  # fmt: skip
        for quantity, measure in ((ENDS, exact.error), (CURVE, exact.distance)):
            value = measure(run) if run.success else float("nan")
            rows.append(row(quantity=quantity, value=value, **where))
    return rows


def judge(table: pd.DataFrame) -> list[Row]:
    """The curve's base against the square root of the step's; its order against half the step's."""
    n, ends = series(table, "n", study=IN_N, quantity=ENDS)
    _, curve = series(table, "n", study=IN_N, quantity=CURVE)
    steps = fits.geometric(n, ends, floor=FLOOR[ENDS])
    fit = fits.geometric(n, curve, floor=FLOOR[CURVE])
    root = math.sqrt(steps.rate) if steps.rate > 0.0 else math.nan
    slack = fit.uncertainty + 0.5 * root * steps.uncertainty / steps.rate
    worst = fits.worst_ratio(ends, floor=FLOOR[ENDS])
    rows = [
        Row(
            id="V14",
            quantity="base of the step's error",
            source="H thm. 2.3.6",
            setup=SETUP % f" of h = {STEP:g}",
            claimed="geometric convergence, O(K^n)",
            bound=f"each n multiplies the error by at most {GAIN:g}, down to {FLOOR[ENDS]:g}",
            measured=steps.rate,
            uncertainty=steps.uncertainty,
            expected=verdicts.HOLDS,
            reason="The motion is analytic in t; this is the K of the next row.",
            reference=KEPLER.name,
            verdict=verdicts.every_n_gains(steps, worst, GAIN),
        ),
        Row(
            id="V14",
            quantity="base of the curve's distance",
            source="H thm. 2.3.6",
            setup=SETUP % f" of h = {STEP:g}",
            claimed=f"O(sqrt(K)^n), K the step's base, measured {steps.rate:.3g}",
            bound=f"at most sqrt(K) = {root:.3g} + 2 standard errors of both",
            measured=fit.rate,
            uncertainty=fit.uncertainty,
            expected=verdicts.HOLDS,
            reason="The curve is the polynomial of degree n - 1 nearest in energy, and the error "
            "of a step end is the square of its distance.",
            reference=KEPLER.name,
            verdict=verdicts.bound(fit.rate, root + 2.0 * slack),
        ),
    ]
    return rows + [_order(table, n) for n in NS]


def _fit(table: pd.DataFrame, n: int, quantity: str) -> Fit:
    h, errors = series(table, "step", study=IN_H, quantity=quantity, n=n)
    return fits.algebraic(h, errors, floor=FLOOR[quantity])


def _order(table: pd.DataFrame, n: int) -> Row:
    steps, fit = _fit(table, n, ENDS), _fit(table, n, CURVE)
    half = float(np.maximum(0.5 * steps.rate, n - 0.5))
    slack = 2.0 * (fit.uncertainty + 0.5 * steps.uncertainty)
    return Row(
        id="V14",
        quantity=f"order of the curve's distance, n = {n}",
        source="H thm. 2.3.7",
        setup=SETUP % f" of h = 2^(-j/2), j = 0, 1, ... (3 to 9 in the quick form); n = {n}",
        claimed=f"O(h^((p + 1) / 2)), half the order of a step's error, measured {steps.rate:.3g}",
        bound=f"at least {half:.3g}, the larger half of that and of 2 n - 1, - 2 standard errors",
        measured=fit.rate,
        uncertainty=fit.uncertainty,
        expected=verdicts.HOLDS,
        reason=f"Over one step the curve is of order n = {n}, the end of order 2 n - 1 = "
        f"{2 * n - 1}: half an order to spare.",
        reference=KEPLER.name,
        verdict=verdicts.within(fit.rate, half - slack, math.inf),
    )


V14 = Claim(
    "V14",
    "Galerkin curves between the same points: at least half the rate of the steps",
    study,
    judge,
    ("H thm. 2.3.6", "H thm. 2.3.7"),
)
