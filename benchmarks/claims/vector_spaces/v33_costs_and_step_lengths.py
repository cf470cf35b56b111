"""V33: how long steps are beside other methods', what one costs, and whether curves keep pace."""

from __future__ import annotations

from benchmarks.claims.kit import *
from benchmarks.claims.vector_spaces.curves_beside_steps import curve_rows, errors_of_curves
from benchmarks.claims.vector_spaces.v09_solar_system_in_long_steps import (
    MERCURY,
    STEP,
    STEPS,
    VISIBLE,
    N,
)
from benchmarks.measures.orbit_shape import period
from references import Contender
from references.rebound.ias15 import IAS15
from references.rebound.leapfrog import BEST as ORDER_8
from references.rebound.leapfrog import LEAPFROG
from references.rebound.whfast import WHFAST
from references.textbook.euler import STORMER_VERLET
from references.textbook.nystrom import Nystrom

RK4 = Nystrom(
    "the classical Runge-Kutta method",
    order=4,
    stages=((0.0,) * 4, (0.0,) * 4, (0.25, 0.0, 0.0, 0.0), (0.0, 0.5, 0.0, 0.0)),
    nodes=(0.0, 0.5, 0.5, 1.0),
    position=(1.0 / 6.0, 1.0 / 6.0, 1.0 / 6.0, 0.0),
    velocity=(1.0 / 6.0, 1.0 / 3.0, 1.0 / 3.0, 1.0 / 6.0),
)
FIXED_POINT, NEWTON = "Galerkin", "Galerkin, by Newton's method"
LEAP, KUTTA, EIGHT, WISDOM = "leapfrog", "Runge-Kutta 4", "leapfrog of order 8", "WHFast"
EXPLICIT: Mapping[str, tuple[Contender, Mapping[str, Any], int]] = {  # with the finest 2^(j/2)
    LEAP: (STORMER_VERLET, {}, 26),
    KUTTA: (RK4, {}, 24),
    EIGHT: (LEAPFROG, ORDER_8, 12),
    WISDOM: (WHFAST, {}, 12),
}
COARSE = 12  # powers of 2^(1/2) that the quick form takes one by one
FINE = 41  # basis functions, of V9's scan
ERROR, FARTHEST = "distance to IAS15", "Mercury's distance from the Sun, over the mean one"
SEVERAL = 2.0  # orders of magnitude
BOUND = 2.0  # mean distances: no ellipse of this axis leads farther away


def study(make_method: MakeMethod, quick: bool, report: Report) -> DataFrame:
    """By method, in `label`, and step: the largest distance of a body to IAS15 every 100 days and
    Mercury's largest from the Sun; the series of `errors_of_curves`."""
    problem = galvi.problems.solar_system()
    report("IAS15")
    truth = IAS15.run(problem, STEP * STEPS, {"samples": STEPS})
    found = []
    for n, solver, label in ((N, "fixed_point", FIXED_POINT), (N, "newton", NEWTON),
                             (FINE, "fixed_point", FIXED_POINT)):  # fmt: skip
        report(f"{label}, n = {n}")
        method = method_of(make_method, n)
        run = galvi.integrate(problem, method, STEP, STEPS, solver=solver)
        found += _measured(run, truth, label=label, n=n, step=STEP, steps=STEPS)
    for label, (contender, options, last) in EXPLICIT.items():
        report(label)
        for j in (*range(COARSE), *range(COARSE, last + 1, 2 if quick else 1)):
            k = round(2.0 ** (j / 2))
            setting = {"step": STEP / k, "save_every": k, **options}
            run = contender.run(problem, STEP * STEPS, setting)
            found += _measured(run, truth, label=label, step=STEP / k, steps=k * STEPS)
    return frame([*found, *errors_of_curves(make_method, quick, report)])


def _measured(run: Trajectory, truth: Trajectory, **where: Any) -> list[dict[str, Any]]:
    work = run.counts.get("force_evaluations", math.nan)  # REBOUND counts none
    away = np.linalg.norm(run.q[:, MERCURY] - run.q[:, 0], axis=-1)
    apart = np.linalg.norm(run.q - truth.q, axis=-1)
    named = {ERROR: np.max(apart), FARTHEST: np.max(away) / mean_distance(run.problem)}
    known = {"status": failure(run), "force_evaluations": work, **where}
    return [row(quantity=name, value=float(value), **known) for name, value in named.items()]


