"""V22: best approximation, errors along the path, and orders limited by the rule (M section 5)."""

from __future__ import annotations

from decimal import Decimal, localcontext

from benchmarks.claims.kit import *
from benchmarks.claims.vector_spaces import oscillator
from benchmarks.measures.best_approximation import Motion, best_errors, step_error
from benchmarks.test_problems.oscillators import DURATION, KINK, SMOOTHNESS, motion, two_springs
from references.closed_forms.kepler import KEPLER
from references.scipy.ivp import DOP853, TIGHT

LARGEST, MEAN, PATH = "e_max", "e_mean", "error along the path"
ENDS = "one-step error"
DEGREES, RULED = (1, 2, 3, 4), (2, 3, 4)
FLOOR, ENDS_FLOOR = 1e-12, 3e-13  # of norms, and of Kepler's positions
INTEGRAL = "error of the rule"
NODES, INTEGRAL_FLOOR = 3, 1e-30  # errors of integrals in extended precision
ORBIT, SPAN = galvi.problems.kepler(eccentricity=0.3), 4.0
SLIP = "Index slip, safe direction"
RULE_SETUP = "int_0^h e^t dt, h = 1 to 1/128, in 50 digits"
CHECK = {"samples": 1, **TIGHT, "max_step": 0.02}  # of DOP853


@dataclass(frozen=True)
class Case:
    """A motion of stated smoothness: u^(smoothness) is the last derivative in L^2, None for all."""

    problem: Problem
    motion: Motion
    duration: float
    kinks: tuple[float, ...]
    smoothness: float
    setting: str


def _cosine(t: Any) -> Any:
    return np.cos(t), -np.sin(t)


CASES: Mapping[str, Case] = {
    "smooth": Case(
        oscillator.problem(),
        _cosine,
        oscillator.DURATION,
        (),
        np.inf,
        f"{oscillator.OSCILLATION}; T = {oscillator.DURATION:g}",
    ),
    "rough": Case(
        two_springs(),
        motion,
        DURATION,
        (KINK,),
        SMOOTHNESS,
        "two springs, V = q^2 / 2 for q >= 0 and 2 q^2 for q < 0, q0 = 1, v0 = 0, so that q''' "
        "jumps: s = 3 derivatives in L^2; T = pi, K odd, so that the jump is in the middle",
    ),
}
RULES: Mapping[str, Any] = {
    "Gauss N": lambda degree: galvi.gauss(degree),
    "Lobatto N + 1": lambda degree: galvi.lobatto(degree + 1),
    "Lobatto N": lambda degree: galvi.lobatto(degree),
}
CLOSED = f"closed form; {DOP853.name} agrees to 1e-14"
IN_L2 = (
    "On a subinterval u' is off its best polynomial by about h^N |u^(N + 1)|, over a length h: "
    "h^(N + 1/2) in L2"
)
STEP_IN_X = "one step in the middle, h = T / K, from the exact state, in |.|_X"


def study(make_method: MakeMethod, quick: bool, report: Report) -> DataFrame:
    """Errors of each series, with the degree N as n - 1:

    e_max, e_mean of each case, and of one step along the path with Gauss N + 1
    'error along the path' of one step of the smooth case for each rule, in `study`
    'one-step error'       of Kepler's problem for each rule
    'error of the rule'    int_0^h e^t dt by Gauss and by Lobatto with 3 nodes, in `study`
    'distance between the two references'  closed form and DOP853, of each motion in `study`
    """
    found: list[dict[str, Any]] = []
    counts = sorted({2 * round(2.5 * 2.0 ** (j / 2)) + 1 for j in range(1, 11 if quick else 15)})
    for name, case in CASES.items():
        report(name)
        for degree in DEGREES:
            method = make_method(galvi.Polynomials(degree), galvi.gauss(degree + 1))
            for count in counts:
                found += _approximations(name, case, method, degree, count)
    case = CASES["smooth"]
    for label, rule in RULES.items():
        for degree in DEGREES[1 if label == "Lobatto N" else 0 :]:
            method = make_method(galvi.Polynomials(degree), rule(degree))
            for count in counts:
                where = {"n": degree + 1, "step": case.duration / count, "steps": count}
                path, status = _path(case, method, count)
                found.append(row(study=label, quantity=PATH, value=path, status=status, **where))
        steps = [round(2.0 ** (j / 2)) for j in range(5, 15 if quick else 20)]
        cases = at_fixed_time([degree + 1 for degree in RULED], SPAN, steps)

        def method_of(make: MakeMethod, n: int, rule: Any = rule) -> Any:
            return make(galvi.Polynomials(n - 1), rule(n - 1))

        found += refine(label, ORBIT, KEPLER, cases, (ENDS,), make_method, report, method_of)
    return frame(found + _integrals() + _oracles())


