"""V3: the Kepler problem, n-refinement of the error at step ends (H figure 2.6)."""

from __future__ import annotations

import pandas as pd

from benchmarks.checks import bounds
from benchmarks.checks.claim import Claim, MakeMethod, Report, Row
from benchmarks.claims.vector_spaces.kepler_orbit import FLOOR, SETUP, THEORY, n_refinement
from benchmarks.statistics import convergence_fits
from benchmarks.store.frames import series
from references.closed_forms.kepler import KEPLER

CLAIMED, RESOLUTION = 0.56, 0.005


def study(make_method: MakeMethod, quick: bool, report: Report) -> pd.DataFrame:
    """Series 'n-refinement' of the one-step error."""
    ns = range(8, 55, 3) if quick else range(7, 61)
    return n_refinement(ns, ("one-step error",), make_method, report)


def judge(table: pd.DataFrame) -> list[Row]:
    """Compare the fitted base with 0.56."""
    n, errors = series(table, "n", study="n-refinement", quantity="one-step error")
    fit = convergence_fits.geometric(n, errors, floor=FLOOR)
    return [
        Row(
            id="V3",
            quantity="base of the one-step error",
            source="H fig. 2.6",
            setup=SETUP,
            claimed="O(0.56^n)",
            bound=f"base {CLAIMED} -+ {RESOLUTION} (as printed) -+ 2 standard errors",
            measured=fit.rate,
            uncertainty=fit.uncertainty,
            expected=bounds.EXCEEDS,
            reason=f"{THEORY}, times an algebraic factor n^-g that makes a fit over finite n a "
            "little steeper: 0.54.",
            reference=KEPLER.name,
            verdict=bounds.base(fit, CLAIMED, RESOLUTION),
        )
    ]


V3 = Claim("V3", "Kepler at h = 2: one-step error O(0.56^n)", study, judge, ("H fig. 2.6",))
