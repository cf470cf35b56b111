"""V15: Noether quantities, discrete and along the curve (H theorems 2.3.10 and 2.3.11)."""

from __future__ import annotations

from benchmarks.claims.kit import *
from benchmarks.measures import independent_invariants
from benchmarks.measures.errors import angular_momentum_errors
from benchmarks.measures.space_rule_pairs import MANY, kinds, pairs
from references.closed_forms.kepler import KEPLER

ANGULAR, LINEAR = "angular momentum", "linear momentum"
NUMBERS, POINTS = (1, 2, 3, 4), (1, 2, 3, 4, 6, MANY)
QUICK_NUMBERS, QUICK_POINTS = (2,), (1, 2, 3, MANY)
STEP, STEPS, QUICK_STEPS = 0.1, 500, 100
EPS = 2.0**-52
ROTATION, TRANSLATION = "rotation", "translation"
MIXED = ((5, 2), (5, 3), (6, 4))  # degrees of the components
MIXED_TIME, MIXED_STEPS = 25.0, tuple(round(70 * 2 ** (k / 2)) for k in range(7))
MIXED_FLOOR = 1e-14
ALONG, N = "angular momentum along the curve, n = 8", 8
LONG_STEP, LONG = 0.5, 8000
PER_STEP, STARTS = 10, 400  # points of a step; exact states to start single steps from
ONE_STEP = f"largest error of {ALONG}, single steps from exact states"

UNIT = (
    "The unit is a random walk of one rounding, 2^-52 of q and p, a step: a momentum that is "
    "conserved in exact arithmetic changes by less."
)


def three_bodies() -> Problem:
    """Three bodies in space with nonzero total momentum; masses 1, 0.2 and 0.1, G = 1."""
    q = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.1], [-0.3, 3.0, 0.0]]
    v = [[0.1, -0.2, 0.3], [0.1, 0.9, 0.3], [-0.5, -0.2, 0.2]]
    return Problem(galvi.NBody([1.0, 0.2, 0.1]), q, v, name="three bodies in space")


def pair_on_a_line() -> Problem:
    """q1 and q2 with V = r^2 / 2 + r^4 / 4, r = q1 - q2: invariant under translations."""

    def gradient(q: Array) -> Array:
        pull = (q[0] - q[1]) + (q[0] - q[1]) ** 3
        return np.array([pull, -pull])

    def potential(q: Array) -> float:
        r = q[0] - q[1]
        return float(0.5 * r**2 + 0.25 * r**4)

    return Problem(galvi.Canonical(1.0, potential, gradient), [1.0, -0.5], [0.3, 0.4])


def study(make_method: MakeMethod, quick: bool, report: Report) -> DataFrame:
    """Changes of momenta at step ends by method, in units of rounding; an order; a history."""
    numbers, points = (QUICK_NUMBERS, QUICK_POINTS) if quick else (NUMBERS, POINTS)
    problem, rows = three_bodies(), []
    for pair in pairs(numbers, points):
        try:
            method = make_method(pair.space, pair.rule)
        except ValueError:  # ill-posed or inconsistent, which V19 is about
            continue
        run = galvi.integrate(problem, method, STEP, QUICK_STEPS if quick else STEPS)
        where = {"study": pair.kind, "n": pair.space.dimension, "status": failure(run)}
        rows += [
            row(quantity=ANGULAR, value=_in_roundings(run, _angular, _angular_size), **where),
            row(quantity=LINEAR, value=_in_roundings(run, _linear, _linear_size), **where),
        ]
    report("degrees by component")
    line = pair_on_a_line()
    for degrees in MIXED:
        mixed = make_method(galvi.ComponentPolynomials(degrees), galvi.gauss(max(degrees)))
        label = str(degrees)
        for steps in MIXED_STEPS:
            h = MIXED_TIME / steps
            orbit = galvi.integrate(galvi.problems.kepler(0.3), mixed, h, steps)
            value = np.max(np.abs(angular_momentum_errors(orbit))) if orbit.success else np.nan
            where = {"study": ROTATION, "label": label, "step": h, "steps": steps}
            rows.append(row(quantity=ANGULAR, value=float(value), status=failure(orbit), **where))
        run = galvi.integrate(line, mixed, MIXED_TIME / MIXED_STEPS[0], MIXED_STEPS[0])
        value = _in_roundings(run, _linear, _linear_size)
        where = {"study": TRANSLATION, "label": label, "status": failure(run)}
        rows.append(row(quantity=LINEAR, value=value, **where))
    report("along the curve")
    return frame(rows + _along(make_method, LONG))


