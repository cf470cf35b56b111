"""L10: interpolating curves on a group are equivariant (H lemma 3.2.1)."""

from __future__ import annotations

from benchmarks.claims.kit import *
from benchmarks.measures.matrix_group import MatrixGroup
from galvi.charts import CHARTS
from galvi.charts.chart import Chart, coordinates, place
from galvi.groups import GROUPS
from galvi.groups.group import Group

NODES = np.array([0.0, 0.1, 0.3, 0.7, 1.0])  # t_i, the first at the base point
TIMES = np.linspace(0.0, 1.0, 21)
TURN = 0.6  # size of the steps between points: rotations by up to about 2 rad
TRIALS, QUICK_TRIALS, SEED = 20, 5, 2013
N, STEP, STEPS = 6, 0.4, 10
LIMIT = 1e-12  # of entries of size 1 to 10; 1e-14 was measured
CURVE = "largest defect of the interpolating curve, "
THROUGH = "largest distance to the points, of the curve, "
RUN = "largest defect of a run's curve, "
SETUP = (
    f"curves through 5 random points of the group at t = 0, 0.1, 0.3, 0.7, 1, steps of {TURN:g} "
    "standard deviations in the algebra; moved by a random element from the left"
)
RUN_SETUP = (
    f"free bodies; Polynomials({N - 1}), gauss({N}); h = {STEP:g}, {STEPS} steps; curve of the run "
    "from g q0 against g times that from q0"
)
BODIES = {
    "SO3": galvi.problems.free_rigid_body,
    "SE3": galvi.problems.free_body_se3,
}


def measure(make_method: MakeMethod, quick: bool, report: Report) -> dict[str, float]:
    """Largest differences over random curves of each group and chart, and over curves of runs."""
    rng, found = np.random.default_rng(SEED), {}
    trials = QUICK_TRIALS if quick else TRIALS
    for group in GROUPS:
        for chart in CHARTS:
            label = _label(group, chart)
            report(label)
            worst = np.max([_one(group, chart, rng) for _ in range(trials)], axis=0)
            found |= {CURVE + label: worst[0], THROUGH + label: worst[1]}
    for name, make in BODIES.items():
        for chart in CHARTS:
            method = make_method(galvi.Polynomials(N - 1), galvi.gauss(N), chart)
            found[f"{RUN}{name}, {_name(chart)}"] = _apart(make(), method, rng)
    return found


def interpolated(chart: Chart, group: Group, points: Array, t: Array) -> Array:
    """g_1 Phi(sum_i Phi^-1(g_1^-1 g_i) phi_i(t)), (k, ...), phi_i Lagrange's polynomials."""
    base = np.broadcast_to(points[0], points.shape)
    xi = coordinates(chart, group, base, points)
    basis = np.ones((t.size, NODES.size))
    for i in range(NODES.size):
        for j in range(NODES.size):
            if j != i:
                basis[:, i] *= (t - NODES[j]) / (NODES[i] - NODES[j])
    return place(chart, group, np.broadcast_to(points[0], (t.size, *group.shape)), basis @ xi)


def _one(group: Group, chart: Chart, rng: np.random.Generator) -> tuple[float, float]:
    """(difference of moved curve and curve of the moved points, distance of curve to points)."""
    matrices = MatrixGroup(group)
    unit = matrices.element(np.eye(len(matrices.basis[0])))
    first, other = (matrices.moved(unit, rng.standard_normal(group.dimension)) for _ in range(2))
    steps = TURN * rng.standard_normal((NODES.size, group.dimension))
    points = np.array([first, *(matrices.chart(chart, first, xi) for xi in steps[1:])])
    curve = interpolated(chart, group, points, TIMES)
    moved = interpolated(chart, group, _times(matrices, other, points), TIMES)
    apart = float(np.max(np.abs(moved - _times(matrices, other, curve))))
    return apart, float(np.max(np.abs(interpolated(chart, group, points, NODES) - points)))


def _apart(body: Problem, method: Any, rng: np.random.Generator) -> float:
    """Of the curves of two runs, one of them moved; NaN where one fails."""
    group: Group = body.system.group  # type: ignore[attr-defined]
    matrices = MatrixGroup(group)
    other = matrices.moved(body.q0, rng.standard_normal(group.dimension))
    runs = [
        galvi.integrate(Problem(body.system, q0, body.v0), method, STEP, STEPS)
        for q0 in (body.q0, _times(matrices, other, body.q0[None])[0])
    ]
    if not all(run.success for run in runs):
        return math.nan
    t = np.linspace(0.0, STEP * STEPS, 20 * STEPS + 1)
    return float(np.max(np.abs(runs[1](t) - _times(matrices, other, runs[0](t)))))


def _times(matrices: MatrixGroup, g: Array, elements: Array) -> Array:
    """g k for each k, as products of matrices."""
    left = matrices.matrix(g)
    return np.array([matrices.element(left @ matrices.matrix(k)) for k in elements])


def _label(group: Group, chart: Chart) -> str:
    return f"{' x '.join(_names(group))}, {_name(chart)}"


def _names(group: Any) -> list[str]:
    factors = group.factors if isinstance(group, galvi.Product) else (group,)
    return [f"R{one.n}" if isinstance(one, galvi.Rn) else type(one).__name__ for one in factors]


def _name(chart: Chart) -> str:
    return type(chart).__name__


def checks() -> Iterator[Check]:
    """For each group with each chart, then for the runs."""
    for group in GROUPS:
        for chart in CHARTS:
            yield check(
                CURVE + _label(group, chart),
                AtMost(LIMIT),
                claimed="the curve is Lie group equivariant",
                reason="The chart is centred at the first point, and moves with it.",
            )
            yield check(
                THROUGH + _label(group, chart),
                AtMost(LIMIT),
                claimed="the curve passes through its points",
                reason="Phi and its inverse are the inverse of each other.",
            )
    for name in BODIES:
        for chart in CHARTS:
            yield check(
                f"{RUN}{name}, {_name(chart)}",
                AtMost(LIMIT),
                setup=RUN_SETUP,
                claimed="discrete Lagrangians inherit the symmetry",
                reason="The Lagrangian of a free body does not change with g, and so its curves "
                "move along.",
            )


L10 = scalars(
    "L10",
    "Interpolating curves are equivariant under left translation",
    measure,
    checks,
    source="H lemma 3.2.1",
    setup=SETUP,
    reference="products of matrices",
    statement="H lemma 3.2.1: the interpolating curve is equivariant under left translation, and "
    "discrete Lagrangians inherit the symmetry.",
    caught=(
        Fault(
            "a chart that is no inverse",
            lambda found: sum(THROUGH in one for one in found) == len(GROUPS) * len(CHARTS),
            wrong={f"{__name__}.coordinates": scaled(1.0 + 1e-9)},
        ),
    ),
)
