"""V4: the Kepler problem, n-refinement of the error along the curve (H figure 2.6)."""

from __future__ import annotations

import numpy as np

from benchmarks.claims.kit import (
    ENDS_AND_CURVE,
    ORACLES,
    DataFrame,
    MakeMethod,
    Measurement,
    Report,
    number,
    readings,
    table_of,
)
from benchmarks.claims.vector_spaces import v03_kepler_step_error_in_n as v03
from benchmarks.claims.vector_spaces.kepler_orbit import (
    FLOOR,
    IN_N,
    STEP,
    STEPS,
    n_refinement,
    oracles,
)

FROM = 33  # smallest n of the fit to the curve's error

# Legendre coefficients of q', singular like (t - t*)^(-1/2), are of size n^0 r^-n. The curve leaves
# out what lies above degree n - 1: its error is near the integral of P_(n - 1), of size n^(-3/2)
# inside a step, times r^-n.
POWER = (1.5, 0.0)


def study(make_method: MakeMethod, quick: bool, report: Report) -> DataFrame:
    """Series 'n-refinement' of the one-step and the curve error; the distance between the two
    references, at step ends."""
    ns = range(14, 63, 3) if quick else range(7, 62)
    rows = n_refinement(ns, ENDS_AND_CURVE, make_method, report)
    return table_of(rows + oracles("oracles", STEP * STEPS, STEPS))


def read(table: DataFrame) -> dict[str, Measurement]:
    """The base of the curve's error from n = 33 on, and the n at which both fits cross: the largest
    n at which the error of step ends is at least that of the curve."""
    series = table[table["study"] == IN_N]
    ends = readings.base(series, FLOOR, quantity=ENDS_AND_CURVE[0], power=v03.POWER)
    curve = readings.base(series, FLOOR, FROM, quantity=ENDS_AND_CURVE[1], power=POWER)
    n = np.linspace(1.0, 100.0, 9901)
    return {
        "base of the curve error": curve,
        "n where the curve error leaves the one-step error": readings.largest(
            n[ends.evaluate(n) >= curve.evaluate(n)]
        ),
        "apart": number(table, quantity=ORACLES),
    }