def mean_distance(problem: Problem) -> float:
    """Mercury's, by Kepler's third law."""
    masses = problem.system.masses
    gm = problem.system.G * (masses[0] + masses[MERCURY])
    return float(gm * (period(problem, MERCURY) / (2.0 * math.pi)) ** 2) ** (1.0 / 3.0)


def stable_leapfrog(problem: Problem) -> float:
    """The step from which leapfrog is unstable on a circle of Mercury's period: h w = 2."""
    return period(problem, MERCURY) / math.pi


def longest(
    table: DataFrame, label: str, limit: float, quantity: str = ERROR, **where: Any
) -> float:
    """The longest step in which, and in all shorter ones, a number is within the limit; of errors
    between two steps, by a power law. NaN where the shortest is outside."""
    h, values = series(table, "step", quantity=quantity, label=label, **where)
    outside = np.flatnonzero(~(values <= limit))
    first = int(outside[-1]) + 1 if outside.size else 0
    if first == len(h):
        return math.nan
    if first == 0 or quantity != ERROR or not math.isfinite(values[first - 1]):
        return float(h[first])
    x, y = np.log(h[first - 1 : first + 1]), np.log(values[first - 1 : first + 1])
    return float(np.exp(np.interp(math.log(limit), y[::-1], x[::-1])))


def judge(table: DataFrame) -> list[Row]:
    """Steps of one error, steps that are accurate or bounded at all, costs, and curves."""
    return [*_of_one_error(table), *_tolerated(table), *_costs(table), *curve_rows(table, V33.row)]


SETUP = (
    f"V9: Sun, 8 planets, Pluto, Polynomials(n - 1), gauss(2 n), h = {STEP:g} d, {STEPS} steps; "
    "largest distance of a body to IAS15 every 100 d; the others in steps of 100 d / k, k = 1 to "
    "8192 (4096 for Runge-Kutta 4, 64 for leapfrog of order 8 and WHFast)"
)
TRUTH = f"{IAS15.name}, which V9 compares with heyoka's stored motion"
LONGER = (
    "more accurate than explicit methods even when the Galerkin step is several orders of "
    "magnitude larger; several is read as two or more"
)


def _decades(table: DataFrame, label: str, n: int = N) -> float:
    """log10 of the Galerkin step over that of equal error."""
    return math.log10(STEP / longest(table, label, _error(table, n)))


def _error(table: DataFrame, n: int, label: str = FIXED_POINT) -> float:
    return readings.largest_of(table, quantity=ERROR, label=label, n=n)


def _of_one_error(table: DataFrame) -> list[Row]:
    found = [
        _longer(
            f"log10 of the Galerkin step over that of {label} with its error, n = {n}",
            AtLeast(SEVERAL),
            _decades(table, label, n),
            f"An error of order {order} in h is {size} of the orbit in a revolution only in steps "
            "of a small part of a day.",
        )
        for label, n, order, size in (
            (LEAP, N, 2, "6e-6"),
            (KUTTA, N, 4, "6e-6"),
            (KUTTA, FINE, 4, "6e-11"),
        )
    ]
    best = readings.largest(np.array([_decades(table, label) for label in (EIGHT, WISDOM)]))
    return [
        *found,
        _longer(
            f"largest log10 of the Galerkin step over that of {EIGHT} or of {WISDOM} with its "
            f"error, n = {N}",
            Finding(Below(SEVERAL)),
            best,
            "H does not say which explicit methods. Those of high order, and those that follow "
            "Kepler's orbits, need steps of days: one order of magnitude, not several.",
        ),
    ]


def _longer(quantity: str, bound: Any, measured: float, reason: str) -> Row:
    return V33.row(
        quantity, bound, measured, source="H 4.2", setup=SETUP, claimed=LONGER, reason=reason,
        reference=TRUTH,
    )  # fmt: skip


