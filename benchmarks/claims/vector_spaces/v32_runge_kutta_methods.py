"""V32: Gauss N is collocation, Lobatto N + 1 the pair IIIA-IIIB (M section 1)."""

from __future__ import annotations

from benchmarks.claims.kit import *
from benchmarks.measures.independent_space import (
    all_of_degree,
    gauss_points,
    lobatto_points,
    values,
)

DEGREES = (1, 2, 3, 4)
GAUSS, LOBATTO = "Gauss N", "Lobatto N + 1"
ENDS, STAGES = "distance of q and p at the end", "distance of the curve from the stages"
OWN = "distance of the tableau from its partner"
VERLET, NEWMARK = "Stormer-Verlet", "Newmark, beta = 0, gamma = 1/2"
STEP, PASSES = 0.5, 200
ROUND_OFF = 1e-14  # of numbers of size 1; 2e-16 was measured


@dataclass(frozen=True, eq=False)
class Nonlinear:
    """m q'' = force(q), a problem of galvi and the same in numpy; force of (stages, d)."""

    name: str
    problem: Callable[[], Problem]
    mass: float
    force: Callable[[Array], Array]


def _two_springs(q: Array) -> Array:
    x, y = q[..., 0], q[..., 1]
    return np.stack([-x - 2.0 * x * y, -y - x**2 + y**2], axis=-1)


def _heavy_pendulum() -> Problem:
    return Problem(galvi.Canonical(2.0, galvi.CosinePotential(1.0)), np.ones(1), np.ones(1))


PROBLEMS = (
    Nonlinear("Henon-Heiles", galvi.problems.henon_heiles, 1.0, _two_springs),
    Nonlinear("pendulum", _heavy_pendulum, 2.0, lambda q: -np.sin(q)),
)


def collocation(c: Array) -> Array:
    """a_ij, the integral from 0 to c_i of the Lagrange polynomial that is 1 at c_j."""
    functions = all_of_degree(len(c) - 1)
    s, w = gauss_points(len(c))
    within = [values(functions, end * s) @ (end * w) for end in c]
    return np.linalg.solve(values(functions, c), np.array(within).T).T


def partner(a: Array, b: Array) -> Array:
    """a^ with b_i a^_ij + b_j a_ji = b_i b_j."""
    return b * (1.0 - a.T / b[:, None])


def runge_kutta(case: Nonlinear, a: Array, b: Array, h: float) -> tuple[Array, Array, Array]:
    """One step: q and p at its end, and the places of the stages; a of q, its partner of p."""
    start = case.problem()
    q, p = start.q0, case.mass * start.v0
    other = partner(a, b)
    places = np.tile(q, (len(b), 1))
    for _ in range(PASSES):
        momenta = p + h * other @ case.force(places)
        places = q + h * a @ momenta / case.mass
    momenta = p + h * other @ case.force(places)
    return q + h * b @ momenta / case.mass, p + h * b @ case.force(places), places


def verlet(case: Nonlinear, h: float) -> tuple[Array, Array]:
    """Half a kick, a drift, half a kick."""
    start = case.problem()
    half = case.mass * start.v0 + 0.5 * h * case.force(start.q0)
    q = start.q0 + h * half / case.mass
    return q, half + 0.5 * h * case.force(q)


def newmark(
    case: Nonlinear, h: float, beta: float = 0.0, gamma: float = 0.5
) -> tuple[Array, Array]:
    """Displacements and velocities from both accelerations (Newmark 1959)."""
    start = case.problem()
    q0, v0 = start.q0, start.v0
    before = case.force(q0) / case.mass
    q = q0 + h * v0 + h**2 * 0.5 * before
    for _ in range(PASSES):
        after = case.force(q) / case.mass
        q = q0 + h * v0 + h**2 * ((0.5 - beta) * before + beta * after)
    after = case.force(q) / case.mass
    return q, case.mass * (v0 + h * ((1.0 - gamma) * before + gamma * after))


def study(make_method: MakeMethod, quick: bool, report: Report) -> DataFrame:
    """Distances of one step from the Runge-Kutta method's, by rule, in `study`, degree, n = N + 1,
    and problem, in `label`; of Lobatto 2 from two formulas; of a tableau from its partner."""
    found: list[dict[str, Any]] = []
    for name, rule, points in (
        (GAUSS, galvi.gauss, gauss_points),
        (LOBATTO, galvi.lobatto, lobatto_points),
    ):
        for degree in DEGREES:
            report(f"{name}, N = {degree}")
            count = degree if name == GAUSS else degree + 1
            c, b = points(count)
            a = collocation(c)
            method = make_method(galvi.Polynomials(degree), rule(count))
            if name == GAUSS:
                apart = float(np.max(abs(partner(a, b) - a)))
                found += rows({OWN: apart}, study=name, n=degree + 1)
            for case in PROBLEMS:
                run = galvi.integrate(case.problem(), method, STEP, 1)
                q, p, places = runge_kutta(case, a, b, STEP)
                curve = run(run.t[0] + STEP * c)
                seen = {ENDS: _apart(run, q, p), STAGES: float(np.max(abs(curve - places)))}
                if name == LOBATTO and degree == 1:
                    seen[VERLET] = _apart(run, *verlet(case, STEP))
                    seen[NEWMARK] = _apart(run, *newmark(case, STEP))
                where = {"n": degree + 1, "label": case.name, "status": failure(run)}
                found += rows(seen, study=name, **where)
    return frame(found)


