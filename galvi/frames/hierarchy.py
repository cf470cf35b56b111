"""Hierarchies of bodies that move about each other, and their Kepler orbits.

Orbits are analytic functions of real or complex arrays, for derivatives by complex steps.
"""

from __future__ import annotations

import math
from decimal import Decimal
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from galvi.arrays import Array, read_only
from galvi.extended_precision import decimals, extended_precision, rounded
from galvi.lanes.frames import universal
from galvi.problem import Problem

MAX_CORRECTIONS = 60


class Orbits(NamedTuple):
    """Positions and velocities (k, D, n) after a time, and terms (k, n) for `pull_back_changes`."""

    positions: Array
    velocities: Array
    pull_back_terms: tuple[Array, Array, Array, Array, Array]


@np.errstate(invalid="ignore", over="ignore")  # steps that failed hold NaN
def orbits(mu: Array, q: Array, v: Array, t: Array) -> Orbits:
    """The orbits after times t (k, 1) from q and v (k, D, n)."""
    r0 = np.sqrt(np.sum(q * q, axis=1))
    eta, beta = np.sum(q * v, axis=1), 2.0 * mu / r0 - np.sum(v * v, axis=1)
    zeta = mu - beta * r0
    X, has_converged = t * beta / mu, False
    reach = universal.LARGEST_ANOMALY_LEAD / np.sqrt(np.real(beta))
    low, high = np.real(X) - reach, np.real(X) + reach
    for _ in range(MAX_CORRECTIONS):
        G = universal.universal(beta, X, universal.SERIES_TERMS)
        step = universal.far_correction(beta, r0, eta, zeta, X, G, t, lambda x, y: x / y, np.sqrt)
        new_X, low, high = universal.bracketed(np.real(X), np.real(step), low, high, np.where)
        X = new_X + 1j * np.imag(X + step) if np.iscomplexobj(X) else new_X
        if has_converged:
            break
        has_converged = bool(
            np.all(np.abs(step) <= 1e-15 * np.abs(X))
        )  # imaginary parts need one more
    G1, G2, G3, _, _ = G = universal.universal(beta, X, universal.SERIES_TERMS)
    r = r0 + eta * G1 + zeta * G2
    Q = q * (1.0 - mu * G2 / r0)[:, None] + v * (t - mu * G3)[:, None]
    V = v * (1.0 - mu * G2 / r)[:, None] - q * (mu * G1 / (r * r0))[:, None]
    return Orbits(Q, V, (G2, universal.lag(mu, X, G, t), mu * G3 - t, r / mu, 1.0 / r0))


def pull_back_changes(
    mu: Array, q: Array, v: Array, after: Orbits, a: Array
) -> tuple[Array, Array]:
    """The changes (k, D, n) of q and v for changes a of the velocities after the orbits."""
    vectors = (q, v, after.positions, after.velocities, a)
    q0, v0, Q, V, velocity_change = (np.moveaxis(x, 1, 0) for x in vectors)
    changes = universal.pull_back(mu, *after.pull_back_terms, q0, v0, Q, V, velocity_change, _dot)
    positions, velocities = (np.stack(part, axis=1) for part in changes)
    return positions, velocities


def attraction(strengths: Array, q: Any) -> Array:
    """The accelerations of point masses at q (k, bodies, D), of the given masses times G."""
    gap = q[:, None] - q[:, :, None]  # from the second to the third of the axes
    square = np.sum(gap * gap, axis=-1)
    bodies = np.arange(q.shape[1])
    square[:, bodies, bodies] = 1.0
    return np.einsum("j,kijx->kix", strengths, gap * (square**-1.5)[..., None])


def _dot(a: Any, b: Any) -> Any:
    return sum(x * y for x, y in zip(a, b, strict=True))


TINY = Decimal("1e-800")  # replaces a mass or a distance of 0

Nested = Any  # number or name of a body, or a tuple of such parts, inner ones first


