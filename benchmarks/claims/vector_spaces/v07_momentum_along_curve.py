"""V7: the Kepler problem, invariants along the curve under h-refinement (H figures 2.10, 2.11)."""

from __future__ import annotations

import numpy as np

from benchmarks.claims.kit import (
    DataFrame,
    Estimate,
    Fault,
    Fit,
    MakeMethod,
    Measurement,
    Report,
    pick,
    readings,
    refine,
    table_of,
    times,
    with_fixed_number,
)
from benchmarks.claims.vector_spaces.kepler_orbit import (
    FIXED_TIME,
    INVARIANTS,
    SINGULARITY,
    at_one_time,
    fixed_number,
    problem,
)
from references.closed_forms.kepler import KEPLER

NS = (3, 4, 5, 6, 7, 8)
FLOOR = 1e-13
ENERGY, ANGULAR = INVARIANTS
NUMBER = {ENERGY: 10, ANGULAR: 100}  # quantity -> fixed number of steps
ELSEWHERE, START, EVEN = "h-refinement, 100 steps from t = 1", 1.0, 4
SHORT = SINGULARITY / 3.0  # total time below which the orbit is still near the pericentre
# Quantity -> numbers of steps N for n = 3 to 6, such that errors for N h < SHORT exceed round-off:
SMALL_STEPS = {ENERGY: (10, 10, 10, 10), ANGULAR: (100, 100, 10, 10)}


FAULTS = {
    "an order less": Fault(table=times(1.0, power=-1.0, study=fixed_number(100), quantity=ANGULAR))
}


def study(make_method: MakeMethod, quick: bool, report: Report) -> DataFrame:
    """Series 'h-refinement, T = 2', '... 10 steps' and '... 100 steps' of both for n = 3 to 8, and
    '... 100 steps from t = 1' for n = 4; relative errors from (q, q') at 20 times a step."""
    sizes = [2.0 ** (-j / 2) for j in range(2, 27)]
    rows = refine(
        FIXED_TIME, problem(), KEPLER, at_one_time(NS, quick), INVARIANTS, make_method, report
    )
    for number in NUMBER.values():
        cases = with_fixed_number(NS, number, sizes)
        rows += refine(
            fixed_number(number), problem(), KEPLER, cases, INVARIANTS, make_method, report
        )
    cases = with_fixed_number([EVEN], 100, sizes)
    rows += refine(ELSEWHERE, problem(START), KEPLER, cases, INVARIANTS, make_method, report)
    return table_of(rows)


def read(table: DataFrame) -> dict[str, Measurement]:
    """The orders for each n: over one range of h, as h tends to 0, from another point, and for a
    fixed time; and the increase of the order of the angular momentum with n."""

    def order(quantity: str, n: int, number: int, above: float, below: float = np.inf) -> Fit:
        rows = pick(table, study=fixed_number(number), quantity=quantity, n=n)
        total = rows["step"] * number
        return readings.order(rows[(total > above) & (total < below)], FLOOR)

    angular = {n: order(ANGULAR, n, 100, SINGULARITY) for n in NS}
    line, spread = np.polyfit(NS, [angular[n].rate for n in NS], 1, cov=True)
    gain = Estimate(float(line[0]), float(np.sqrt(spread[0, 0])))
    numbers: dict[str, Measurement] = {
        f"what the order of the {ANGULAR} gains with n, 100 steps": gain
    }
    for n in NS:
        numbers[f"order of the {ENERGY}, n = {n}, 10 steps"] = order(ENERGY, n, 10, SINGULARITY)
        numbers[f"order of the {ANGULAR}, number of points n = {n}, 100 steps"] = angular[n]
        if n < NS[-1]:
            numbers[f"order of the {ANGULAR}, degree n = {n}, 100 steps"] = angular[n + 1]
    for quantity in NUMBER:
        for n, number in zip(NS, SMALL_STEPS[quantity], strict=False):
            name = f"order of the {quantity} as h tends to 0, n = {n}, {number} steps"
            numbers[name] = order(quantity, n, number, 0.0, SHORT)
        name = f"order of the {quantity}, n = {EVEN}, 100 steps from another point"
        numbers[name] = readings.order(table, FLOOR, study=ELSEWHERE, quantity=quantity)
        for n in NS:
            numbers[f"order of the {quantity}, n = {n}, fixed T"] = readings.order(
                table, FLOOR, study=FIXED_TIME, quantity=quantity, n=n
            )
    return numbers
