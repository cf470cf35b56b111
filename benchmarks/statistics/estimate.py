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
        its standard error; None where it has none
    refuted
        errors stayed large, or became large again: they contradict any rate
    """

    value: float
    uncertainty: float | None = None
    refuted: bool = False


Measurement = float | Estimate | Fit | Decay | Drift


def estimate(measured: Measurement) -> Estimate:
    """The number of a measurement: a fit's rate, the largest error of a drift, or the number."""
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