class Hierarchy(NamedTuple):
    """Generalised Jacobi coordinates of a problem: n pairs of n + 1 bodies, inner pairs first.

    Pair i joins bodies first <= a < middle and middle <= b < end in the order of ``bodies``; its
    position is that of the latter's barycentre relative to the former's.

    Attributes
    ----------
    bodies
        n + 1 numbers of the problem's bodies
    pairs : array, shape (n, 3)
        first, middle and end of each pair
    positions, velocities : array, shape (n + 1, D)
        decimals at the start, of the barycentre and then of the pairs
    axes : array, shape (n,)
        semi-major axes in the frame; negative or infinite for an orbit that is not bound
    eccentricities : array, shape (n,)
    masses : array, shape (3 n + 1,)
        G times the masses of the bodies (n + 1,), G times those of pairs (n,), and the second
        side's share of the pairs' masses (n,); the first numbers in
        galvi.lanes.frames.kepler_motion
    """

    bodies: list[int]
    pairs: Array
    positions: Any
    velocities: Any
    axes: Array
    eccentricities: Array
    masses: Array

    @property
    def fastest(self) -> int:
        """The index of the pair with the shortest period."""
        return int(np.argmin(self.axes**3 / self.pair_masses))

    @property
    def pair_masses(self) -> Array:
        """G times the masses (n,) of pairs."""
        return self.masses[1 + len(self.pairs) :][: len(self.pairs)]

    @property
    def share(self) -> Array:
        """The share (n,) of the second side in the pairs' masses."""
        return self.masses[1 + 2 * len(self.pairs) :]


def number_hierarchy(problem: Problem, hierarchy: Nested) -> tuple[Nested, str]:
    """The hierarchy as numbers of bodies, with the massless ones that it leaves out, and ""; for a
    hierarchy that does not fit the problem, () and a clause on the reason.

    Massless bodies that are left out move about the first part, and come before parts that are
    farther from it.
    """
    names, system = problem.body_names(), problem.system
    masses: Array = system.masses  # type: ignore[attr-defined]

    def number(part: Nested) -> Nested:
        if isinstance(part, tuple):
            return tuple(number(inner) for inner in part)
        if part in names and isinstance(part, str):
            return names.index(part)
        return part

    def missing(part: Nested) -> bool:
        return isinstance(part, str) or not 0 <= part < masses.size

    numbered = number(hierarchy)
    listed_bodies = leaves(numbered)
    unknown = [part for part in listed_bodies if missing(part)]
    if unknown:
        return (), f"one with {unknown[0]!r}, which is none of {names}"
    listed_twice = [names[part] for part in listed_bodies if listed_bodies.count(part) > 1]
    unlisted = [i for i in range(masses.size) if i not in listed_bodies]
    unlisted_heavy = [names[i] for i in unlisted if masses[i] > 0.0]
    if listed_twice or unlisted_heavy:
        return (
            (),
            f"one with {listed_twice[0]} twice"
            if listed_twice
            else f"one without {unlisted_heavy[0]}",
        )

    def centre(part: Nested) -> Array:
        inside = leaves(part)
        mass = float(np.sum(masses[inside]))
        weights = masses[inside] / mass if mass > 0.0 else np.full(len(inside), 1 / len(inside))
        return weights @ problem.q0[inside]

    parts = [*numbered]
    for body in unlisted:
        distances = [float(np.linalg.norm(centre(part) - centre(parts[0]))) for part in parts[1:]]
        distance = float(np.linalg.norm(problem.q0[body] - centre(parts[0])))
        parts.insert(1 + sum(inner < distance for inner in distances), body)
    bodies, pairs = _flatten(tuple(parts))
    for first, _middle, end in pairs:
        if not np.any(masses[bodies[first:end]] > 0.0):
            return (), f"one that joins {names[bodies[first]]} and others, all of them massless"
    return tuple(parts), ""


def leaves(part: Nested) -> list[Any]:
    """The bodies of a part."""
    return [body for inner in part for body in leaves(inner)] if isinstance(part, tuple) else [part]


@lru_cache(maxsize=32)
def held_pairs(nested: Nested) -> Array:
    """The matrix (bodies, bodies) that is 1 for two bodies of which one is in the first part of the
    smallest part with both, and else 0: other bodies of that part do not move about each other."""
    count = len(leaves(nested))
    held = np.zeros((count, count))

    def visit(part: Nested) -> None:
        if isinstance(part, tuple):
            first, *outer = (leaves(inner) for inner in part)
            for bodies in outer:
                held[np.ix_(first, bodies)] = held[np.ix_(bodies, first)] = 1.0
            for inner in part:
                visit(inner)

    visit(nested)
    return read_only(held)


