"""V7: the Kepler problem, invariants along the curve under h-refinement (H figures 2.10, 2.11)."""

from __future__ import annotations

import math

import numpy as np
import pandas as pd

from benchmarks.checks.bounds import (
    ATTAINED,
    NOT_REPRODUCED,
    ORDER_RESOLUTION,
    AtLeast,
    Converges,
    Finding,
    Near,
    Order,
    Reported,
)
from benchmarks.checks.claim import Claim, MakeMethod, Report, Row
from benchmarks.claims.vector_spaces.kepler_orbit import (
    FIXED_TIME,
    METHOD,
    ORBIT,
    SINGULARITY,
    at_one_time,
    fixed_number,
    problem,
    protocols,
)
from benchmarks.measures.refinement import refine, with_fixed_number
from benchmarks.statistics import readings
from benchmarks.statistics.convergence_fits import Fit
from benchmarks.statistics.estimate import Estimate
from benchmarks.store.frames import frame, pick
from references.closed_forms.kepler import KEPLER

NS = (3, 4, 5, 6, 7, 8)
FLOOR = 1e-13
ENERGY, ANGULAR = "energy error along the curve", "angular momentum error along the curve"
NUMBER = {ENERGY: 10, ANGULAR: 100}
EXACT = {ENERGY: "exact energy -1/2", ANGULAR: "exact angular momentum 0.8"}
ELSEWHERE, START, EVEN = "h-refinement, 100 steps from t = 1", 1.0, 4
SHORT = SINGULARITY / 3.0  # total time N h at which the orbit is still near the pericentre
VISIBLE = ", h above round-off"  # of an order that is another as h tends to 0
REACHED = {100: (3, 4), 10: (3, 4, 5, 6)}  # n whose errors for N h < SHORT are above round-off
POINTS, DEGREE = "number of points", "degree"
READINGS = {POINTS: 0, DEGREE: 1}  # what n is: the number of basis functions less n
SOURCES = {POINTS: "H fig. 2.11, sec. 2.4", DEGREE: "H fig. 2.11, sec. 2.2.2"}
RESOLUTION = 0.1  # of what an order gains with n, from six or five of them
PARITY = (
    "In a step the curve's velocity errs by h^(n - 1) q^(n) times a polynomial, the curve by h^n "
    "only, so that the leading errors of angular momentum and energy are h^(n - 1) q x q^(n) and "
    "h^(n - 1) q' . q^(n). About the pericentre x is even in time and y odd: both are odd in time "
    "for even n, and of size N h in N steps from there"
)


def order_of(n: int) -> int:
    """For a fixed number of steps from the pericentre, as h tends to 0."""
    return n if n % 2 == 0 else n - 1


def study(make_method: MakeMethod, quick: bool, report: Report) -> pd.DataFrame:
    """Series 'h-refinement, T = 2', '... 10 steps' and '... 100 steps' of both for n = 3 to 8, and
    '... 100 steps from t = 1' for n = 4; relative errors from (q, q') at 20 times a step."""
    both = tuple(NUMBER)
    sizes = [2.0 ** (-j / 2) for j in range(2, 27)]
    rows = refine(FIXED_TIME, problem(), KEPLER, at_one_time(NS, quick), both, make_method, report)
    for number in REACHED:
        cases = with_fixed_number(NS, number, sizes)
        rows += refine(fixed_number(number), problem(), KEPLER, cases, both, make_method, report)
    cases = with_fixed_number([EVEN], 100, sizes)
    rows += refine(ELSEWHERE, problem(START), KEPLER, cases, both, make_method, report)
    return frame(rows)


def judge(table: pd.DataFrame) -> list[Row]:
    """Energy converges; angular momentum against n / 2 + 2, one table for each of H's meanings of
    n; and what the orders are."""
    return [
        *(_energy(table, n) for n in NS),
        *(_against_h(table, POINTS, n) for n in NS),
        *_law(table, POINTS),
        *(_against_h(table, DEGREE, n) for n in NS[:-1]),
        *_law(table, DEGREE),
        *(_parity(table, ENERGY, n) for n in REACHED[10]),
        _parity(table, ANGULAR, 6),
        *(_elsewhere(table, quantity) for quantity in NUMBER),
        *(_fixed_time(table, quantity, n) for quantity in NUMBER for n in NS),
    ]


def largest_step(n: int, number: int) -> float:
    """The order for `number` steps is fitted to smaller h: N h < SHORT, where that can be seen."""
    return SHORT / number if n in REACHED[number] else math.inf


def _fit(table: pd.DataFrame, quantity: str, n: int, number: int) -> Fit:
    rows = pick(table, study=fixed_number(number), quantity=quantity, n=n)
    return readings.order(rows[rows["step"] <= largest_step(n, number)], FLOOR)


def _setup(n: int, number: int, seen: bool) -> str:
    steps = protocols(number)[fixed_number(number)][1]
    end = f", N h < {SHORT:.2g}" if seen else ""
    return f"{ORBIT}; {METHOD}, n = {n}; relative, from (q, q') at 20 times a step; {steps}{end}"


def _energy(table: pd.DataFrame, n: int) -> Row:
    number = NUMBER[ENERGY]
    return V7.row(
        f"order of the {ENERGY}, n = {n}, 10 steps",
        Converges(),
        _fit(table, ENERGY, n, number),
        source="H fig. 2.10",
        setup=_setup(n, number, n in REACHED[number]),
        claimed="converges (H prints no rate)",
        reason=f"{PARITY}; order {order_of(n)} as h tends to 0.",
        reference=EXACT[ENERGY],
    )


