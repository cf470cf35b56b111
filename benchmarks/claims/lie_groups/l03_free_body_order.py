"""L3: the free rigid body, order under h-refinement (H figure 3.2, theorem 3.3.1)."""

from __future__ import annotations

from benchmarks.claims.kit import *
from benchmarks.claims.lie_groups.free_body import BODY, DURATION, OTHER_MOTIONS, problem
from benchmarks.claims.lie_groups.rule_on_potential import PlanePendulum, clenshaw_curtis_points
from benchmarks.claims.rule_orders import WHY_ORDER, order_with_clenshaw_curtis
from benchmarks.measures.independent_space import gauss_points
from benchmarks.store import frames
from references.closed_forms.pendulum import PENDULUM as PLANE
from references.closed_forms.top_motion import FREE_TOP
from references.scipy.ivp import DOP853, TIGHT
from references.scipy.rigid_ivp import RIGID_DOP853
from references.textbook.quaternions import QUATERNION_DOP853
from references.textbook.quaternions import TIGHT as COMPENSATED

NS = (3, 4, 5, 6)
QUANTITY, AT_END = "one-step error", "error at the end"
BODY_STUDY, PENDULUM = "h-refinement, T = 5", "h-refinement, pendulum"
FEW, EXACT = "h-refinement, Clenshaw-Curtis", "h-refinement, Clenshaw-Curtis on V alone"
POINTS: Mapping[str, Any] = {
    "n - 1": lambda n: n - 1,
    "n": lambda n: n,
    "n + 1": lambda n: n + 1,
    "2 n": lambda n: 2 * n,
}  # of Gauss's rule, which H leaves open; n - 1, the degree, is the least that is well posed
STUDIES = {name: BODY_STUDY if name == "n" else f"{BODY_STUDY}, Gauss {name}" for name in POINTS}
WITH_FEW = (3, 4, 5, 6, 7)
MANY = tuple(round(2.0 ** (j / 2)) for j in range(6, 17))  # of steps: order 2 needs small ones
WEIGHT = 98.1
FLOOR, END_FLOOR = 2e-13, 3e-13  # ten times what the oracles differ by, and more
PENDULUM_SETUP = (
    f"3D pendulum of H 3.5.2 with m g = {WEIGHT:g}, swinging by 0.1 rad in 1 s; Polynomials(n - "
    f"1), gauss(n); Cayley; T = {DURATION:g}, error at the end, h = T / (4 round(2^(j/2))), "
    "j = 3, 4, ..."
)
LADDER = f"T = {DURATION:g}, h = T / round(2^(j/2)), j = 6, 7, ..."
FEW_SETUP = (
    f"{BODY}; Polynomials(n - 2), Clenshaw-Curtis of n - 1 points, n = {{}}, not the rule that H "
    f"names (Gauss); Cayley; {LADDER}"
)
AMPLITUDE = 2.0
EXACT_SETUP = (
    f"plane pendulum, V = -cos q, m = 1, from rest at q = {AMPLITUDE:g}; polynomials of degree "
    f"n - 2, kinetic part by Gauss n - 1, V by Clenshaw-Curtis of n - 1 points, n = {{}}; {LADDER}"
)
OPTIMAL = "optimal (we read order n) for even n, n - 1 for odd"
BODY_TRUTHS = f"{FREE_TOP.name}; {QUATERNION_DOP853.name} agrees to a tenth of the fits' floor"
PENDULUM_TRUTHS = (
    f"{RIGID_DOP853.name}, rtol {TIGHT['rtol']:g}; {QUATERNION_DOP853.name} agrees to a tenth of "
    "the fits' floor"
)
PLANE_TRUTHS = f"{PLANE.name}; {DOP853.name} agrees to a tenth of the fits' floor"


def study(make_method: MakeMethod, quick: bool, report: Report) -> DataFrame:
    """Errors at the ends of steps of H's body for n = 3 to 6 and each number of Gauss points; at
    the end for a pendulum, whose errors reach the asymptotic order before round-off; and with
    Clenshaw-Curtis rules, for n = 3 to 7, on H's body and on a plane pendulum."""
    body, pendulum = problem(), galvi.problems.pendulum_3d(WEIGHT)
    exact = FREE_TOP.run(body, DURATION, {"samples": 1}).q[-1]
    swung = RIGID_DOP853.run(pendulum, DURATION, {"samples": 1, **TIGHT}).q[-1]
    counts = [round(2.0 ** (j / 2)) for j in range(6, 15 if quick else 17)]
    found = []
    for name, points in POINTS.items():
        of = partial(_gauss, points)
        cases = at_fixed_time(NS, DURATION, counts)
        where = (STUDIES[name], QUANTITY, body, exact, cases)
        found += refine_at_end(*where, make_method, report, of)
    cases = at_fixed_time(WITH_FEW, DURATION, MANY)
    found += refine_at_end(FEW, QUANTITY, body, exact, cases, make_method, report, _few)
    counts = [4 * round(2.0 ** (j / 2)) for j in range(3, 11 if quick else 17)]
    cases = at_fixed_time(NS, DURATION, counts)
    options = (make_method, report, method_on_group)
    found += refine_at_end(PENDULUM, AT_END, pendulum, swung, cases, *options)
    found += _on_potential(report)
    for name, case, end in ((BODY_STUDY, body, exact), (PENDULUM, pendulum, swung)):
        other = QUATERNION_DOP853.run(case, DURATION, {"samples": 1, **COMPENSATED}).q[-1]
        found += rows({ORACLES: float(np.max(abs(other - end)))}, study=name)
    return frame(found)


