"""The frame that moves with Kepler's orbits in Jacobi coordinates."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, NamedTuple, cast

import numpy as np

from galvi import input_checks
from galvi.arrays import Array
from galvi.extended_precision import decimals, extended_precision, rounded
from galvi.frames.frame import EVEN, Motion, matrix_of
from galvi.frames.hierarchy import (
    Hierarchy,
    Nested,
    about_the_heaviest,
    attraction,
    held_pairs,
    hierarchy_of,
    jacobi,
    mean_anomaly,
    nested_in,
    orbits,
    pulled_back,
)
from galvi.input_checks import shown
from galvi.kernels.compile.function_pointers import addresses
from galvi.kernels.constants import COMPLEX_STEP
from galvi.kernels.forces.celestial import SOURCE, TARGET, WEIGHT, pulls
from galvi.lanes.frames import kepler_functions
from galvi.lanes.frames.collocation import DRIFT, LEAVE, RATES
from galvi.lanes.frames.hierarchy import rows_of_hierarchy
from galvi.lanes.frames.kepler import rows_of_planets
from galvi.lanes.frames.kepler_drift import LARGEST_ANOMALY_CHANGE
from galvi.lanes.frames.kepler_motion import ARGUMENT_HALVINGS, LEAST_DISTANCE_RATIO
from galvi.lanes.vectors import LANES
from galvi.problem import Problem
from galvi.systems.forces.celestial import Force
from galvi.systems.nbody import NBody

LARGEST_STRETCH = 0.45  # half of what planets need, whose orbits may change
# Eccentricity at the start, and its rounding: up to it a revolution errs by 4e-13 of the axis, and
# up to that of `LEAST_DISTANCE` by 9e-13 (measured by
# tests/properties/test_eccentric_orbits_in_frames.py).
MOST_ECCENTRIC = 0.9 + 1e-9
CLOCK = "clock=galvi.DynamicalTime()"
# |beta X^2| in half a step, for which the series of a pass are accurate.
LARGEST_ARGUMENT = 4.0**ARGUMENT_HALVINGS


@dataclass(frozen=True)
class KeplerFrame:
    """Kepler's orbits of `NBody` systems about their heaviest body, done exactly.

    In Jacobi coordinates, planets in the order of their orbits at the start: the frame has the
    attraction of the bodies inside each orbit, and collocation solves the remainder.

    Parameters
    ----------
    passes
        of a step's iteration; None: as many as the tolerance needs at the start. Two are accurate
        where planets are light, but let the energy drift slowly
    even
        whether nodes are Gauss nodes in time; else in the eccentric anomaly of the innermost orbit
        at the start, moved towards each other at the step's middle
    hierarchy
        nested tuples of bodies, by number or by the problem's names for them, for others than one
        star with planets: ("Sun", ("Earth", "Moon"), "Mars") or ((0, 1), (2, 3)). Each part moves
        about all parts before it. It has all bodies with a mass; massless ones that it leaves out
        move about the first part. None: the heaviest body and its planets

    Notes
    -----
    Forces of position that are in the Lagrangian act besides. Every body needs a bound orbit of
    eccentricity up to 0.9, and a step at most 1.27 revolutions of the fastest one, or 0.75 where
    that is so eccentric and anything else acts. Two bodies under gravity alone are done exactly.

    Examples
    --------
    >>> frame = galvi.KeplerFrame()
    >>> method = galvi.Galerkin(galvi.Polynomials(8), galvi.gauss(8), chart=frame)
    >>> run = galvi.integrate(galvi.problems.outer_solar_system(), method, step=400.0, steps=100)
    >>> run.status, run.engine
    ('Completed.', 'frame')
    """

    passes: int | None = None
    even: bool = False
    hierarchy: Any = None

    def __post_init__(self) -> None:
        if self.passes is not None:
            object.__setattr__(self, "passes", input_checks.whole("passes", self.passes))
        object.__setattr__(self, "even", input_checks.flag("even", self.even))
        if self.hierarchy is not None:
            object.__setattr__(self, "hierarchy", _nested(self.hierarchy))

    @property
    def name(self) -> str:
        """For titles and tables."""
        return "Kepler frame"

    @property
    def reversible(self) -> bool:
        """See `Frame`."""
        return self.even

    @property
    def conserved(self) -> str:
        """See `Frame`."""
        return "it keeps the linear and the angular momentum"

    def refusal(self, problem: Problem) -> str:
        """See `Frame`."""
        system: Any = problem.system
        if not isinstance(system, NBody) or system.masses.size < 2:
            kind = type(system).__name__
            received = "one body" if isinstance(system, NBody) else f"a {kind} system"
            return (
                f"a KeplerFrame needs an NBody system of at least two bodies; received {received}. "
                f"Use another chart."
            )
        if not system.acting.conserve:
            unsupported = {
                type(force).__name__
                for force in system.forces
                if force.takes_velocity or isinstance(force, Force)
            }
            return (
                f"a KeplerFrame takes gravity and the forces that have an energy (Oblateness, "
                f"PowerLaw, Relativity of the form 'potential'); received an NBody system with "
                f"{', '.join(sorted(unsupported))}. Use another chart."
            )
        if self.hierarchy is not None:
            wrong = nested_in(problem, self.hierarchy)[1]
            if wrong:
                return (
                    f"the hierarchy of a KeplerFrame must name every body that has a mass once; "
                    f"received {wrong}."
                )
        hierarchy = self._hierarchy(problem)
        bound = _bound(hierarchy)
        if not np.all(bound):
            inner = "the heaviest body" if self.hierarchy is None else "what its hierarchy names"
            bodies = _named(problem, hierarchy, int(np.argmin(bound)))
            return (
                f"a KeplerFrame needs bound orbits about {inner}; received one of {bodies} that is "
                f"not, at the start. Use another chart."
            )
        eccentric = _above(problem, hierarchy, MOST_ECCENTRIC)
        if eccentric:
            return (
                f"a KeplerFrame needs orbits of eccentricity up to {MOST_ECCENTRIC:.3g}, beyond "
                f"which it loses digits; received {eccentric}, at the start. Use {CLOCK}."
            )
        return ""

    def leaves(self, problem: Problem, step: float) -> str:
        """See `Frame`."""
        hierarchy = self._hierarchy(problem)
        bound = _bound(hierarchy)
        if not np.all(bound):
            bodies = _named(problem, hierarchy, int(np.argmin(bound)))
            return (
                f"the orbit of {bodies} is not bound any more, which the Kepler frame does not "
                f"cover. Use another chart from there on."
            )
        eccentric = _above(problem, hierarchy, 1.0 - LEAST_DISTANCE_RATIO)
        if eccentric:
            return (
                f"an orbit is more eccentric than the Kepler frame covers: {eccentric}. Use "
                f"{CLOCK} from there on."
            )
        turns = abs(step) * np.sqrt(hierarchy.pair_masses / hierarchy.axes**3) / (2.0 * math.pi)
        k, arguments = hierarchy.fastest, _farthest(hierarchy, step)
        if turns[k] < LARGEST_ANOMALY_CHANGE / (2.0 * math.pi):
            k = int(np.argmax(arguments))
            if _holds_all_forces(problem) or arguments[k] < LARGEST_ARGUMENT:
                return ""
        return (
            f"the step is {turns[k]:.3g} revolutions of {_named(problem, hierarchy, k)}, more than "
            f"the Kepler frame covers, which are 1.27, or 0.75 at eccentricity 0.9. Use a smaller "
            f"step."
        )

    def _nested_in(self, problem: Problem) -> Nested:
        if self.hierarchy is None:
            return about_the_heaviest(problem)
        return nested_in(problem, self.hierarchy)[0]

    def _hierarchy(self, problem: Problem) -> Hierarchy:
        return hierarchy_of(problem, self._nested_in(problem))

    def held_pairs(self, problem: Problem) -> Array:
        """1 for pairs of bodies that the frame moves about each other, (bodies, bodies)."""
        return held_pairs(self._nested_in(problem))

    def rows(self, problem: Problem) -> int:
        """See `Frame`."""
        return problem.q0.size - problem.q0.shape[1]

    def enter(self, problem: Problem, q: Array, v: Array) -> Array:
        """See `Frame`."""
        hierarchy, size = self._hierarchy(problem), q.size
        state = np.zeros((8, size + LANES))
        state[0, :size], state[2, :size] = q.ravel(), v.ravel()
        for row, x in ((4, q), (6, v)):
            exact = jacobi(problem, hierarchy.bodies, hierarchy.pairs, x)
            entries = np.concatenate([exact[1:].T.ravel(), exact[0]])
            state[row, :size] = rounded(entries)
            with extended_precision():
                state[row + 1, :size] = rounded(entries - decimals(rounded(entries)))
        return state

    def motion(self, problem: Problem, step: float, c: Array) -> Motion:
        """See `Frame`."""
        hierarchy, D = self._hierarchy(problem), problem.q0.shape[1]
        kind = PLANETS if self.hierarchy is None else NESTED
        last = max(
            np.flatnonzero(_farthest(hierarchy, step) > LARGEST_STRETCH), default=-1
        )  # of those that turn far
        numbers = np.concatenate(
            [
                [step, (int(last) + 2) // 2, len(hierarchy.pairs)],
                hierarchy.masses,
                *kind.blocks(hierarchy),
                1.0 / hierarchy.pair_masses,
                np.array(hierarchy.bodies, dtype=float),
                *_terms(problem, hierarchy),
            ]
        )
        functions, n = kind.functions[D], len(hierarchy.pairs)
        if _holds_all_forces(problem):
            functions = (kepler_functions.rates_of_two, *functions[1:])
        pointers = addresses(*zip(functions, (RATES, DRIFT, LEAVE), strict=True))
        clock = EVEN if self.even else _clock(hierarchy, step)
        places, speeds = (
            np.linalg.norm(np.array(exact[1:], dtype=float), axis=1)
            for exact in (hierarchy.places, hierarchy.speeds)
        )
        sizes = np.concatenate([np.tile(places, D), np.tile(speeds, D)])
        stretch = 0.0 if self.even else _stretch(clock[0], c)
        return Motion(pointers, functions, numbers, kind.rows(D) * n, n, sizes, clock, stretch)

    def flow(self, problem: Problem, w: Array, t: Array) -> Array:
        """See `Frame`."""
        hierarchy, D = self._hierarchy(problem), problem.q0.shape[1]
        q, v, centre = _parts(w[:, :2], hierarchy, D)
        Q = orbits(hierarchy.pair_masses, q, v, t[:, None]).places
        return _bodies(hierarchy, Q, centre[:, 0] + t[:, None] * centre[:, 1])

    def derivatives(self, problem: Problem, w: Array, t: float) -> tuple[Array, Array]:
        """See `Frame`; by complex steps."""
        hierarchy, D = self._hierarchy(problem), problem.q0.shape[1]
        d, n, system = problem.q0.size, len(hierarchy.pairs), cast(NBody, problem.system)
        nudged = w[None, :, :d] + 1j * COMPLEX_STEP * np.eye(2 * d).reshape(2 * d, 2, d)
        q, v, centre = _parts(nudged, hierarchy, D)
        after = orbits(hierarchy.pair_masses, q, v, np.full((2 * d, 1), t))
        bodies = _bodies(hierarchy, after.places, centre[:, 0] + t * centre[:, 1])
        pull = attraction(system.G * system.masses, bodies)
        pull += pulls(system.acting.terms, system.acting.poles, bodies)[0]
        into = matrix_of(self, problem)[: D * n]
        pair_pulls = (pull.reshape(2 * d, d) @ into.T).reshape(2 * d, D, n)
        cube = np.sum(after.places**2, axis=1)[:, None] ** 1.5
        perturbation = pair_pulls + hierarchy.pair_masses * after.places / cube
        slopes = pulled_back(hierarchy.pair_masses, q, v, after, perturbation)
        free = centre[:, 0] + t * centre[:, 1], centre[:, 1]
        ends = [
            np.concatenate([x.reshape(2 * d, D * n), y], axis=1)
            for x, y in zip((after.places, after.speeds), free, strict=True)
        ]
        rates = [
            np.concatenate([x.reshape(2 * d, D * n), 0.0 * y], axis=1)
            for x, y in zip(slopes, free, strict=True)
        ]
        motion, slope = (np.imag(np.concatenate(x, axis=1)).T / COMPLEX_STEP for x in (ends, rates))
        return motion, slope


def _holds_all_forces(problem: Problem) -> bool:
    """Whether the frame's orbits are the exact motion: two bodies without further forces."""
    system: Any = problem.system
    return bool(system.masses.size == 2 and not system.forces)


