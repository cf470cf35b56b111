"""L17: the discrete Lagrangian on SO(3) against the exact one (H 3.1.1, 3.3.1, 3.3.2)."""

from __future__ import annotations

from benchmarks.claims.kit import *
from benchmarks.claims.lie_groups import free_body, pendulum_motion
from benchmarks.claims.lie_groups.cayley_curve import distance_of_polynomials
from benchmarks.claims.vector_spaces.step_actions import (
    ACTION,
    IN_N,
    STEPPED,
    action_along,
    discrete_lagrangian,
)
from benchmarks.measures.boundary_motion import between
from benchmarks.work_precision.with_settings import WithSettings
from references import Contender
from references.closed_forms.top_motion import FREE_TOP
from references.scipy.ivp import TIGHT
from references.scipy.rigid_ivp import RIGID_DOP853

BEST = "distance of the motion from polynomials"
FREE, PENDULUM, STEADY = "free body", "3D pendulum", "steady turning"
LOBATTO = f"{FREE}, Lobatto rule of n - 1 points"
NS, LOBATTO_NS, STEADY_NS = (3, 4, 5), (4, 5), (3, 5)
ROUND_OFF = 2e-16  # of the steady turning's actions, below 3.4
FLOOR: Mapping[str, float] = {ACTION: 1e-14, STEPPED: 2e-15}  # actions, of 0.3 to 4; entries of R
LONG_FLOOR = 3e-14  # of the actions of the longest steps, up to 7; 1e-14 was measured at large n
RATES: Mapping[int, float] = {3: 0.5, 5: 1.0}  # |xi^(n)| of 2 tan(t / 2) at t = 0
OTHER = WithSettings(RIGID_DOP853, TIGHT)
DENSE = 400  # samples of a motion for the best approximation


@dataclass(frozen=True)
class Case:
    """A motion and its truth.

    powers  j of the steps 2^(-j / 4) of the h-refinement;  step  that of the n-refinement
    """

    problem: Problem
    truth: Contender
    setup: str
    powers: range
    step: float


CASES: Mapping[str, Case] = {
    FREE: Case(free_body.problem(), FREE_TOP, free_body.BODY, range(8, 25), 0.5),
    PENDULUM: Case(
        pendulum_motion.problem(), pendulum_motion.TRUTH, pendulum_motion.MOTION, range(6, 25), 1.0
    ),
}
TURNING = "J = diag(3.3, 2.5, 3.4), R0 = I, body velocity (0, 0, 1)"
EXACT = (
    "S = h T of the free body between the same attitudes, in closed form; of the pendulum the "
    "integral of T - V by Romberg; both motions by shooting"
)


def exact_lagrangian(case: Case, last: Array, h: float) -> float:
    """The action of the motion from the problem's attitude to ``last`` in the time h: h T of a free
    body, whose T is constant, else Romberg's integral; NaN without a motion."""
    exact = between(case.problem, last, h, case.truth, samples=1)
    if exact is None:
        return math.nan
    if case.problem.system.potential is None:
        return float(0.5 * h * exact.problem.v0 @ case.problem.system.inertia @ exact.problem.v0)
    return action_along(exact.problem, h, case.truth)[0]


def steady_lagrangian(run: Trajectory) -> float:
    """Of the turning about the third axis to a run's attitude: J theta^2 / (2 h)."""
    turn = math.atan2(run.q[1][1, 0], run.q[1][0, 0])
    return 3.4 * turn**2 / (2.0 * float(run.t[1] - run.t[0]))


