"""L3: the free rigid body, order under h-refinement (H figure 3.2, theorem 3.3.1)."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

import galvi
from benchmarks.claims.kit import (
    CAYLEY,
    ORACLES,
    DataFrame,
    Estimate,
    Fault,
    Fit,
    MakeMethod,
    Measurement,
    Report,
    at_fixed_time,
    number,
    of_table,
    readings,
    refine_at_end,
    row,
    scaled,
    table_of,
    times,
)
from benchmarks.claims.lie_groups.free_body import OTHER_MOTIONS
from benchmarks.claims.lie_groups.pendulum_motion import SECOND, TRUTH, oracles
from benchmarks.claims.lie_groups.rule_on_potential import clenshaw_curtis_points, pendulum_after
from benchmarks.measures.independent_space import gauss_points
from benchmarks.work_precision.with_settings import WithSettings
from references.closed_forms.pendulum import PENDULUM as PLANE_TRUTH
from references.closed_forms.top_motion import FREE_TOP
from references.scipy.ivp import DOP853, TIGHT

NS, CLENSHAW_CURTIS_NS = (3, 4, 5, 6), (3, 4, 5, 6, 7)
# Numbers of Gauss points, which H leaves open; n - 1, the degree, is the smallest well-posed one:
POINTS = ("n - 1", "n", "n + 1", "2 n")
ERROR = "error at the end"
BODY, CLENSHAW_CURTIS, PENDULUM, PLANE = (
    "free body",
    "Clenshaw-Curtis",
    "3D pendulum",
    "plane pendulum",
)
WEIGHT = 98.1
FLOOR, END_FLOOR = 2e-13, 3e-13  # at least ten times the distance of the oracles


def with_newton(original: Callable[..., Any]) -> Callable[..., Any]:
    """`galvi.integrate` with stages that are solved by Newton's method."""
    return partial(original, solver="newton")


FAULTS = {
    **OTHER_MOTIONS,
    **{
        f"{array} 1e-4, Newton": of_table(
            wrong={"galvi.integrate": with_newton}, **{array: 1.0 + 1e-4}
        )
        for array in ("psi", "slope")
    },
    "a rule on V that is off": Fault(wrong={f"{__name__}.clenshaw_curtis_points": scaled(1.0001)}),
    **{
        f"five orders less, {study}": Fault(table=times(1.0, -5.0, study=study))
        for study in (*POINTS, CLENSHAW_CURTIS, PLANE)
    },
}


def study(make_method: MakeMethod, quick: bool, report: Report) -> DataFrame:
    """Errors at the end: of H's body for each number of Gauss points; of a 3D pendulum, whose
    errors reach the asymptotic order before round-off; with Clenshaw-Curtis rules, of H's body and
    of a plane pendulum with exact kinetic part; and the distances of oracles."""
    counts = [round(2.0 ** (j / 2)) for j in range(3, 17)]
    cases = {
        **dict.fromkeys(POINTS, at_fixed_time(NS, 5.0, counts[3 : 12 if quick else 14])),
        CLENSHAW_CURTIS: at_fixed_time(CLENSHAW_CURTIS_NS, 5.0, counts[3:]),
        PENDULUM: at_fixed_time(NS, 5.0, [4 * k for k in counts[: 8 if quick else 14]]),
    }
    motions: dict[str, Any] = {
        BODY: (galvi.problems.free_rigid_body(), FREE_TOP, TRUTH),
        PENDULUM: (galvi.problems.pendulum_3d(WEIGHT), SECOND, TRUTH),
        PLANE: (galvi.problems.planar_pendulum(2.0), PLANE_TRUTH, WithSettings(DOP853, TIGHT)),
    }
    rows = [
        oracles(body, 5.0, 1, truth, second, name)
        for name, (body, truth, second) in motions.items()
    ]
    ends = {
        name: truth.run(body, 5.0, {"samples": 1}).q[-1]
        for name, (body, truth, _) in motions.items()
    }
    for study, refined in cases.items():
        name = PENDULUM if study == PENDULUM else BODY
        options = (refined, make_method, report, partial(method, study))
        rows += refine_at_end(study, ERROR, motions[name][0], ends[name], *options)
    for case in cases[CLENSHAW_CURTIS]:
        rules = (gauss_points(case.n - 1), clenshaw_curtis_points(case.n - 1))
        q, _ = pendulum_after(2.0, 0.0, case.step, case.steps, case.n - 2, *rules)
        error = abs(q - float(ends[PLANE][0]))
        rows.append(row(study=PLANE, quantity=ERROR, value=error, **case.columns))
    return table_of(rows)


def method(study: str, make_method: MakeMethod, n: int) -> Any:
    """The method of a study, by n, with polynomials in Cayley's chart."""
    if study == CLENSHAW_CURTIS:
        return make_method(galvi.Polynomials(n - 2), galvi.clenshaw_curtis(n - 1), CAYLEY)
    points = {"n - 1": n - 1, "n + 1": n + 1, "2 n": 2 * n}.get(study, n)
    return make_method(galvi.Polynomials(n - 1), galvi.gauss(points), CAYLEY)


def read(table: DataFrame) -> dict[str, Measurement]:
    """The orders, with the least over all numbers of Gauss points, and the distances of oracles."""

    def order(study: str, n: int, floor: float = FLOOR) -> Fit:
        return readings.order(table, floor, study=study, n=n)

    numbers: dict[str, Measurement] = {}
    for n in NS:
        fits = [order(points, n) for points in POINTS]
        lowest = int(np.argmin([fit.rate for fit in fits]))  # one without a rate, if there is one
        numbers[f"order of the one-step error, n = {n}"] = order("n", n)
        numbers[f"least order over {', '.join(POINTS)} Gauss points, n = {n}"] = fits[lowest]
        numbers[f"order from both sides, n = {n}"] = order(PENDULUM, n, END_FLOOR)
    for n in CLENSHAW_CURTIS_NS:
        name = "order with Clenshaw-Curtis n - 1"
        numbers[f"{name}, degree n - 2, n = {n}"] = order(CLENSHAW_CURTIS, n)
        numbers[f"{name} on V alone, degree n - 2, n = {n}"] = order(PLANE, n, END_FLOOR)
    for name in (BODY, PENDULUM, PLANE):
        numbers[f"{ORACLES}, {name}"] = number(table, study=name, quantity=ORACLES)
    four, five = (order(PENDULUM, n, END_FLOOR) for n in (4, 5))
    numbers["order at n = 5 minus order at n = 4"] = Estimate(
        five.rate - four.rate, math.hypot(five.uncertainty, four.uncertainty)
    )
    return numbers
