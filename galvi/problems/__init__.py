"""Functions that return ready problems, as `galvi.Problem` values.

>>> galvi.problems.solar_system().units
'au, day (TDB); masses are GM in au^3/day^2 and G = 1'
"""

from galvi.problems.brownout import brownout
from galvi.problems.pendulums import (
    double_pendulum,
    driven_oscillator,
    elastic_pendulum,
    fermi_pasta_ulam_tsingou,
    harmonic_oscillator,
    henon_heiles,
    planar_chain,
    planar_pendulum,
    skew_arm,
    spherical_pendulum,
)
from galvi.problems.planets import applegate, kepler, kepler_polar, outer_solar_system, solar_system
from galvi.problems.rigid_bodies import (
    free_body_se3,
    free_box,
    free_rigid_body,
    heavy_top,
    pendulum_3d,
)

__all__ = [
    "applegate", "brownout", "double_pendulum", "driven_oscillator", "elastic_pendulum",
    "fermi_pasta_ulam_tsingou", "free_body_se3", "free_box", "free_rigid_body",
    "harmonic_oscillator", "heavy_top", "henon_heiles", "kepler", "kepler_polar",
    "outer_solar_system", "pendulum_3d", "planar_chain", "planar_pendulum", "skew_arm",
    "solar_system", "spherical_pendulum",
]  # fmt: skip
