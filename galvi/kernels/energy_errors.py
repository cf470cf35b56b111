"""What errors of the energy are measured by, from sample to sample, and when they are too large."""

from __future__ import annotations

import math

from galvi.kernels.compile.jit import jit

LOWEST, HIGHEST, MEASURE, WORST = range(4)
TOLERATED = 0.01  # share of its measure up to which an error is not reported
ROUND_OFF = 2.0**-40  # share of |T| + |V| that is not an error


@jit
def measure_errors(errors, round_off, sizes, lowest, highest, single, so_far, largest, measures):
    """What n errors of the energy are measured by, in order; all arrays are (n,) but ``so_far``.

    errors     those up to ``round_off`` become 0; NaN where an energy is unknown
    sizes      by which an error is measured, if they exceed the range of V
    lowest, highest  V there
    single     whether these are errors of single steps, each good if small; those since the start
               must not exceed the measure before them either: a run that jumps into a deep well is
               not measured by its depth
    so_far     (4,) least and greatest V, measure and largest error of what precedes these; the
               first three become those of these too
    largest    <- the measure if that sample is good
    measures   <- the measure after it
    """
    low, high, measure = so_far[LOWEST], so_far[HIGHEST], so_far[MEASURE]
    for k in range(errors.size):
        if errors[k] <= round_off[k]:
            errors[k] = 0.0
        if lowest[k] < low or math.isnan(low):
            low = lowest[k]
        if highest[k] > high or math.isnan(high):
            high = highest[k]
        reached = high - low
        if not reached > sizes[k]:
            reached = sizes[k]
        largest[k] = reached if reached > measure else measure
        error = errors[k]
        if error <= TOLERATED * largest[k] and (
            single or error <= measure or measure <= round_off[k]
        ):
            measure = largest[k]
        measures[k] = measure
    so_far[LOWEST], so_far[HIGHEST], so_far[MEASURE] = low, high, measure