def _gauss(points: Any, make_method: MakeMethod, n: int) -> Any:
    return make_method(galvi.Polynomials(n - 1), galvi.gauss(points(n)), CAYLEY)


def _few(make_method: MakeMethod, n: int) -> Any:
    return make_method(galvi.Polynomials(n - 2), galvi.clenshaw_curtis(n - 1), CAYLEY)


def _on_potential(report: Report) -> list[dict[str, Any]]:
    """The plane pendulum, its kinetic part integrated exactly."""
    report(EXACT)
    swing = galvi.problems.planar_pendulum(AMPLITUDE)
    exact, other = (
        float(truth.run(swing, DURATION, setting).q[-1, 0])
        for truth, setting in ((PLANE, {"samples": 1}), (DOP853, {"samples": 1, **TIGHT}))
    )
    found = rows({ORACLES: abs(other - exact)}, study=EXACT)
    for n in WITH_FEW:
        method = PlanePendulum(n - 2, gauss_points(n - 1), clenshaw_curtis_points(n - 1))
        for steps in MANY:
            error = abs(method.run(AMPLITUDE, 0.0, DURATION / steps, steps)[0] - exact)
            where = {"study": EXACT, "n": n, "step": DURATION / steps, "steps": steps}
            found.append(frames.row(quantity=AT_END, value=error, **where))
    return found


def claimed_order(n: int) -> int:
    """The order observed in H: n for even n, n - 1 for odd."""
    return 2 * math.floor(n / 2)


def judge(table: DataFrame) -> list[Row]:
    """Against H's orders; both sides of 2 (n - 1); H's parity, with its candidate reading."""
    return [
        *(row for n in NS for row in _against_h(table, n)),
        _parity(table),
        *(_both_sides(table, n) for n in NS),
        *(_candidate(table, n) for n in WITH_FEW),
        *(_stiffness(table, n) for n in WITH_FEW),
        *(
            _oracles(table, *case)
            for case in (
                (BODY_STUDY, "free body", FLOOR, BODY, BODY_TRUTHS),
                (PENDULUM, "3D pendulum", END_FLOOR, PENDULUM_SETUP, PENDULUM_TRUTHS),
                (EXACT, "plane pendulum", END_FLOOR, EXACT_SETUP.format("3 to 7"), PLANE_TRUTHS),
            )
        ),
    ]


def _against_h(table: DataFrame, n: int) -> list[Row]:
    """The order with Gauss's rule of n points, and the least over the numbers that were scanned."""
    claimed = claimed_order(n)
    fits = [readings.order(table, FLOOR, study=s, quantity=QUANTITY, n=n) for s in STUDIES.values()]
    reason = (
        f"Polynomials of degree s = {n - 1} with any Gauss rule of s points or more have order "
        f"2 s = {2 * (n - 1)}, on groups as on vector spaces; H's other counts of the degree, n "
        "and n + 1, and a fixed number of steps add to it."
    )
    if n > 3:
        reason += (
            " With more than s points the leading term is small here, and errors fall faster until "
            "steps are small or round-off is reached: local slopes have not settled, and are no "
            "orders."
        )
    setup = f"{BODY}; Polynomials(n - 1), {{}}; n = {n}; Cayley; {LADDER}"
    bound = Reported(Order(claimed), AtLeast(2.0 * (n - 1), uncertainty=0.0))
    texts = {
        "claimed": f"{OPTIMAL}: order {claimed}",
        "expected": NOT_REPRODUCED,
        "reason": reason,
    }
    return [
        L3.row(
            f"order of the one-step error, n = {n}",
            bound,
            fits[list(STUDIES).index("n")],
            setup=setup.format("gauss(n) (H names Gauss, and no number of points)"),
            **texts,
        ),
        L3.row(
            f"least order over {', '.join(POINTS)} Gauss points, n = {n}",
            bound,
            _least(fits),
            setup=setup.format(f"Gauss's rule of {', '.join(POINTS)} points, which H leaves open"),
            **texts,
        ),
    ]


def _least(fits: list[Fit]) -> Fit:
    """The fit with the least rate; one without a rate when there is such a fit."""
    missing = [fit for fit in fits if math.isnan(fit.rate)]
    return missing[0] if missing else min(fits, key=lambda fit: fit.rate)


