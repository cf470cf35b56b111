"""V4: the Kepler problem, n-refinement of the error along the curve (H figure 2.6)."""

from __future__ import annotations

from benchmarks.claims.kit import *
from benchmarks.claims.vector_spaces import v03_kepler_step_error_in_n as v03
from benchmarks.claims.vector_spaces.kepler_orbit import (
    FLOOR,
    SETUP,
    STEP,
    STEPS,
    THEORY,
    n_refinement,
    oracles,
    truths,
)
from references.closed_forms.kepler import KEPLER

CLAIMED, RESOLUTION = 0.74, 0.005
FROM, ABOUT = 33, 4  # "about 32" is read as within a tenth or so

# Legendre coefficients of q', singular like (t - t*)^(-1/2), are of size n^0 r^-n. The curve leaves
# out what lies above degree n - 1: its error is near the integral of P_(n - 1), of size n^(-3/2)
# inside a step, times r^-n.
POWER = (1.5, 0.0)


def study(make_method: MakeMethod, quick: bool, report: Report) -> DataFrame:
    """Series 'n-refinement' of the one-step and the curve error; the distance between the two
    references, at step ends."""
    ns = range(14, 63, 3) if quick else range(7, 62)
    found = n_refinement(ns, ENDS_AND_CURVE, make_method, report)
    return frame([*found.to_dict("records"), *oracles("oracles", STEP * STEPS, STEPS)])


def judge(table: DataFrame) -> list[Row]:
    """The base from n = 33 on, and the n at which the two fitted lines cross."""
    where = {"study": "n-refinement"}
    ends = readings.base(table, FLOOR, quantity=ENDS_AND_CURVE[0], power=v03.POWER, **where)
    curve = readings.base(table, FLOOR, FROM, quantity=ENDS_AND_CURVE[1], power=POWER, **where)
    return [
        V4.row(
            "base of the curve error",
            Base(CLAIMED, RESOLUTION),
            curve,
            setup=f"{SETUP}; n >= {FROM}, times n^({-POWER[0]:g})",
            claimed="O(0.74^n) once n is about 32",
            reason=f"{THEORY}. A curve that leaves out the Legendre polynomials P_(n - 1), ... of "
            "its velocity has an error of size n^(-3/2) r^-n; without this factor the same errors "
            "give 0.717.",
            reference=truths(table),
        ),
        V4.row(
            "n where the curve error leaves the one-step error",
            Near(FROM - 1, ABOUT, noun="about"),
            _crossing(ends, curve),
            setup=f"{SETUP}; where the two fitted lines cross",
            claimed="n about 32",
            reason="Errors accumulate over 32 revolutions at step ends but not along a curve, so "
            "the curve's slower rate shows only when the accumulated error is small enough. H's "
            f'"about" is read as a tenth or so, {ABOUT}.',
            reference=truths(table),
        ),
    ]


def _crossing(ends: Fit, curve: Fit) -> float:
    """The largest n at which the fitted error of step ends is not below that of the curve; NaN
    without both."""
    n = np.linspace(1.0, 100.0, 9901)
    above = n[ends.evaluate(n) >= curve.evaluate(n)]
    return float(above[-1]) if above.size else float("nan")


V4 = Claim(
    "V4",
    "Kepler at h = 2: curve error O(0.74^n) for n above 32",
    study,
    judge,
    ("H fig. 2.6",),
    reference=f"{KEPLER.name}; REBOUND IAS15 (A9)",
    statement="H fig. 2.6: the curve error is O(0.74^n) once n is about 32.",
    caught=(of_table("base of the curve error", C=1.0 + 1e-4),),
)
