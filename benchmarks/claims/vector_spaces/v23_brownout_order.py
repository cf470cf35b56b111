"""V23: one brownout particle, order with a velocity-dependent force (M figure 3, left)."""

from __future__ import annotations

from benchmarks.claims.kit import *
from benchmarks.claims.vector_spaces.brownout_crossing import crossing
from benchmarks.claims.vector_spaces.brownout_particle import (
    ACROSS,
    AWAY,
    METHOD,
    MOVING,
    PIECES,
    STARTS,
    method_of_degree,
    trajectory_error,
    truth,
)
from benchmarks.measures.refinement import outcome
from benchmarks.store.frames import rows as rows_of
from references.scipy.ivp import DOP853, RADAU
from references.textbook.euler import SEMI_IMPLICIT_EULER

DEGREES = (1, 2, 3, 4)
RICHEST, MOST = 12, 64  # M's own reference, in 64 steps
ERROR = "error of the place"
EULER = "semi-implicit Euler"
OWN = "M's reference, N = 12"
CHECKED = "Radau"
SOLVED = f"{AWAY}, solved to round-off"
FLOOR = 1e-12  # m, of errors that an order rests on
AGREED = 0.1 * FLOOR  # of DOP853 and Radau: 2e-14 and 3e-14 were measured
FINER = 64  # times as many steps of semi-implicit Euler
SATURATED = 10.0  # ratio to the error of a solve to round-off
TOLERANCES = (1e-3, 1e-5, 1e-7)
SCANNED = tuple(10.0**-k for k in range(2, 9))  # for the power that errors fall with
LAST = 5  # smallest steps averaged (geometric mean), since their errors scatter by two decades
SATURATING = 4  # degree of the runs whose solve is stopped early
SHORTER = {2: (16, 32, 64, 90, 128, 181, 256), 3: (16, 23, 32, 45, 64, 90, 128)}
SHORTER[4] = SHORTER[3]  # multiples of PIECES, by degree: the first of each group of placements
LIMITING = {2: 2e-3, 3: np.inf, 4: np.inf}  # s; steps at which that through w = 0 errs most
PLACEMENTS = 13  # runs in a group, of consecutive multiples, which move w = 0 through its step
PLACED = f"{ACROSS}, largest of {PLACEMENTS} placements"
PLACED_QUICKLY = 8
DERIVED, BESIDE = "derived h^3 term", "error beside the derived h^3 term"
TRUTH = f"{DOP853.name}; {RADAU.name} agrees to 3e-14 m"


def step_counts(quick: bool) -> list[int]:
    """Multiples of PIECES, growing by about the square root of 2."""
    multiples = (2, 3, 4, 6, 8, 11, 16) if quick else (1, 2, 3, 4, 6, 8, 11, 16, 23, 32)
    return [PIECES * k for k in multiples]


def study(make_method: MakeMethod, quick: bool, report: Report) -> DataFrame:
    """'error of the place' [m], with N + 1 in `n`:

    of each start, in `study`, N = 1 to 4 in h, and semi-implicit Euler with n = 1, as if N = 0;
    of 'w away from 0, tolerance 1e-03' and so on, N = 4 with a solve that stops there, and of
    'w away from 0, solved to round-off', the same to the end;
    of 'M's reference' and 'Radau', against DOP853, with the start in `label`.
    'w through 0, largest of 13 placements' is the upper envelope, for N = 2, 3, 4, of runs whose
    step through w = 0 is cut elsewhere: with 'derived h^3 term' and what is left beside it.
    """
    rows = []
    for start, known in STARTS.items():
        report(start)
        problem, exact = known.problem(), truth(start)
        apart = float(np.abs(truth(start, RADAU) - exact).max())
        rows.append(row(study=CHECKED, quantity=ERROR, label=start, value=apart))
        for k in step_counts(quick):
            h = known.duration / (FINER * k)
            run = SEMI_IMPLICIT_EULER.run(problem, known.duration, {"step": h})
            rows.append(_row(start, 0, FINER * k, run, start))
            for degree in DEGREES if start == AWAY else (1,):
                run = _galvi(make_method, problem, start, degree, k)
                rows.append(_row(start, degree, k, run, start))
                if start == AWAY and degree == SATURATING:
                    rows.append(_row(SOLVED, degree, k, run, start))
            for tolerance in SCANNED if start == AWAY else ():
                run = _galvi(make_method, problem, start, SATURATING, k, tolerance)
                rows.append(_row(stopped_at(tolerance), SATURATING, k, run, start))
        run = _galvi(make_method, problem, start, RICHEST, MOST)
        rows.append(_row(OWN, RICHEST, MOST, run, start))
    bound = crossing(ACROSS).largest(STARTS[ACROSS].duration / MOST, RICHEST)
    rows.append(row(study=OWN, quantity=DERIVED, label=ACROSS, value=bound))
    for degree in LIMITING:
        report(f"{ACROSS}, N = {degree}")
        rows += _placements(make_method, degree, quick)
    return frame(rows)


