"""Names the point masses for which a step could not be solved, or is too long.

It also estimates the error of massless bodies, which the energy of the system does not show: from
some states of a run a step is done backwards, whole and in two halves. The difference changes the
energy of a body by v . dv + G M / r^2 dr, here relative to v^2 / 2 + G M / r, where M is the mass
that attracts it most: an estimate of the error of a step. Other steps may err more, and errors of
many steps may cancel, as they do for a symplectic method.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from galvi.arrays import Array
from galvi.kernels.constants import LARGEST_SQUARED
from galvi.kernels.forces.passages import FOUND, UNRESOLVED, UNRESOLVED_IN_A_FRAME
from galvi.problem import Problem
from galvi.systems.nbody import NBody

SOLVABLE_SHARE = 0.5  # largest solvable step / sqrt(r^3 / G(m_i + m_j)), per stage
MAX_PARTS = 1e5  # largest ratio of the step to a solvable one for which a smaller step is proposed
CLOCK_PARTS = 1e3  # ratio of the step to the time scale of a passage, above which to use a clock
USE_CLOCK = "Use clock=galvi.DynamicalTime(), whose steps follow the motion"
COLLISION_RATIO = 1e-12  # share of their distance, up to which the closest approach is a collision


@np.errstate(all="ignore")
def encounter(
    problem: Problem, system: NBody, stages: int, step: float, state: Array, in_frame: bool = False
) -> str:
    """The bodies for which the step from ``state`` failed, and the remedy, as a sentence.

    Parameters
    ----------
    framed
        whether the run is in a moving frame

    Notes
    -----
    It names either a body that is too far away, or the pair with the shortest time scale.
    """
    q, v = (state[row].reshape(problem.q0.shape) for row in (0, 2))
    masses, G = system.masses, system.G
    names = body_names(problem, len(masses))
    distance = np.max(np.abs(q), axis=1)
    farthest = int(np.argmax(distance))
    if abs(step) > LARGEST_SQUARED or np.max(np.abs(v)) > LARGEST_SQUARED:
        return "steps and velocities above 1e100 overflow. Use other units, or a smaller step."
    if not distance[farthest] < LARGEST_SQUARED:
        return (
            f"body {names[farthest]} is {distance[farthest]:.1e} away. Remove it, or stop before "
            f"then."
        )
    i, j = np.triu_indices(len(masses), 1)
    i, j = (x[masses[i] + masses[j] > 0.0] for x in (i, j))
    gap, relative_velocity = q[j] - q[i], v[j] - v[i]
    square_speed = np.sum(relative_velocity**2, axis=1)
    time_of_closest = -np.sum(gap * relative_velocity, axis=1) / np.where(
        square_speed > 0.0, square_speed, 1.0
    )
    time_in_step = np.clip(time_of_closest, min(step, 0.0), max(step, 0.0))
    closest = np.linalg.norm(gap + time_in_step[:, None] * relative_velocity, axis=1)
    mu, separation = G * (masses[i] + masses[j]), np.linalg.norm(gap, axis=1)
    meets_soon = (time_of_closest * step > 0.0) & (
        abs(time_of_closest) < 1.5 * abs(step)
    )  # a fall takes 2/3 of that
    closest = np.where(
        meets_soon, _pericentres(mu, gap, relative_velocity), np.minimum(closest, separation)
    )
    time_scales = np.sqrt(closest**3 / mu)
    pair = int(np.argmin(time_scales))
    solvable = SOLVABLE_SHARE * stages * time_scales[pair]
    bodies = f"bodies {names[i[pair]]} and {names[j[pair]]}"
    if not closest[pair] > COLLISION_RATIO * separation[pair]:
        return f"{bodies} collide. Stop before then, or merge them."
    if system.forces and solvable > abs(step) and not in_frame:
        if not system.acting.functions:
            return "with the forces beside gravity the step cannot be solved. Use a smaller step."
        return (
            "with your Force the step cannot be solved: it is not finite (nor may it push a body "
            "without mass), or it varies too fast. Check its function, or use a smaller step."
        )
    remedy = "Use a smaller step or a higher degree"
    if not solvable > abs(step) / MAX_PARTS:
        remedy = USE_CLOCK
    return (
        f"{bodies} pass at a distance of about {closest[pair]:.1e}, where steps of up to about "
        f"{solvable:.1e} can be solved; received {abs(step):g}. {remedy}."
    )


def _pericentres(mu: Array, gap: Array, velocity: Array) -> Array:
    """The least distances (pairs,) of pairs of bodies that move under their own attraction."""
    separation, radial = np.linalg.norm(gap, axis=1), np.sum(gap * velocity, axis=1)
    transverse = velocity - (radial / separation**2)[:, None] * gap
    square_momentum = separation**2 * np.sum(transverse**2, axis=1)  # of the angular momentum
    energy = 0.5 * np.sum(velocity**2, axis=1) - mu / separation
    e = np.sqrt(np.maximum(1.0 + 2.0 * energy * square_momentum / mu**2, 0.0))
    return square_momentum / (mu * (1.0 + e))


def needs_clock(problem: Problem, step: float, passage: Array) -> bool:
    """Whether the step is more than CLOCK_PARTS times the time scale of the worst passage."""
    _error, first, second, distance, _number = passage[:FOUND]
    system: Any = problem.system
    mu = system.G * (system.masses[int(first)] + system.masses[int(second)])
    return bool(np.sqrt(distance**3 / mu) < abs(step) / CLOCK_PARTS)


def unresolved_passage(
    problem: Problem, step: float | None, passage: Array, framed: bool = False
) -> str:
    """A clause on the worst passage of two bodies, see galvi.kernels.forces.passages; "" if it is
    resolved.

    Parameters
    ----------
    step
        step of the run; None in a clock, where ``passage`` holds the time of the passage
    framed
        whether the run is in a moving frame
    """
    if passage.size == 0 or not passage[0] > (UNRESOLVED_IN_A_FRAME if framed else UNRESOLVED):
        return ""
    error, first, second, distance, number = passage[:FOUND]
    names = body_names(problem, problem.q0.shape[0])
    t = number if step is None else problem.t0 + (number - 0.5) * step
    return (
        f"bodies {names[int(first)]} and {names[int(second)]} passed at a distance of about "
        f"{distance:.1e} near t = {t:.10g}, which left an error of "
        f"about {error:.0e} in their relative velocity"
    )


def body_names(problem: Problem, bodies: int) -> Sequence[Any]:
    names = problem.parameters.get("bodies")
    if not isinstance(names, (tuple, list)) or len(names) != bodies:
        return range(bodies)
    return names


LONG_RUN_STATES = 6  # largest number of examined states, with the last one
# Steps of a run for each further examined state, from which three steps are done without a guess.
# In a clock steps are as long as a body's motion allows, and err most near a pericentre.
STEPS_PER_STATE, STEPS_PER_STATE_IN_A_CLOCK = 32768, 256
RESOLVED_ENERGY_CHANGE = 1e-3  # a step that resolves a body's motion changes less of its energy


class MasslessError(NamedTuple):
    """The massless body whose energy a step changes most, among the examined states.

    Attributes
    ----------
    body
        its index
    share
        that change, over v^2 / 2 + G M / r
    states
        number of examined states from which the steps could be done
    """

    body: int
    share: float
    states: int


def examined_states(
    states: int, steps: int, steps_per_state: int, *, start: bool = False
) -> list[int]:
    """Indices of the examined states among ``states`` states of a run: the last one, a further one
    for every ``steps_per_state`` steps, and with ``start`` the first; at most LONG_RUN_STATES."""
    parts = min(LONG_RUN_STATES - start, 1 + steps // steps_per_state)
    return list(dict.fromkeys(round((states - 1) * k / parts) for k in range(parts, -start, -1)))


@np.errstate(all="ignore")
def massless_error(problem: Problem, ends: Callable[[int], Array]) -> MasslessError | None:
    """The estimated error of massless bodies; None where no step could be done.

    Parameters
    ----------
    ends
        n -> q and v, (2, k, bodies, dimension), after n steps backwards from k states of a run,
        each 1 / n of its step; NaN where they cannot be done
    """
    full_steps, halves = ends(1), ends(2)
    finite = np.isfinite(full_steps + halves).all(axis=(0, 2, 3))
    if not finite.any():
        return None
    system: Any = problem.system
    massless = np.flatnonzero(system.masses == 0.0)
    share = _energy_changes(system, massless, full_steps[:, finite], halves[:, finite]).max(axis=0)
    worst = int(np.argmax(share))
    return MasslessError(int(massless[worst]), float(share[worst]), int(np.count_nonzero(finite)))


def _energy_changes(system: Any, light: Any, full_steps: Array, halves: Array) -> Array:
    """Relative differences (k, n) of the energy of the ``light`` bodies (n,) between a step and its
    two halves."""
    light_states, off = halves[:, :, light], (full_steps - halves)[:, :, light]
    strongest_pull, puller = (
        np.zeros(light_states.shape[1:3]),
        np.zeros(light_states.shape[1:3], dtype=np.int64),
    )
    for body in np.flatnonzero(system.masses):  # one by one: there may be many of both
        r = _lengths(light_states[0] - halves[0, :, body, None])
        by_body = system.G * system.masses[body] / r**2
        puller[by_body > strongest_pull] = body
        strongest_pull = np.maximum(by_body, strongest_pull)
    r, speed = _lengths(light_states - halves[:, np.arange(len(puller))[:, None], puller])
    dq, dv = _lengths(off)
    return np.fmax((speed * dv + strongest_pull * dq) / (0.5 * speed**2 + strongest_pull * r), 0.0)


def _lengths(vectors: Array) -> Array:
    return np.sqrt((vectors * vectors).sum(axis=-1))
