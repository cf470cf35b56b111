"""V24: one brownout particle, error against processor time (M figure 3, right)."""

from __future__ import annotations

from benchmarks.claims.kit import *
from benchmarks.claims.vector_spaces.brownout_particle import (
    AWAY,
    METHOD,
    MOVING,
    PIECES,
    STARTS,
    method_of_degree,
    trajectory_error,
    truth,
)
from benchmarks.claims.vector_spaces.v23_brownout_order import ERROR, EULER
from benchmarks.statistics.timing import interleaved, warmed
from benchmarks.work_precision.fronts import seconds_at
from references.scipy.ivp import DOP853, RADAU
from references.textbook.euler import SEMI_IMPLICIT_EULER

DEGREES = (1, 2, 4, 6)
SECONDS, FASTEST, SLOWEST = "seconds", "seconds, fastest round", "seconds, slowest round"
EVALUATIONS = "force evaluations"
APART = "distance between the two references [m]"
ROUNDS = 3
ASKED = 2e-4  # m, a small error, reached at low order with 65,536 steps
FINE = 1e-7  # m, out of reach at low order
COARSE = 2e-2  # m, a hundred times ASKED
SLOWEST_GROWTH = 0.5  # 1 - 1 / (2 N), N = 1
LOW, HIGH = 1e-4, 2.0  # m, search range of the crossing; the particle is carried 8 m


def multiples(quick: bool) -> dict[str, tuple[int, ...]]:
    """Numbers of steps per piece of the duration, for each contender."""
    euler = (4, 16, 64, 256, 1024, 8192) if quick else (4, 16, 64, 256, 1024, 4096, 8192, 16384)
    ours = (1, 2, 4, 8, 32) if quick else (1, 2, 3, 4, 6, 8, 16, 32)
    short = [size for size in ours if size <= 8]  # of the highest degree, then at round-off
    high = {label_of(max(DEGREES)): tuple(short)}
    return {EULER: euler, **{label_of(degree): ours for degree in DEGREES}, **high}


def study(make_method: MakeMethod, quick: bool, report: Report) -> DataFrame:
    """Of each contender, in `study`, and number of steps: 'error of the place' [m], 'force
    evaluations', and 'seconds' with the fastest and the slowest round, timed alternately.

    'distance between the two references [m]'  DOP853 and Radau
    """
    known, exact = STARTS[AWAY], truth(AWAY)
    problem, calls, warm, found = known.problem(), [], [], []
    for label, sizes in multiples(quick).items():
        report(label)
        for size in sizes:
            call = partial(_solve, make_method, problem, known.duration, label, size)
            run, seconds = warmed(call)
            calls.append(call)
            warm.append(seconds)
            found.append((label, size, run))
    timings = interleaved(calls, ROUNDS, 0.003 if quick else 0.03, warm)
    observed = []
    for (label, size, run), timing in zip(found, timings, strict=True):
        values = {
            ERROR: trajectory_error(run, exact),
            EVALUATIONS: float(run.counts["force_evaluations"]),
            SECONDS: timing.seconds,
            FASTEST: timing.low,
            SLOWEST: timing.high,
        }
        observed += rows(values, study=label, steps=PIECES * size, status=failure(run))
    apart = float(np.max(np.abs(truth(AWAY, RADAU) - exact)))
    return frame([*observed, row(study=RADAU.name, quantity=APART, value=apart)])


def label_of(degree: int) -> str:
    """The name of the study of a degree."""
    return f"N = {degree}"


def _solve(make_method: MakeMethod, problem: Any, duration: float, label: str, size: int) -> Any:
    """One run with `size` steps per piece, saved at the ends of the pieces."""
    h, steps = duration / (PIECES * size), PIECES * size
    if label == EULER:
        return SEMI_IMPLICIT_EULER.run(problem, duration, {"step": h, "save_every": size})
    method = method_of_degree(make_method, int(label.split()[-1]))
    return galvi.integrate(problem, method, h, steps, save_every=size)


def front_of(table: DataFrame, *labels: str, cost: str = EVALUATIONS) -> tuple[Array, Array]:
    """The Pareto front (errors, costs) of these contenders, by decreasing error."""
    points = []
    for label in labels:
        rows = pick(table, study=label)
        if not rows.empty:
            wide = rows.pivot(index="steps", columns="quantity", values="value")
            wide = wide.reindex(columns=[ERROR, cost]).dropna()
            points += list(zip(wide[ERROR], wide[cost], strict=True))
    best, kept = np.inf, []
    for error, spent in sorted(points, key=lambda point: (point[1], point[0])):
        if error < best:
            best = error
            kept.append((error, spent))
    errors, costs = np.array(kept).reshape(-1, 2).T
    return errors, costs