def _tolerated(table: DataFrame) -> list[Row]:
    shared = {
        "source": "H 2.5",
        "setup": SETUP,
        "claimed": "stable and accurate in steps orders of magnitude larger than can be tolerated "
        "by traditional integrators; H names none and does not say what is tolerated",
        "reference": TRUTH,
    }
    problem = galvi.problems.solar_system()
    visible = VISIBLE * mean_distance(problem)
    own = longest(table, FIXED_POINT, visible, n=N)
    steps = {
        label: (longest(table, label, visible), longest(table, label, BOUND, FARTHEST))
        for label in (LEAP, KUTTA)
    }
    ellipse = (
        f"'Tolerated' may also mean that orbits stay bounded: Mercury within {BOUND:g} mean "
        "distances, farther than an ellipse of its axis leads"
    )
    limit = stable_leapfrog(problem)
    return [
        *(
            V33.row(
                f"log10 of the Galerkin step over the longest of {label} that is accurate, n = {N}",
                Finding(AtLeast(SEVERAL)),
                math.log10(own / steps[label][0]),
                reason=f"'Tolerated' may mean accurate, here to {VISIBLE:g} of Mercury's mean "
                "distance, a line's width in H's figure, as V9 asks of the Galerkin steps.",
                **shared,
            )
            for label in (LEAP, KUTTA)
        ),
        V33.row(
            f"log10 of the Galerkin step over the longest of {LEAP} in which Mercury stays",
            Finding(Below(1.0)),
            math.log10(own / steps[LEAP][1]),
            reason=f"{ellipse}. Leapfrog is stable on a circle below period / pi, {limit:.0f} d, "
            f"and below {limit * (1.0 - 0.2056) ** 1.5:.0f} d for the frequency at Mercury's "
            "perihelion: that is a fifth of a Galerkin step, not an order of magnitude less.",
            **shared,
        ),
        V33.row(
            f"log10 of the Galerkin step over the longest of {KUTTA} in which Mercury stays",
            Finding(Below(SEVERAL)),
            math.log10(own / steps[KUTTA][1]),
            reason=f"{ellipse}. The method loses energy, a part of (h w)^6 / 72 in each step, and "
            "in a hundred revolutions falls in only from steps of days on.",
            **shared,
        ),
    ]


def _per_step(table: DataFrame, label: str, n: int = N) -> float:
    """Force evaluations; NaN where none were counted."""
    own = {"n": n} if label in (FIXED_POINT, NEWTON) else {}
    rows = pick(table, quantity=ERROR, label=label, **own)
    return readings.least((rows["force_evaluations"] / rows["steps"]).to_numpy(np.float64))


def _costs(table: DataFrame) -> list[Row]:
    shared = {"source": "H 2.5", "setup": SETUP, "reference": "counts of force evaluations"}
    least = readings.least(np.array([_per_step(table, label) for label in (FIXED_POINT, NEWTON)]))
    return [
        *(
            V33.row(
                f"log10 of the force evaluations in a Galerkin step over those of {label}, n = {N}",
                AtLeast(SEVERAL),
                math.log10(least / _per_step(table, label)),
                claimed="the effort of a step is orders of magnitude larger than that of other "
                "methods; orders of magnitude is read as two or more",
                reason=f"One pass over the points is {2 * N} evaluations, and the equations of a "
                "step longer than a revolution take tens of passes; counted with fixed-point "
                "iteration or Newton's method, whichever is less, without the latter's Hessians.",
                **shared,
            )
            for label in (LEAP, KUTTA)
        ),
        *(
            V33.row(
                "force evaluations of the Galerkin method over those of "
                f"{label} with its error, n = {n}",
                Finding(bound),
                _per_step(table, FIXED_POINT, n)
                * longest(table, label, _error(table, n))
                / (STEP * _per_step(table, label)),
                claimed="a major trade-off in terms of practicality; H compares no run",
                reason=reason,
                **{**shared, "reference": TRUTH},
            )
            for label, n, bound, reason in (
                (LEAP, N, AtMost(1.0), "The longer step outweighs its cost."),
                (KUTTA, N, AtLeast(1.0), "At this error four stages of order 4 are cheaper."),
                (
                    KUTTA,
                    FINE,
                    AtMost(1.0),
                    "An error 1e5 times smaller costs order 4 a factor of 18, and the Galerkin "
                    f"method {FINE} / {N} of the evaluations in a pass.",
                ),
            )
        ),
    ]


V33 = Claim(
    "V33",
    "Steps and costs orders of magnitude larger, and curves as good as step ends",
    study,
    judge,
    source="H 4.2, H 2.5, H 1.3, H 2.4.2",
    statement="H 4.2, 2.5: Galerkin steps may be orders of magnitude longer than those of explicit "
    "methods, and cost as much more. Measured: so beside leapfrog and Runge-Kutta of order 4, not "
    "beside methods of high order. H 1.3: in practice curves converge like step ends; H 2.4.2: in "
    "h the curve's own error is hidden. Neither is reproduced: the first only up to an n that "
    "grows with the number of steps.",
    caught=(
        Fault(
            "Galerkin steps of a larger error",
            {
                f"log10 of the Galerkin step over that of {label} with its error, n = 25"
                for label in (LEAP, KUTTA)
            },
            table=times(1e4, label=FIXED_POINT, quantity=ERROR),
        ),
    ),
)
