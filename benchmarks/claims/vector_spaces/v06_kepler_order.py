"""V6: the Kepler problem, order under h-refinement (H figure 2.9, theorem 2.3.3)."""

from __future__ import annotations

import math

import pandas as pd

from benchmarks.checks.bounds import ATTAINED, EXCEEDS, Order
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

NS = (3, 4, 5, 6)
NUMBER = 10
FLOOR = 1e-13  # of positions of size 1; 4e-14 was measured at n = 6
QUANTITIES = ("one-step error", "curve error")
FIXED_NUMBER = fixed_number(NUMBER)
PROTOCOLS = protocols(NUMBER)


def study(make_method: MakeMethod, quick: bool, report: Report) -> pd.DataFrame:
    """Series 'h-refinement, T = 2' and 'h-refinement, 10 steps' for n = 3 to 6."""
    cases = {
        FIXED_TIME: at_one_time(NS, quick),
        FIXED_NUMBER: in_as_many_steps(NS, NUMBER, quick),
    }
    return frame(
        row
        for name, those in cases.items()
        for row in refine(name, problem(), KEPLER, those, QUANTITIES, make_method, report)
    )


def judge(table: pd.DataFrame) -> list[Row]:
    """Two rows for each n, compared with 2 ceil(n / 2)."""
    return [_against_h(table, n, name) for n in NS for name in PROTOCOLS]


def _against_h(table: pd.DataFrame, n: int, name: str) -> Row:
    claimed, order = 2 * math.ceil(n / 2), 2 * (n - 1)
    fixed, steps = PROTOCOLS[name]
    reason = (
        f"Polynomials of degree {n - 1} with a rule this exact have the order of Gauss collocation "
        f"with {n - 1} points, 2 (n - 1) = {order}."
    )
    if name == FIXED_NUMBER:
        order += 1
        reason = (
            f"With a fixed number of steps the final time shrinks with h and the error of one step "
            f"is seen, one order more than the method's: 2 n - 1 = {order} as h tends to 0; steps "
            "that leave the pericentre show somewhat more."
        )
    return V6.row(
        f"order of the one-step error, n = {n}, {fixed}",
        Order(claimed),
        readings.order(table, FLOOR, study=name, quantity="one-step error", n=n),
        setup=f"{ORBIT}; {METHOD}, n = {n}; {steps}",
        claimed=f"order 2 ceil(n / 2) = {claimed}",
        expected=EXCEEDS if order > claimed else ATTAINED,
        reason=reason,
    )


V6 = Claim(
    "V6",
    "Kepler: one-step error of order 2 ceil(n / 2) in h",
    study,
    judge,
    ("H fig. 2.9",),
    source="H fig. 2.9, thm. 2.3.3",
    reference=f"{KEPLER.name}; REBOUND IAS15 (A9)",
    statement="H fig. 2.9, thm. 2.3.3: the one-step error has order 2 ceil(n / 2) in h. Measured: "
    "2 (n - 1) at a fixed end and more over a fixed number of steps, so the claim is exceeded "
    "except for n = 3 at a fixed end.",
)