def advantage(
    table: DataFrame, errors: Sequence[float], theirs: str = EVALUATIONS, ours: str = ""
) -> Array:
    """Ratio of the costs of semi-implicit Euler and the best degree at errors [m]; NaN beyond.

    theirs, ours  the costs, of Euler and of the degrees; the same unless given
    """
    euler = front_of(table, EULER, cost=theirs)
    best = front_of(table, *map(label_of, DEGREES), cost=ours or theirs)
    return np.array([seconds_at(*euler, e) / seconds_at(*best, e) for e in errors])


def crossing(table: DataFrame, theirs: str = SECONDS, ours: str = SECONDS) -> float:
    """The error [m] below which high order is cheaper, at all errors that both reach.

    0 when it is not cheaper at the smallest common error; NaN without a common error.
    """
    errors = np.geomspace(HIGH, LOW, 200)
    ratios = advantage(table, errors, theirs, ours)
    reached = np.isfinite(ratios)
    if not np.any(reached):
        return float("nan")
    if not ratios[reached][-1] > 1.0:
        return 0.0
    dearer = np.flatnonzero(reached & (ratios <= 1.0))
    return float(errors[dearer[-1]]) if dearer.size else HIGH


def between(middle: float, *ends: float) -> Estimate:
    """A number with half the distance of its ends, where they differ, as its uncertainty."""
    return Estimate(middle, 0.5 * abs(ends[0] - ends[1]) or None)


def growth(table: DataFrame) -> float:
    """The power of 1 / error with which the ratio of evaluations grows, from COARSE to ASKED."""
    coarse, fine = advantage(table, (COARSE, ASKED))
    return float(np.log(fine / coarse) / np.log(COARSE / ASKED))


def judge(table: DataFrame) -> list[Row]:
    """The claim by evaluations, which every machine counts alike; the times are findings."""
    high, low = (seconds_at(*front_of(table, label_of(d)), FINE) for d in (max(DEGREES), 2))
    times = [
        advantage(table, (ASKED,), *costs)[0]
        for costs in ((SECONDS, SECONDS), (FASTEST, SLOWEST), (SLOWEST, FASTEST))
    ]
    measured = "A time, of one machine and run; the ends are those of its slowest and fastest round"
    return [
        V24.row(
            f"force evaluations of semi-implicit Euler over those of the best N at {ASKED:g} m",
            AtLeast(1.0),
            advantage(table, (ASKED,))[0],
        ),
        V24.row(
            "power of the inverse error with which that ratio grows, from "
            f"{COARSE:g} to {ASKED:g} m",
            Finding(AtLeast(SLOWEST_GROWTH)),
            growth(table),
            reason="Order 2 N needs error^(-1 / (2 N)) steps and Euler error^(-1): their ratio "
            "grows with a power of 1 - 1 / (2 N), at least 1/2. Whatever an evaluation costs more "
            "in a step of high order, there is an error below which that step is cheaper.",
        ),
        V24.row(
            f"force evaluations of N = 2 over those of N = {max(DEGREES)} at {FINE:g} m",
            Finding(AtLeast(1.0)),
            low / high,
        ),
        V24.row(
            f"time of semi-implicit Euler over that of the best N at {ASKED:g} m",
            Finding(),
            between(*times),
            reason=f"{measured}.",
        ),
        V24.row(
            "error below which high order is cheaper in time than semi-implicit Euler [m]",
            Finding(),
            between(
                crossing(table),
                crossing(table, FASTEST, SLOWEST),
                crossing(table, SLOWEST, FASTEST),
            ),
            reason=f"{measured}. M gives no number. Setting up a run of galvi takes about a "
            "millisecond, which moves it down.",
        ),
        V24.row(
            APART,
            Finding(AtMost(0.1 * FINE)),
            number(table, quantity=APART),
            claimed="no claim: check of the reference",
            reason="At most a tenth of the smallest error that a row rests on.",
        ),
    ]


def _dear(table: DataFrame) -> None:
    """A thousand times as many evaluations of the Galerkin methods."""
    ours = (table["study"] != EULER) & (table["quantity"] == EVALUATIONS)
    table.loc[ours, "value"] *= 1000.0


V24 = Claim(
    "V24",
    "Brownout particle: high order is cheaper where small errors are asked for",
    study,
    judge,
    ("M fig. 3",),
    timed=True,
    source="M 6.2, fig. 3",
    setup=f"{MOVING}; {STARTS[AWAY].words}; {METHOD}, N = 1, 2, 4, 6; T = 2 s; all timed in one "
    "interleaved run, both compiled",
    claimed="high order is more efficient when low error levels are required",
    reason="A step of high order costs some tens of evaluations of the force, but the number of "
    "steps grows only with the error's root of order 2 N; Euler's grows with its inverse.",
    reference=f"{DOP853.name}; {RADAU.name} agrees to 2e-14 m",
    statement="M 6.2, fig. 3 right: high order is cheaper where small errors are asked for.",
    caught=(
        OTHER_TRUTH,
        Fault(
            "a high order that is dear",
            some("force evaluations of semi-implicit Euler"),
            table=_dear,
        ),
    ),
)