def _angular(run: Trajectory) -> Array:
    v = run.problem.system.velocity(run.p)
    total = independent_invariants.angular_momentum(run.problem, run.q, v)
    return total - total[0]


def _linear(run: Trajectory) -> Array:
    return np.sum(run.p - run.p[0], axis=1)


def _angular_size(run: Trajectory) -> float:
    """The largest sum of |q| |p| over the bodies."""
    return float(np.max(np.sum(_norms(run.q) * _norms(run.p), axis=1)))


def _linear_size(run: Trajectory) -> float:
    """The largest sum of |p| over the bodies."""
    return float(np.max(np.sum(_norms(run.p), axis=1)))


def _norms(places: Array) -> Array:
    """Lengths (k, bodies) of vectors (k, bodies, d), or of numbers (k, bodies)."""
    return np.abs(places) if places.ndim == 2 else np.linalg.norm(places, axis=-1)


def _in_roundings(
    run: Trajectory, measure: Callable[[Trajectory], Array], size: Callable[[Trajectory], float]
) -> float:
    """The largest change, over what one rounding of q and p a step comes to as a random walk."""
    if not run.success:
        return float("nan")
    steps = len(run.t) - 1
    return float(np.max(np.abs(measure(run)))) / (np.sqrt(steps) * EPS * size(run))


def _along(make_method: MakeMethod, steps: int) -> list[dict[str, Any]]:
    """The largest error along the curve of each step, at the step's end, over that of one step.

    The unit is the largest error of a single step of the same size from exact states all round
    the orbit.
    """
    orbit, method = galvi.problems.kepler(0.6), method_of(make_method, N)
    run = galvi.integrate(orbit, method, LONG_STEP, steps, curves=True)
    errors = np.full(steps, np.nan)
    exact = KEPLER.run(orbit, 2.0 * np.pi, {"samples": STARTS})
    single = np.array(
        [_of_one_step(orbit, method, *state) for state in zip(exact.q, exact.p, strict=True)]
    )
    unit = float(np.max(single))
    if run.success:
        t = (np.arange(steps)[:, None] + np.linspace(0.0, 1.0, PER_STEP + 1)) * LONG_STEP
        along = angular_momentum_errors(run, t.ravel()).reshape(t.shape)
        errors = np.max(np.abs(along), axis=1) / unit
    where = {"study": "history", "n": N, "step": LONG_STEP, "status": failure(run)}
    return [
        row(study="history", quantity=ONE_STEP, n=N, step=LONG_STEP, value=unit),
        *history(ALONG, run.t[1:], errors, **where),
    ]


def _of_one_step(orbit: Problem, method: Any, q: Array, p: Array) -> float:
    """The largest error of the angular momentum along one step from this state."""
    start = Problem(orbit.system, q, orbit.system.velocity(p[None])[0])
    run = galvi.integrate(start, method, LONG_STEP, 1, curves=True)
    if not run.success:
        return float("nan")
    t = np.linspace(0.0, LONG_STEP, PER_STEP + 1)
    return float(np.max(np.abs(angular_momentum_errors(run, t))))


def judge(table: DataFrame) -> list[Row]:
    """Both momenta for each kind of space; degrees by component; along the curve."""
    rows = [_discrete(table, kind, quantity) for kind in kinds() for quantity in (ANGULAR, LINEAR)]
    return [*rows, *_mixed(table), _along_the_curve(table)]


def _discrete(table: DataFrame, kind: str, quantity: str) -> Row:
    changes = readings.values(table, study=kind, quantity=quantity)
    return V15.row(
        f"change of {quantity} at step ends, {kind} [roundings]",
        AtMost(1.0),
        readings.largest(changes),
        setup=f"three bodies in space, masses 1, 0.2, 0.1; h = {STEP:g}, {STEPS} steps; spaces of "
        "this kind made from 1 to 4, every family of rules with 1 to 4, 6 and "
        f"{MANY} points (from 2, with 1 to 3 and {MANY} points, {QUICK_STEPS} steps, in the quick "
        f"form); refused pairs left out; the worst of the {changes.size} methods left",
        reason=f"With one space for all components rotations and translations map its curves to "
        f"one another: they leave the discrete Lagrangian as it is. {UNIT}",
        reference="sums of m v and m q x v at the start",
    )


