"""Celestial forces by textbook formulas, independent of galvi's kernels.

q and v have shape (bodies, 2 or 3), of numbers or of another engine's expressions.
"""

from __future__ import annotations

from functools import singledispatch
from typing import Any

import numpy as np

import galvi
from galvi.arrays import Array


def accelerations(system: galvi.NBody, q: Array, v: Array, t: float) -> Array:
    """Accelerations by a system's forces, without gravity, (bodies, 3)."""
    shape = system.masses.size, -1
    q, v = (np.pad(x.reshape(shape), ((0, 0), (0, 3 - x.size // shape[0]))) for x in (q, v))
    total = sum((_of(force, system, q, v, t) for force in system.forces), np.zeros_like(q))
    return np.asarray(total)


def length(x: Array) -> Any:
    """Lengths (...) of vectors (..., D)."""
    return np.sum(x * x, axis=-1) ** 0.5


@singledispatch
def _of(force: Any, system: galvi.NBody, q: Array, v: Array, t: float) -> Array:
    raise TypeError(f"there is no formula here for {force!r}.")


def _pairs(system: galvi.NBody, source: int, q: Array, pull: Any) -> Array:
    """Accelerations (bodies, 3): pull(x) of each body but the source, x its position relative to
    the source, and the recoil of the source."""
    acceleration = np.zeros_like(q)
    for k, mass in enumerate(system.masses):
        if k != source:
            acceleration[k] = pull(q[k] - q[source])
            acceleration[source] -= mass / system.masses[source] * acceleration[k]
    return acceleration


@_of.register
def _(force: galvi.Oblateness, system: galvi.NBody, q: Array, v: Array, t: float) -> Array:
    mu, R, pole = system.G * system.masses[force.body], force.radius, np.array(force.pole)

    def pull(x: Array) -> Array:
        r = length(x)
        up = x / r
        sine = up @ pole
        north = pole - sine * up  # cos(latitude) times the unit vector to the north
        p2, p4 = 1.5 * sine**2 - 0.5, (35 * sine**4 - 30 * sine**2 + 3) / 8
        radial = 3 * force.J2 * (R / r) ** 2 * p2 + 5 * force.J4 * (R / r) ** 4 * p4
        slope = 3 * force.J2 * (R / r) ** 2 * sine
        slope += force.J4 * (R / r) ** 4 * (35 * sine**3 - 15 * sine) / 2
        return mu / r**2 * (radial * up - slope * north)

    return _pairs(system, force.body, q, pull)


@_of.register
def _(force: galvi.PowerLaw, system: galvi.NBody, q: Array, v: Array, t: float) -> Array:
    def pull(x: Array) -> Array:
        r = length(x)
        return force.strength * r**force.power * x / r

    return _pairs(system, force.source, q, pull)


@_of.register
def _(force: galvi.Relativity, system: galvi.NBody, q: Array, v: Array, t: float) -> Array:
    c, source, mu = force.c, force.source, system.G * system.masses
    if force.form == "EIH":
        return _einstein_infeld_hoffmann(mu, c, q, v)
    M = mu[source]
    if force.form == "potential":
        return _pairs(system, source, q, lambda x: -6 * M**2 / c**2 * x / (x @ x) ** 2)
    acceleration = np.zeros_like(q)
    for k in range(len(q)):
        if k != source:
            x, w = q[k] - q[source], v[k] - v[source]
            r = length(x)
            up, rate = x / r, w @ x / r
            acceleration[k] = M / (c * r) ** 2 * ((4 * M / r - w @ w) * up + 4 * rate * w)
            acceleration[source] -= mu[k] / M * acceleration[k]
    return acceleration


def _einstein_infeld_hoffmann(mu: Array, c: float, q: Array, v: Array) -> Array:
    """The accelerations of order c^-2 of two and more bodies, term by term (Will, Theory and
    Experiment in Gravitational Physics (1993), 6.80), with Newton's for the accelerations on the
    right."""
    n = len(mu)
    gaps = q[:, None] - q  # from the second to the first
    r, off_diagonal = np.eye(n).astype(gaps.dtype), ~np.eye(n, dtype=bool)
    r[off_diagonal] = length(gaps[off_diagonal])
    pull = -np.sum(mu[:, None] * gaps / r[:, :, None] ** 3, axis=1)
    acceleration = np.zeros_like(q)
    for a in range(n):
        for b in (k for k in range(n) if k != a):
            x, w = gaps[a, b], v[a] - v[b]
            up = x / r[a, b]
            bracket = 4 * sum(mu[d] / r[a, d] for d in range(n) if d != a)
            bracket += sum(mu[d] / r[b, d] for d in range(n) if d != b)
            bracket += -v[a] @ v[a] + 4 * v[a] @ v[b] - 2 * v[b] @ v[b] + 1.5 * (v[b] @ up) ** 2
            bracket += 0.5 * (x @ pull[b])
            acceleration[a] += mu[b] * x / r[a, b] ** 3 * bracket
            acceleration[a] += mu[b] / r[a, b] ** 3 * (x @ (4 * v[a] - 3 * v[b])) * w
            acceleration[a] += 3.5 * mu[b] * pull[b] / r[a, b]
    return acceleration / c**2


@_of.register
def _(force: galvi.Radiation, system: galvi.NBody, q: Array, v: Array, t: float) -> Array:
    x, w = q - q[force.source], v - v[force.source]
    r = length(x)
    r[force.source] = 1.0
    up = x / r[:, None]
    push = force.beta * system.G * system.masses[force.source] / r**2
    doppler = 1 - np.sum(w * up, axis=1) / force.c
    return np.asarray(push[:, None] * (doppler[:, None] * up - w / force.c))


@_of.register
def _(force: galvi.Drag, system: galvi.NBody, q: Array, v: Array, t: float) -> Array:
    acceleration, dragged = np.zeros_like(v), np.flatnonzero(force.coefficients)
    size = force.coefficients[dragged] * length(v[dragged]) ** (force.power - 1.0)
    acceleration[dragged] = -size[:, None] * v[dragged]
    return acceleration


@_of.register
def _(force: galvi.Tides, system: galvi.NBody, q: Array, v: Array, t: float) -> Array:
    """The pull of the bulge as a force between two points, radial and tangential (Hut 1981, eq.
    8)."""
    acceleration, body = np.zeros_like(q), force.body
    for k, mass in enumerate(system.masses):
        if k == body or (force.raised_by is not None and k != force.raised_by):
            continue
        x, w = q[k] - q[body], v[k] - v[body]
        r = length(x)
        up = x / r
        size = 3 * system.G * mass**2 / r**2 * (force.radius / r) ** 5 * force.k2
        turning = np.cross(np.array(force.spin), x) - (w - (w @ up) * up)
        onto = -size * (1 + 3 * (w @ up) / r * force.lag) * up + size * force.lag * turning / r
        acceleration[k] += onto / mass
        acceleration[body] -= onto / system.masses[body]
    return acceleration


@_of.register
def _(force: galvi.Force, system: galvi.NBody, q: Array, v: Array, t: float) -> Array:
    mass = np.where(system.masses > 0.0, system.masses, 1.0)[:, None]
    return np.asarray(force.at(q, v, t) / mass)
