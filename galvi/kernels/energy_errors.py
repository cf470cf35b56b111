"""Errors of the energy: what they are measured by, and when they are too large.

Rows of a table of n errors, (8, n):

ERROR            those up to ROUNDING become 0; NaN where an energy is unknown
RUINING          the part of an error that ruins a run where it exceeds the measure
SIZE             by which an error is measured if it exceeds the range of V
LEAST, GREATEST  V there
ROUNDING         errors up to which are none
LARGEST          the measure if that sample is good; filled by `assess_errors`, as the next is
LIMIT            the measure after it
"""

import math

from galvi.kernels.compile.jit import jit

ERROR, RUINING, SIZE, LEAST, GREATEST, ROUNDING, LARGEST, LIMIT, ROWS = range(9)
LOWEST, HIGHEST, MEASURE, WORST = range(4)  # of `Checkpoint.energies`
TOLERATED = 0.01  # share of its measure up to which an error is not reported
ENERGY_ROUND_OFF = 2.0**-40  # share of |T| + |V| that is not an error
REST_SHARE = 1e-9  # share of what a step gives below which a kinetic energy is none


@jit
def errors_since_start(kinetic, potential, energies, driven, start, start_kinetic, table):
    """table (8, n) <- the errors of T + V, (n,) each, since the start.

    Parameters
    ----------
    energies
        (n,) or (1,) exact T + V
    driven
        whether errors are measured by T and the work since the start too
    start
        the energy at the start; ``start_kinetic`` is the size of its T
    """
    for k in range(kinetic.size):
        energy = energies[min(k, energies.size - 1)]
        error = abs(kinetic[k] + potential[k] - energy)
        table[ERROR, k] = table[RUINING, k] = error
        if math.isnan(error) and math.isfinite(start):
            table[RUINING, k] = math.inf
        size = start_kinetic
        if driven and abs(kinetic[k]) > size:
            size = abs(kinetic[k])
        if driven and abs(energy - start) > size:
            size = abs(energy - start)
        table[SIZE, k] = size
        table[LEAST, k] = table[GREATEST, k] = potential[k]
        table[ROUNDING, k] = ENERGY_ROUND_OFF * (abs(kinetic[k]) + abs(potential[k]))


@jit
def share_of(error, measure):
    """error / measure; 0 for no error, infinite without a measure."""
    if not error > 0.0:
        return 0.0
    return error / measure if measure > 0.0 else math.inf


@jit
def grow_measures(table, single, floor, so_far):
    """Fill the rows LARGEST and LIMIT, the measures with and up to each error, and set errors of
    round-off to 0; whether an error is NaN. The arguments are those of `assess_errors`."""
    low, high, measure = so_far[LOWEST], so_far[HIGHEST], so_far[MEASURE]
    unknown = False
    for k in range(table.shape[1]):
        rounding = max(floor, table[ROUNDING, k])
        if table[ERROR, k] <= rounding:
            table[ERROR, k] = 0.0
        error, reached = table[ERROR, k], table[SIZE, k]
        unknown = unknown or math.isnan(error)
        if table[LEAST, k] < low or math.isnan(low):
            low = table[LEAST, k]
        if table[GREATEST, k] > high or math.isnan(high):
            high = table[GREATEST, k]
        if high - low > reached:
            reached = high - low
        table[LARGEST, k] = reached if reached > measure else measure
        if error <= TOLERATED * table[LARGEST, k] and (
            single or error <= measure or measure <= rounding
        ):
            measure = table[LARGEST, k]
        table[LIMIT, k] = measure
    so_far[LOWEST], so_far[HIGHEST], so_far[MEASURE] = low, high, measure
    return unknown


@jit
def assess_single_steps(table, least_measure, so_far):
    """Errors of single steps, up to one that ruins the run: see `assess_errors`.

    Parameters
    ----------
    least_measure
        smallest measure of an error that ruins the run
    """
    share, worst = 0.0, 0
    for k in range(table.shape[1]):
        error, limit = table[ERROR, k], table[LIMIT, k]
        if least_measure > limit:
            limit = least_measure
        if table[RUINING, k] > limit and not error <= TOLERATED * table[LARGEST, k]:
            so_far[WORST] = math.inf
            return share_of(error, limit), k, k
        if share_of(error, table[LARGEST, k]) > share:
            share, worst = share_of(error, table[LARGEST, k]), k
    return share, worst, -1


@jit
def assess_since_start(table, measure, so_far):
    """Errors since the start, which share one measure: see `assess_errors`."""
    share, worst, ruined = 0.0, 0, -1
    for k in range(table.shape[1]):
        error = table[ERROR, k]
        if ruined < 0 and table[RUINING, k] > measure and not error <= TOLERATED * measure:
            ruined = k
        if share_of(error, measure) > share:
            share, worst = share_of(error, measure), k
        if error > so_far[WORST]:
            so_far[WORST] = error
    return share, worst, ruined


@jit
def assess_errors(table, single, start_kinetic, floor, kick, so_far):
    """The largest error over its measure, its index, that of the first error that ruins the run or
    -1, whether one is NaN, and the measure of the run.

    Parameters
    ----------
    table : array, shape (8, n)
        in the order of the run
    single
        whether these are errors of single steps, each good if small, and measured by what was up to
        it. One since the start must not exceed the measure before it either, and is measured by the
        whole run: a run that jumps into a deep well is not measured by its depth
    start_kinetic
        the size of T at the start
    floor
        a larger ROUNDING
    kick
        the kinetic energy that the forces at the start give in a step
    so_far : array, shape (4,)
        least and greatest V, measure and largest error of the steps before; they become those of
        these too, the last one infinite where a single step ruins
    """
    before = so_far[WORST]
    unknown = grow_measures(table, single, floor, so_far)
    measure, at_rest = so_far[MEASURE], start_kinetic <= REST_SHARE * kick
    if single:
        least_measure = kick if at_rest else 0.0
        share, worst, ruined = assess_single_steps(table, least_measure, so_far)
        if ruined >= 0:
            return share, worst, ruined, unknown, measure
    else:
        if at_rest and measure <= start_kinetic:
            measure = kick
        share, worst, ruined = assess_since_start(table, measure, so_far)
    return max(share, share_of(before, measure)), worst, ruined, unknown, measure