def study(make_method: MakeMethod, quick: bool, report: Report) -> DataFrame:
    """For one step: errors of L_d and of R at the end against h for each motion and n, and against
    n, with the distance of polynomials; L_d of a steady turning; two references' distance."""
    found: list[dict[str, Any]] = []
    for name, case in CASES.items():
        sizes = [2.0 ** (-j / 4) for j in case.powers]
        for n in NS:
            report(f"{name}, h-refinement, n = {n}")
            found += _steps(name, case, method_on_group(make_method, n), n, sizes)
        report(f"{name}, {IN_N}")
        found += _in_n(name, case, make_method)
        for h in (case.step, *sizes[::4]):
            found.append(row(study=name, quantity=ORACLES, step=h, value=_apart(case, h)))
    sizes = [2.0 ** (-j / 4) for j in CASES[FREE].powers]
    for n in LOBATTO_NS:
        report(f"{LOBATTO}, n = {n}")
        method = make_method(galvi.Polynomials(n - 1), galvi.lobatto(n - 1), CAYLEY)
        found += _steps(LOBATTO, CASES[FREE], method, n, sizes)
    return frame([*found, *_turnings(make_method)])


def _steps(
    study: str, case: Case, method: Any, n: int, sizes: Iterable[float]
) -> list[dict[str, Any]]:
    found = []
    for h in sizes:
        run = galvi.integrate(case.problem, method, h, 1)
        values = dict.fromkeys((ACTION, STEPPED), math.nan)
        if run.success:
            end = case.truth.run(case.problem, h, {"samples": 1}).q[-1]
            error = abs(discrete_lagrangian(run) - exact_lagrangian(case, run.q[1], h))
            values = {ACTION: error, STEPPED: float(np.max(np.abs(run.q[1] - end)))}
        found += rows(values, study=study, n=n, step=h, steps=1, status=failure(run))
    return found


def _in_n(name: str, case: Case, make_method: MakeMethod) -> list[dict[str, Any]]:
    """One step for each n, and the distance of the exact motion from polynomials in the chart."""
    h = case.step
    motion = case.truth.run(case.problem, h, {"samples": DENSE})
    omega = case.problem.system.velocity(motion.p)
    found = []
    for n in range(3, 14):
        study = f"{name}, {IN_N}"
        found += _steps(study, case, method_on_group(make_method, n), n, [h])
        best = distance_of_polynomials(motion.q, omega, n - 1)
        found.append(row(study=study, quantity=BEST, n=n, step=h, value=best))
    return found


def _apart(case: Case, h: float) -> float:
    """The action from the problem's start, by its reference and along SciPy's DOP853."""
    along, _ = action_along(case.problem, h, OTHER)
    last = case.truth.run(case.problem, h, {"samples": 1}).q[-1]
    return abs(along - exact_lagrangian(case, last, h))


def _turnings(make_method: MakeMethod) -> list[dict[str, Any]]:
    body, found = galvi.problems.free_rigid_body(velocity=(0.0, 0.0, 1.0)), []
    for n in STEADY_NS:
        for h in [2.0 ** (-j / 2) for j in range(-1, 12)]:
            run = galvi.integrate(body, method_on_group(make_method, n), h, 1)
            error = abs(discrete_lagrangian(run) - steady_lagrangian(run))
            found += rows({ACTION: error}, study=STEADY, n=n, step=h, status=failure(run))
    return found


def judge(table: DataFrame) -> list[Row]:
    """Orders of both errors, the printed bounds in h and n, and the constants."""
    apart = readings.largest_of(table, quantity=ORACLES)
    judged = [
        *(_order(table, name, n, what) for what in (ACTION, STEPPED) for name in CASES for n in NS),
        *(_limited(table, n, quantity) for quantity in (ACTION, STEPPED) for n in LOBATTO_NS),
        *(_printed(table, n) for n in NS),
        *(row for name in CASES for row in _in_numbers(table, name)),
        *(_constant(table, n) for n in STEADY_NS),
        L17.row(
            ORACLES,
            Finding(AtMost(FLOOR[ACTION])),
            apart,
            source="H thm. 3.1.1",
            setup="; ".join(case.setup for case in CASES.values()),
            claimed="none: no more than the smallest error fitted",
            reason="One is the action between two attitudes, by shooting; the other the integral "
            f"of T - V along the motion from the start, by {OTHER.name}.",
        ),
    ]
    reference = f"{EXACT}; the integral along the motion by {OTHER.name} agrees to {apart:.0e}"
    return [replace(one, reference=reference) for one in judged]


