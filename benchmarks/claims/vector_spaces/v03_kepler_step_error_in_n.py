"""V3: the Kepler problem, n-refinement of the error at step ends (H figure 2.6)."""

from __future__ import annotations

import pandas as pd

from benchmarks.checks.bounds import EXCEEDS, Base
from benchmarks.checks.claim import Claim, MakeMethod, Report, Row
from benchmarks.claims.vector_spaces.kepler_orbit import FLOOR, SETUP, THEORY, n_refinement
from benchmarks.statistics import readings
from references.closed_forms.kepler import KEPLER

CLAIMED, RESOLUTION = 0.56, 0.005


def study(make_method: MakeMethod, quick: bool, report: Report) -> pd.DataFrame:
    """Series 'n-refinement' of the one-step error."""
    ns = range(8, 55, 3) if quick else range(7, 61)
    return n_refinement(ns, ("one-step error",), make_method, report)


def judge(table: pd.DataFrame) -> list[Row]:
    """Compare the fitted base with 0.56."""
    fit = readings.base(table, FLOOR, study="n-refinement", quantity="one-step error")
    return [V3.row("base of the one-step error", Base(CLAIMED, RESOLUTION), fit, expected=EXCEEDS)]


V3 = Claim(
    "V3",
    "Kepler at h = 2: one-step error O(0.56^n)",
    study,
    judge,
    ("H fig. 2.6",),
    setup=SETUP,
    claimed="O(0.56^n)",
    reason=f"{THEORY}, times an algebraic factor n^-g that makes a fit over finite n a little "
    "steeper: 0.54.",
    reference=KEPLER.name,
)
