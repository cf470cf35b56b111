"""Orbits of N bodies about one of them: relative states and osculating elements."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from galvi import input_checks
from galvi.arrays import Array
from galvi.input_checks import shown
from galvi.kernels.constants import TWO_PI
from galvi.systems.nbody import NBody
from galvi.trajectory import Trajectory

MAX_KEPLER_ITERATIONS = 100
LEAST_DIVISOR = 1e-300  # replaces an e - 1 of 0


@dataclass(frozen=True, eq=False)
class OrbitalElements:
    """Osculating Kepler orbits, each array (saved, bodies - 1); angles in radians.

    Attributes
    ----------
    semi_major_axis
        a, in the problem's length; negative on a hyperbola, infinite on a parabola
    eccentricity
        e
    inclination
        i in [0, pi], to the plane of the first two coordinates
    node
        longitude of the ascending node in [0, 2 pi); 0 when i is 0 or pi
    pericentre
        argument of pericentre in [0, 2 pi), from the node
    mean_anomaly
        M in [0, 2 pi) on an ellipse, any real number on a hyperbola, 0 on a parabola

    Notes
    -----
    With u = 2.2e-16, e and i have errors of a few u, a of a few u a / r, relatively. Angles that
    become undefined are ill-conditioned near there: the pericentre and M as u / e, the node and
    the pericentre as u / sin i. Their sums are not: `pericentre_longitude` has an error of u / e
    at any i short of pi, and `mean_longitude` one of a few u a / r down to e = 0.

    Examples
    --------
    >>> method = galvi.Galerkin(galvi.Polynomials(8), galvi.gauss(8))
    >>> run = galvi.integrate(galvi.problems.outer_solar_system(), method, step=500.0, steps=10)
    >>> orbits = galvi.orbital_elements(run)
    >>> orbits.eccentricity.shape, orbits.mean_longitude.shape
    ((11, 5), (11, 5))
    """

    semi_major_axis: Array
    eccentricity: Array
    inclination: Array
    node: Array
    pericentre: Array
    mean_anomaly: Array

    @property
    def pericentre_longitude(self) -> Array:
        """node + pericentre, in [0, 2 pi)."""
        return _angle(self.node + self.pericentre)

    @property
    def mean_longitude(self) -> Array:
        """node + pericentre + mean anomaly, in [0, 2 pi)."""
        return _angle(self.node + self.pericentre + self.mean_anomaly)

    def states(self, gm: Any) -> tuple[Array, Array]:
        """Positions and velocities relative to the centre, (..., 3) each, for elements of shape
        (...); gm = G (m_centre + m_body) of that shape, or a number.

        The inverse of `orbital_elements`; NaN where an element is.

        Raises
        ------
        ValueError
            For a parabola and for e = 1, whose elements do not say where the body is, for an
            eccentricity that is negative, or does not belong to the sign of the axis, and for a gm
            that is not positive.
        """
        a, e, i, node, turn, mean, mu = np.broadcast_arrays(
            *(
                np.asarray(x, dtype=np.float64)
                for x in (
                    self.semi_major_axis,
                    self.eccentricity,
                    self.inclination,
                    self.node,
                    self.pericentre,
                    self.mean_anomaly,
                    gm,
                )
            )
        )
        is_inconsistent = (e < 1.0) & (a < 0.0) | (e > 1.0) & (a > 0.0) & np.isfinite(a)
        if np.any(e < 0.0) or np.any(is_inconsistent):
            raise ValueError(
                "an eccentricity must be at least 0, below 1 for a positive axis and above 1 for a "
                f"negative one; received {e.tolist()} and axes {a.tolist()}."
            )
        if np.any(is_parabolic := (e == 1.0) | np.isinf(a)):
            index = tuple(int(k) for k in np.argwhere(is_parabolic)[0])
            raise ValueError(
                f"a and e must be those of an ellipse or a hyperbola, as on a parabola they do not "
                f"say where the body is; received a = {a[index]:g} and e = {e[index]:g}"
                f"{f' at {list(index)}' if index else ''}. Leave it out, or give its place and "
                f"velocity."
            )
        if not np.all(mu > 0.0):
            raise ValueError(f"gm must be positive; received {shown(gm)}.")
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            return _states(a, e, i, node, turn, mean, mu)


def heliocentric(run: Trajectory, centre: int | None = None) -> tuple[Array, Array]:
    """Positions and velocities relative to one of the bodies.

    Parameters
    ----------
    run : galvi.Trajectory
        of an NBody system
    centre : int, optional
        index of that body; None: the heaviest

    Returns
    -------
    positions, velocities : array, shape (saved, bodies - 1, d)
        of the other bodies, in their order

    Raises
    ------
    ValueError
        For a system other than NBody and for an index out of range.

    Examples
    --------
    >>> method = galvi.Galerkin(galvi.Polynomials(8), galvi.gauss(8))
    >>> run = galvi.integrate(galvi.problems.outer_solar_system(), method, step=500.0, steps=10)
    >>> x, v = galvi.heliocentric(run)
    >>> x.shape, v.shape
    ((11, 5, 3), (11, 5, 3))
    """
    system = _nbody(run)
    centre = _centre(system, centre)
    q, v = (np.delete(x - x[:, centre : centre + 1], centre, axis=1) for x in (run.q, run.v))
    return q, v


def orbital_elements(run: Trajectory, centre: int | None = None) -> OrbitalElements:
    """The osculating Kepler orbit of each other body about the centre.

    The gravitational parameter is gm = G (m_centre + m_body) for each body. Elements are NaN past a
    failed step, and for a body on a straight line through the centre. In the plane, orbits are
    counter-clockwise at i = 0 and clockwise at i = pi.

    Parameters
    ----------
    run : galvi.Trajectory
        of an NBody system
    centre : int, optional
        index of the central body; None: the heaviest

    Returns
    -------
    galvi.OrbitalElements
        arrays of shape (saved, bodies - 1), angles in radians

    Raises
    ------
    ValueError
        As `heliocentric`.

    Examples
    --------
    >>> method = galvi.Galerkin(galvi.Polynomials(8), galvi.gauss(8))
    >>> run = galvi.integrate(galvi.problems.outer_solar_system(), method, step=500.0, steps=10)
    >>> galvi.orbital_elements(run).semi_major_axis[0].round(1)  # Jupiter to Pluto, in au
    array([ 5.2,  9.6, 19.2, 30.1, 39.3])
    """
    system = _nbody(run)
    centre = _centre(system, centre)
    gm = system.G * np.delete(system.masses[centre] + system.masses, centre)
    q, v = heliocentric(run, centre)
    pad = ((0, 0), (0, 0), (0, 3 - q.shape[-1]))
    with np.errstate(divide="ignore", invalid="ignore"):
        return _elements(gm, np.pad(q, pad), np.pad(v, pad))


def _elements(gm: Array, q: Array, v: Array) -> OrbitalElements:
    """The elements of relative states q, v (saved, bodies, 3).

    The pericentre and M contain the true anomaly nu with opposite signs and the same rounding, so
    that its error cancels in their sum.
    """
    r = np.linalg.norm(q, axis=-1)
    momentum = np.cross(q, v)
    size = np.linalg.norm(momentum, axis=-1)
    radial = np.sum(q * v, axis=-1)
    inverse_axis = 2.0 / r - np.sum(v**2, axis=-1) / gm

    horizontal = np.hypot(momentum[..., 0], momentum[..., 1])
    node = np.where(horizontal > 0.0, np.arctan2(momentum[..., 0], -momentum[..., 1]), 0.0)
    node_direction = np.stack([np.cos(node), np.sin(node), np.zeros_like(node)], axis=-1)
    transverse = np.cross(momentum / size[..., None], node_direction)
    latitude = np.arctan2(np.sum(q * transverse, axis=-1), np.sum(q * node_direction, axis=-1))

    cosine, sine = size**2 / (gm * r) - 1.0, size * radial / (gm * r)  # e cos nu, e sin nu
    e, nu = np.hypot(cosine, sine), np.arctan2(sine, cosine)

    s = radial * np.sqrt(np.abs(inverse_axis) / gm)  # e sin E, or e sinh H
    c = 1.0 - r * inverse_axis  # e cos E
    eta = size * np.sqrt(np.abs(inverse_axis) / gm)  # sqrt(1 - e^2)
    ellipse = nu - 2.0 * np.arctan2(s, 1.0 + eta - c) - s
    hyperbola = s - np.arcsinh(s / e)
    mean = np.where(inverse_axis > 0.0, _angle(ellipse), np.where(s == 0.0, 0.0, hyperbola))
    nan_of_state = 0.0 * (latitude + r)  # NaN where a state is, or the motion is straight
    return OrbitalElements(
        semi_major_axis=1.0 / inverse_axis + nan_of_state,
        eccentricity=e + nan_of_state,
        inclination=np.arctan2(horizontal, momentum[..., 2]) + nan_of_state,
        node=_angle(node) + nan_of_state,
        pericentre=_angle(latitude - nu),
        mean_anomaly=mean + nan_of_state,
    )


def _states(
    a: Array, e: Array, i: Array, node: Array, turn: Array, mean: Array, mu: Array
) -> tuple[Array, Array]:
    """As `OrbitalElements.states`; (cosine, sine) and (x, y) are in the plane of the orbit."""
    is_ellipse = e < 1.0
    anomaly = _anomaly(
        e, np.where(is_ellipse, np.remainder(mean + np.pi, TWO_PI) - np.pi, mean), is_ellipse
    )
    cosine = np.where(is_ellipse, np.cos(anomaly), np.cosh(anomaly))
    sine = np.where(is_ellipse, np.sin(anomaly), np.sinh(anomaly))
    root = np.sqrt(np.abs(1.0 - e) * (1.0 + e))
    x, y = a * (cosine - e), np.abs(a) * root * sine
    speed = np.sqrt(mu * np.abs(a)) / np.abs(a * (1.0 - e * cosine))
    vx, vy = -speed * sine, speed * root * cosine
    c, s = np.cos(turn), np.sin(turn)
    C, S, ci, si = np.cos(node), np.sin(node), np.cos(i), np.sin(i)
    ahead = np.stack([C * c - S * s * ci, S * c + C * s * ci, s * si], axis=-1)
    left = np.stack([-C * s - S * c * ci, -S * s + C * c * ci, c * si], axis=-1)
    q = x[..., None] * ahead + y[..., None] * left
    return q, vx[..., None] * ahead + vy[..., None] * left


def _anomaly(e: Array, mean: Array, bound: Any) -> Array:
    """E of E - e sin E = M, |M| <= pi, where ``bound``, else H of e sinh H - H = M.

    Newton's method from a start at which the function is convex and too large, so that it descends
    to the root; it stops where rounding ends the descent.
    """
    size = np.abs(mean)
    linear_bound = np.arcsinh(size / np.maximum(e - 1.0, LEAST_DIVISOR))
    cubic_bound = np.cbrt(6.0 * size / np.where(bound, 1.0, e))  # sinh H - H >= H^3 / 6
    anomaly = np.where(bound, np.minimum(size + e, np.pi), np.minimum(linear_bound, cubic_bound))
    for _ in range(MAX_KEPLER_ITERATIONS):
        value = (
            np.where(bound, anomaly - e * np.sin(anomaly), e * np.sinh(anomaly) - anomaly) - size
        )
        slope = np.where(bound, 1.0 - e * np.cos(anomaly), e * np.cosh(anomaly) - 1.0)
        new_anomaly = np.maximum(anomaly - value / slope, 0.0)
        anomaly, anomaly_before = np.where(new_anomaly < anomaly, new_anomaly, anomaly), anomaly
        if np.array_equal(anomaly, anomaly_before, equal_nan=True):
            break
    return np.copysign(anomaly, mean)


def _angle(x: Array) -> Array:
    """x reduced to [0, 2 pi)."""
    reduced = np.mod(x, TWO_PI)
    return np.where(reduced == TWO_PI, 0.0, reduced)


def _nbody(run: Trajectory) -> NBody:
    if not isinstance(run, Trajectory):
        raise TypeError(f"run must be a galvi.Trajectory; received {shown(run)}.")
    system = run.problem.system
    if not isinstance(system, NBody):
        raise ValueError(
            "orbits about a body need N bodies that attract each other; received a "
            f"{type(system).__name__} system. Use galvi.NBody."
        )
    return system


def _centre(system: NBody, centre: int | None) -> int:
    if centre is None:
        return int(np.argmax(system.masses))
    return input_checks.whole("centre", centre, 0, system.masses.size - 1)
