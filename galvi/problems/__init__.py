"""Ready problems: each is a function that returns a `galvi.Problem`."""

from galvi.problems.applegate import applegate
from galvi.problems.brownout import brownout
from galvi.problems.double_pendulum import double_pendulum
from galvi.problems.elastic_pendulum import elastic_pendulum
from galvi.problems.fermi_pasta_ulam_tsingou import fermi_pasta_ulam_tsingou
from galvi.problems.free_body_se3 import free_body_se3
from galvi.problems.free_box import free_box
from galvi.problems.free_rigid_body import free_rigid_body
from galvi.problems.harmonic_oscillator import harmonic_oscillator
from galvi.problems.heavy_top import heavy_top
from galvi.problems.henon_heiles import henon_heiles
from galvi.problems.kepler import kepler
from galvi.problems.kepler_polar import kepler_polar
from galvi.problems.outer_solar_system import outer_solar_system
from galvi.problems.pendulum_3d import pendulum_3d
from galvi.problems.planar_chain import planar_chain
from galvi.problems.planar_pendulum import planar_pendulum
from galvi.problems.skew_arm import skew_arm
from galvi.problems.solar_system import solar_system
from galvi.problems.spherical_pendulum import spherical_pendulum

__all__ = [
    "applegate",
    "brownout",
    "double_pendulum",
    "elastic_pendulum",
    "fermi_pasta_ulam_tsingou",
    "free_body_se3",
    "free_box",
    "free_rigid_body",
    "harmonic_oscillator",
    "heavy_top",
    "henon_heiles",
    "kepler",
    "kepler_polar",
    "outer_solar_system",
    "pendulum_3d",
    "planar_chain",
    "planar_pendulum",
    "skew_arm",
    "solar_system",
    "spherical_pendulum",
]
