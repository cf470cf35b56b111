"""V26: the discrete Lagrangian against the exact one (H 2.1.1, 2.3.2; M theorems 4 and 5)."""

from __future__ import annotations

from benchmarks.claims.kit import *
from benchmarks.claims.vector_spaces.kepler_orbit import (
    METHOD,
    ORBIT,
    STEP,
    convergence_of_polynomials,
)
from benchmarks.claims.vector_spaces.kepler_orbit import problem as kepler
from benchmarks.claims.vector_spaces.step_actions import (
    ACTION,
    IN_N,
    STEPPED,
    action_along,
    discrete_lagrangian,
    exact_lagrangian,
)
from benchmarks.measures.boundary_motion import BoundaryValueMotion
from references import Contender
from references.closed_forms.kepler import KEPLER
from references.closed_forms.oscillator import OSCILLATOR

SQUARE = "error of L_d over |u - u_N|^2 in X"
FLOOR = 1e-14  # of actions up to 4, each rounded to 4e-16
LEAST_SQUARE = 1e-10  # actions with a larger error are compared with the square of a distance
RESOLUTION = 0.005  # of a base, as for those that H prints
POWER = 1.0  # of the factor n^-1, see the row

CIRCLE = "oscillator in the plane, m = k = 1, q0 = (1, 0), v0 = (0, 1)"
NAMES = {"oscillator": CIRCLE, "Kepler": ORBIT}
TRUTHS: dict[str, Contender] = {"oscillator": OSCILLATOR, "Kepler": KEPLER}
NS = {"oscillator": (3, 4, 5, 6), "Kepler": (3, 4, 5)}
LOBATTO = "Kepler, Lobatto rule of n - 1 points"
LOBATTO_NS = (4, 5)
EXACT = "S(q0, q1) in closed form, for Kepler by Lambert's theorem"


def problems() -> dict[str, Problem]:
    """The circular oscillator, on which |q^(n)| = 1, and the Kepler problem from pericentre."""
    spring = galvi.problems.harmonic_oscillator().system
    return {"oscillator": Problem(spring, [1.0, 0.0], [0.0, 1.0]), "Kepler": kepler()}


def with_lobatto(make_method: MakeMethod, n: int) -> Any:
    """Polynomials of degree N = n - 1 with the Lobatto rule of N points: its error dominates."""
    return make_method(galvi.Polynomials(n - 1), galvi.lobatto(n - 1))


def study(make_method: MakeMethod, quick: bool, report: Report) -> DataFrame:
    """For one step: errors of L_d and of (q, p) at the end against h for each problem and n, and
    against n at h = 2; SQUARE for the oscillator; the distance between the two references."""
    sizes = {
        "oscillator": [2.0 ** (-j / 2) for j in range(-2, 16)],
        "Kepler": [2.0 ** (-j / 2) for j in range(4, 16)],
    }  # h below 0.2986
    found: list[dict[str, Any]] = []
    for name, problem in problems().items():
        report(f"{name}, h-refinement")
        for n in NS[name]:
            method = method_of(make_method, n)
            found += _steps(name, problem, TRUTHS[name], method, n, sizes[name])
    report(LOBATTO)
    for n in LOBATTO_NS:
        found += _steps(LOBATTO, kepler(), KEPLER, with_lobatto(make_method, n), n, sizes["Kepler"])
    report(IN_N)
    for n in range(6, 31, 3 if quick else 1):
        found += _steps(IN_N, kepler(), KEPLER, method_of(make_method, n), n, [STEP])
    for name, problem in problems().items():
        for h in (STEP, *sizes[name][::4]):
            along, end = action_along(problem, h, TRUTHS[name])
            apart = abs(along - exact_lagrangian(problem, problem.q0, end, h))
            found.append(row(study=name, quantity=ORACLES, step=h, value=apart))
    return frame(found)


def _steps(
    study: str, problem: Problem, truth: Contender, method: Any, n: int, sizes: Iterable[float]
) -> list[dict[str, Any]]:
    found = []
    for h in sizes:
        run = galvi.integrate(problem, method, h, 1)
        values = dict.fromkeys((ACTION, STEPPED), math.nan)
        if run.success:
            error = abs(discrete_lagrangian(run) - exact_lagrangian(problem, *run.q, h))
            end = truth.run(problem, h, {"samples": 1})
            apart = np.abs(run.q[1] - end.q[1]), np.abs(run.p[1] - end.p[1])
            values = {ACTION: error, STEPPED: float(np.max(apart))}
            if study == "oscillator" and error > LEAST_SQUARE and h < math.pi:
                motion = BoundaryValueMotion(problem, h, truth)
                values[SQUARE] = error / motion.square_of_rates(run)
        found += rows(values, study=study, n=n, step=h, steps=1, status=failure(run))
    return found