def _placements(make_method: MakeMethod, degree: int, quick: bool) -> list[dict[str, Any]]:
    """The upper envelope of the errors over placements of w = 0 in its step, by groups."""
    known, exact, kink = STARTS[ACROSS], truth(ACROSS), crossing(ACROSS)
    problem, found = known.problem(), []
    firsts = [k for k in SHORTER[degree] if not quick or k.bit_count() == 1]
    for first in firsts:
        group = []
        for multiple in range(first, first + (PLACED_QUICKLY if quick else PLACEMENTS)):
            k = PIECES * multiple
            run = _galvi(make_method, problem, ACROSS, degree, k)
            h = known.duration / k
            term, fault = kink.height_error(h, degree), float(run.q[-1, 2] - exact[-1, 2])
            group.append((trajectory_error(run, exact), h, k, abs(term), abs(fault - term)))
        error, h, k = max(group)[:3] if all(np.isfinite(group[0])) else (float("nan"), h, k)
        values = {
            ERROR: error,
            DERIVED: max(one[3] for one in group),
            BESIDE: max(one[4] for one in group),
        }
        found += rows_of(values, study=PLACED, n=degree + 1, step=h, steps=k)
    return found


def stopped_at(tolerance: float) -> str:
    """The study of runs whose solve stops at this change relative to |q|."""
    return f"{AWAY}, tolerance {tolerance:.0e}"


def _galvi(
    make_method: MakeMethod,
    problem: Any,
    start: str,
    degree: int,
    k: int,
    tolerance: float | None = None,
) -> Trajectory:
    method, h = method_of_degree(make_method, degree), STARTS[start].duration / k
    return galvi.integrate(problem, method, h, k, tolerance=tolerance)


def _row(study: str, degree: int, k: int, run: Trajectory, start: str) -> dict[str, Any]:
    return row(
        study=study,
        quantity=ERROR,
        n=degree + 1,
        step=STARTS[start].duration / k,
        steps=k,
        label=start,
        value=trajectory_error(run, truth(start)),
        **outcome(run),
    )


def judge(table: DataFrame) -> list[Row]:
    """Rows for the orders from each start, the saturation of errors, and M's reference."""
    return [
        *(_order(table, AWAY, degree) for degree in (*DEGREES, 0)),
        *(_order(table, ACROSS, degree) for degree in (1, 0)),
        *(_envelope(table, degree) for degree in LIMITING),
        _left_beside(table),
        *(_departure(table, degree) for degree in (3, 4)),
        *_saturation(table),
        *(_distance(table, start) for start in STARTS),
        *(_agreement(table, start) for start in STARTS),
    ]


SMOOTH = "Away from w = 0 the force is analytic, and a rule this exact has the order 2 N."
KINK = (
    "At w = 0 the drag's second derivative jumps: the velocity after this step is wrong by "
    "2 (k / m) c^2 e h^3, with c = dw/dt there and e the rule's error for (t - theta)_+^2 on "
    "[0, 1], theta the place of w = 0 in its step, whatever N is"
)
OPEN = "M does not say whether w passes through 0; without it the order is 2 N = {}"


