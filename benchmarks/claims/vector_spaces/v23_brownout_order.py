"""V23: one brownout particle, order with a velocity-dependent force (M figure 3, left)."""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd

import galvi
from benchmarks.checks.bounds import ATTAINED, CONTRADICTED, AtLeast, AtMost, Order, Within
from benchmarks.checks.claim import Claim, MakeMethod, Report, Row
from benchmarks.claims.vector_spaces.brownout_particle import (
    ACROSS,
    AWAY,
    METHOD,
    MOVING,
    PIECES,
    STARTS,
    method_of_degree,
    trajectory_error,
    truth,
)
from benchmarks.measures.refinement import outcome
from benchmarks.statistics import readings
from benchmarks.statistics.estimate import Estimate
from benchmarks.store.frames import frame, number, row, series
from galvi import Trajectory
from references.scipy.ivp import DOP853, RADAU
from references.textbook.semi_implicit_euler import SEMI_IMPLICIT_EULER

DEGREES = (1, 2, 3, 4)
RICHEST, MOST = 12, 64  # M's own reference, in 64 steps
ERROR = "error of the place"
EULER = "semi-implicit Euler"
OWN = "M's reference, N = 12"
CHECKED = "Radau"
SOLVED = f"{AWAY}, solved to round-off"
FLOOR = {AWAY: 2e-13, ACROSS: 1e-10}  # m; DOP853 and Radau differ by 2e-14 and 1.2e-11
NEAR = {AWAY: 1e-12, ACROSS: 1e-8}  # of M's reference: 9e-15 and 1.1e-10 were measured
AGREED = {AWAY: 1e-12, ACROSS: 1e-10}  # of Radau
FINER = 64  # times as many steps of semi-implicit Euler
SATURATED = 10.0  # ratio to the error of a solve to round-off
TOLERANCES = (1e-3, 1e-5, 1e-7)
SCANNED = tuple(10.0**-k for k in range(2, 9))  # for the power that errors fall with
LAST = 5  # smallest steps averaged (geometric mean), since their errors scatter by two decades
SATURATING = 4  # degree of the runs whose solve is stopped early
TRUTH = f"{DOP853.name}, checked by {RADAU.name}"


def step_counts(quick: bool) -> list[int]:
    """Multiples of PIECES, growing by about the square root of 2."""
    multiples = (2, 3, 4, 6, 8, 11, 16) if quick else (1, 2, 3, 4, 6, 8, 11, 16, 23, 32)
    return [PIECES * k for k in multiples]


def study(make_method: MakeMethod, quick: bool, report: Report) -> pd.DataFrame:
    """'error of the place' [m], with N + 1 in `n`:

    of each start, in `study`, N = 1 to 4 in h, and semi-implicit Euler with n = 1, as if N = 0;
    of 'w away from 0, tolerance 1e-03' and so on, N = 4 with a solve that stops there, and of
    'w away from 0, solved to round-off', the same to the end;
    of 'M's reference' and 'Radau', against DOP853, with the start in `label`.
    """
    rows = []
    for start, known in STARTS.items():
        report(start)
        problem, exact = known.problem(), truth(start)
        apart = float(np.abs(truth(start, RADAU) - exact).max())
        rows.append(row(study=CHECKED, quantity=ERROR, label=start, value=apart))
        for k in step_counts(quick):
            h = known.duration / (FINER * k)
            run = SEMI_IMPLICIT_EULER.run(problem, known.duration, {"step": h})
            rows.append(_row(start, 0, FINER * k, run, start))
            for degree in DEGREES:
                run = _galvi(make_method, problem, start, degree, k)
                rows.append(_row(start, degree, k, run, start))
                if start == AWAY and degree == SATURATING:
                    rows.append(_row(SOLVED, degree, k, run, start))
            for tolerance in SCANNED if start == AWAY else ():
                run = _galvi(make_method, problem, start, SATURATING, k, tolerance)
                rows.append(_row(stopped_at(tolerance), SATURATING, k, run, start))
        run = _galvi(make_method, problem, start, RICHEST, MOST)
        rows.append(_row(OWN, RICHEST, MOST, run, start))
    return frame(rows)


def stopped_at(tolerance: float) -> str:
    """The study of runs whose solve stops at this change relative to |q|."""
    return f"{AWAY}, tolerance {tolerance:.0e}"


def _galvi(
    make_method: MakeMethod,
    problem: Any,
    start: str,
    degree: int,
    k: int,
    tolerance: float | None = None,
) -> Trajectory:
    method, h = method_of_degree(make_method, degree), STARTS[start].duration / k
    return galvi.integrate(problem, method, h, k, tolerance=tolerance)


