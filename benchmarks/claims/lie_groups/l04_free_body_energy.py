"""L4: the free rigid body, energy over ten thousand steps (H figure 3.3)."""

from __future__ import annotations

import pandas as pd

import galvi
from benchmarks.checks.bounds import NoGrowth
from benchmarks.checks.claim import Claim, MakeMethod, Report, Row
from benchmarks.claims.lie_groups.free_body import BODY, STEP, problem
from benchmarks.measures import rigid_invariants
from benchmarks.measures.refinement import method_on_group
from benchmarks.statistics import readings
from benchmarks.store.frames import failure, frame, history

N, COARSE = 12, 8
STEPS, QUICK_STEPS, EVERY = 10000, 2000, 4
LIMITS = {COARSE: 1e-11, N: 1e-13}
ROUND_OFF = 1e-13  # below it growth is that of rounding errors; 2.4e-14 was measured
QUANTITIES = {n: f"energy error, n = {n}" for n in (N, COARSE)}
REASONS = {
    N: "The method is symplectic and the step is constant; at n = 12 the truncation error is below "
    "round-off, and what is seen is rounding, whose growth the study of a million steps tells.",
    COARSE: "With four basis functions fewer the truncation error is seen: it oscillates with the "
    "motion, and a step gives back what another took.",
}


def study(make_method: MakeMethod, quick: bool, report: Report) -> pd.DataFrame:
    """Series 'history' of the relative energy error at every fourth step end, n = 12 and 8; 10000
    steps, 2000 in the quick form."""
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
    return frame(rows)


def judge(table: pd.DataFrame) -> list[Row]:
    """Bounded and without drift."""
    return [
        L4.row(
            quantity,
            NoGrowth(LIMITS[n], ROUND_OFF if n == N else 0.0),
            readings.drift(table, study="history", quantity=quantity),
            setup=f"{BODY}; Polynomials({n - 1}), gauss({n}), Cayley; h = {STEP:g}, {STEPS} steps "
            f"({QUICK_STEPS} in the quick form); relative, at every fourth step end",
            reason=REASONS[n],
        )
        for n, quantity in QUANTITIES.items()
    ]


L4 = Claim(
    "L4",
    "Free rigid body, 10000 steps: the energy error oscillates and stays bounded",
    study,
    judge,
    ("H fig. 3.3",),
    claimed="oscillates and remains bounded",
    reference="exact energy, v0 . J v0 / 2",
)
