"""L4: the free rigid body, energy over ten thousand steps (H figure 3.3)."""

from __future__ import annotations

import numpy as np

import galvi
from benchmarks.claims.kit import (
    Array,
    DataFrame,
    MakeMethod,
    Measurement,
    Report,
    Trajectory,
    failure,
    history,
    method_on_group,
    readings,
    row,
    table_of,
)
from benchmarks.claims.short_runs import SHORT, short_runs
from benchmarks.measures import rigid_invariants
from references.closed_forms.top_motion import FREE_TOP

STEPS = 10000
N, COARSE = 12, 8
QUANTITIES = {n: f"energy error, n = {n}" for n in (N, COARSE)}
FLOOR = 2e-14  # round-off; 6e-15 was measured at h = 0.35


def study(make_method: MakeMethod, quick: bool, report: Report) -> DataFrame:
    """Series 'history' of the relative energy error at every second step end, n = 12 and 8; 10000
    steps, 4000 in the quick form. 'h-refinement' of its largest value, and short runs from all over
    the motion, at n = 8."""
    body = galvi.problems.free_rigid_body()
    method = method_on_group(make_method, COARSE)
    rows = list(short_runs("energy error", body, FREE_TOP, 200.0, method, 0.5))
    for n, quantity in QUANTITIES.items():
        steps = 4000 if quick else STEPS
        run = galvi.integrate(body, method_on_group(make_method, n), 0.5, steps, save_every=2)
        rows += history(quantity, run.t, errors(run), study="history", status=failure(run))
    for steps in (238, 283, 336, 400, 476):
        run = galvi.integrate(body, method, 200.0 / steps, steps)
        where = {"study": "h-refinement", "step": 200.0 / steps, "status": failure(run)}
        rows.append(row(value=float(np.max(abs(errors(run)))), **where))
    return table_of(rows)


def errors(run: Trajectory) -> Array:
    """The relative errors of the energy, from (R, p), at all saved times."""
    start = rigid_invariants.energy(run.problem, run.q[:1], run.p[:1])
    return rigid_invariants.energy(run.problem, run.q, run.p) / start - 1.0


def read(table: DataFrame) -> dict[str, Measurement]:
    """The drifts, the limit of the error and its order at n = 8, and whether rounding is biased.

    The last is the mean change over 50 blocks, in standard errors: a small linear drift would stay
    below any bound on the largest error. Rounding p once a step, up or down, changes v . p / 2 by
    up to 2^-52 of itself: `rounding` is five standard deviations of that random walk.
    """
    histories = table[table["study"] == "history"]
    rounding = readings.values(histories, "t", quantity=QUANTITIES[N])
    blocks = np.diff(rounding[:: rounding.size // 50])
    scatter = np.std(blocks, ddof=1) / blocks.size**0.5
    bias_name = f"mean change of the energy over blocks, in its standard errors, n = {N}"
    order = readings.order(table, FLOOR, study="h-refinement")
    return {
        **{
            quantity: readings.drift(histories, quantity=quantity)
            for quantity in QUANTITIES.values()
        },
        "rounding": 5.0 * (STEPS / 3.0) ** 0.5 * 2.0**-52,
        "limit": readings.largest_of(table, study=SHORT),
        bias_name: float(abs(np.mean(blocks)) / scatter),
        f"order of the largest energy error, n = {COARSE}": order,
    }
