"""The errors of the energy at some steps of a run, and what they are measured by."""

from __future__ import annotations

import math
from functools import cache

import numpy as np
from numba import types

from galvi.kernels.compile.array_types import VECTOR
from galvi.kernels.compile.jit import compiled_for, jit

LOWEST, HIGHEST, MEASURE, WORST = range(4)
SMALL = 0.01  # share of its measure below which an error is not reported
CLOSE = 0.03  # relative error of a momentum; that of the energy is of the order of its square
ROUND_OFF = 2.0**-40  # share of |T| + |V| that is not an error
ROWS = types.Array(types.float64, 2, "A", readonly=True)
FIXED_VECTOR, FIXED_MATRIX = (types.Array(types.float64, n, "C", readonly=True) for n in (1, 2))


@jit
def energy_errors(kinetic, potential, energy, kinetic_at_start, floor, so_far, errors):
    """errors (n,) <- |T + V - energy| of T and V (n,), 0 up to round-off; returns the largest.

    NaN, also as the largest, where an energy is unknown.

    energy            that of the start
    kinetic_at_start  its size
    floor             errors up to which are round-off
    so_far            (4,) least and greatest V, measure and largest error of the steps before;
                      the first three become those of these steps too. A step whose error is small,
                      and below the measure of the steps before it, adds to the measure
    """
    lowest, highest, measure = so_far[LOWEST], so_far[HIGHEST], so_far[MEASURE]
    largest = 0.0
    for k in range(errors.size):
        here, error = potential[k], abs(kinetic[k] + potential[k] - energy)
        round_off = max(floor, ROUND_OFF * (abs(kinetic[k]) + abs(here)))
        if error <= round_off:
            error = 0.0
        if here < lowest or math.isnan(lowest):
            lowest = here
        if here > highest or math.isnan(highest):
            highest = here
        reached = highest - lowest
        if not reached > kinetic_at_start:
            reached = kinetic_at_start
        if error <= SMALL * reached and (error <= measure or measure <= round_off):
            measure = max(measure, reached)
        if not (error <= largest or math.isnan(largest)):
            largest = error
        errors[k] = error
    so_far[LOWEST], so_far[HIGHEST], so_far[MEASURE] = lowest, highest, measure
    return largest


@jit
def first_look(rows, form, near, momenta, value, potential, energy, kinetic_at_start, so_far):
    """As ``energy_errors``, T from the rows of a run; returns the largest error.

    NaN also where velocities have not the momenta.

    rows       (n, d)   velocities or momenta x
    form       (d, 1) or (d, d)  T = x . form x / 2, form a diagonal or a matrix; (0, 0) for a
                        Lagrangian, where x are momenta and T = x . near - value - potential
    near       (n, d)   velocities near those that have these momenta; (0, 0) for a form
    momenta    (n, d)   that they have; (0, 0) for a form
    value      (n,)     L there; (0,) for a form
    potential  (n,)
    so_far     (4,)     becomes that of all steps, the largest error included
    """
    n, d = rows.shape
    kinetic, errors = np.zeros(n), np.empty(n)
    for k in range(n):
        total = 0.0
        for i in range(d):
            if form.shape[0] == 0:
                along = 2.0 * near[k, i]
            elif form.shape[1] == 1:
                along = form[i, 0] * rows[k, i]
            else:
                along = 0.0
                for j in range(d):
                    along += form[i, j] * rows[k, j]
            total += along * rows[k, i]
        kinetic[k] = 0.5 * total
        if form.shape[0] == 0:
            kinetic[k] -= value[k] + potential[k]
            off, size = 0.0, 0.0
            for i in range(d):
                off = max(off, abs(momenta[k, i] - rows[k, i]))
                size = max(size, abs(rows[k, i]))
            if not off <= CLOSE * size:
                return math.nan
    largest = energy_errors(kinetic, potential, energy, kinetic_at_start, 0.0, so_far, errors)
    so_far[WORST] = max(largest, so_far[WORST])
    return largest


@cache
def compiled_first_look():
    """``first_look`` compiled or cached."""
    real = types.float64
    signature = real(
        ROWS, FIXED_MATRIX, FIXED_MATRIX, ROWS, FIXED_VECTOR, FIXED_VECTOR, real, real,
        VECTOR,
    )  # fmt: skip
    return compiled_for(first_look, signature)