def _order(table: DataFrame, start: str, degree: int) -> Row:
    fit = readings.order(table, FLOOR, study=start, quantity=ERROR, n=degree + 1)
    if degree == 0:
        return V23.row(
            f"order, {EULER}, {start}",
            Order(1),
            fit,
            setup=_setup(start),
            claimed="first order",
            reason="It is Euler's method in v.",
        )
    below = "The step in which w is 0 adds an error of h^3 only, below the method's own h^2."
    return V23.row(
        f"order, N = {degree}, {start}",
        Order(2 * degree),
        fit,
        setup=_setup(start),
        claimed=f"optimal convergence rates, order 2 N = {2 * degree}",
        reason=SMOOTH if start == AWAY else below,
    )


def _envelope(table: DataFrame, degree: int) -> Row:
    return V23.row(
        f"order of the upper envelope, N = {degree}, {ACROSS}",
        Finding(Order(3)),
        readings.order(table, FLOOR, LIMITING[degree], study=PLACED, quantity=ERROR, n=degree + 1),
        setup=_placed(
            f"h at most {LIMITING[degree]:g} s"
            if degree == 2
            else f"from {PIECES * SHORTER[degree][0]} steps on"
        ),
        claimed=OPEN.format(2 * degree),
        reason=f"{KINK}; e is of one size for all h and 0 for a few theta, so that single runs "
        "scatter below this envelope.",
    )


def _left_beside(table: DataFrame) -> Row:
    return V23.row(
        f"order of the {BESIDE}, N = 2, {ACROSS}",
        Finding(Order(4)),
        readings.order(table, FLOOR, study=PLACED, quantity=BESIDE, n=3),
        setup=_placed(f"from {PIECES * SHORTER[2][0]} steps on; height at the end"),
        claimed=OPEN.format(4),
        reason="Without this term the method has its own order 2 N = 4; the two are equal at about "
        "h = 0.003 s.",
    )


def _departure(table: DataFrame, degree: int) -> Row:
    left, derived = (
        series(table, "step", study=PLACED, quantity=name, n=degree + 1)[1]
        for name in (BESIDE, DERIVED)
    )
    return V23.row(
        f"{BESIDE}, over its largest in the group, N = {degree}, {ACROSS}",
        Finding(AtMost(0.1)),
        readings.largest(left / derived),
        setup=_placed(f"from {PIECES * SHORTER[degree][0]} steps on; height at the end"),
        claimed=OPEN.format(2 * degree),
        reason=f"{KINK}; other errors of this step and the method's own error are of order 4 and "
        f"{2 * degree}.",
    )


def _saturation(table: DataFrame) -> list[Row]:
    """Rows for the error of an early stop of the solve at the smallest steps."""
    solved = _at_small_steps(table, SOLVED)
    levels = np.array([_at_small_steps(table, stopped_at(t)) for t in SCANNED])
    power = Estimate(float("nan"))
    if np.all(np.isfinite(levels)):
        line, spread = np.polyfit(np.log(SCANNED), np.log(levels), 1, cov=True)
        power = Estimate(float(line[0]), float(np.sqrt(spread[0, 0])))
    shared = {
        "setup": _setup(AWAY),
        "claimed": "saturation is due to the tolerance of the Newton method; M prints neither a "
        "tolerance nor a level",
    }
    return [
        *(
            V23.row(
                f"error at the {LAST} smallest steps, solve stopped at {tolerance:.0e}, over that "
                f"with a solve to round-off, N = {SATURATING}",
                Finding(AtLeast(SATURATED)),
                _at_small_steps(table, stopped_at(tolerance)) / solved,
                reason="Where the solve stops early, what is left is a part of its last change, at "
                "most the tolerance; galvi's first guess, better at small steps, leaves less, so "
                "that errors wander below a ceiling instead of staying on it. Solved to round-off "
                "they go on falling.",
                **shared,
            )
            for tolerance in TOLERANCES
        ),
        V23.row(
            f"power of the tolerance that this error falls with, N = {SATURATING}",
            Finding(Within(0.5, 1.5)),
            power,
            reason="What is left of the last change is a part of it.",
            **shared,
        ),
    ]


