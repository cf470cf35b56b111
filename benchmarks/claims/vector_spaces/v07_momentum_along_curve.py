"""V7: the Kepler problem, invariants along the curve under h-refinement (H figures 2.10, 2.11)."""

from __future__ import annotations

from benchmarks.checks.bounds import Converges
from benchmarks.claims.kit import *
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
from references.closed_forms.kepler import KEPLER

NS = (3, 4, 5, 6, 7, 8)
FLOOR = 1e-13
ENERGY, ANGULAR = "energy error along the curve", "angular momentum error along the curve"
NUMBER = {ENERGY: 10, ANGULAR: 100}
EXACT = {ENERGY: "exact energy -1/2", ANGULAR: "exact angular momentum 0.8"}
ELSEWHERE, START, EVEN = "h-refinement, 100 steps from t = 1", 1.0, 4
SINCE = SINGULARITY  # total time N h from which H's orders are fitted, for every n
SHORT = SINGULARITY / 3.0  # total time below which the orbit is still near the pericentre
REACHED: Mapping[str, Mapping[int, int]] = {  # n whose errors for N h < SHORT are above round-off
    ENERGY: {3: 10, 4: 10, 5: 10, 6: 10},
    ANGULAR: {3: 100, 4: 100, 5: 10, 6: 10},
}  # with N
POINTS, DEGREE = "number of points", "degree"
READINGS = {POINTS: 0, DEGREE: 1}  # what n is: the number of basis functions less n
SOURCES = {POINTS: "H fig. 2.11, sec. 2.4", DEGREE: "H fig. 2.11, sec. 2.2.2"}
RESOLUTION = 0.1  # of what an order gains with n, from six of them
PARITY = (
    "In a step the curve's velocity errs by h^(n - 1) q^(n) times a polynomial, the curve by h^n "
    "only, so that the leading errors of angular momentum and energy are h^(n - 1) q x q^(n) and "
    "h^(n - 1) q' . q^(n). About the pericentre x is even in time and y odd: both are odd in time "
    "for even n, and of size N h in N steps from there"
)
LEADING = (
    "The curve's velocity is a polynomial of degree n - 2 for n basis functions: order n - 1. One "
    "range of h for all n, in which the motion of N steps leaves the pericentre and the errors are "
    "above round-off; the last rows have smaller h and a fixed time."
)
RANGE = f", N h > {SINCE:.2g}"


def order_of(n: int) -> int:
    """For a fixed number of steps from the pericentre, as h tends to 0."""
    return n if n % 2 == 0 else n - 1


def earliest_step(number: int) -> float:
    """H's orders for `number` steps are fitted to larger h: N h > SINCE."""
    return SINCE / number


def study(make_method: MakeMethod, quick: bool, report: Report) -> DataFrame:
    """Series 'h-refinement, T = 2', '... 10 steps' and '... 100 steps' of both for n = 3 to 8, and
    '... 100 steps from t = 1' for n = 4; relative errors from (q, q') at 20 times a step."""
    both = tuple(NUMBER)
    sizes = [2.0 ** (-j / 2) for j in range(2, 27)]
    rows = refine(FIXED_TIME, problem(), KEPLER, at_one_time(NS, quick), both, make_method, report)
    for number in NUMBER.values():
        cases = with_fixed_number(NS, number, sizes)
        rows += refine(fixed_number(number), problem(), KEPLER, cases, both, make_method, report)
    cases = with_fixed_number([EVEN], 100, sizes)
    rows += refine(ELSEWHERE, problem(START), KEPLER, cases, both, make_method, report)
    return frame(rows)


def judge(table: DataFrame) -> list[Row]:
    """Energy converges; angular momentum against n / 2 + 2, one table for each of H's meanings of
    n; what an order gains with n; and what the orders are as h tends to 0 and at a fixed time."""
    return [
        *(_energy(table, n) for n in NS),
        *(_against_h(table, POINTS, n) for n in NS),
        *(_against_h(table, DEGREE, n) for n in NS[:-1]),
        _law(table),
        *(_parity(table, quantity, n) for quantity, ns in REACHED.items() for n in ns),
        *(_elsewhere(table, quantity) for quantity in NUMBER),
        *(_fixed_time(table, quantity, n) for quantity in NUMBER for n in NS),
    ]


