"""V2: energy of the harmonic oscillator, n-refinement and history (H figures 2.4 and 2.5)."""

from __future__ import annotations

import pandas as pd

import galvi
from benchmarks.checks.bounds import Geometric, NoGrowth
from benchmarks.checks.claim import Claim, MakeMethod, Report, Row
from benchmarks.claims.vector_spaces.v01_oscillator_convergence_in_n import SETUP, STEP, STEPS
from benchmarks.measures.errors import energy_errors
from benchmarks.measures.refinement import Case, history, refine
from benchmarks.statistics import readings
from benchmarks.store.frames import frame
from references.closed_forms.oscillator import OSCILLATOR

QUANTITY = "energy error"
WATCHED = 14  # the n of H figure 2.5
FLOOR = 1e-11
LIMIT = 0.02


def study(make_method: MakeMethod, quick: bool, report: Report) -> pd.DataFrame:
    """Series 'n-refinement' of the largest relative energy error at step ends; for n = 14 also
    'history', the error at each step end."""
    problem = galvi.problems.harmonic_oscillator()
    cases = [Case(n, STEP, STEPS) for n in (range(12, 27) if quick else range(8, 31))]
    rows = refine("n-refinement", problem, OSCILLATOR, cases, [QUANTITY], make_method, report)
    watched = Case(WATCHED, STEP, STEPS)
    rows += history("history", problem, watched, {QUANTITY: energy_errors}, make_method)
    return frame(rows)


def judge(table: pd.DataFrame) -> list[Row]:
    """Whether the error decays geometrically, and for n = 14 is bounded without drift."""
    return [
        V2.row(
            "base of the energy error",
            Geometric(),
            readings.decay(table, FLOOR, study="n-refinement", quantity=QUANTITY),
            source="H fig. 2.4",
            setup=f"{SETUP}; |H - 1/2| / (1/2), largest over step ends",
            claimed="geometric convergence",
            reason="The solution is entire: as in V1, faster than any geometric rate.",
        ),
        V2.row(
            f"energy error, n = {WATCHED}",
            NoGrowth(LIMIT),
            readings.drift(table, study="history", quantity=QUANTITY),
            source="H fig. 2.5",
            setup=f"{SETUP}; n = {WATCHED}, |H - 1/2| / (1/2) at step ends",
            claimed="does not grow",
            reason="A step is a linear symplectic map, at n = 14 a stable one: it conserves a "
            "quadratic form near the energy exactly, so that the energy error oscillates.",
        ),
    ]


V2 = Claim(
    "V2",
    "Oscillator at h = 20: the energy error falls geometrically with n and does not grow",
    study,
    judge,
    ("H fig. 2.4", "H fig. 2.5"),
    reference="exact energy 1/2",
)