def _apart(run: galvi.Trajectory, q: Array, p: Array) -> float:
    return float(max(np.max(abs(run.q[-1] - q)), np.max(abs(run.p[-1] - p))))


def judge(table: DataFrame) -> list[Row]:
    """Rows by rule and degree, then for the two formulas, then for the tableaux."""
    kinds = {
        GAUSS: (
            "collocation at Gauss's points",
            "u_N' interpolates p / m at the points, and p is the polynomial of degree N with "
            "p' = force there.",
        ),
        LOBATTO: (
            "the pair Lobatto IIIA-IIIB",
            "The curve is the collocation polynomial of p / m, and the discrete momenta are those "
            "of the symplectic partner.",
        ),
    }
    return [
        *(
            V32.row(
                f"{quantity}, {name}, N = {degree}",
                AtMost(ROUND_OFF),
                readings.largest_of(table, quantity=quantity, study=name, n=degree + 1),
                claimed=f"some Galerkin variational integrators are Runge-Kutta methods: {kind}",
                reason=reason,
            )
            for name, (kind, reason) in kinds.items()
            for degree in DEGREES
            for quantity in (ENDS, STAGES)
        ),
        *(
            V32.row(
                f"distance of q and p at the end from {name}, Lobatto 2, N = 1",
                AtMost(ROUND_OFF),
                readings.largest_of(table, quantity=name),
                claimed=f"{name.split(',')[0]} fits in this framework",
                reason=reason,
                reference="its formula in numpy",
            )
            for name, reason in (
                (VERLET, "The pair IIIA-IIIB of two stages."),
                (NEWMARK, "Explicit, it is Stormer-Verlet; M does not say which beta and gamma."),
            )
        ),
        V32.row(
            f"{OWN}, {GAUSS}, all N",
            Finding(AtMost(ROUND_OFF)),
            readings.largest_of(table, quantity=OWN),
            claimed="no claim: one tableau stands for both halves of the pair",
            reason="Collocation at Gauss's points is symplectic by itself.",
            reference="numpy",
        ),
    ]


V32 = Claim(
    "V32",
    "Gauss N is collocation, Lobatto N + 1 the pair IIIA-IIIB",
    study,
    judge,
    source="M sec. 1",
    setup=f"{' and '.join(case.name for case in PROBLEMS)} (m = 2, q = v = 1); one step of "
    f"h = {STEP:g}; Polynomials(N)",
    reference="Runge-Kutta steps in numpy: a by collocation at the nodes, its partner from "
    "b_i a^_ij + b_j a_ji = b_i b_j",
    statement="M sec. 1: Stormer-Verlet, Newmark's method and symplectic partitioned Runge-Kutta "
    "methods fit in the framework, and some Galerkin variational integrators are Runge-Kutta "
    "methods. Measured: Gauss N is collocation at these points, and Lobatto N + 1 the pair "
    "IIIA-IIIB.",
    caught=(
        *(
            of_table(
                *(
                    f"{ENDS}, {name}, N = {N}"
                    for name in (GAUSS, LOBATTO)
                    for N in DEGREES[1 if (array, name) == ("A", LOBATTO) else 0 :]
                ),
                **{array: 1.0 + 1e-11},
            )
            for array in ("A", "b", "beta")
        ),
        of_table(
            *(f"{STAGES}, {name}, N = {N}" for name in (GAUSS, LOBATTO) for N in DEGREES),
            C=1.0 + 1e-11,
        ),
        Fault(
            "a rule of one point more",
            {f"{ENDS}, {name}, N = {N}" for name in (GAUSS, LOBATTO) for N in DEGREES},
            lambda space, rule: galvi.Galerkin(
                space, (galvi.lobatto if "Lobatto" in rule.name else galvi.gauss)(rule.points + 1)
            ),
        ),
        *(
            Fault(f"a wrong {name}", seen, wrong={f"{__name__}.{name}": change})
            for name, change, seen in (
                (
                    "partner",
                    always(lambda a, b: a),
                    {f"{ENDS}, {LOBATTO}, N = {N}" for N in DEGREES},
                ),
                (
                    "verlet",
                    always(lambda case, h: newmark(case, h, 0.25)),
                    {f"{ENDS} from {VERLET}, Lobatto 2, N = 1"},
                ),
                (
                    "newmark",
                    always(lambda case, h: (case.problem().q0, case.problem().v0)),
                    {f"{ENDS} from {NEWMARK}, Lobatto 2, N = 1"},
                ),
                ("collocation", scaled(1.0 + 1e-11), {f"{OWN}, {GAUSS}, all N"}),
            )
        ),
    ),
)
