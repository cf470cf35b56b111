"""A measured number with its standard error, from any kind of measurement."""

from __future__ import annotations

from dataclasses import dataclass

from benchmarks.statistics.convergence_fits import Decay, Fit
from benchmarks.statistics.drift import Drift


@dataclass(frozen=True)
class Estimate:
    """A measured number; NaN where it could not be measured.

    Attributes
    ----------
    uncertainty
        standard error; None where it is not known
    refuted
        whether errors stayed large, or became large again, which contradicts any rate
    """

    value: float
    uncertainty: float | None = None
    refuted: bool = False


Measurement = float | Estimate | Fit | Decay | Drift


def estimate(measured: Measurement) -> Estimate:
    """The estimate of a measurement: a fit's rate, the largest error of a drift, or the number."""
    match measured:
        case Estimate():
            return measured
        case Decay():
            return estimate(measured.fit)
        case Fit():
            refuted = measured.stays_large or measured.relapse
            return Estimate(measured.rate, measured.uncertainty, refuted)
        case Drift():
            return Estimate(measured.largest)
        case _:
            return Estimate(float(measured))
