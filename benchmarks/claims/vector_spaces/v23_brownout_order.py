"""V23: one brownout particle, order with a velocity-dependent force (M figure 3, left)."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

import galvi
from benchmarks.claims.kit import (
    DataFrame,
    Estimate,
    Fault,
    Fit,
    MakeMethod,
    Measurement,
    Problem,
    Report,
    number,
    of_motion,
    readings,
    row,
    rows,
    series,
    table_of,
    with_arguments,
)
from benchmarks.claims.vector_spaces.brownout_crossing import kink_error
from benchmarks.claims.vector_spaces.brownout_particle import (
    ACROSS,
    AWAY,
    DURATION,
    ERROR,
    EULER,
    PIECES,
    STARTS,
    crossing_time,
    error_of,
    run_of,
    truth,
)
from benchmarks.measures.refinement import outcome
from references.scipy.ivp import RADAU

DEGREES = (1, 2, 3, 4)
BESIDE = "error beside the derived h^3 term"
OVER = f"{BESIDE}, over its largest in the group"
REFERENCE_DISTANCE = "distance between the two references [m], SciPy DOP853 and SciPy Radau"
OWN = "distance to DOP853 [m], M's reference, N = 12"
KINK = "largest error of the height by the derived h^3 term, N = 12 [m]"
SOLVED = f"{AWAY}, solved to round-off"
FLOOR = 1e-12  # m, smallest errors in fits of orders
TOLERANCES = (1e-3, 1e-5, 1e-7)
SCANNED = tuple(10.0**-k for k in range(2, 9))  # tolerances of the fit to saturated errors
LAST = 5  # smallest steps in the geometric mean of errors, which scatter by two decades
SATURATING = 4  # degree of the runs whose solve is stopped early
SHORTER = {2: (16, 32, 64, 90, 128, 181, 256), 3: (16, 23, 32, 45, 64, 90, 128)}
SHORTER[4] = SHORTER[3]  # degree -> steps in a piece: the first of each group of placements
LIMITING = {2: 2e-3, 3: np.inf, 4: np.inf}  # s; largest steps for which the one through w = 0 errs
# most
PLACED = f"{ACROSS}, largest of 13 placements"  # of w = 0 in its step, by consecutive sizes


def study(make_method: MakeMethod, quick: bool, report: Report) -> DataFrame:
    """Rows of 'error of the place' [m], with N + 1 in `n`, for these studies:

    each start                            N = 1 to 4 over h, and semi-implicit Euler with n = 1
    'w away from 0, tolerance 1e-03' ...  N = 4, with a solve that stops at this tolerance
    'w away from 0, solved to round-off'  N = 4, with a complete solve
    OWN, REFERENCE_DISTANCE               distances to DOP853 for each start
    KINK                                  the bound on an error in OWN
    'w through 0, largest of 13 placements'  the upper envelope, for N = 2, 3, 4, of runs in which
        w = 0 lies elsewhere in its step, with the error of the height beside the derived h^3 term
    """
    sizes = (2, 3, 4, 6, 8, 11, 16) if quick else (1, 2, 3, 4, 6, 8, 11, 16, 23, 32)
    cases: list[Any] = [
        *((start, start, 0, 64 * size) for start in STARTS for size in sizes),
        *((AWAY, AWAY, N, size) for N in DEGREES for size in sizes),
        *((ACROSS, ACROSS, 1, size) for size in sizes),
        *((SOLVED, AWAY, SATURATING, size) for size in sizes),
        *((stopped_at(t), AWAY, SATURATING, size, t) for t in SCANNED for size in sizes),
        *((f"{OWN}, {start}", start, 12, 8) for start in STARTS),
    ]
    table = []
    for study, start, degree, size, *tolerance in cases:
        report(f"{study}, N = {degree}")
        run = run_of(make_method, start, degree, size, *tolerance)
        where = {"n": degree + 1, "step": DURATION[start] / (PIECES * size), **outcome(run)}
        table.append(row(study=study, quantity=ERROR, value=error_of(run, start), **where))
    for start in STARTS:
        distance = np.max(abs(truth(start, RADAU) - truth(start)))
        table.append(row(study=f"{REFERENCE_DISTANCE}, {start}", quantity=ERROR, value=distance))
    kinks = [kink_error(DURATION[ACROSS] / 64, 12, theta) for theta in np.linspace(0.0, 1.0, 2001)]
    table.append(row(study=KINK, value=np.max(np.abs(kinks))))
    for degree, firsts in SHORTER.items():
        report(f"{PLACED}, N = {degree}")
        for first in firsts:
            if not quick or first.bit_count() == 1:
                table += _largest_of_placements(
                    make_method, degree, range(first, first + (8 if quick else 13))
                )
    return table_of(table)


def stopped_at(tolerance: float) -> str:
    """The name of the study of runs whose solve stops at this change relative to |q|."""
    return f"{AWAY}, tolerance {tolerance:.0e}"


def _largest_of_placements(
    make_method: MakeMethod, degree: int, sizes: range
) -> list[dict[str, Any]]:
    """Rows of the largest errors in a group of runs; the step is that of the largest ERROR."""
    group = []
    for size in sizes:
        run, h = run_of(make_method, ACROSS, degree, size), DURATION[ACROSS] / (PIECES * size)
        kink = kink_error(h, degree, crossing_time() / h % 1.0)
        beside = run.q[-1, 2] - truth(ACROSS)[-1, 2] - kink
        group.append((h, error_of(run, ACROSS), abs(beside), abs(kink)))
    steps, *largest = np.array(group).T
    error, beside, kink = map(np.max, largest)
    values = {ERROR: error, BESIDE: beside, OVER: beside / kink}
    return rows(values, study=PLACED, n=degree + 1, step=steps[np.argmax(largest[0])])


def read(table: DataFrame) -> dict[str, Measurement]:
    """The orders from each start, the errors beside the derived term, the saturation of errors, and
    the distances to DOP853."""

    def order(study: str, degree: int, until: float = np.inf, quantity: str = ERROR) -> Fit:
        return readings.order(table, FLOOR, until, study=study, quantity=quantity, n=degree + 1)

    def at_small_steps(study: str) -> float:
        return float(np.exp(np.mean(np.log(series(table, "step", study=study)[1][-LAST:]))))

    levels = {tolerance: at_small_steps(stopped_at(tolerance)) for tolerance in SCANNED}
    line, spread = np.polyfit(np.log(SCANNED), np.log([*levels.values()]), 1, cov=True)
    over = f"over that with a solve to round-off, N = {SATURATING}"
    return {
        "kink": number(table, study=KINK),
        **{f"order, N = {N}, {AWAY}": order(AWAY, N) for N in DEGREES},
        f"order, N = 1, {ACROSS}": order(ACROSS, 1),
        **{f"order, {EULER}, {start}": order(start, 0) for start in STARTS},
        **{
            f"order of the upper envelope, N = {N}, {ACROSS}": order(PLACED, N, until)
            for N, until in LIMITING.items()
        },
        f"order of the {BESIDE}, N = 2, {ACROSS}": order(PLACED, 2, quantity=BESIDE),
        **{
            f"{OVER}, N = {N}, {ACROSS}": readings.largest_of(table, quantity=OVER, n=N + 1)
            for N in (3, 4)
        },
        **{
            f"error at the {LAST} smallest steps, solve stopped at {tolerance:.0e}, {over}": (
                levels[tolerance] / at_small_steps(SOLVED)
            )
            for tolerance in TOLERANCES
        },
        f"power of the tolerance that this error falls with, N = {SATURATING}": Estimate(
            float(line[0]), float(np.sqrt(spread[0, 0]))
        ),
        **{
            f"{distance}, {start}": number(table, study=f"{distance}, {start}")
            for distance in (OWN, REFERENCE_DISTANCE)
            for start in STARTS
        },
    }


def with_drag(start: Problem, coefficient: float) -> Problem:
    """The problem from this start with another drag coefficient C_d than 0.44."""
    return galvi.problems.brownout(200e-6, start.q0, start.v0, coefficient)


FAULTS = {
    "drag stronger by a millionth": of_motion(partial(with_drag, coefficient=0.44000044)),
    "hardly any drag": of_motion(partial(with_drag, coefficient=1e-12)),
    "rotor late by a millionth of a second": of_motion(
        lambda problem: replace(problem, t0=problem.t0 - 1e-6)
    ),
    "a solve that never stops early": Fault(
        wrong={
            "galvi.integrate": lambda original: (
                lambda *arguments, tolerance, **options: original(*arguments, **options)
            )
        }
    ),
    "the term of another rule": Fault(
        wrong={
            f"{kink_error.__module__}.rule_error": with_arguments(lambda theta, n: (theta, n + 1))
        }
    ),
}