def judge(table: DataFrame) -> list[Row]:
    """Orders and bases of both errors, the printed bounds, and the constants."""
    apart = readings.largest_of(table, quantity=ORACLES)
    judged = [
        *(
            _order(table, name, n, quantity)
            for quantity in (ACTION, STEPPED)
            for name in NS
            for n in NS[name]
        ),
        *(_limited(table, n, quantity) for n in LOBATTO_NS for quantity in (ACTION, STEPPED)),
        *(_printed(table, n) for n in NS["Kepler"]),
        *_bases(table),
        _square(table),
        *(_constant(table, n) for n in NS["oscillator"][:3]),
        V26.row(
            ORACLES,
            Finding(AtMost(FLOOR / 10)),
            apart,
            source="H sec. 2.1.1",
            setup=f"{CIRCLE}; {ORBIT}; h = 2^(-j/2)",
            claimed="none: a tenth of the smallest error fitted",
            reason="One is a formula of the ends, the other an integral along the motion.",
        ),
    ]
    reference = f"{EXACT}; the integral of L along the exact motion agrees to {apart:.0e}"
    return [replace(one, reference=reference) for one in judged]


def _order(table: DataFrame, name: str, n: int, quantity: str) -> Row:
    """O(h^(r + 1)), r the step's order."""
    order = 2 * (n - 1)
    return V26.row(
        f"order of the {quantity}, {name}, n = {n}",
        Order(order + 1),
        _fit(table, name, n, quantity),
        source="H thm. 2.1.1, 3.1.1, M thm. 4",
        setup=_setup(NAMES[name], n),
        claimed=f"L_d has error O(h^(r + 1)) where the step has order r, here {order}",
        reason="L_d, at the ends of the step, differs from S by half the second variation in the "
        f"curve's error, whose square has order 2 n - 1 = {order + 1}; the ends' momenta are the "
        "derivatives of both.",
    )


def _limited(table: DataFrame, n: int, quantity: str) -> Row:
    """The same equivalence where the rule limits the order."""
    order = 2 * (n - 1) - 2
    return V26.row(
        f"order of the {quantity}, {LOBATTO}, n = {n}",
        Order(order + 1),
        _fit(table, LOBATTO, n, quantity),
        source="H thm. 2.1.1, 3.1.1, M thm. 4, 5",
        setup=_setup(ORBIT, n).replace("gauss(2 n)", "lobatto(n - 1)"),
        claimed=f"L_d has error O(h^(r + 1)) where the step has order r, here {order}",
        reason=f"The rule of N = {n - 1} points is exact to degree 2 N - 3 = {2 * n - 5}: its "
        f"error in the action is of order 2 N - 1 = {order + 1}, and larger than the curve's.",
    )


def _printed(table: DataFrame, n: int) -> Row:
    return V26.row(
        f"order of the {ACTION}, Kepler, n = {n}, against the bound",
        Order(n),
        _fit(table, "Kepler", n, ACTION),
        source="H thm. 2.3.3",
        setup=_setup(ORBIT, n),
        claimed=f"error O(h^(k + 1)) where curves of the space come within O(h^k) of motion and "
        f"velocity, here k = n - 1 = {n - 1}",
        expected=EXCEEDS,
        reason="The proof takes the action for Lipschitz continuous; it is stationary, so that the "
        f"error is of second order in the curve's: 2 n - 1 = {2 * n - 1}.",
    )


def _bases(table: DataFrame) -> list[Row]:
    base = convergence_of_polynomials(0.0, STEP) ** 2
    claimed = "L_d and the flow map have error O(K^n) with one K < 1"
    place = (
        f"K = {base:.4f} from the branch point (t - t*)^(1/2) at -1 + 0.2986 i of the step [-1, 1] "
        "(Bernstein's ellipse)"
    )
    cases = {
        ACTION: (POWER, "the squared norm of P_n adds n^-1 to the square of a coefficient n^0"),
        STEPPED: (0.0, "the derivative of r^-2n by the ends adds n to the n^-1 of L_d"),
    }
    return [
        V26.row(
            f"base of the {quantity}, Kepler",
            Base(base, RESOLUTION),
            readings.base(table, FLOOR, power=(power, 0.0), study=IN_N, quantity=quantity),
            source="H thm. 2.3.2, 2.3.4",
            setup=f"{ORBIT}; {METHOD}; one step of h = {STEP:g}",
            claimed=claimed,
            reason=f"{place}; {why}.",
        )
        for quantity, (power, why) in cases.items()
    ]