def _row(study: str, degree: int, k: int, run: Trajectory, start: str) -> dict[str, Any]:
    return row(
        study=study,
        quantity=ERROR,
        n=degree + 1,
        step=STARTS[start].duration / k,
        steps=k,
        label=start,
        value=trajectory_error(run, truth(start)),
        **outcome(run),
    )


def judge(table: pd.DataFrame) -> list[Row]:
    """Rows for the orders from each start, the saturation of errors, and M's reference."""
    return [
        *(_order(table, start, degree) for start in STARTS for degree in (*DEGREES, 0)),
        *_saturation(table),
        *(_distance(table, start, study) for start in STARTS for study in (OWN, CHECKED)),
    ]


BEFORE = (
    "At these steps the method's own error is above that of the one step in which w is 0, of h^3, "
    "which would show at smaller ones."
)
SMOOTH = "Away from w = 0 the force is analytic, and a rule this exact has the order 2 N."
KINK = (
    "At w = 0 the drag's second derivative jumps: one step has an error of h^3 whatever N is, "
    "so that no order is above 3; M's runs do not say whether w passes through 0."
)


def _order(table: pd.DataFrame, start: str, degree: int) -> Row:
    fit = readings.order(table, FLOOR[start], study=start, quantity=ERROR, n=degree + 1)
    if degree == 0:
        return V23.row(
            f"order, {EULER}, {start}",
            Order(1),
            fit,
            setup=_setup(start),
            claimed="first order",
            reason="It is Euler's method in v.",
        )
    limited = start == ACROSS and degree > 2
    return V23.row(
        f"order, N = {degree}, {start}",
        Order(2 * degree),
        fit,
        setup=_setup(start),
        claimed=f"optimal convergence rates, order 2 N = {2 * degree}",
        expected=CONTRADICTED if limited else ATTAINED,
        reason=SMOOTH if start == AWAY else KINK if limited else BEFORE,
    )


def _saturation(table: pd.DataFrame) -> list[Row]:
    """Rows for the error of an early stop of the solve at the smallest steps."""
    solved = _at_small_steps(table, SOLVED)
    levels = np.array([_at_small_steps(table, stopped_at(t)) for t in SCANNED])
    power = Estimate(float("nan"))
    if np.all(np.isfinite(levels)):
        line, spread = np.polyfit(np.log(SCANNED), np.log(levels), 1, cov=True)
        power = Estimate(float(line[0]), float(np.sqrt(spread[0, 0])))
    shared = {
        "setup": _setup(AWAY),
        "claimed": "saturation is due to the tolerance of the Newton method",
    }
    return [
        *(
            V23.row(
                f"error at the {LAST} smallest steps, solve stopped at {tolerance:.0e}, over that "
                f"with a solve to round-off, N = {SATURATING}",
                AtLeast(SATURATED),
                _at_small_steps(table, stopped_at(tolerance)) / solved,
                reason="Where the solve stops early, what is left is a part of its last change, at "
                "most the tolerance; galvi's first guess, better at small steps, leaves less, so "
                "that errors wander below a ceiling instead of staying on it. Solved to round-off "
                "they go on falling.",
                **shared,
            )
            for tolerance in TOLERANCES
        ),
        V23.row(
            f"power of the tolerance that this error falls with, N = {SATURATING}",
            Within(0.5, 1.5),
            power,
            reason="What is left of the last change is a part of it.",
            **shared,
        ),
    ]


def _at_small_steps(table: pd.DataFrame, study: str) -> float:
    """The geometric mean of the errors at the smallest steps; NaN where one is missing."""
    errors = series(table, "step", study=study, quantity=ERROR, n=SATURATING + 1)[1][-LAST:]
    return float(np.exp(np.mean(np.log(errors)))) if errors.size == LAST else float("nan")


def _distance(table: pd.DataFrame, start: str, study: str) -> Row:
    theirs = study == OWN
    return V23.row(
        f"distance to DOP853 [m], {study}, {start}",
        AtMost(NEAR[start] if theirs else AGREED[start]),
        number(table, study=study, quantity=ERROR, label=start),
        setup=_setup(start),
        claimed="the reference solution has N = 12" if theirs else "none: the truth is checked",
        reason="Both are at round-off."
        if start == AWAY
        else "Neither steps on the moment at which w is 0, and loses digits there.",
    )


def _setup(start: str) -> str:
    known = STARTS[start]
    return (
        f"{MOVING}; {known.words}; {METHOD}; T = {known.duration:g} s; largest error of the place "
        f"at {PIECES} times"
    )


V23 = Claim(
    "V23",
    "Brownout particle: the order with a drag that depends on velocity",
    study,
    judge,
    ("M fig. 3",),
    source="M 6.2, fig. 3",
    reference=TRUTH,
)
