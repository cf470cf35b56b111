"""L16: a step is symplectic on every group, in left trivialisation (H 3.1.1)."""

from __future__ import annotations

from benchmarks.claims.kit import *
from benchmarks.measures.symplectic_form import StepMap, form_defect
from benchmarks.test_problems import thrown_plate
from benchmarks.test_problems.body_on_cart import body_on_cart
from benchmarks.test_problems.coupled import Coupled
from benchmarks.test_problems.hung_body import HUNG_BODY
from benchmarks.test_problems.joined_pendulums import JOINED_PENDULUMS
from galvi.charts import CHARTS
from galvi.systems.velocities import velocity_at

STEP = 0.4
PAIRS = {"gauss": (4, 4), "lobatto": (4, 5), "clenshaw_curtis": (4, 6)}  # degree, points
LIMIT = 1e-12  # 2e-13 was measured; differences of order eight leave that
SETUP = (
    "one step of h = 0.4 from the problem's start; Polynomials(4) with gauss(4), lobatto(5) and "
    "clenshaw_curtis(6), the largest, relative to |DF|^2; derivative by central differences of "
    "order eight"
)
PROBLEMS: Mapping[str, Callable[[], Problem]] = {
    "free rigid body on SO(3)": galvi.problems.free_rigid_body,
    "3D pendulum on SO(3)": galvi.problems.pendulum_3d,
    "body hung by a spring on SE(3)": HUNG_BODY.problem,
    "thrown plate on SE(2)": thrown_plate.problem,
    "body on a cart on SO(3) x R": body_on_cart,
    "joined pendulums on SO(3) x SO(3)": JOINED_PENDULUMS.problem,
}
FLOWS: Mapping[str, Coupled] = {
    "body hung by a spring on SE(3)": HUNG_BODY,
    "joined pendulums on SO(3) x SO(3)": JOINED_PENDULUMS,
}
EXACTLY = "exact flow"


def starts_of(system: Any) -> Callable[[Array, Array], Problem]:
    """(g, mu) -> the problem that starts there, made once: charts and rules start alike."""
    known: dict[bytes, Problem] = {}

    def start(g: Array, mu: Array) -> Problem:
        key = g.tobytes() + mu.tobytes()
        if key not in known:
            known[key] = Problem(system, g, velocity_at(system, g, mu, 0.0))
        return known[key]

    return start


def step_of(start: Callable[[Array, Array], Problem], method: Any) -> StepMap:
    """One step of the method as a map (g, mu) -> (g1, mu1); NaN when it fails."""

    def step(g: Array, mu: Array) -> tuple[Array, Array]:
        run = galvi.integrate(start(g, mu), method, STEP, 1)
        return run.q[-1], run.p[-1]

    return step


def study(make_method: MakeMethod, quick: bool, report: Report) -> DataFrame:
    """'defect' of each problem, in `label`, and chart and rule, in `quantity`; and of the exact
    flow where that is known."""
    found = []
    for label, make_problem in PROBLEMS.items():
        report(label)
        problem = make_problem()
        group: Any = problem.system.group  # type: ignore[attr-defined]
        at = starts_of(problem.system)
        for chart in CHARTS:
            for rule, (degree, points) in PAIRS.items():
                method = make_method(galvi.Polynomials(degree), getattr(galvi, rule)(points), chart)
                run = galvi.integrate(problem, method, STEP, 1)
                value = float("nan")
                if run.success:
                    value = form_defect(step_of(at, method), group, problem.q0, problem.p0)
                where = {"study": "defect", "label": label, "n": degree + 1, "step": STEP}
                found += rows({type(chart).__name__: value}, status=failure(run), **where)
    for label, known in FLOWS.items():
        report(f"{label}, {EXACTLY}")
        start = known.problem()
        group = start.system.group  # type: ignore[attr-defined]
        value = form_defect(partial(known.flow, duration=STEP), group, start.q0, start.p0)
        found += rows({EXACTLY: value}, study="defect", label=label, step=STEP)
    return frame(found)


def judge(table: DataFrame) -> list[Row]:
    """A row for each problem and chart: the worst of the rules; and for each exact flow."""
    return [
        *(_row(table, label, type(chart).__name__) for label in PROBLEMS for chart in CHARTS),
        *(_flow(table, label) for label in FLOWS),
    ]


def _row(table: DataFrame, label: str, chart: str) -> Row:
    defects = readings.values(table, study="defect", quantity=chart, label=label)
    return L16.row(
        f"defect of the form, {label}, {chart} chart",
        AtMost(LIMIT),
        readings.largest(defects) if len(defects) == len(PAIRS) else float("nan"),
    )


def _flow(table: DataFrame, label: str) -> Row:
    return L16.row(
        f"defect of the form, {label}, {EXACTLY}",
        Finding(AtMost(LIMIT)),
        number(table, study="defect", quantity=EXACTLY, label=label),
        setup=f"flow over {STEP:g} from the problem's start, by Newton's and Euler's equations; "
        "derivative by central differences of order eight",
        claimed="no claim of H about this problem: a check of the form and of mu",
        reason="The flow of a Hamiltonian system preserves its canonical form.",
    )


L16 = Claim(
    "L16",
    "A step is symplectic on every group, in left trivialisation",
    study,
    judge,
    source="H 3.1.1",
    setup=SETUP,
    claimed="discrete flows preserve the canonical symplectic form",
    reason="A step is generated by its discrete Lagrangian, whatever the group, the chart and the "
    "rule.",
    reference="<d mu2, eta1> - <d mu1, eta2> + <mu, [eta1, eta2]>",
    statement="H 3.1.1: steps on a group preserve the canonical symplectic form, in left "
    "trivialisation.",
    caught=(
        Fault(
            "another flow of one coupled problem",
            some(EXACTLY),
            wrong={
                f"{__name__}.PROBLEMS": always({}),
                f"{__name__}.FLOWS": lambda sound: {
                    name: replace(
                        flow,
                        state=lambda *given, of=flow.state: (
                            (end := of(*given))[0],
                            1.001 * end[1],
                        ),
                    )
                    for name, flow in sound.items()
                },
            },
        ),
    ),
)