def _terms(problem: Problem, hierarchy: Hierarchy) -> tuple[Array, Array]:
    """The first term of each pair (n + 1,), and the terms in the frame's order."""
    system, n = cast(NBody, problem.system), len(hierarchy.pairs)
    rows = system.acting.terms.copy()
    rows[:, [SOURCE, TARGET]] = np.argsort(hierarchy.bodies)[rows[:, [SOURCE, TARGET]].astype(int)]
    rows[:, WEIGHT] = np.arange(len(rows)) >= system.acting.poles
    first, middle, end = hierarchy.pairs.T
    inner, outer = np.sort(rows[:, [SOURCE, TARGET]], axis=1).T[..., None]
    between = (first <= inner) & (inner < middle) & (middle <= outer) & (outer < end)
    pair = np.argmax(between, axis=1)
    starts = np.searchsorted(np.sort(pair), np.arange(n + 1)).astype(float)
    return starts, rows[np.argsort(pair, kind="stable")].ravel()


def _bound(hierarchy: Hierarchy) -> Array:
    """Which orbits are ellipses, (n,)."""
    return np.asarray(np.isfinite(hierarchy.axes) & (hierarchy.axes > 0.0))


def _above(problem: Problem, hierarchy: Hierarchy, limit: float) -> str:
    """The largest eccentricity and its bodies, if it is above ``limit``; else ""."""
    k = int(np.argmax(hierarchy.eccentricities))
    e = hierarchy.eccentricities[k]
    return f"{e:.12g} of {_named(problem, hierarchy, k)}" if e > limit else ""


