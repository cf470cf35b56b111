"""V6: the Kepler problem, order under h-refinement (H figure 2.9, theorem 2.3.3)."""

from __future__ import annotations

from typing import Any

import galvi
from benchmarks.claims.kit import (
    ENDS_AND_CURVE,
    DataFrame,
    MakeMethod,
    Measurement,
    Report,
    readings,
    refine,
    table_of,
)
from benchmarks.claims.vector_spaces.kepler_orbit import (
    FIXED_TIME,
    OTHER_MOTIONS,
    at_one_time,
    fixed_number,
    in_as_many_steps,
    problem,
)
from references.closed_forms.kepler import KEPLER

NS = (3, 4, 5, 6)
FAULTS = OTHER_MOTIONS
FLOOR = 1e-13  # of positions of size 1; 4e-14 was measured at n = 6
FIXED_NUMBER = fixed_number(10)
CANDIDATE = f"{FIXED_TIME}, Clenshaw-Curtis n"
ENDS, CURVE = ENDS_AND_CURVE
ORDERS = {  # name of an order -> its study and quantity
    "one-step error, n = {}, fixed T": (FIXED_TIME, ENDS),
    "one-step error, n = {}, fixed number of steps": (FIXED_NUMBER, ENDS),
    "one-step error with Clenshaw-Curtis n, n = {}": (CANDIDATE, ENDS),
    "curve error, n = {}, fixed T": (FIXED_TIME, CURVE),
}


def study(make_method: MakeMethod, quick: bool, report: Report) -> DataFrame:
    """Series 'h-refinement, T = 2' and 'h-refinement, 10 steps' for n = 3 to 6, and the first
    with Clenshaw-Curtis rules of n points."""
    options = (make_method, report)
    cases = in_as_many_steps(NS, 10, quick)
    rows = refine(FIXED_NUMBER, problem(), KEPLER, cases, ENDS_AND_CURVE, *options)
    cases = at_one_time(NS, quick)
    rows += refine(FIXED_TIME, problem(), KEPLER, cases, ENDS_AND_CURVE, *options)
    rows += refine(CANDIDATE, problem(), KEPLER, cases, [ENDS], *options, clenshaw_curtis)
    return table_of(rows)


def clenshaw_curtis(make_method: MakeMethod, n: int) -> Any:
    """Polynomials of degree n - 1 with the rule of n points."""
    return make_method(galvi.Polynomials(n - 1), galvi.clenshaw_curtis(n))


def read(table: DataFrame) -> dict[str, Measurement]:
    """The fitted orders."""
    return {
        f"order of the {name.format(n)}": readings.order(
            table, FLOOR, study=protocol, quantity=quantity, n=n
        )
        for name, (protocol, quantity) in ORDERS.items()
        for n in NS
    }