def _square(table: DataFrame) -> Row:
    return V26.row(
        f"largest {SQUARE}",
        AtMost(0.5),
        readings.largest_of(table, quantity=SQUARE),
        source="M thm. 5",
        setup=f"{CIRCLE}; {METHOD}; one step, n = 3 to 6, h below pi, errors of L_d above "
        f"{LEAST_SQUARE:g}",
        claimed="|S(u) - S_N(u_N)| is at most a constant times |u - u_N|_X^2, and the error of the "
        "rule, here 0",
        reason="With e = u_N - u the difference is (|e'|^2 - |e|^2) / 2, at most |e'|^2 / 2, and "
        "|e|_X^2 = |e'|^2 where both ends are met.",
    )


def _constant(table: DataFrame, n: int) -> Row:
    """L_d - S = h^(2n-1) |q^(n)|^2 ((n-1)! / (2n-2)!)^2 / (2 (2n-1)) (1 + O(h^2))."""
    chosen = pick(table, study="oscillator", quantity=ACTION, n=n).sort_values(
        "step", ascending=False
    )
    h, error = chosen["step"].to_numpy(float), chosen["value"].to_numpy(float)
    ratio = math.factorial(n - 1) / math.factorial(2 * n - 2)
    theory = h ** (2 * n - 1) * ratio**2 / (2 * (2 * n - 1))
    seen = error > 1e3 * FLOOR
    return V26.row(
        f"order of the departure of {ACTION} from its leading term, relative, oscillator, n = {n}",
        Finding(Order(2.0)),
        algebraic(h[seen], np.abs(error / theory - 1.0)[seen], floor=1e-3),
        source="H sec. 2.1.1",
        setup=_setup(CIRCLE, n),
        claimed="none: the constant",
        reason="The curve's velocity leaves out the multiple h^(n - 1) |q^(n)| (n - 1)! / "
        "(2 n - 2)! of P_(n - 1), with half its square, on a circle of radius 1: h^(2 n - 1) "
        "((n - 1)! / (2 n - 2)!)^2 / (2 (2 n - 1)), up to a factor 1 + O(h^2).",
    )


def _fit(table: DataFrame, study: str, n: int, quantity: str) -> Fit:
    return readings.order(table, FLOOR, study=study, quantity=quantity, n=n)


def _setup(problem: str, n: int) -> str:
    first = -2 if problem == CIRCLE else 4
    return f"{problem}; {METHOD}; one step of h = 2^(-j/2), j = {first}, {first + 1}, ...; n = {n}"


V26 = Claim(
    "V26",
    "The discrete Lagrangian: error of one order and base with the step's",
    study,
    judge,
    ("H thm. 2.3.2", "M thm. 4"),
    reference=EXACT,
    statement="H thm. 2.1.1, 2.3.2 to 2.3.4, 3.1.1, M thm. 4, 5: a method of order r has a "
    "discrete Lagrangian with an error O(h^(r + 1)), and in n both have one base K.",
    caught=(
        of_table(*(f"order of the {STEPPED}, Kepler, n = {n}" for n in (4, 5)), beta=1.0 + 1e-6),
        of_table(
            *(f"order of the {ACTION}, oscillator, n = {n}" for n in (5, 6)),
            f"base of the {ACTION}, Kepler",
            C=1.0 + 1e-4,
        ),
        Fault(
            "the potential's sign, which no step sees",
            {f"order of the {ACTION}, Kepler, n = 3", ORACLES},
            wrong={
                "benchmarks.claims.vector_spaces.step_actions.lagrangian": lambda sound: (
                    lambda p, q, v: np.sum(v * v, axis=-1) - sound(p, q, v)
                )
            },
        ),
        Fault(
            "oracles that differ",
            {ORACLES},
            wrong={f"{__name__}.exact_lagrangian": scaled(1.0 + 1e-12)},
        ),
    ),
)