def _named(problem: Problem, hierarchy: Hierarchy, pair: int) -> str:
    """The second side of a pair, in words."""
    _first, middle, end = hierarchy.pairs[pair]
    names = [str(problem.body_names()[hierarchy.bodies[k]]) for k in range(middle, end)]
    return f"bod{'y' if len(names) == 1 else 'ies'} {', '.join(names)}"


def _parts(w: Array, hierarchy: Hierarchy, D: int) -> tuple[Array, Array, Array]:
    """Places and velocities (k, D, n) of pairs, and both of the barycentre (k, 2, D)."""
    n = len(hierarchy.pairs)
    q, v = (w[:, half, : D * n].reshape(-1, D, n) for half in range(2))
    return q, v, w[:, :, D * n : D * n + D]


def _bodies(hierarchy: Hierarchy, Q: Array, centre: Array) -> Array:
    """The bodies' places (k, bodies, D) from those of pairs (k, D, n) and the barycentre's."""
    out = np.empty((len(Q), len(hierarchy.bodies), Q.shape[1]), dtype=Q.dtype)
    out[:, hierarchy.bodies[0]] = centre
    for i in range(len(hierarchy.pairs) - 1, -1, -1):
        first, second = (hierarchy.bodies[k] for k in hierarchy.pairs[i, :2])
        out[:, first] -= hierarchy.share[i] * Q[:, :, i]
        out[:, second] = out[:, first] + Q[:, :, i]
    return out


