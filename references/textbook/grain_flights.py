"""Flights of grains in a rotor's wind."""

from __future__ import annotations

from functools import cache
from typing import Any, NamedTuple

import numpy as np
from numba import types

from galvi import Problem
from galvi.arrays import Array
from references.compiled import njit
from references.forces.force import FUNCTION, OPTIONS
from references.newton import external_force
from references.textbook.quaternions import dop853_tableau

# The compiled loop of DOP853 for grains above the ground, with contacts found to rounding.
#
# y        (6,) q and v;  f = m g + drag
# force    (q, v, t, numbers, out), the drag, of `references.forces.formulas`
# inverse  1 / m
# A        (13, 12), the last row the weights;  E3, E5 (12,) the error estimates
# ends     (n, 8): q, v, time, and 1 for a grain that stays on the ground, 0 aloft, -1 failed

jit: Any = njit(**OPTIONS)
ROW, ROWS = types.float64[::1], types.float64[:, ::1]
STAGES = 12
SAFETY, MIN_FACTOR, MAX_FACTOR, EXPONENT = 0.9, 0.2, 10.0, -1.0 / 8.0
MAX_STEPS = 1_000_000  # of one flight
MAX_CONTACTS = 1000  # of one flight
MAX_REFINEMENTS = 12  # Newton steps for the time of a contact
DEFAULT_TOLERANCE = 1e-13  # relative, and absolute in m and m/s


@jit
def slope(force, numbers, inverse, gravity, y, t, out):
    """out <- y'."""
    out[:3] = y[3:]
    out[3:] = 0.0
    force(y[:3], y[3:], t, numbers, out[3:])
    out[3:] *= inverse
    out[5] -= gravity


@jit
def try_step(force, numbers, inverse, gravity, y, t, h, A, K, new):
    """K[1:] and new (6,) <- the slopes at the stages and the end of a step; K[0] is the slope at
    the start."""
    for j in range(1, STAGES + 1):
        new[:] = y
        for k in range(j):
            if A[j, k] != 0.0:
                for i in range(6):
                    new[i] += h * A[j, k] * K[k, i]
        if j < STAGES:
            slope(force, numbers, inverse, gravity, new, t + np.sum(A[j, :j]) * h, K[j])


@jit
def error_of(y, new, h, K, E3, E5, tolerance):
    """The step's estimated error over its tolerance (Hairer, Norsett and Wanner I, II.10)."""
    low = high = 0.0
    for i in range(6):
        scale = tolerance * (1.0 + max(abs(y[i]), abs(new[i])))
        third = fifth = 0.0
        for j in range(STAGES):
            third += E3[j] * K[j, i]
            fifth += E5[j] * K[j, i]
        low += (third / scale) ** 2
        high += (fifth / scale) ** 2
    if high == 0.0:
        return 0.0
    return h * high / np.sqrt(6.0 * (high + 0.01 * low))


def fall(force, numbers, inverse, gravity, starts, until, tolerance, ground, table, ends):
    """The flights of all grains, starts (n, 7) q, v and time, to a common end or to the ground.

    Parameters
    ----------
    ground : array, shape (e, slowest)
        e is the vertical speed after a contact over that before; a grain stays where e is below 0,
        or where it would leave the ground no faster than ``slowest``
    """
    A, E3, E5 = table
    e, slowest = ground
    K, y, new, last = np.zeros((STAGES, 6)), np.zeros(6), np.zeros(6), np.zeros(6)
    for grain in range(starts.shape[0]):
        y[:], t, next_step, contacts = starts[grain, :6], starts[grain, 6], 1e-4, 0
        ends[grain, 7] = -1.0
        slope(force, numbers, inverse, gravity, y, t, K[0])
        for _ in range(MAX_STEPS):
            h = min(next_step, until - t)
            try_step(force, numbers, inverse, gravity, y, t, h, A, K, new)
            error = error_of(y, new, h, K, E3, E5, tolerance)
            if not error <= 1.0:  # NaN comes here too
                next_step = h * (
                    max(MIN_FACTOR, SAFETY * error**EXPONENT) if error > 1.0 else MIN_FACTOR
                )
                if not next_step > 1e-15:
                    break
                continue
            hits_ground = new[2] <= 0.0
            if hits_ground:
                for _ in range(MAX_REFINEMENTS):
                    if abs(new[2]) <= 1e-16 or not new[5] < 0.0:
                        break
                    h -= new[2] / new[5]
                    last[:] = new
                    try_step(force, numbers, inverse, gravity, y, t, h, A, K, new)
                    if abs(new[2]) >= abs(last[2]):
                        break
                contacts += 1
            elif error > 0.0:
                next_step = h * min(MAX_FACTOR, max(MIN_FACTOR, SAFETY * error**EXPONENT))
            ends_here = not hits_ground and h >= until - t
            t = until if ends_here else t + h
            y[:] = new
            if hits_ground:
                y[2], y[5], next_step = 0.0, -e * new[5], 1e-4
                if e < 0.0 or not y[5] > slowest:
                    y[3:] = 0.0
                    ends[grain, 7] = 1.0
                    break
                if contacts >= MAX_CONTACTS:
                    break
            elif ends_here:
                ends[grain, 7] = 0.0
                break
            slope(force, numbers, inverse, gravity, y, t, K[0])
        ends[grain, :6], ends[grain, 6] = y, t


SIGNATURE = types.void(
    FUNCTION,
    ROW,
    types.float64,
    types.float64,
    ROWS,
    types.float64,
    types.float64,
    types.UniTuple(types.float64, 2),
    types.Tuple((ROWS, ROW, ROW)),
    ROWS,
)


@cache
def compiled() -> Any:
    """`fall`, compiled once and cached on disk."""
    return njit(SIGNATURE, **OPTIONS)(fall)


class Landings(NamedTuple):
    """The ends of n flights: positions and velocities (n, 3), times (n,), and whether the grain
    stays on the ground (n,)."""

    q: Array
    v: Array
    t: Array
    landed: Any


def landings(
    problem: Problem,
    q0: Array,
    v0: Array,
    t0: Array,
    until: float,
    *,
    restitution: float | None = None,
    slowest: float = 0.05,
    tolerance: float = DEFAULT_TOLERANCE,
) -> Landings:
    """The flights of n grains of a `galvi.problems.brownout` from (q0, v0) (n, 3) at t0 (n,).

    Parameters
    ----------
    restitution, slowest
        as benchmarks.applications.brownout.flights.Ground

    Raises
    ------
    RuntimeError
        Where the steps of a flight became too small or too many, or its contacts too many.

    Notes
    -----
    The time of a contact is the length of step whose end has height 0, by Newton's method.
    """
    drag, mass = external_force(problem), float(problem.system.mass)
    starts = np.ascontiguousarray(np.column_stack([q0, v0, t0]))
    ends = np.zeros((len(starts), 8))
    e = -1.0 if restitution is None else float(restitution)
    gravity = -float(problem.system.potential.force[2]) / mass
    compiled()(
        drag.function,
        drag.numbers,
        1.0 / mass,
        gravity,
        starts,
        until,
        tolerance,
        (e, slowest),
        dop853_tableau(),
        ends,
    )
    if np.any(ends[:, 7] < 0.0):
        raise RuntimeError(
            f"DOP853 did not complete {int(np.sum(ends[:, 7] < 0.0))} flights: the steps became "
            f"too small or more than {MAX_STEPS}, or a grain had {MAX_CONTACTS} contacts. Loosen "
            f"the tolerance, or give a larger slowest."
        )
    return Landings(ends[:, :3], ends[:, 3:6], ends[:, 6], ends[:, 7] > 0.0)