def _order(table: DataFrame, name: str, n: int, quantity: str) -> Row:
    """O(h^(r + 1)), r the step's order."""
    order = 2 * (n - 1)
    return L17.row(
        f"order of the {quantity}, {name}, n = {n}",
        Order(order + 1),
        _fit(table, name, n, quantity),
        source="H thm. 3.1.1",
        setup=_setup(name, n),
        claimed=f"the step has order r, here {order}, where L_d has error O(h^(r + 1))",
        reason="L_d, at the ends of the step, differs from S by half the second variation in the "
        f"error of xi, whose square has order 2 n - 1 = {order + 1}; the ends' momenta are the "
        "derivatives of both, on a group in left trivialisation.",
    )


def _limited(table: DataFrame, n: int, quantity: str) -> Row:
    """The same where the rule limits the order."""
    order = 2 * (n - 1) - 2
    return L17.row(
        f"order of the {quantity}, {LOBATTO}, n = {n}",
        Order(order + 1),
        _fit(table, LOBATTO, n, quantity),
        source="H thm. 3.1.1",
        setup=_setup(FREE, n).replace("gauss(n)", "lobatto(n - 1)"),
        claimed=f"the step has order r, here {order}, where L_d has error O(h^(r + 1))",
        reason=f"The rule of N = {n - 1} points is exact to degree 2 N - 3 = {2 * n - 5}: its "
        f"error in the action is of order 2 N - 1 = {order + 1}, and larger than the curve's.",
    )


def _printed(table: DataFrame, n: int) -> Row:
    return L17.row(
        f"order of the {ACTION}, {PENDULUM}, n = {n}, against the bound",
        Order(n),
        _fit(table, PENDULUM, n, ACTION),
        source="H thm. 3.3.1",
        setup=_setup(PENDULUM, n),
        claimed="error O(h^(k + 1)) where curves of the algebra come within O(h^k) of xi and xi', "
        f"here k = n - 1 = {n - 1}",
        expected=EXCEEDS,
        reason="The proof takes the action for Lipschitz continuous; it is stationary, so that the "
        f"error is of second order in the curve's: 2 n - 1 = {2 * n - 1}.",
    )


def _in_numbers(table: DataFrame, name: str) -> list[Row]:
    """Geometric in n, with a base below that of the best approximation: its square."""
    where = {"study": f"{name}, {IN_N}"}
    best = readings.base(table, LONG_FLOOR, quantity=BEST, **where)
    error = readings.decay(table, LONG_FLOOR, quantity=ACTION, **where)
    shared = {
        "source": "H thm. 3.3.2, H thm. 3.7.1",
        "setup": f"{CASES[name].setup}; {free_body.METHOD}; one step of h = {CASES[name].step:g}, "
        "n = 3 to 13",
    }
    square = (
        "the error of L_d is half the second variation in that of xi, a quadratic form that is "
        "bounded from both sides (lemmas 3.3.1, 3.3.2)"
    )
    distances, errors = (series(table, "n", quantity=what, **where)[1] for what in (BEST, ACTION))
    return [
        L17.row(
            f"base of the {ACTION}, {name}",
            Geometric(),
            error,
            claimed="L_d has error O(K^n), K < 1",
            reason="The motion is analytic in t.",
            **shared,
        ),
        L17.row(
            f"base of the {ACTION} against that of the best approximation, {name}",
            AtMost(best.rate, uncertainty=best.uncertainty),
            error.fit,
            claimed=f"O(K^n) with K = max(K_A, K_g): K_A, measured {best.rate:.3g}, is the base of "
            "the best approximation in the algebra; that of the rule, which is exact to degree "
            "2 n - 1, is not larger",
            reason=f"K_A^2 would do: {square}.",
            **shared,
        ),
        L17.row(
            f"power of the {BEST} in the {ACTION}, {name}",
            Finding(Order(2.0)),
            algebraic(distances, errors, floor=LONG_FLOOR),
            claimed="none: at least 1, by K = max(K_A, K_g)",
            reason=f"{square[0].upper()}{square[1:]}. The distance is the least in body velocity, "
            "root mean square over the step.",
            **shared,
        ),
    ]


