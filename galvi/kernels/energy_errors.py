"""The errors of the energy at some steps of a run, and what they are measured by."""

from __future__ import annotations

import math

from galvi.kernels.compile.jit import jit

LOWEST, HIGHEST, MEASURE, WORST = range(4)
SMALL = 0.01  # share of its measure below which an error is not reported
CLOSE = 0.03  # relative error of a momentum; that of the energy is of the order of its square
ROUND_OFF = 2.0**-40  # share of |T| + |V| that is not an error


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
