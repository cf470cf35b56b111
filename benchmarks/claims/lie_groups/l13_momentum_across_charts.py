"""L13: the momentum is matched where the chart changes (H 3.2.2, 3.4.3)."""

from __future__ import annotations

from benchmarks.claims.kit import *
from benchmarks.claims.lie_groups.free_body import BODY, CAYLEY, METHODS, STEP, problem
from benchmarks.measures.discrete_momenta import discrete_momenta
from benchmarks.measures.rigid_invariants import spatial_momentum

N, STEPS, QUICK_STEPS = 8, 1000, 200
LIMIT = 1e-13  # over 1000 steps; 1e-14 was measured
SINGLE = 1e-12  # of one step's; 5e-14 was measured: the curve is fitted and differentiated anew
KEPT = {chart: f"spatial angular momentum, {chart} chart" for chart in METHODS}
FIRST = "D1 L_d of a step against the run's momentum at its start"
SECOND = "D2 L_d of a step against the run's momentum at its end"
MATCHED = "D2 L_d of a step plus D1 L_d of the next"
FAST = ", packed kernel"  # of methods with as many stages as their degree
FROM_CURVES = "spatial angular momentum R D2 L_d, from the curves alone"
EXACT = "R0 J Omega0"
MOVED = (
    "L_d's derivative by its first point moves the base point of the chart along with it; the "
    "derivative at a base point that stays, as 3.2.2 can be read, loses momentum at every step"
)


def study(make_method: MakeMethod, quick: bool, report: Report) -> DataFrame:
    """Series 'history', each relative to |mu0|, over 1000 steps (200 in the quick form)."""
    steps, rows = QUICK_STEPS if quick else STEPS, []
    for chart, method in METHODS.items():
        report(f"{chart} chart, {steps} steps")
        run = galvi.integrate(problem(), method(make_method, N), STEP, steps)
        rows += _rows(run, KEPT[chart], run.t, _change(run, run.q, run.p))
        if chart == CAYLEY:
            rows += _discrete(run, N, "")
    report("as many stages as the degree")
    method = make_method(galvi.Polynomials(N), galvi.gauss(N))
    return frame(rows + _discrete(galvi.integrate(problem(), method, STEP, steps), N + 1, FAST))


def _discrete(run: Trajectory, n: int, kernel: str) -> list[dict[str, Any]]:
    size = np.linalg.norm(run.problem.p0)
    before, after = discrete_momenta(run, n, N)

    def apart(mine: Array, other: Array) -> Array:
        return np.linalg.norm(mine - other, axis=-1) / size

    return [
        *_rows(run, FIRST + kernel, run.t[:-1], apart(before, run.p[:-1])),
        *_rows(run, SECOND + kernel, run.t[1:], apart(after, run.p[1:])),
        *_rows(run, MATCHED + kernel, run.t[1:-1], apart(after[:-1], before[1:])),
        *_rows(run, FROM_CURVES + kernel, run.t[1:], _change(run, run.q[1:], after)),
    ]


def _change(run: Trajectory, R: Array, p: Array) -> Array:
    start = spatial_momentum(run.problem.q0[None], run.problem.p0[None])
    return np.linalg.norm(spatial_momentum(R, p) - start, axis=-1) / np.linalg.norm(start)


def _rows(run: Trajectory, quantity: str, t: Array, values: Array) -> list[dict[str, Any]]:
    where = {"study": "history", "n": N, "step": STEP, "steps": len(run.t) - 1}
    return history(quantity, t, values, status=failure(run), **where)


def judge(table: DataFrame) -> list[Row]:
    """Momentum is conserved in every chart, and the run's momenta agree with its curves'."""
    whole = "Rotations leave the discrete Lagrangian as it is: R mu is its Noether quantity."
    fitted = f"{MOVED}. Computed from the curve R(t) alone, by complex steps."
    kernels, measured = ("", FAST), (FIRST, SECOND, MATCHED, FROM_CURVES)
    return [
        *(_row(table, quantity, LIMIT, whole) for quantity in KEPT.values()),
        *(_row(table, name + kernel, SINGLE, fitted) for kernel in kernels for name in measured),
    ]


def _row(table: DataFrame, quantity: str, limit: float, reason: str) -> Row:
    return L13.row(
        f"largest error of {quantity}",
        AtMost(limit),
        readings.largest_of(table, study="history", quantity=quantity),
        setup=f"{BODY}; Polynomials({N if FAST in quantity else N - 1}), gauss({N}); "
        f"h = {STEP:g}, {STEPS} steps ({QUICK_STEPS} in the quick form); relative to |mu0|",
        reason=reason,
        reference=EXACT if "spatial" in quantity else "derivatives of the discrete Lagrangian",
    )


L13 = Claim(
    "L13",
    "The momentum is matched where the chart changes",
    study,
    judge,
    source="H 3.2.2, 3.4.3",
    claimed="momentum is matched across the change of chart",
    statement="H 3.2.2, 3.4.3: the momentum is matched where the chart changes.",
    caught=(of_table(f"largest error of {SECOND}", b=1.0 + 1e-9),),
)
