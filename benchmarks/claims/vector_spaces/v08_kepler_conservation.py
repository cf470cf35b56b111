"""V8: the Kepler problem, energy and angular momentum over 1000 steps (H figures 2.12, 2.13)."""

from __future__ import annotations

import pandas as pd

from benchmarks.checks.bounds import NoGrowth
from benchmarks.checks.claim import Claim, MakeMethod, Report, Row
from benchmarks.claims.vector_spaces.kepler_orbit import METHOD, ORBIT, STEP, problem
from benchmarks.measures.errors import angular_momentum_errors, energy_errors
from benchmarks.measures.refinement import Case, history
from benchmarks.statistics import readings
from benchmarks.store.frames import frame

N, STEPS = 8, 1000
LIMIT = 1e-12
ROUND_OFF = 2e-13  # below it growth is that of rounding errors; 3e-14 was measured
SETUP = f"{ORBIT}; {METHOD}, n = {N}; h = {STEP:g}, {STEPS} steps; relative, at step ends"
MEASURES = {"energy error": energy_errors, "angular momentum error": angular_momentum_errors}


def study(make_method: MakeMethod, quick: bool, report: Report) -> pd.DataFrame:
    """Series 'history' of both relative errors at step ends, from (q, p)."""
    report(f"n = {N}, {STEPS} steps of {STEP:g}")
    return frame(history("history", problem(), Case(N, STEP, STEPS), MEASURES, make_method))


def judge(table: pd.DataFrame) -> list[Row]:
    """Bounded and without drift."""
    energy, angular = (readings.drift(table, study="history", quantity=name) for name in MEASURES)
    return [
        V8.row(
            f"energy error, n = {N}",
            NoGrowth(0.1),
            energy,
            source="H fig. 2.12",
            reference="exact energy -1/2",
            reason="The method is symplectic and the step is constant: a step that passes the "
            "pericentre misses the energy by up to 7 %, and the next ones give it back.",
        ),
        V8.row(
            f"angular momentum error, n = {N}",
            NoGrowth(LIMIT, ROUND_OFF),
            angular,
            source="H fig. 2.13",
            reference="exact angular momentum 0.8",
            reason="Rotations leave the discrete Lagrangian as it is, so (q, p) at step ends "
            "conserves angular momentum exactly; what is seen is round-off.",
        ),
    ]


V8 = Claim(
    "V8",
    "Kepler, n = 8, 1000 steps: energy and angular momentum do not grow",
    study,
    judge,
    ("H fig. 2.12", "H fig. 2.13"),
    setup=SETUP,
    claimed="does not grow",
)
