"""V7: the Kepler problem, invariants along the curve under h-refinement (H figures 2.10, 2.11)."""

from __future__ import annotations

import pandas as pd

from benchmarks.checks.bounds import ATTAINED, CONTRADICTED, EXCEEDS, Converges, Order
from benchmarks.checks.claim import Claim, MakeMethod, Report, Row
from benchmarks.claims.vector_spaces.kepler_orbit import (
    FIXED_TIME,
    METHOD,
    ORBIT,
    at_one_time,
    fixed_number,
    in_as_many_steps,
    problem,
    protocols,
)
from benchmarks.measures.refinement import refine
from benchmarks.statistics import readings
from benchmarks.store.frames import frame
from references.closed_forms.kepler import KEPLER

NS = (3, 4, 5, 6, 7, 8)
FLOOR = 1e-13
ENERGY, ANGULAR = "energy error along the curve", "angular momentum error along the curve"
NUMBER = {ENERGY: 10, ANGULAR: 100}
EXACT = {ENERGY: "exact energy -1/2", ANGULAR: "exact angular momentum 0.8"}


def study(make_method: MakeMethod, quick: bool, report: Report) -> pd.DataFrame:
    """Series 'h-refinement, T = 2' of both, '... 10 steps' of the energy, '... 100 steps' of the
    angular momentum, for n = 3 to 8; relative errors from (q, q') at 20 times a step."""
    cases = at_one_time(NS, quick)
    rows = refine(FIXED_TIME, problem(), KEPLER, cases, NUMBER, make_method, report)
    for quantity, number in NUMBER.items():
        cases = in_as_many_steps(NS, number, quick)
        rows += refine(
            fixed_number(number), problem(), KEPLER, cases, [quantity], make_method, report
        )
    return frame(rows)


def judge(table: pd.DataFrame) -> list[Row]:
    """For each n and protocol: does the energy converge; angular momentum against n / 2 + 2."""
    return [
        _row(table, n, quantity, study)
        for quantity, number in NUMBER.items()
        for n in NS
        for study in protocols(number)
    ]


def _row(table: pd.DataFrame, n: int, quantity: str, study: str) -> Row:
    protocol, steps = protocols(NUMBER[quantity])[study]
    how = {
        "setup": f"{ORBIT}; {METHOD}, n = {n}; relative, from (q, q') at 20 times a step; {steps}",
        "reference": EXACT[quantity],
    }
    quantity_of = f"order of the {quantity}, n = {n}, {protocol}"
    fit = readings.order(table, FLOOR, study=study, quantity=quantity, n=n)
    order, claimed = n - 1, n / 2 + 2
    reason = (
        f"The curve's velocity, a polynomial of degree n - 2 = {n - 2}, has order n - 1 = {order}, "
        f"and so have invariants from (q, q'), whether T is fixed or not"
    )
    if quantity == ENERGY:
        return V7.row(
            quantity_of,
            Converges(),
            fit,
            source="H fig. 2.10",
            claimed="converges (H prints no rate)",
            reason=f"{reason}.",
            **how,
        )
    expected = CONTRADICTED if order < claimed else EXCEEDS if order > claimed else ATTAINED
    return V7.row(
        quantity_of,
        Order(claimed),
        fit,
        source="H fig. 2.11",
        claimed=f"O(h^(n/2 + 2)), order {claimed:g}",
        expected=expected,
        reason=f"{reason}: below, at or above n/2 + 2 as n is below, at or above 6.",
        **how,
    )


V7 = Claim(
    "V7",
    "Kepler: angular momentum along the curve O(h^(n/2 + 2))",
    study,
    judge,
    ("H fig. 2.10", "H fig. 2.11"),
)