def _against_h(table: pd.DataFrame, reading: str, n: int) -> Row:
    """Angular momentum against n / 2 + 2, in one of READINGS."""
    basis, claimed = n + READINGS[reading], n / 2 + 2
    limit, seen = order_of(basis), basis in REACHED[NUMBER[ANGULAR]]
    order = limit if seen else basis - 1
    reason = f"{PARITY}; order {limit} as h tends to 0"
    if order != limit:
        reason += f", and {order} for the larger N h above round-off"
    elif not seen:
        reason += ", as for the larger N h above round-off"
    met = abs(order - claimed) <= ORDER_RESOLUTION
    return V7.row(
        f"order of the {ANGULAR}, {reading} n = {n}, 100 steps{VISIBLE if order != limit else ''}",
        Reported(Order(claimed), Order(order)),
        _fit(table, ANGULAR, basis, NUMBER[ANGULAR]),
        source=SOURCES[reading],
        setup=_setup(basis, NUMBER[ANGULAR], seen),
        claimed=f"O(h^(n/2 + 2)), order {claimed:g}; n is the {reading}",
        expected=ATTAINED if met else NOT_REPRODUCED,
        reason=f"{reason}.",
        reference=EXACT[ANGULAR],
    )


def _law(table: pd.DataFrame, reading: str) -> list[Row]:
    """Whether n / 2 + 2 is the law, and whether it is a lower bound."""
    ns = [n - READINGS[reading] for n in NS if n - READINGS[reading] >= NS[0]]
    fits = [_fit(table, ANGULAR, n + READINGS[reading], NUMBER[ANGULAR]) for n in ns]
    orders = np.array([fit.rate for fit in fits])
    above = orders - (np.array(ns) / 2 + 2)
    least = int(np.argmin(above))
    setup = _setup(NS[0], NUMBER[ANGULAR], False).replace(f"n = {NS[0]}", f"{reading} n = %s")
    texts = {
        "source": SOURCES[reading],
        "setup": setup % f"{ns[0]} to {ns[-1]}",
        "claimed": f"O(h^(n/2 + 2)); n is the {reading}",
        "reference": EXACT[ANGULAR],
    }
    law = V7.row(
        f"what the order of the {ANGULAR} gains with n, {reading} n",
        Reported(Near(0.5, RESOLUTION), Near(1.0, 0.25)),
        float(np.polyfit(ns, orders, 1)[0]),
        expected=NOT_REPRODUCED,
        reason="Each basis function gains one order, two for every second one as h tends to 0.",
        **texts,
    )
    if reading == POINTS:
        return [law]
    return [
        law,
        V7.row(
            f"least order of the {ANGULAR} less n/2 + 2, {reading} n",
            AtLeast(0.0, uncertainty=0.0, most=ORDER_RESOLUTION),
            Estimate(float(above[least]), fits[least].uncertainty),
            reason="With n the degree, O(h^(n/2 + 2)) is true: the order, n or n + 1, is not less.",
            **texts,
        ),
    ]


def _parity(table: pd.DataFrame, quantity: str, n: int) -> Row:
    return V7.row(
        f"order of the {quantity} as h tends to 0, n = {n}, 10 steps",
        Finding(Order(order_of(n))),
        _fit(table, quantity, n, 10),
        source="H fig. 2.10, 2.11",
        setup=_setup(n, 10, True),
        claimed="none of energy, or for 10 steps of angular momentum",
        reason=f"{PARITY}; order n for even n, n - 1 for odd n.",
        reference=EXACT[quantity],
    )


def _elsewhere(table: pd.DataFrame, quantity: str) -> Row:
    setup = _setup(EVEN, 100, False).replace(ORBIT, f"{ORBIT}, from t = {START:g} on")
    return V7.row(
        f"order of the {quantity}, n = {EVEN}, 100 steps from another point",
        Finding(Order(EVEN - 1)),
        readings.order(table, FLOOR, study=ELSEWHERE, quantity=quantity),
        source="H fig. 2.10, 2.11",
        setup=setup,
        claimed="none: H starts at the pericentre",
        reason="The control of the parity law: from another point the leading term does not "
        f"vanish, and the order is n - 1 = {EVEN - 1}.",
        reference=EXACT[quantity],
    )


def _fixed_time(table: pd.DataFrame, quantity: str, n: int) -> Row:
    protocol, steps = protocols(10)[FIXED_TIME]
    return V7.row(
        f"order of the {quantity}, n = {n}, {protocol}",
        Finding(Order(n - 1)),
        readings.order(table, FLOOR, study=FIXED_TIME, quantity=quantity, n=n),
        source="H fig. 2.10, 2.11",
        setup=f"{ORBIT}; {METHOD}, n = {n}; relative, from (q, q') at 20 times a step; {steps}",
        claimed="none: H fixes the number of steps",
        reason=f"The curve's velocity, a polynomial of degree n - 2 = {n - 2}, has order n - 1 = "
        f"{n - 1}, and so have invariants from (q, q') over a fixed time.",
        reference=EXACT[quantity],
    )


V7 = Claim(
    "V7",
    "Kepler: angular momentum along the curve O(h^(n/2 + 2))",
    study,
    judge,
    ("H fig. 2.10", "H fig. 2.11"),
    statement="H fig. 2.10, 2.11: the energy error along the curve converges, and that of the "
    "angular momentum is seen to have order n/2 + 2. Measured: order n for an even number n of "
    "basis functions, n - 1 for an odd one. H's number is reproduced where n is the number of "
    "points and 4 or 6; where n is the degree it is a lower bound; as a law in n it is neither.",
)