def _integrals() -> list[dict[str, Any]]:
    """|int_0^h e^t dt - its rule|, from nodes and weights of 50 digits."""
    found = []
    for family, rule in (("Gauss", galvi.gauss(NODES)), ("Lobatto", galvi.lobatto(NODES))):
        with localcontext() as context:
            context.prec = 50
            for k in range(8):
                h = Decimal(1) / 2**k
                terms = zip(rule.exact_weights, rule.exact_nodes, strict=True)
                total = h * sum((w * (h * c).exp() for w, c in terms), Decimal(0))
                error = float(abs(h.exp() - 1 - total))
                where = {"study": family, "n": NODES, "step": float(h)}
                found.append(row(quantity=INTEGRAL, value=error, **where))
    return found


def _oracles() -> list[dict[str, Any]]:
    """The closed forms against DOP853, from kink to kink, at the ends of the pieces."""
    found = []
    for name, case in CASES.items():
        problem, gap = case.problem, 0.0
        for end in (*case.kinks, case.duration):
            run = DOP853.run(problem, end - problem.t0, CHECK)
            q, v = case.motion(np.array([end]))
            now = problem.system.velocity(run.p[-1:])[0]
            gap = max(gap, abs(float(run.q[-1, 0] - q[0])), abs(float(now[0] - v[0])))
            problem = Problem(problem.system, run.q[-1], now, end)
        found.append(row(study=name, quantity=ORACLES, value=gap))
    runs = (KEPLER.run(ORBIT, SPAN, {"samples": 1}), DOP853.run(ORBIT, SPAN, CHECK))
    gap = float(np.max(np.abs(runs[0].q[-1] - runs[1].q[-1])))
    return [*found, row(study="Kepler", quantity=ORACLES, value=gap)]


def _approximations(
    name: str, case: Case, method: Any, degree: int, count: int
) -> list[dict[str, Any]]:
    edges = np.linspace(0.0, case.duration, count + 1)
    best = best_errors(case.motion, edges, degree, case.kinks)
    path, status = _path(case, method, count)
    values = {LARGEST: best.max(), MEAN: best.mean(), PATH: path}
    where = {"n": degree + 1, "step": case.duration / count, "steps": count}
    return rows(values, study=name, status=status, **where)