def _fit(table: DataFrame, quantity: str, n: int) -> Fit:
    number = NUMBER[quantity]
    rows = pick(table, study=fixed_number(number), quantity=quantity, n=n)
    return readings.order(rows[rows["step"] > earliest_step(number)], FLOOR)


def _setup(n: int | str, number: int, end: str = "") -> str:
    steps = protocols(number)[fixed_number(number)][1]
    return f"{ORBIT}; {METHOD}, n = {n}; relative, from (q, q') at 20 times a step; {steps}{end}"


def _energy(table: DataFrame, n: int) -> Row:
    return V7.row(
        f"order of the {ENERGY}, n = {n}, 10 steps",
        Converges(),
        _fit(table, ENERGY, n),
        source="H fig. 2.10",
        setup=_setup(n, NUMBER[ENERGY], RANGE),
        claimed="converges (H prints no rate)",
        reason=LEADING,
        reference=EXACT[ENERGY],
    )


def _against_h(table: DataFrame, reading: str, n: int) -> Row:
    """Angular momentum against n / 2 + 2, in one of READINGS."""
    basis, claimed = n + READINGS[reading], n / 2 + 2
    order = basis - 1
    return V7.row(
        f"order of the {ANGULAR}, {reading} n = {n}, 100 steps",
        Reported(Order(claimed), Order(order)),
        _fit(table, ANGULAR, basis),
        source=SOURCES[reading],
        setup=_setup(basis, NUMBER[ANGULAR], RANGE),
        claimed=f"O(h^(n/2 + 2)), order {claimed:g}; n is the {reading}",
        expected=ATTAINED if abs(order - claimed) <= ORDER_RESOLUTION else NOT_REPRODUCED,
        reason=LEADING,
        reference=EXACT[ANGULAR],
    )


def _law(table: DataFrame) -> Row:
    """Whether n / 2 + 2 is the law: a shift of n changes nothing here."""
    orders = [_fit(table, ANGULAR, n).rate for n in NS]
    slope = Estimate(float("nan"))
    if np.all(np.isfinite(orders)):
        line, spread = np.polyfit(NS, orders, 1, cov=True)
        slope = Estimate(float(line[0]), float(np.sqrt(spread[0, 0])))
    return V7.row(
        f"what the order of the {ANGULAR} gains with n, 100 steps",
        Reported(Near(0.5, RESOLUTION), Near(1.0, RESOLUTION)),
        slope,
        source="H fig. 2.11",
        setup=_setup(f"{NS[0]} to {NS[-1]}", NUMBER[ANGULAR], RANGE),
        claimed="O(h^(n/2 + 2)): 1/2, whether n is the number of points or the degree",
        expected=NOT_REPRODUCED,
        reason="Each basis function gains one order. As h tends to 0 every second one gains two, "
        "the others none: on average one, too.",
        reference=EXACT[ANGULAR],
    )


def _parity(table: DataFrame, quantity: str, n: int) -> Row:
    number = REACHED[quantity][n]
    rows = pick(table, study=fixed_number(number), quantity=quantity, n=n)
    return V7.row(
        f"order of the {quantity} as h tends to 0, n = {n}, {number} steps",
        Finding(Order(order_of(n))),
        readings.order(rows[rows["step"] < SHORT / number], FLOOR),
        source="H fig. 2.10, 2.11",
        setup=_setup(n, number, f", N h < {SHORT:.2g}"),
        claimed="none of small h alone: H prints one order for a figure",
        reason=f"{PARITY}; order n for even n, n - 1 for odd n.",
        reference=EXACT[quantity],
    )


def _elsewhere(table: DataFrame, quantity: str) -> Row:
    setup = _setup(EVEN, 100).replace(ORBIT, f"{ORBIT}, from t = {START:g} on")
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


def _fixed_time(table: DataFrame, quantity: str, n: int) -> Row:
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
    "Kepler: along the curve energy converges in h, angular momentum like h^(n/2 + 2)",
    study,
    judge,
    ("H fig. 2.10", "H fig. 2.11"),
    statement="H fig. 2.10, 2.11: the energy error along the curve converges, and that of the "
    "angular momentum is seen to have order n/2 + 2. Measured: n - 1 for n basis functions over "
    "one range of h, so that H's number is met at n = 6 points, or at the degree n = 4, and the "
    "law in neither reading. As h tends to 0 even n gain one order.",
    caught=(
        of_table(
            "order of the angular momentum error along the curve, n = 8, fixed T", C=1.0 + 1e-4
        ),
    ),
)