@lru_cache(maxsize=32)
def around_heaviest(problem: Problem) -> Nested:
    """The number of a problem's heaviest body, then those of the others in the order of their
    orbits about it; orbits that are not bound come last."""
    system: Any = problem.system
    masses, q, v = system.G * system.masses, problem.q0, problem.v0
    star = int(np.argmax(masses))
    planets = [i for i in range(masses.size) if i != star]
    relative_positions, relative_velocities = q[planets] - q[star], v[planets] - v[star]
    distance = np.linalg.norm(relative_positions, axis=1)
    mass_sums = masses[star] + masses[planets]
    with np.errstate(all="ignore"):  # states that are no orbits come last
        inverse = 2.0 / distance - np.sum(relative_velocities**2, axis=1) / mass_sums
    rank = np.where(inverse > 0.0, 1.0 / np.where(inverse > 0.0, inverse, 1.0), np.inf)
    return star, *(planets[k] for k in np.lexsort((distance, rank)))


def _flatten(nested: Nested) -> tuple[list[int], Array]:
    """The bodies of a hierarchy in their order, and first, middle and end of pairs (n, 3)."""
    bodies: list[int] = []
    pairs: list[tuple[int, int, int]] = []

    def visit(part: Nested) -> None:
        if not isinstance(part, tuple):
            bodies.append(part)
            return
        first = len(bodies)
        visit(part[0])
        for outer in part[1:]:
            middle = len(bodies)
            visit(outer)
            pairs.append((first, middle, len(bodies)))

    visit(nested)
    return bodies, np.array(pairs)


@lru_cache(maxsize=32)
def hierarchy_of(problem: Problem, nested: Nested) -> Hierarchy:
    """The hierarchy at a problem's start."""
    bodies, pairs = _flatten(nested)
    system: Any = problem.system
    with extended_precision():
        m = (decimals(system.G) * decimals(system.masses))[bodies]
        mass, mass_sums, share = list(m), [], []
        for first, middle, _ in pairs:
            mass_sums.append(mass[first] + mass[middle])
            share.append(mass[middle] / mass_sums[-1])
            mass[first] = mass_sums[-1]
        masses = np.concatenate(
            [rounded(m), rounded(np.array(mass_sums)), rounded(np.array(share))]
        )
    positions, velocities = (jacobi(problem, bodies, pairs, x) for x in (problem.q0, problem.v0))
    with extended_precision():  # near a parabola, 2 / r - v.v / mu cancels
        Q, V, mu = positions[1:], velocities[1:], np.array([max(x, TINY) for x in mass_sums])
        r = np.array([max(x.sqrt(), TINY) for x in np.sum(Q * Q, axis=1)])
        inverse = 2 / r - np.sum(V * V, axis=1) / mu
        cosine, sine = 1 - r * inverse, np.sum(Q * V, axis=1)  # e cos u, and e sin u times a root
        square = cosine * cosine + sine * sine * abs(inverse) / mu
        inverse, e = (rounded(x) for x in (inverse, [x.sqrt() for x in square]))
    with np.errstate(divide="ignore"):
        axes = 1.0 / inverse
    return Hierarchy(bodies, pairs, positions, velocities, axes, e, masses)


def jacobi(problem: Problem, bodies: list[int], pairs: Array, x: Array) -> Any:
    """Positions, or velocities, of the barycentre and of pairs: decimals (n + 1, D), from those x
    of the bodies."""
    system: Any = problem.system
    with extended_precision():
        mass = list((decimals(system.G) * decimals(system.masses))[bodies])
        centres, rows = list(decimals(x)[bodies]), []
        for first, middle, _ in pairs:
            rows.append(centres[middle] - centres[first])
            mass_sum = mass[first] + mass[middle]
            centres[first] = centres[first] + (mass[middle] / mass_sum) * rows[-1]
            mass[first] = mass_sum
    return np.array([centres[0], *rows])


def mean_anomaly(hierarchy: Hierarchy, pair: int) -> float:
    """The mean anomaly of a pair at the start over 2 pi."""
    Q, V = (
        np.array(exact[1 + pair], dtype=float)
        for exact in (hierarchy.positions, hierarchy.velocities)
    )
    axis, mu = float(hierarchy.axes[pair]), float(hierarchy.pair_masses[pair])
    sine = float(Q @ V) / math.sqrt(mu * abs(axis))
    u = math.atan2(sine, 1.0 - float(np.linalg.norm(Q)) / axis)
    return (u - float(hierarchy.eccentricities[pair]) * math.sin(u)) / (2.0 * math.pi)
