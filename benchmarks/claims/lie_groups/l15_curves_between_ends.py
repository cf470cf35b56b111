"""L15: Galerkin curves against exact motions with the same end points (H theorems 3.3.3, 3.3.4)."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

import galvi
from benchmarks.claims.kit import (
    DataFrame,
    MakeMethod,
    Measurement,
    Report,
    failure,
    method_on_group,
    of_motion,
    readings,
    reversed_clock,
    rows,
    table_of,
)
from benchmarks.claims.lie_groups.pendulum_motion import TRUTH, problem
from benchmarks.measures.boundary_motion import CURVE, ENDS, IN_H, IN_N, distance

STEP = 1.0
NS = (3, 4, 5, 6)
FLOOR = {ENDS: 5e-15, CURVE: 1e-14}
# Factor n^-g of each: the motion's complex singularities have no closed form, so that g is not
# known; branch points and poles as in V14 and V26 have g between 0 and 1.
POWER = (0.5, 0.5)  # and its error


def study(make_method: MakeMethod, quick: bool, report: Report) -> DataFrame:
    """Both quantities for one step: over n at h = 1, and over h for n = 3 to 6."""
    cases = [(IN_N, n, STEP) for n in range(3, 14 if quick else 17)]
    cases += [(IN_H, n, 2.0 ** (-j / 2)) for n in NS for j in range(9 if quick else 14)]
    measured: list[dict[str, Any]] = []
    for name, n, h in cases:
        report(f"{name}, n = {n}, h = {h:.3g}")
        run = galvi.integrate(problem(), method_on_group(make_method, n), h, 1)
        exact = TRUTH.run(problem(), h, {"samples": 1}).q[-1]
        values = {ENDS: np.max(abs(run.q[-1] - exact)), CURVE: distance(run, TRUTH)}
        measured += rows(values, study=name, n=n, step=h, steps=1, status=failure(run))
    return table_of(measured)


def read(table: DataFrame) -> dict[str, Measurement]:
    """The bases of both, with the root of the step's; the orders of the curve, and halves of the
    step's orders, at least n - 1/2."""
    steps = readings.base(table, FLOOR[ENDS], study=IN_N, quantity=ENDS, power=POWER)
    root = math.sqrt(steps.rate)
    numbers: dict[str, Measurement] = {
        "base of the step's error": readings.decay(table, FLOOR[ENDS], study=IN_N, quantity=ENDS),
        "base of the curve's distance": readings.base(
            table, FLOOR[CURVE], study=IN_N, quantity=CURVE, power=POWER
        ),
        "base": steps.rate,
        "root": root,
        "error": 0.5 * root * steps.uncertainty / steps.rate,
    }
    for n in NS:
        curve, steps = (
            readings.order(table, FLOOR[quantity], study=IN_H, quantity=quantity, n=n)
            for quantity in (CURVE, ENDS)
        )
        numbers |= {
            f"order of the curve's distance, n = {n}": curve,
            f"order{n}": steps.rate,
            f"half{n}": np.maximum(0.5 * steps.rate, n - 0.5),
            f"error{n}": 0.5 * steps.uncertainty,
        }
    return numbers


FAULTS = {
    "clock reversed": of_motion(reversed_clock),
    "another weight": of_motion(
        lambda start: galvi.problems.pendulum_3d(weight=9.81 * (1.0 + 1e-6))
    ),
}
