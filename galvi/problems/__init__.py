"""Ready problems: each is a function that returns a `galvi.Problem`."""

from galvi.problems.applegate import applegate
from galvi.problems.fermi_pasta_ulam_tsingou import fermi_pasta_ulam_tsingou
from galvi.problems.harmonic_oscillator import harmonic_oscillator
from galvi.problems.henon_heiles import henon_heiles
from galvi.problems.kepler import kepler
from galvi.problems.outer_solar_system import outer_solar_system
from galvi.problems.solar_system import solar_system

__all__ = [
    "applegate",
    "fermi_pasta_ulam_tsingou",
    "harmonic_oscillator",
    "henon_heiles",
    "kepler",
    "outer_solar_system",
    "solar_system",
]