def _path(case: Case, method: Any, count: int) -> tuple[float, str]:
    """|u - u_N|_X of one step in the middle from the exact state, and why the run failed."""
    t = np.linspace(0.0, case.duration, count + 1)[count // 2]
    q, v = case.motion(np.array([t]))
    start = Problem(case.problem.system, q, v, float(t))
    run = galvi.integrate(start, method, case.duration / count, 1)
    path = step_error(run, case.motion, case.kinks) if run.success else float("nan")
    return path, failure(run)


def judge(table: DataFrame) -> list[Row]:
    """The rates in X of both motions, the path by rule, the orders at step ends, the rules."""
    return [
        *(
            _rate(table, name, quantity, degree)
            for name in CASES
            for quantity in (LARGEST, MEAN)
            for degree in DEGREES
        ),
        *(_path_row(table, "smooth", "Gauss N + 1", degree) for degree in DEGREES),
        *(
            _path_row(table, label, label, degree)
            for label in RULES
            for degree in DEGREES[1 if label == "Lobatto N" else 0 :]
        ),
        *(_rough_path(table, degree) for degree in DEGREES),
        *(_order(table, label, degree) for label in RULES for degree in RULED),
        *(_rule(table, family) for family in ("Gauss", "Lobatto")),
        *_ours(table),
        *(_apart(table, name) for name in (*CASES, "Kepler")),
    ]


def _rate(table: DataFrame, name: str, quantity: str, degree: int) -> Row:
    case = CASES[name]
    less, words = (1.0, "1") if quantity == LARGEST else (0.5, "1/2")
    claimed = min(case.smoothness, degree + 1) - less
    expected, reason = _expectation(name, quantity, degree)
    which = "largest" if quantity == LARGEST else "mean"
    upper = "an upper bound, of order " if quantity == LARGEST else ""
    return V22.row(
        f"order of {quantity}, {name}, N = {degree}",
        Order(claimed),
        readings.order(table, FLOOR, study=name, quantity=quantity, n=degree + 1),
        source="M sec. 5, (13)",
        setup=f"{case.setting}; {which} of K subintervals, h = T / K, best polynomial of degree N "
        "in |.|_X",
        claimed=f"{upper}min(s, N + 1) - {words} = {claimed:g}",
        expected=expected,
        reason=reason,
        reference=CLOSED,
    )


def _expectation(name: str, quantity: str, degree: int) -> tuple[str, str]:
    """The expected verdict of this rate, and the reason."""
    rough = name == "rough"
    if quantity == LARGEST:
        more = ", also where the third derivative jumps" if rough else ""
        return EXCEEDS, (
            "An upper bound, which M calls very conservative: it takes the L2 norm of the "
            "derivative over the whole interval for that over a subinterval, which for this motion "
            f"is smaller by sqrt(h){more}."
        )
    if rough and degree > 2:
        return EXCEEDS, (
            "The subinterval with the jump has an error of order 5/2, and is one of K in the mean."
        )
    return ATTAINED, f"{IN_L2}."


def _path_row(table: DataFrame, study: str, label: str, degree: int) -> Row:
    """The smooth path by rule: M's N + 1/2, and N - 1/2 for Lobatto with N nodes."""
    few = label == "Lobatto N"
    rule = "" if study == "smooth" else f", {label}"
    return V22.row(
        f"order of {PATH}, smooth{rule}, N = {degree}",
        Finding(Order(degree - 0.5)) if few else Order(degree + 0.5),
        readings.order(table, FLOOR, study=study, quantity=PATH, n=degree + 1),
        source="M sec. 5, thm. 3",
        setup=f"{CASES['smooth'].setting}; {STEP_IN_X}; Polynomials(N), {label} points",
        claimed="nothing for this rule: M names Gauss N and Lobatto N + 1"
        if few
        else f"for smooth solutions N + 1/2 = {degree + 0.5:g}",
        reason="With N nodes the rule is wrong for the square of the derivative's highest mode, "
        "which is of size h^(N - 1/2) in L^2. M prints the inequality from which N + 1/2 follows "
        "for M + 1 >= N nodes, which would include this rule."
        if few
        else f"{IN_L2}; the rule adds no more (theorem 3).",
        reference=CLOSED,
    )


def _rough_path(table: DataFrame, degree: int) -> Row:
    case = CASES["rough"]
    least = min(case.smoothness, degree + 1) - 1.0
    return V22.row(
        f"order of {PATH}, rough, N = {degree}",
        AtLeast(least, uncertainty=0.0),
        readings.order(table, FLOOR, study="rough", quantity=PATH, n=degree + 1),
        source="M sec. 5, thm. 3",
        setup=f"{case.setting}; {STEP_IN_X}, across the jump; Polynomials(N), Gauss N + 1 points",
        claimed=f"e_max gives the lower bound for the order: min(s, N + 1) - 1 = {least:g}",
        reason="The step with the jump has an error of order 5/2, whatever the degree"
        + (": q'' vanishes there, and degree 1 errs as degree 2." if degree == 1 else "."),
        reference=CLOSED,
    )


def _order(table: DataFrame, label: str, degree: int) -> Row:
    fewer = label == "Lobatto N"
    order = 2 * degree - 2
    return V22.row(
        f"order of the one-step error, {label}, N = {degree}",
        Finding(Order(order)) if fewer else Order(order, better=0),
        readings.order(table, ENDS_FLOOR, study=label, quantity=ENDS, n=degree + 1),
        source="M sec. 5, thm. 5",
        setup=_order_setup(label),
        claimed="none for Lobatto with N nodes" if fewer else f"order 2 N - 2 = {order}",
        expected=FINDING if fewer else CONTRADICTED,
        reason="A rule with N nodes is exact to degree 2 N - 1 (Gauss) or 2 N - 3 (Lobatto), so "
        "that its error is h^(2 N + 1) or h^(2 N - 1), and of Lobatto with N + 1 nodes h^(2 N + 1):"
        f" order 2 N{' - 2' if fewer else f'. {SLIP}: M counts h^2 less'}.",
        reference=f"{KEPLER.name}; {DOP853.name} agrees to 2e-14",
    )


def _order_setup(label: str) -> str:
    return (
        f"Kepler, GM = 1, e = 0.3, from the pericentre; Polynomials(N), {label} points; T = 4"
        ", h = T / round(2^(j/2)), j = 5, 6, ..."
    )


def _rule(table: DataFrame, family: str) -> Row:
    printed = 2 * NODES - (1 if family == "Gauss" else 3)
    return V22.row(
        f"order of the error of the rule, {family}, {NODES} nodes",
        Order(float(printed), better=0),
        readings.order(table, INTEGRAL_FLOOR, study=family, quantity=INTEGRAL),
        source="M sec. 5",
        setup=RULE_SETUP,
        claimed=f"h^(2 M + 1) Gauss (h^(2 M - 1) Lobatto), M + 1 = {NODES} nodes: order {printed}",
        expected=CONTRADICTED,
        reason=f"{SLIP}: true with M nodes, M's count at the start of section 5; with the M + 1 "
        "printed here it is h^2 too cautious, and M's order 2 N - 2 rests on it.",
        reference="e^h - 1",
    )


def _ours(table: DataFrame) -> list[Row]:
    """What the two slips should be."""
    steps = [
        V22.row(
            f"order of the one-step error against 2 N, {label}, N = {degree}",
            Finding(Order(2 * degree)),
            readings.order(table, ENDS_FLOOR, study=label, quantity=ENDS, n=degree + 1),
            source="M sec. 5, thm. 5",
            setup=_order_setup(label),
            claimed=f"2 N - 2; our value: 2 N = {2 * degree}",
            reason="Gauss's rule of N nodes makes the method Gauss collocation, Lobatto's of N + 1 "
            "the pair IIIA-IIIB, both of order 2 N.",
            reference=f"{KEPLER.name}; {DOP853.name} agrees to 2e-14",
        )
        for label in ("Gauss N", "Lobatto N + 1")
        for degree in DEGREES[1:]
    ]
    rules = [
        V22.row(
            f"order of the error of the rule with its own count of nodes, {family}, {NODES} nodes",
            Finding(Order(float(exact))),
            readings.order(table, INTEGRAL_FLOOR, study=family, quantity=INTEGRAL),
            source="M sec. 5",
            setup=RULE_SETUP,
            claimed=f"h^{exact - 2}; our value: h^{exact}",
            reason="A rule exact to degree d has an error of h^(d + 2).",
            reference="e^h - 1",
        )
        for family, exact in (("Gauss", 2 * NODES + 1), ("Lobatto", 2 * NODES - 1))
    ]
    return [*steps, *rules]


def _apart(table: DataFrame, name: str) -> Row:
    return V22.row(
        f"{ORACLES}, {name}",
        Finding(AtMost(0.1 * (ENDS_FLOOR if name == "Kepler" else FLOOR))),
        number(table, study=name, quantity=ORACLES),
        setup="Kepler, e = 0.3, T = 4" if name == "Kepler" else CASES[name].setting,
        claimed="no claim: check of the reference",
        reason="At most a tenth of the smallest error that a row rests on.",
        reference=f"closed form; {DOP853.name}",
    )


V22 = Claim(
    "V22",
    "Best approximation, path and rule: what limits the order",
    study,
    judge,
    ("M sec. 5",),
    statement="M sec. 5: orders in h of best approximation (e_max, e_mean), of the error along "
    "the path, and of the step, which the rule limits. Measured: the orders of e_mean for smooth "
    "motions and of the path are attained, that of e_max is a lower bound, and those of the rule "
    "and the step are an index slip on the safe side.",
    caught=(
        OTHER_TRUTH,
        of_table(
            "order of error along the path, smooth, N = 4",
            "order of the one-step error against 2 N, Gauss N, N = 4",
            "order of the one-step error against 2 N, Lobatto N + 1, N = 4",
            A=1.0 + 1e-4,
            C=1.0 + 1e-3,
        ),
        Fault(
            "approximations of degree 1",
            {f"order of {MEAN}, {name}, N = {n}" for name in CASES for n in (2, 3, 4)},
            wrong={
                f"{__name__}.refine": always(lambda *given: []),
                f"{__name__}.best_errors": given(lambda *these: (*these[:2], 1, *these[3:])),
            },
        ),
    ),
)
