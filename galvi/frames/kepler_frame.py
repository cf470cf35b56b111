"""The moving frame of Kepler orbits in Jacobi coordinates."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, NamedTuple, cast

import numpy as np

from galvi import input_checks
from galvi.arrays import Array
from galvi.extended_precision import decimals, extended_precision, rounded
from galvi.frames.frame import GAUSS_CLOCK, Motion, matrix_of
from galvi.frames.hierarchy import (
    Hierarchy,
    Nested,
    around_heaviest,
    attraction,
    held_pairs,
    hierarchy_of,
    jacobi,
    mean_anomaly,
    number_hierarchy,
    orbits,
    pull_back_changes,
)
from galvi.input_checks import shown
from galvi.kernels.compile.function_pointers import addresses
from galvi.kernels.constants import COMPLEX_STEP
from galvi.kernels.forces.celestial import SOURCE, TARGET, WEIGHT, pulls
from galvi.lanes.frames import kepler_functions
from galvi.lanes.frames.collocation import DRIFT, LEAVE, RATES
from galvi.lanes.frames.hierarchy import rows_of_hierarchy
from galvi.lanes.frames.kepler import work_rows_per_planet
from galvi.lanes.frames.kepler_drift import LARGEST_ANOMALY_CHANGE
from galvi.lanes.frames.kepler_motion import ARGUMENT_HALVINGS, LEAST_DISTANCE_RATIO
from galvi.lanes.vectors import LANES
from galvi.problem import Problem
from galvi.systems.forces.celestial import Force
from galvi.systems.nbody import NBody

LARGEST_STRETCH = 0.45  # half of what planets need, whose orbits may change
# Largest eccentricity at the start, with a margin for its rounding. Up to it the error of a
# revolution is 4e-13 of the axis, and up to that of `LEAST_DISTANCE` 9e-13 (measured by
# tests/properties/test_eccentric_orbits_in_frames.py).
MAX_ECCENTRICITY = 0.9 + 1e-9
USE_CLOCK = "clock=galvi.DynamicalTime()"
# Largest |beta X^2| in half a step for which the series of a pass are accurate.
LARGEST_ARGUMENT = 4.0**ARGUMENT_HALVINGS


@dataclass(frozen=True)
class KeplerFrame:
    """Kepler orbits of an `NBody` system about its heaviest body, solved exactly.

    The coordinates are Jacobi's, with the planets in the order of their orbits at the start: the
    frame includes the attraction of each orbit's inner bodies, and collocation solves the
    remainder.

    Parameters
    ----------
    passes
        number of passes of a step; None: as many as the tolerance needs at the start. Two are
        accurate where planets are light, but let the energy drift slowly
    even
        whether nodes are Gauss nodes in time; else they are nodes in the eccentric anomaly of the
        fastest orbit at the start, which are closer to each other at the middle of the step
    hierarchy
        nested tuples of bodies, by number or by the problem's names, for systems other than one
        star with planets: ("Sun", ("Earth", "Moon"), "Mars") or ((0, 1), (2, 3)). Each part moves
        about all parts before it. Every body with a mass must occur once; massless ones that are
        left out move about the first part. None: the heaviest body and its planets

    Notes
    -----
    Forces with an energy may act besides gravity. Every body needs a bound orbit of eccentricity at
    most 0.9, and a step at most 1.27 revolutions of the fastest orbit, or 0.75 at that eccentricity
    unless gravity of two bodies is the only force. Two bodies under gravity alone are solved
    exactly.

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
        """See `Frame`."""
        return "Kepler frame"

    @property
    def reversible(self) -> bool:
        """See `Frame`."""
        return self.even

    @property
    def conserved(self) -> str:
        """See `Frame`."""
        return "it conserves the linear and the angular momentum"

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
            defect = number_hierarchy(problem, self.hierarchy)[1]
            if defect:
                return (
                    f"the hierarchy of a KeplerFrame must name every body that has a mass once; "
                    f"received {defect}."
                )
        hierarchy = self._hierarchy(problem)
        is_bound = _is_bound(hierarchy)
        if not np.all(is_bound):
            inner = "the heaviest body" if self.hierarchy is None else "what its hierarchy names"
            bodies = _second_side(problem, hierarchy, int(np.argmin(is_bound)))
            return (
                f"a KeplerFrame needs bound orbits about {inner}; received one of {bodies} that is "
                f"not, at the start. Use another chart."
            )
        above_limit = _above_eccentricity(problem, hierarchy, MAX_ECCENTRICITY)
        if above_limit:
            return (
                f"a KeplerFrame needs orbits of eccentricity up to {MAX_ECCENTRICITY:.3g}, beyond "
                f"which it loses digits; received {above_limit}, at the start. Use {USE_CLOCK}."
            )
        return ""

    def leaves(self, problem: Problem, step: float) -> str:
        """See `Frame`."""
        hierarchy = self._hierarchy(problem)
        bound = _is_bound(hierarchy)
        if not np.all(bound):
            bodies = _second_side(problem, hierarchy, int(np.argmin(bound)))
            return (
                f"the orbit of {bodies} is not bound any more, which the Kepler frame does not "
                f"cover. Use another chart from there on."
            )
        eccentric = _above_eccentricity(problem, hierarchy, 1.0 - LEAST_DISTANCE_RATIO)
        if eccentric:
            return (
                f"an orbit is more eccentric than the Kepler frame covers: {eccentric}. Use "
                f"{USE_CLOCK} from there on."
            )
        revolutions = (
            abs(step) * np.sqrt(hierarchy.pair_masses / hierarchy.axes**3) / (2.0 * math.pi)
        )
        k, arguments = hierarchy.fastest, _largest_arguments(hierarchy, step)
        if revolutions[k] < LARGEST_ANOMALY_CHANGE / (2.0 * math.pi):
            k = int(np.argmax(arguments))
            if _is_exact(problem) or arguments[k] < LARGEST_ARGUMENT:
                return ""
        return (
            f"the step is {revolutions[k]:.3g} revolutions of "
            f"{_second_side(problem, hierarchy, k)}, more than the Kepler frame covers, which are "
            f"1.27, or 0.75 at eccentricity 0.9. Use a smaller step."
        )

    def _nested_in(self, problem: Problem) -> Nested:
        if self.hierarchy is None:
            return around_heaviest(problem)
        return number_hierarchy(problem, self.hierarchy)[0]

    def _hierarchy(self, problem: Problem) -> Hierarchy:
        return hierarchy_of(problem, self._nested_in(problem))

    def held_pairs(self, problem: Problem) -> Array:
        """The matrix (bodies, bodies) that is 1 for two bodies which the frame moves about each
        other, and else 0."""
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
        frame_functions = PLANETS if self.hierarchy is None else NESTED
        last = max(
            np.flatnonzero(_largest_arguments(hierarchy, step) > LARGEST_STRETCH), default=-1
        )  # of those that turn far
        numbers = np.concatenate(
            [
                [step, (int(last) + 2) // 2, len(hierarchy.pairs)],
                hierarchy.masses,
                *frame_functions.blocks(hierarchy),
                1.0 / hierarchy.pair_masses,
                np.array(hierarchy.bodies, dtype=float),
                *_terms(problem, hierarchy),
            ]
        )
        functions, n = frame_functions.functions[D], len(hierarchy.pairs)
        if _is_exact(problem):
            functions = (kepler_functions.rates_of_two, *functions[1:])
        pointers = addresses(*zip(functions, (RATES, DRIFT, LEAVE), strict=True))
        clock = GAUSS_CLOCK if self.even else _clock(hierarchy, step)
        distances, speeds = (
            np.linalg.norm(np.array(exact[1:], dtype=float), axis=1)
            for exact in (hierarchy.positions, hierarchy.velocities)
        )
        sizes = np.concatenate([np.tile(distances, D), np.tile(speeds, D)])
        stretch = 0.0 if self.even else _node_stretch(clock[0], c)
        return Motion(
            pointers, functions, numbers, frame_functions.rows(D) * n, n, sizes, clock, stretch
        )

    def flow(self, problem: Problem, w: Array, t: Array) -> Array:
        """See `Frame`."""
        hierarchy, D = self._hierarchy(problem), problem.q0.shape[1]
        q, v, centre = _split_state(w[:, :2], hierarchy, D)
        Q = orbits(hierarchy.pair_masses, q, v, t[:, None]).positions
        return _bodies(hierarchy, Q, centre[:, 0] + t[:, None] * centre[:, 1])

    def derivatives(self, problem: Problem, w: Array, t: float) -> tuple[Array, Array]:
        """See `Frame`; by complex steps."""
        hierarchy, D = self._hierarchy(problem), problem.q0.shape[1]
        d, n, system = problem.q0.size, len(hierarchy.pairs), cast(NBody, problem.system)
        perturbed = w[None, :, :d] + 1j * COMPLEX_STEP * np.eye(2 * d).reshape(2 * d, 2, d)
        q, v, centre = _split_state(perturbed, hierarchy, D)
        after = orbits(hierarchy.pair_masses, q, v, np.full((2 * d, 1), t))
        bodies = _bodies(hierarchy, after.positions, centre[:, 0] + t * centre[:, 1])
        pull = attraction(system.G * system.masses, bodies)
        pull += pulls(system.acting.terms, system.acting.poles, bodies)[0]
        into_frame = matrix_of(self, problem)[: D * n]
        pair_pulls = (pull.reshape(2 * d, d) @ into_frame.T).reshape(2 * d, D, n)
        cube = np.sum(after.positions**2, axis=1)[:, None] ** 1.5
        perturbation = pair_pulls + hierarchy.pair_masses * after.positions / cube
        slopes = pull_back_changes(hierarchy.pair_masses, q, v, after, perturbation)
        barycentre = centre[:, 0] + t * centre[:, 1], centre[:, 1]
        ends = [
            np.concatenate([x.reshape(2 * d, D * n), y], axis=1)
            for x, y in zip((after.positions, after.velocities), barycentre, strict=True)
        ]
        rates = [
            np.concatenate([x.reshape(2 * d, D * n), 0.0 * y], axis=1)
            for x, y in zip(slopes, barycentre, strict=True)
        ]
        motion, slope = (np.imag(np.concatenate(x, axis=1)).T / COMPLEX_STEP for x in (ends, rates))
        return motion, slope


def _is_exact(problem: Problem) -> bool:
    """Whether the frame's orbits are the exact motion: two bodies without other forces."""
    system: Any = problem.system
    return bool(system.masses.size == 2 and not system.forces)


def _terms(problem: Problem, hierarchy: Hierarchy) -> tuple[Array, Array]:
    """The index of the first term of each pair, with their number at the end (n + 1,), and the
    terms ordered by pairs."""
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


def _is_bound(hierarchy: Hierarchy) -> Array:
    """Whether each orbit is an ellipse, (n,)."""
    return np.asarray(np.isfinite(hierarchy.axes) & (hierarchy.axes > 0.0))


def _above_eccentricity(problem: Problem, hierarchy: Hierarchy, limit: float) -> str:
    """A clause on the largest eccentricity and its bodies if it is above ``limit``; else ""."""
    k = int(np.argmax(hierarchy.eccentricities))
    e = hierarchy.eccentricities[k]
    return f"{e:.12g} of {_second_side(problem, hierarchy, k)}" if e > limit else ""


def _second_side(problem: Problem, hierarchy: Hierarchy, pair: int) -> str:
    """The bodies on the second side of a pair, for messages."""
    _first, middle, end = hierarchy.pairs[pair]
    names = [str(problem.body_names()[hierarchy.bodies[k]]) for k in range(middle, end)]
    return f"bod{'y' if len(names) == 1 else 'ies'} {', '.join(names)}"


def _split_state(w: Array, hierarchy: Hierarchy, D: int) -> tuple[Array, Array, Array]:
    """Positions and velocities (k, D, n) of pairs, and both of the barycentre (k, 2, D)."""
    n = len(hierarchy.pairs)
    q, v = (w[:, half, : D * n].reshape(-1, D, n) for half in range(2))
    return q, v, w[:, :, D * n : D * n + D]


def _bodies(hierarchy: Hierarchy, Q: Array, centre: Array) -> Array:
    """The positions (k, bodies, D) of bodies from those of pairs (k, D, n) and of the barycentre
    (k, D)."""
    out = np.empty((len(Q), len(hierarchy.bodies), Q.shape[1]), dtype=Q.dtype)
    out[:, hierarchy.bodies[0]] = centre
    for i in range(len(hierarchy.pairs) - 1, -1, -1):
        first, second = (hierarchy.bodies[k] for k in hierarchy.pairs[i, :2])
        out[:, first] -= hierarchy.share[i] * Q[:, :, i]
        out[:, second] = out[:, first] + Q[:, :, i]
    return out


class FrameFunctions(NamedTuple):
    """The functions and numbers for planets about a star, or for other hierarchies.

    Attributes
    ----------
    functions
        dimension -> compiled functions, see galvi.lanes.frames.kepler_functions
    rows
        dimension -> number of rows of work for each pair
    blocks
        hierarchy -> arrays of the numbers that these functions read
    """

    functions: Any
    rows: Any
    blocks: Any


def _planet_numbers(hierarchy: Hierarchy) -> list[Array]:
    with extended_precision():
        m = decimals(hierarchy.masses[: 1 + len(hierarchy.pairs)])
        inner = np.cumsum(m)
        M, before = inner[1:], inner[:-1]
        rows = m[0] / before, (before - m[0]) / before, M / before, 1 / before
        return [rounded(row) for row in rows]


def _pair_numbers(hierarchy: Hierarchy) -> list[Array]:
    with extended_precision():
        first_share = rounded(1 - decimals(hierarchy.share))
    return [first_share, *hierarchy.pairs.T.astype(float)]


PLANETS = FrameFunctions(kepler_functions.PLANETS, work_rows_per_planet, _planet_numbers)
NESTED = FrameFunctions(kepler_functions.NESTED, rows_of_hierarchy, _pair_numbers)


def _nested(hierarchy: Any) -> Any:
    """A hierarchy of tuples, whole numbers and names; ValueError for other values."""

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


def _largest_arguments(hierarchy: Hierarchy, step: float) -> Array:
    """The largest |beta X^2| (n,) in half a step.

    While its mean anomaly changes by M, the eccentric anomaly of an orbit changes most about the
    pericentre: by E with E - 2 e sin(E / 2) = M.
    """
    mean_change = 0.5 * abs(step) * np.sqrt(hierarchy.pair_masses / hierarchy.axes**3)
    low, high = mean_change, mean_change + 2.0
    for _ in range(60):
        E = 0.5 * (low + high)
        is_too_small = E - 2.0 * hierarchy.eccentricities * np.sin(0.5 * E) < mean_change
        low, high = np.where(is_too_small, E, low), np.where(is_too_small, high, E)
    return high**2


def _node_stretch(revolutions: float, c: Array) -> float:
    """The stretch of nodes (`Motion.stretch`): proportional to short steps, so that the order is
    that of Gauss.

    For long steps it tends to a limit, since accuracy needs nodes near the ends of the step; the
    limits are the best of several that were tried for 8 and 16 nodes on the planets.
    """
    largest = 0.78 if c.size <= LANES else 0.86
    return largest * abs(revolutions) / math.hypot(revolutions, 0.2)


def _clock(hierarchy: Hierarchy, step: float) -> tuple[float, float, float]:
    """`Motion.clock` of the fastest orbit."""
    k = hierarchy.fastest
    revolutions = (
        step * math.sqrt(hierarchy.pair_masses[k] / hierarchy.axes[k] ** 3) / (2.0 * math.pi)
    )
    return revolutions, float(hierarchy.eccentricities[k]), mean_anomaly(hierarchy, k)