def _at_small_steps(table: DataFrame, study: str) -> float:
    """The geometric mean of the errors at the smallest steps; NaN where one is missing."""
    errors = series(table, "step", study=study, quantity=ERROR, n=SATURATING + 1)[1][-LAST:]
    return float(np.exp(np.mean(np.log(errors)))) if errors.size == LAST else float("nan")


def _distance(table: DataFrame, start: str) -> Row:
    away = start == AWAY
    bound = AGREED if away else number(table, study=OWN, quantity=DERIVED, label=start)
    return V23.row(
        f"distance to DOP853 [m], {OWN}, {start}",
        AtMost(bound),
        number(table, study=OWN, quantity=ERROR, label=start),
        setup=_setup(start),
        claimed="the reference solution has N = 12",
        reason="At round-off; the bound is a tenth of the least error that an order rests on."
        if away
        else f"{KINK}; the bound is the largest such error for N = 12 in {MOST} steps.",
    )


def _agreement(table: DataFrame, start: str) -> Row:
    return V23.row(
        f"distance between the two references [m], {DOP853.name} and {RADAU.name}, {start}",
        Finding(AtMost(AGREED)),
        number(table, study=CHECKED, quantity=ERROR, label=start),
        setup=_setup(start),
        claimed="no claim: check of the reference",
        reason="Both stop at w = 0 and start anew, so that neither steps over it; the bound is a "
        "tenth of the least error that an order rests on.",
    )


def _setup(start: str) -> str:
    known = STARTS[start]
    return (
        f"{MOVING}; {known.words}; {METHOD}; T = {known.duration:g} s; largest error of the place "
        f"at {PIECES} times"
    )


def _placed(words: str) -> str:
    return (
        f"{_setup(ACROSS)}; {words}; largest of {PLACEMENTS} ({PLACED_QUICKLY} in the quick form) "
        f"runs of k, k + {PIECES}, k + {2 * PIECES}, ... steps, which place w = 0 differently in "
        "its step"
    )


WRONG_MOTIONS: Mapping[str, Callable[[Problem], Problem]] = {
    "drag stronger by a millionth": lambda problem: galvi.problems.brownout(
        problem.parameters["diameter"],
        problem.q0,
        problem.v0,
        drag_coefficient=0.44 * (1.0 + 1e-6),
    ),
    "no drag": lambda problem: replace(
        problem, system=replace(problem.system, force=None, timed_force=False)
    ),
    "rotor late by a millionth of a second": lambda problem: replace(problem, t0=problem.t0 - 1e-6),
}

V23 = Claim(
    "V23",
    "Brownout particle: the order with a drag that depends on velocity",
    study,
    judge,
    ("M fig. 3",),
    source="M 6.2, fig. 3",
    reference=TRUTH,
    statement="M 6.2, fig. 3 left: the order is 2 N although the drag depends on velocity, until "
    "the tolerance of Newton's method is reached. Measured: so while the relative velocity w "
    "stays away from 0; where it passes through 0 the order is about 3 for N > 1.",
    caught=(
        *(
            of_table(
                f"order, N = 4, {AWAY}",
                f"distance to DOP853 [m], M's reference, N = 12, {AWAY}",
                **{array: 1.0 + 1e-6},
            )
            for array in ("b", "integral")
        ),
        *(
            of_motion(
                what,
                {
                    *(f"order, N = {N}, {AWAY}" for N in (3, 4)),
                    f"distance to DOP853 [m], M's reference, N = 12, {ACROSS}",
                },
                change,
            )
            for what, change in WRONG_MOTIONS.items()
        ),
    ),
)
