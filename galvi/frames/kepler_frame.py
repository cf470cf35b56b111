"""The frame that moves with Kepler's orbits in Jacobi coordinates."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from galvi import input_checks
from galvi.arrays import Array
from galvi.extended_precision import decimals, extended_precision, rounded
from galvi.frames.frame import EVEN, Motion
from galvi.kernels.compile.function_pointers import addresses
from galvi.kernels.lanes.frames import universal
from galvi.kernels.lanes.frames.collocation import DRIFT, LEAVE, RATES
from galvi.kernels.lanes.frames.kepler import rows_of_kepler
from galvi.kernels.lanes.frames.kepler_functions import FUNCTIONS
from galvi.kernels.lanes.vectors import LANES
from galvi.problem import Problem
from galvi.systems.nbody import NBody

FLAT = 0.45  # half of what planets need, whose orbits may change
ROUNDEST = 0.9  # largest eccentricity of the orbit on which nodes are placed
CORRECTIONS = 60


@dataclass(frozen=True)
class KeplerFrame:
    """Kepler's orbits of `NBody` systems about their heaviest body, done exactly.

    In Jacobi coordinates, planets in the order of their orbits at the start: the frame holds the
    attraction of all that is inside each orbit, and collocation what is left.

    passes  of a step's iteration; None: as many as the tolerance needs at the start. Two are
            accurate where planets are light, but let the energy drift slowly
    even    whether nodes are Gauss nodes in time; else in the eccentric anomaly of the innermost
            orbit at the start, moved towards each other at the step's middle

    Every body needs a bound orbit, and a step at most about one revolution of the innermost one.
    """

    passes: int | None = None
    even: bool = False

    def __post_init__(self) -> None:
        if self.passes is not None:
            object.__setattr__(self, "passes", input_checks.whole("passes", self.passes))

    @property
    def name(self) -> str:
        """For titles and tables."""
        return "Kepler frame"

    @property
    def reversible(self) -> bool:
        """See `Frame`."""
        return self.even

    @property
    def keeps(self) -> str:
        """See `Frame`."""
        return "it keeps the linear and the angular momentum"

    def refusal(self, problem: Problem) -> str:
        """See `Frame`."""
        system: Any = problem.system
        if not isinstance(system, NBody) or system.masses.size < 2:
            kind = type(system).__name__
            what = "one body" if isinstance(system, NBody) else f"a {kind} system"
            return (
                f"a KeplerFrame needs an NBody system of at least two bodies; received {what}. Use "
                f"another chart."
            )
        found = _hierarchy(problem)
        if not np.all(found.axes > 0.0):
            body = _name(problem, found.bodies[1 + int(np.argmin(found.axes > 0.0))])
            return (
                f"a KeplerFrame needs bound orbits about the heaviest body; received one of body "
                f"{body} that is not, at the start. Use another chart."
            )
        return ""

    def rows(self, problem: Problem) -> int:
        """See `Frame`."""
        return problem.q0.size - problem.q0.shape[1]

    def enter(self, problem: Problem) -> Array:
        """See `Frame`."""
        found = _hierarchy(problem)
        n, D = len(found.bodies) - 1, problem.q0.shape[1]
        state = np.zeros((8, problem.q0.size + LANES))
        state[0, : problem.q0.size], state[2, : problem.q0.size] = (
            problem.q0.ravel(), problem.v0.ravel(),
        )  # fmt: skip
        for row, exact in ((4, found.places), (6, found.speeds)):
            entries = np.concatenate([exact[1:].T.ravel(), exact[0]])
            state[row, : D * n + D] = rounded(entries)
            with extended_precision():
                state[row + 1, : D * n + D] = rounded(entries - decimals(rounded(entries)))
        return state

    def motion(self, problem: Problem, step: float, c: Array) -> Motion:
        """See `Frame`."""
        found = _hierarchy(problem)
        D, functions = problem.q0.shape[1], FUNCTIONS[problem.q0.shape[1]]
        last = max(
            np.flatnonzero(_farthest(found, step) > FLAT), default=-1
        )  # of those that turn far
        head = [step, found.numbers[0], (int(last) + 2) // 2]
        numbers = np.concatenate([head, found.numbers[1:], np.array(found.bodies, dtype=float)])
        pointers = addresses(*zip(functions, (RATES, DRIFT, LEAVE), strict=True))
        clock = EVEN if self.even else _clock(found, step)
        n = len(found.bodies) - 1
        places, speeds = (
            np.linalg.norm(np.array(exact[1:], dtype=float), axis=1)
            for exact in (found.places, found.speeds)
        )
        circular = np.sqrt(found.numbers[1 : 1 + n] / places)  # of a body that starts at rest
        speeds = np.where(speeds > 0.0, speeds, circular)
        sizes = np.concatenate([np.tile(places, D), np.tile(speeds, D)])
        stretch = 0.0 if self.even else _stretch(clock[0], c)
        return Motion(pointers, functions, numbers, rows_of_kepler(D) * n, n, sizes, clock, stretch)

    def flow(self, problem: Problem, w: Array, t: Array) -> Array:
        """See `Frame`."""
        found = _hierarchy(problem)
        n, D = len(found.bodies) - 1, problem.q0.shape[1]
        mu = found.numbers[1 : 1 + n]
        share = found.numbers[1 + 2 * n : 1 + 3 * n]
        q, v = (w[:, half, : D * n].reshape(-1, D, n) for half in range(2))
        Q = _kepler(mu, q, v, t[:, None])
        inner = np.zeros_like(Q[:, :, 0])
        places = []
        for i in range(n):
            places.append(inner + Q[:, :, i])
            inner = inner + share[i] * Q[:, :, i]
        centre = slice(D * n, D * n + D)
        star = w[:, 0, centre] + t[:, None] * w[:, 1, centre] - inner
        out = np.empty((len(t), n + 1, D), dtype=Q.dtype)
        out[:, found.bodies[0]] = star
        for body, place in zip(found.bodies[1:], places, strict=True):
            out[:, body] = star + place
        return out


class Hierarchy(NamedTuple):
    """Jacobi coordinates of a problem, n planets in the order of their orbits.

    bodies          (n + 1,) the star and the planets, among the problem's bodies
    places, speeds  (n + 1, D) of decimals: of the barycentre, then Jacobi's
    axes            (n,) semi-major axes in the frame; not positive for an orbit that is not bound
    eccentricities  (n,)
    phase           mean anomaly of the innermost orbit at the start over 2 pi
    numbers         as in galvi.kernels.lanes.frames.kepler, without h
    """

    bodies: list[int]
    places: Any
    speeds: Any
    axes: Array
    eccentricities: Array
    phase: float
    numbers: Array


@lru_cache(maxsize=32)
def _hierarchy(problem: Problem) -> Hierarchy:
    system: Any = problem.system
    masses, q, v = system.G * system.masses, problem.q0, problem.v0
    star = int(np.argmax(masses))
    others = [i for i in range(masses.size) if i != star]
    gap, speed = q[others] - q[star], v[others] - v[star]
    distance = np.linalg.norm(gap, axis=1)
    whole = masses[star] + masses[others]
    inverse = 2.0 / distance - np.sum(speed**2, axis=1) / whole
    rank = np.where(inverse > 0.0, 1.0 / np.where(inverse > 0.0, inverse, 1.0), np.inf)
    bodies = [star, *(others[k] for k in np.lexsort((distance, rank)))]
    with extended_precision():
        m = decimals(system.G) * decimals(system.masses)
        m = m[bodies]
        inner = np.array([sum(m[: i + 1]) for i in range(len(m))])  # M_0, M_1, ...
        jacobi = []
        for exact in (decimals(q)[bodies], decimals(v)[bodies]):
            centre, rows = exact[0], []
            for i in range(1, len(m)):
                rows.append(exact[i] - centre)
                centre = centre + (m[i] / inner[i]) * rows[-1]
            jacobi.append(np.array([centre, *rows]))
        M, before = inner[1:], inner[:-1]
        star_share = m[0] / before
        blocks = [
            M,
            m[1:],
            m[1:] / M,
            star_share,
            (before - m[0]) / before,
            M / before,
            1 / before,
            1 / M,
        ]
        numbers = np.concatenate([rounded(m[:1]), *(rounded(block) for block in blocks)])
    Q, V = (np.array(exact[1:], dtype=float) for exact in jacobi)
    mu = np.array(M, dtype=float)
    r = np.linalg.norm(Q, axis=1)
    axes = 1.0 / (2.0 / r - np.sum(V**2, axis=1) / mu)
    sine = np.sum(Q * V, axis=1) / np.sqrt(mu * np.abs(axes))  # e sin u, and e cos u
    cosine = 1.0 - r / axes
    e, u = np.hypot(sine, cosine), math.atan2(sine[0], cosine[0])
    phase = (u - float(e[0]) * math.sin(u)) / (2.0 * math.pi)
    places, speeds = jacobi
    return Hierarchy(bodies, places, speeds, axes, e, phase, numbers)


def _farthest(found: Hierarchy, step: float) -> Array:
    """Bounds of |beta X^2| in half a step, (n,)."""
    mu = found.numbers[1 : 1 + found.axes.size]
    pace = np.sqrt(mu / found.axes**3) / np.maximum(1.0 - found.eccentricities, 0.01)
    return (0.5 * step * pace) ** 2


def _stretch(turns: float, c: Array) -> float:
    """How far nodes are moved: in proportion to short steps, so that the order is that of Gauss.

    Long steps are limited by the ends of the step, where polynomials know most; the limits were
    found best of several for 8 and 16 nodes on the planets.
    """
    most = 0.78 if c.size <= LANES else 0.86
    return most * abs(turns) / math.hypot(turns, 0.2)


def _clock(found: Hierarchy, step: float) -> tuple[float, float, float]:
    """The clock of the innermost orbit; `EVEN` where a step is not short enough for it."""
    turns = step * math.sqrt(found.numbers[1] / found.axes[0] ** 3) / (2.0 * math.pi)
    return turns, min(float(found.eccentricities[0]), ROUNDEST), found.phase


def _kepler(mu: Array, q: Array, v: Array, t: Array) -> Array:
    """Q (k, D, n) after times t (k, 1) from q and v; complex numbers give the derivative."""
    r0 = np.sqrt(np.sum(q * q, axis=1))
    eta, beta = np.sum(q * v, axis=1), 2.0 * mu / r0 - np.sum(v * v, axis=1)
    zeta = mu - beta * r0
    X = t * beta / mu
    for _ in range(CORRECTIONS):
        G = universal.universal(beta, X, 10)
        step = universal.far_correction(beta, r0, eta, zeta, X, G, t, lambda x, y: x / y, np.sqrt)
        X = X + step
        if np.all(np.abs(step) <= 1e-15 * np.abs(X)):
            break
    _, G2, G3, _, _ = universal.universal(beta, X, 10)
    return q * (1.0 - mu * G2 / r0)[:, None] + v * (t - mu * G3)[:, None]


def _name(problem: Problem, body: int) -> Any:
    names: Any = problem.parameters.get("bodies")
    fits = isinstance(names, (tuple, list)) and len(names) == problem.q0.shape[0]
    return names[body] if fits else body
