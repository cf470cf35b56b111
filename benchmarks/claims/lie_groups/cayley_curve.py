"""An exact motion of a body in Cayley's chart, and its distance from polynomials.

The coordinates are xi = 2 tan(angle / 2) axis, by textbook formulas, independent of galvi's charts.
`path` (k, 3, 3) are attitudes at evenly spaced times of one step, and `omega` (k, 3) the angular
velocities in the body at these times.
"""

from __future__ import annotations

import numpy as np

from benchmarks.measures.rigid_invariants import turns
from galvi.arrays import Array


def rotation_angle(path: Array) -> float:
    """The rotation angle from the path's first attitude to its last, in [0, 2 pi).

    The skew part of the rotation is sin(angle) axis. Since the axis is continuous, its sign changes
    where the angle passes pi; samples must be dense enough to show each change.
    """
    skew, _ = _parts(path)
    angle = float(turns(path[:1], path[-1:])[0])
    flips = np.sum(np.sum(skew[1:-1] * skew[2:], axis=1) < 0.0)
    return 2.0 * np.pi - angle if flips % 2 else angle


def cayley_rate(path: Array, omega: Array) -> tuple[Array, Array]:
    """xi and xi', (k, 3) each, where xi' = Omega + xi x Omega / 2 + xi (xi . Omega) / 4."""
    skew, trace = _parts(path)
    xi = 2.0 * skew / (1.0 + trace)[:, None]
    along = np.sum(xi * omega, axis=1)[:, None]
    return xi, omega + 0.5 * np.cross(xi, omega) + 0.25 * along * xi


def distance_of_polynomials(path: Array, omega: Array, degree: int) -> float:
    """The distance of xi(t) from polynomials of this degree: the root mean square of the difference
    of velocities.

    It is that of the best polynomial p in the seminorm int |xi' - p'|^2 / (1 + |xi|^2 / 4)^2 dt,
    whose weight is that of the kinetic energy in Cayley's chart.
    """
    xi, rate = cayley_rate(path, omega)
    weight = 1.0 / (1.0 + 0.25 * np.sum(xi**2, axis=1))[:, None]
    basis = np.polynomial.legendre.legvander(np.linspace(-1.0, 1.0, len(path)), degree - 1)
    best, *_ = np.linalg.lstsq(basis * weight, rate * weight, rcond=None)
    difference = (rate - basis @ best) * weight
    return float(np.sqrt(np.mean(np.sum(difference**2, axis=1))))


def _parts(path: Array) -> tuple[Array, Array]:
    """2 sin(angle) axis, (k, 3), and the trace, (k,), of the rotations from the first attitude."""
    relative = np.einsum("ji,kjl->kil", path[0], path)
    skew = relative - np.swapaxes(relative, 1, 2)
    return skew[:, (2, 0, 1), (1, 2, 0)], np.trace(relative, axis1=1, axis2=2)