def _parity(table: DataFrame) -> Row:
    four, five = (
        readings.order(table, END_FLOOR, study=PENDULUM, quantity=AT_END, n=n) for n in (4, 5)
    )
    uncertainty = math.hypot(five.uncertainty, four.uncertainty)
    return L3.row(
        "order at n = 5 minus order at n = 4",
        Finding(Near(2.0, ORDER_RESOLUTION, uncertainty=0.0)),
        Estimate(five.rate - four.rate, uncertainty),
        setup=PENDULUM_SETUP,
        claimed="none: 4 for n = 5 as for n = 4, which H does not explain; our value: 2",
        reason="Each basis function gains two orders with any Gauss rule of enough points, "
        "whatever its parity. A rule of little exactness, as below, gives H's parity.",
        reference=PENDULUM_TRUTHS,
    )


def _both_sides(table: DataFrame, n: int) -> Row:
    order = 2 * (n - 1)
    return L3.row(
        f"order from both sides, n = {n}",
        Finding(Order(order)),
        readings.order(table, END_FLOOR, study=PENDULUM, quantity=AT_END, n=n),
        setup=f"{PENDULUM_SETUP}; n = {n}",
        claimed=f"at least n - 1 = {n - 1} by theorem 3.3.1 (curves of degree n - 1 come within "
        f"h^(n - 1) of the velocity); our value: 2 (n - 1) = {order}, no more",
        reason="A motion of small turns, whose chart is nearly flat: the leading term of the error "
        "is all that is left of it well above round-off.",
        reference=PENDULUM_TRUTHS,
    )


def _candidate(table: DataFrame, n: int) -> Row:
    """A rule that would give H's orders up to n = 6, although it is not the one that H names."""
    order, claimed = order_with_clenshaw_curtis(n - 2, n - 1), claimed_order(n)
    same = "as in H" if order == claimed else f"not H's {claimed}: the reading breaks here"
    s, d = n - 2, n - 2 + (n - 1) % 2
    return L3.row(
        f"order with Clenshaw-Curtis n - 1, degree n - 2, n = {n}",
        Finding(Order(order)),
        readings.order(table, FLOOR, study=FEW, quantity=QUANTITY, n=n),
        setup=FEW_SETUP.format(n),
        claimed=f"{OPTIMAL}: {claimed}; our value: {order}, {same}",
        reason=f"{WHY_ORDER} Here s = {s}, d = {d}; d - s is 0 and 1 by turns, so "
        "that orders stay at 4 for odd and at 6 for even n, from n = 5 and 6 on. H's 3.4.2 names "
        "Gauss's rule: this would explain the figure, and is not what H prints.",
    )


def _stiffness(table: DataFrame, n: int) -> Row:
    order = order_with_clenshaw_curtis(n - 2, n - 1)
    return L3.row(
        f"order with Clenshaw-Curtis n - 1 on V alone, degree n - 2, n = {n}",
        Finding(Order(order)),
        readings.order(table, END_FLOOR, study=EXACT, quantity=AT_END, n=n),
        setup=EXACT_SETUP.format(n),
        claimed=f"our value: {order}: an exact kinetic part changes no order",
        reason="E(p' e) is left of E((p e)') where E(p e') is 0 to leading order, and the lowest "
        "degree that it misses is the same. A free body has no V: with an exact action its order "
        "is 2 s, without parity.",
        reference=PLANE_TRUTHS,
    )


def _oracles(table: DataFrame, study: str, name: str, floor: float, setup: str, truths: str) -> Row:
    return L3.row(
        f"{ORACLES}, {name}",
        Finding(AtMost(floor / 10.0)),
        number(table, study=study, quantity=ORACLES),
        setup=f"{setup.split(';')[0]}; T = {DURATION:g}, largest entry",
        claimed="none: a tenth of the smallest error in a fit",
        reason="Written apart, in other variables.",
        reference=truths,
    )


L3 = Claim(
    "L3",
    "Free rigid body: one-step error of order n, or n - 1 for odd n, in h",
    study,
    judge,
    ("H fig. 3.2",),
    source="H fig. 3.2",
    reference=BODY_TRUTHS,
    statement="H fig. 3.2 reports order n for even n and n - 1 for odd n. Measured: 2 (n - 1) with "
    "every number of Gauss points, so that the figure is not reproduced. H's parity is that of "
    "Clenshaw-Curtis with n - 1 points and degree n - 2, for n = 3 to 6; H names Gauss's rule.",
    caught=(
        of_table("order of the one-step error, n = 5", b=1.0 + 1e-4),
        of_table("order from both sides, n = 4", integral=1.0 + 1e-4),
        *(
            of_table(
                "order from both sides, n = 4",
                wrong={
                    "galvi.integrate": lambda sound: (
                        lambda *given, **how: sound(*given, **{**how, "solver": "newton"})
                    )
                },
                **{array: 1.0 + 1e-4},
            )
            for array in ("psi", "slope")
        ),
        *OTHER_MOTIONS,
    ),
)