def _mixed(table: DataFrame) -> list[Row]:
    changes = readings.values(table, study=TRANSLATION, quantity=LINEAR)
    how = f"ComponentPolynomials%s, gauss({{points}}); T = {MIXED_TIME:g}"
    return [
        *(
            V15.row(
                f"order of the change of angular momentum, degrees {degrees}",
                Finding(Order(2.0 * min(degrees))),
                readings.order(
                    table, MIXED_FLOOR, study=ROTATION, quantity=ANGULAR, label=str(degrees)
                ),
                setup=f"Kepler, e = 0.3; {how.format(points=max(degrees)) % (degrees,)}, h = T / "
                f"{MIXED_STEPS[0]} to T / {MIXED_STEPS[-1]}",
                claimed="conserved when the group leaves the discrete Lagrangian invariant, which "
                "rotations of components with spaces of their own do not",
                reason="Components of the orbit mix under rotation and their spaces do not: the "
                "discrete Lagrangian is invariant up to its own error, of the order 2 N of the "
                "lowest degree N, and so is the momentum conserved.",
                reference="q x v at the start",
            )
            for degrees in MIXED
        ),
        V15.row(
            "change of linear momentum, translation, degrees by component [roundings]",
            AtMost(1.0),
            readings.largest(changes),
            setup=f"two points on a line, V = r^2 / 2 + r^4 / 4; degrees {_listed(MIXED)}; "
            f"h = {MIXED_TIME / MIXED_STEPS[0]:g}, {MIXED_STEPS[0]} steps",
            reason=f"Constants are in every component's space. {UNIT}",
            reference="sum of v at the start",
        ),
    ]


def _listed(degrees: tuple[tuple[int, int], ...]) -> str:
    return ", ".join(map(str, degrees))


def _along_the_curve(table: DataFrame) -> Row:
    return V15.row(
        f"error of {ALONG}, over the largest of single steps from exact states",
        NoGrowth(1.0),
        readings.drift(table, study="history", quantity=ALONG),
        source="H thm. 2.3.11",
        setup=f"Kepler, e = 0.6; Polynomials(7), gauss(16); h = {LONG_STEP:g}, {LONG} steps; "
        f"{PER_STEP + 1} points of each step; {STARTS} exact states evenly spaced in time",
        claimed="bounded, by a constant that does not depend on the number of steps",
        reason="At step ends it is conserved; between them it errs as the curve of one step does, "
        "from a state of an orbit that hardly changes.",
        reference=f"q x v at the start; {KEPLER.name}",
    )


def _leaking(sound: Callable[..., Trajectory]) -> Callable[..., Trajectory]:
    """The momentum grows by 1e-12 in all."""

    def run(*given: Any, **more: Any) -> Trajectory:
        found = sound(*given, **more)
        fading = np.linspace(1.0, 1.0 + 1e-12, len(found.t))
        return replace(found, p=found.p * fading.reshape(-1, *[1] * (found.p.ndim - 1)))

    return run


V15 = Claim(
    "V15",
    "Noether quantities for every space and rule",
    study,
    judge,
    source="H thm. 2.3.10",
    claimed="the discrete Noether quantity is conserved",
    statement="H thm. 2.3.10, 2.3.11: steps conserve the discrete Noether quantity of a symmetry, "
    "and its error along the curve does not grow with their number.",
    caught=(
        of_table(
            f"error of {ALONG}, over the largest of single steps from exact states",
            *(f"change of angular momentum at step ends, {kind} [roundings]" for kind in kinds()),
            beta=1.0 + 1e-6,
            b=1.0 + 1e-3,
        ),
        Fault(
            "a momentum that leaks",
            {
                *(f"change of linear momentum at step ends, {one} [roundings]" for one in kinds()),
                "change of linear momentum, translation, degrees by component [roundings]",
            },
            wrong={"galvi.integrate": _leaking},
        ),
    ),
)
