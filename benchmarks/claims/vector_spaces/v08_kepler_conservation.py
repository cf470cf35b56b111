"""V8: the Kepler problem, energy and angular momentum over 10000 steps (H figures 2.12, 2.13)."""

from __future__ import annotations

import math

from benchmarks.claims.kit import (
    Case,
    DataFrame,
    MakeMethod,
    Measurement,
    Report,
    method_of,
    readings,
    table_of,
)
from benchmarks.claims.short_runs import SHORT, short_runs
from benchmarks.claims.vector_spaces.kepler_orbit import STEP, problem
from benchmarks.measures.errors import angular_momentum_errors, energy_errors
from benchmarks.measures.refinement import history
from references.closed_forms.kepler import KEPLER

MEASURES = {"energy error": energy_errors, "angular momentum error": angular_momentum_errors}


def study(make_method: MakeMethod, quick: bool, report: Report) -> DataFrame:
    """Series 'history' of both relative errors at step ends, from (q, p); and the largest energy
    errors of short runs from states round the orbit."""
    rows = history("history", problem(), Case(8, STEP, 10000), MEASURES, make_method)
    rows += short_runs("energy error", problem(), KEPLER, math.tau, method_of(make_method, 8), STEP)
    return table_of(rows)


def read(table: DataFrame) -> dict[str, Measurement]:
    """Both drifts; the limit of the energy error; and, as `rounding`, that of the angular momentum.

    Rounding q and p once a step changes L = q x p by at most 2^-52 |q| |p|, and |q| |p| <= 1 =
    L / 0.8 on this orbit; `rounding` is the sum over all steps, as if all had the same sign.
    """
    drifts = {
        f"{quantity}, n = 8": readings.drift(table, study="history", quantity=quantity)
        for quantity in MEASURES
    }
    return {
        **drifts,
        "limit": readings.largest_of(table, study=SHORT),
        "rounding": 10000 * 2.0**-52 / 0.8,
    }