class Kind(NamedTuple):
    """The functions and numbers of planets about a star, or of other hierarchies.

    Attributes
    ----------
    functions
        by dimension, see galvi.lanes.frames.kepler_functions
    rows
        of work for each pair, from the dimension
    blocks
        the numbers of a hierarchy that are the frame's own
    """

    functions: Any
    rows: Any
    blocks: Any


def _of_planets(hierarchy: Hierarchy) -> list[Array]:
    with extended_precision():
        m = decimals(hierarchy.masses[: 1 + len(hierarchy.pairs)])
        inner = np.cumsum(m)
        M, before = inner[1:], inner[:-1]
        rows = m[0] / before, (before - m[0]) / before, M / before, 1 / before
        return [rounded(row) for row in rows]


def _of_pairs(hierarchy: Hierarchy) -> list[Array]:
    with extended_precision():
        first_share = rounded(1 - decimals(hierarchy.share))
    return [first_share, *hierarchy.pairs.T.astype(float)]


PLANETS = Kind(kepler_functions.PLANETS, rows_of_planets, _of_planets)
NESTED = Kind(kepler_functions.NESTED, rows_of_hierarchy, _of_pairs)


def _nested(hierarchy: Any) -> Any:
    """A hierarchy of tuples, whole numbers and names; ValueError for others."""

    def part(nested: Any, top: bool = False) -> Any:
        if isinstance(nested, (tuple, list)) and len(nested) > 1:
            return tuple(part(inner) for inner in nested)
        if isinstance(nested, str) and not top:
            return nested
        if isinstance(nested, (int, np.integer)) and not isinstance(nested, bool) and not top:
            return int(nested)
        raise ValueError(
            f"hierarchy must be nested tuples of at least two parts each, bodies by number or "
            f"name, e.g. ('Sun', ('Earth', 'Moon')); received {shown(hierarchy)}."
        )

    return part(hierarchy, top=True)


def _farthest(hierarchy: Hierarchy, step: float) -> Array:
    """Largest |beta X^2| in half a step, (n,).

    An orbit whose mean anomaly changes by M turns most about its pericentre, by E in the eccentric
    one with E - 2 e sin(E / 2) = M.
    """
    turned = 0.5 * abs(step) * np.sqrt(hierarchy.pair_masses / hierarchy.axes**3)
    low, high = turned, turned + 2.0
    for _ in range(60):
        E = 0.5 * (low + high)
        short = E - 2.0 * hierarchy.eccentricities * np.sin(0.5 * E) < turned
        low, high = np.where(short, E, low), np.where(short, high, E)
    return high**2


def _stretch(turns: float, c: Array) -> float:
    """How far nodes are moved: in proportion to short steps, so that the order is that of Gauss.

    Long steps are limited by the ends of the step, where polynomials know most; the limits were
    found best of several for 8 and 16 nodes on the planets.
    """
    largest = 0.78 if c.size <= LANES else 0.86
    return largest * abs(turns) / math.hypot(turns, 0.2)


def _clock(hierarchy: Hierarchy, step: float) -> tuple[float, float, float]:
    """The clock of the fastest orbit."""
    k = hierarchy.fastest
    turns = step * math.sqrt(hierarchy.pair_masses[k] / hierarchy.axes[k] ** 3) / (2.0 * math.pi)
    return turns, float(hierarchy.eccentricities[k]), mean_anomaly(hierarchy, k)