def _constant(table: DataFrame, n: int) -> Row:
    """L_d - S = h^(2n-1) J |xi^(n)|^2 ((n-1)! / (2n-2)!)^2 / (2 (2n-1)) (1 + O(h^2))."""
    chosen = pick(table, study=STEADY, quantity=ACTION, n=n).sort_values("step", ascending=False)
    h, error = chosen["step"].to_numpy(float), chosen["value"].to_numpy(float)
    ratio = RATES[n] * math.factorial(n - 1) / math.factorial(2 * n - 2)
    theory = 3.4 * h ** (2 * n - 1) * ratio**2 / (2 * (2 * n - 1))
    seen = error > 1e3 * ROUND_OFF
    return L17.row(
        f"order of the departure of {ACTION} from its leading term, relative, {STEADY}, n = {n}",
        Finding(Order(2.0)),
        algebraic(h[seen], np.abs(error / theory - 1.0)[seen], floor=1e-3, ceiling=1.0),
        source="H thm. 3.1.1",
        setup=f"{TURNING}; {free_body.METHOD}; one step of h = 2^(-j/2), j = -1, 0, ...; n = {n}",
        claimed="none: the constant",
        reason="S = J theta^2 / (2 h). In the chart xi = 2 tan(t / 2), with xi^(3) = 1/2 and "
        "xi^(5) = 1 at t = 0; polynomials leave out the multiple h^(n - 1) xi^(n) (n - 1)! / "
        "(2 n - 2)! of P_(n - 1) in xi', with J / 2 times its square: h^(2 n - 1) J |xi^(n)|^2 "
        "((n - 1)! / (2 n - 2)!)^2 / (2 (2 n - 1)), up to a factor 1 + O(h^2).",
    )


def _fit(table: DataFrame, study: str, n: int, quantity: str) -> Fit:
    return readings.order(table, FLOOR[quantity], study=study, quantity=quantity, n=n)


def _setup(name: str, n: int) -> str:
    case = CASES[name]
    first = case.powers[0]
    steps = f"one step of h = 2^(-j/4), j = {first}, {first + 1}, ...; n = {n}"
    return f"{case.setup}; {free_body.METHOD}; {steps}"


L17 = Claim(
    "L17",
    "The discrete Lagrangian on SO(3): error of one order with the step's",
    study,
    judge,
    source="H thm. 3.1.1",
    reference=EXACT,
    statement="H thm. 3.1.1, 3.3.1, 3.3.2, 3.7.1: a discrete Lagrangian with an error O(h^(r + 1)) "
    "gives a step of order r, on a group as on R^d, and one with O(K^n) a geometric step; L_d is "
    "as good as the algebra's curves. Measured: as good as their square.",
    caught=(
        *(
            of_table(*(f"order of the {quantity}, {case}, n = 5" for case in CASES), **{array: by})
            for array, by, quantity in (
                ("b", 1.0 + 1e-6, STEPPED),
                ("integral", 1.0 + 1e-4, ACTION),
            )
        ),
        Fault(
            "a coarse reference",
            {ORACLES}.__eq__,
            wrong={
                f"{__name__}.OTHER": lambda sound: WithSettings(
                    RIGID_DOP853, {"rtol": 1e-8, "atol": 1e-8}
                )
            },
        ),
        of_motion("clock reversed", some(STEPPED), reversed_clock),
    ),
)
