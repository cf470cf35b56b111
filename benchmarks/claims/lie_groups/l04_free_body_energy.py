"""L4: the free rigid body, energy over ten thousand steps (H figure 3.3)."""

from __future__ import annotations

from benchmarks.checks.series_bounds import SIGMAS
from benchmarks.claims.kit import *
from benchmarks.claims.lie_groups.free_body import BODY, STEP, problem
from benchmarks.claims.short_runs import PLACES, SHORT, short_runs
from benchmarks.claims.short_runs import STEPS as FEW
from benchmarks.measures import rigid_invariants
from references.closed_forms.top_motion import FREE_TOP

N, COARSE = 12, 8
STEPS, QUICK_STEPS, EVERY = 10000, 4000, 2
# p rounded once a step, to either side, changes v . p / 2 by up to 2^-52 of itself: five standard
# deviations of that random walk.
ROUND_OFF = 5.0 * (STEPS / 3.0) ** 0.5 * 2.0**-52
BLOCKS = 50  # whose changes of the energy have no sign, where rounding has none
REFINED, ORDER = "h-refinement", f"order of the largest energy error, n = {COARSE}"
DURATION = 200.0
NUMBERS = tuple(round(200 * 2.0 ** (j / 4)) for j in range(1, 6))  # of steps
FLOOR = 2e-14  # round-off; 6e-15 was measured at h = 0.35
QUANTITIES = {n: f"energy error, n = {n}" for n in (N, COARSE)}
REASONS = {
    N: "The method is symplectic and the step is constant; at n = 12 the truncation error is below "
    "round-off, and what is seen is rounding, of a compensated sum: see the row on its sign.",
    COARSE: "With four basis functions fewer the truncation error is seen: it oscillates with the "
    "motion, and a step gives back what another took.",
}


def study(make_method: MakeMethod, quick: bool, report: Report) -> DataFrame:
    """Series 'history' of the relative energy error at every second step end, n = 12 and 8; 10000
    steps, 4000 in the quick form. 'h-refinement' of its largest value and
    short runs from all over the motion, at n = 8."""
    steps = QUICK_STEPS if quick else STEPS
    body, rows = problem(), []
    exact = float(rigid_invariants.energy(body, body.q0[None], body.p0[None])[0])
    for n, quantity in QUANTITIES.items():
        report(f"n = {n}, {steps} steps of {STEP:g}")
        method = method_on_group(make_method, n)
        run = galvi.integrate(body, method, STEP, steps, save_every=EVERY)
        errors = rigid_invariants.energy(body, run.q, run.p) / exact - 1.0
        where = {"study": "history", "n": n, "step": STEP, "steps": steps, "status": failure(run)}
        rows += history(quantity, run.t, errors, **where)
    for number in NUMBERS:
        run = galvi.integrate(body, method_on_group(make_method, COARSE), DURATION / number, number)
        errors = rigid_invariants.energy(body, run.q, run.p) / exact - 1.0
        where = {"n": COARSE, "step": DURATION / number, "steps": number, "status": failure(run)}
        value = float(np.max(np.abs(errors)))
        rows.append(row(study=REFINED, quantity=QUANTITIES[COARSE], value=value, **where))
    coarse = method_on_group(make_method, COARSE)
    return frame([*rows, *short_runs(QUANTITIES[COARSE], body, FREE_TOP, DURATION, coarse, STEP)])


def judge(table: DataFrame) -> list[Row]:
    """Bounded and without drift; at n = 8 of the method's order."""
    setup = (
        f"{BODY}; Polynomials(n - 1), gauss(n), Cayley; h = {STEP:g}, {STEPS} steps "
        f"({QUICK_STEPS} in the quick form); relative, at every second step end"
    )
    limits = {
        N: "five standard deviations of one rounding of p a step, to either side",
        COARSE: f"the largest error of {FEW} steps from any of {PLACES} places on the motion by "
        f"{FREE_TOP.name}",
    }
    largest = readings.largest_of(table, study=SHORT, quantity=QUANTITIES[COARSE])
    bounds = {N: NoGrowth(ROUND_OFF, ROUND_OFF), COARSE: NoGrowth(largest)}
    histories = [
        L4.row(
            quantity,
            bounds[n],
            readings.drift(table, study="history", quantity=quantity),
            setup=f"{setup}; limit: {limits[n]}",
            reason=REASONS[n],
        )
        for n, quantity in QUANTITIES.items()
    ]
    order = L4.row(
        ORDER,
        Finding(AtLeast(2.0 * (COARSE - 1), uncertainty=0.0)),
        readings.order(table, FLOOR, study=REFINED, quantity=QUANTITIES[COARSE]),
        setup=f"{BODY}; Polynomials({COARSE - 1}), gauss({COARSE}), Cayley; T = {DURATION:g}, "
        f"h = T / k, k = {', '.join(map(str, NUMBERS))}; relative, the largest at step ends",
        claimed="oscillates",
        reason="Its size is the method's, not a mistake's: the modified energy differs from the "
        "energy by a term of order 2 (n - 1) and by those above, seen at these steps.",
    )
    return [*histories, _sign(table, setup), order]


def _sign(table: DataFrame, setup: str) -> Row:
    """Whether rounding has a sign: a straight line hides below any bound on the largest error."""
    errors = readings.values(table, "t", study="history", quantity=QUANTITIES[N])
    blocks = np.diff(errors[:: max(1, errors.size // BLOCKS)])
    scatter = float(np.std(blocks, ddof=1)) / blocks.size**0.5 if blocks.size > 2 else 0.0
    sized = abs(float(np.mean(blocks))) / scatter if scatter > 0.0 else float("nan")
    return L4.row(
        f"mean change of the energy over blocks, in its standard errors, n = {N}",
        AtMost(SIGMAS),
        sized,
        setup=f"{setup}; {BLOCKS} blocks of steps",
        reason="Rounding of either sign makes a random walk, whose blocks have a mean of 0 within "
        "its standard error; rounding of one sign makes a straight line.",
    )


L4 = Claim(
    "L4",
    "Free rigid body, 10000 steps: the energy error oscillates and stays bounded",
    study,
    judge,
    ("H fig. 3.3",),
    claimed="oscillates and remains bounded",
    reference="exact energy, v0 . J v0 / 2",
    statement="H fig. 3.3: the energy error oscillates and stays bounded over 10000 steps.",
    caught=(of_table("order of the largest energy error, n = 8", integral=1.0 + 1e-4),),
)
