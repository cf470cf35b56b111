"""Errors of the energy: the measures they are compared with, and whether they ruin a run.

Rows of a table of n errors, (8, n):

ERROR            errors; `assess_errors` sets those up to ROUNDING to 0; NaN for an unknown energy
RUINING          the part of an error that ruins a run if it exceeds the measure
SIZE             least measure of an error; the range of V so far is used if it is larger
LEAST, GREATEST  smallest and largest V of the sample
ROUNDING         largest error that counts as round-off
LARGEST          measure with this sample; set by `assess_errors`, as is the next
LIMIT            measure after this sample: it grows only with samples of small error
"""

import math

from galvi.kernels.compile.jit import jit

ERROR, RUINING, SIZE, LEAST, GREATEST, ROUNDING, LARGEST, LIMIT, ROWS = range(9)
LOWEST, HIGHEST, MEASURE, WORST = range(4)  # indices in `Checkpoint.energies`
TOLERATED_SHARE = 0.01  # largest ratio of an error to its measure that is not reported
ENERGY_ROUND_OFF = 2.0**-40  # largest ratio of an error to |T| + |V| that counts as round-off
REST_SHARE = 1e-9  # largest ratio of T at the start to that after a step for a start at rest


@jit
def errors_since_start(kinetic, potential, energies, uses_work, start, start_kinetic, table):
    """Fill table (8, n) with the errors of T + V since the start; LARGEST and LIMIT are not set.

    Parameters
    ----------
    kinetic, potential : array, shape (n,)
        T and V
    energies : array, shape (n,) or (1,)
        exact T + V
    uses_work
        whether SIZE includes |T| and the work since the start
    start, start_kinetic
        T + V and |T| at the start
    """
    for k in range(kinetic.size):
        energy = energies[min(k, energies.size - 1)]
        error = abs(kinetic[k] + potential[k] - energy)
        table[ERROR, k] = table[RUINING, k] = error
        if math.isnan(error) and math.isfinite(start):
            table[RUINING, k] = math.inf
        size = start_kinetic
        if uses_work and abs(kinetic[k]) > size:
            size = abs(kinetic[k])
        if uses_work and abs(energy - start) > size:
            size = abs(energy - start)
        table[SIZE, k] = size
        table[LEAST, k] = table[GREATEST, k] = potential[k]
        table[ROUNDING, k] = ENERGY_ROUND_OFF * (abs(kinetic[k]) + abs(potential[k]))


@jit
def share_of(error, measure):
    """error / measure; 0 unless the error is positive, infinite unless the measure is."""
    if not error > 0.0:
        return 0.0
    return error / measure if measure > 0.0 else math.inf


@jit
def grow_measures(table, are_single_steps, floor, so_far):
    """Fill the rows LARGEST and LIMIT, and set errors of round-off to 0.

    Returns whether an error is NaN. The arguments are those of `assess_errors`.
    """
    low, high, measure = so_far[LOWEST], so_far[HIGHEST], so_far[MEASURE]
    any_nan = False
    for k in range(table.shape[1]):
        rounding = max(floor, table[ROUNDING, k])
        if table[ERROR, k] <= rounding:
            table[ERROR, k] = 0.0
        error, size = table[ERROR, k], table[SIZE, k]
        any_nan = any_nan or math.isnan(error)
        if table[LEAST, k] < low or math.isnan(low):
            low = table[LEAST, k]
        if table[GREATEST, k] > high or math.isnan(high):
            high = table[GREATEST, k]
        if high - low > size:
            size = high - low
        table[LARGEST, k] = size if size > measure else measure
        if error <= TOLERATED_SHARE * table[LARGEST, k] and (
            are_single_steps or error <= measure or measure <= rounding
        ):
            measure = table[LARGEST, k]
        table[LIMIT, k] = measure
    so_far[LOWEST], so_far[HIGHEST], so_far[MEASURE] = low, high, measure
    return any_nan


@jit
def assess_single_steps(table, least_measure, so_far):
    """Assess errors of single steps, up to the first that ruins the run.

    Returns the largest ratio of an error to its measure, its index, and the index of the ruining
    error or -1; with a ruining error, its ratio and index.

    Parameters
    ----------
    least_measure
        least measure for the decision whether an error ruins the run
    """
    share, worst = 0.0, 0
    for k in range(table.shape[1]):
        error, limit = table[ERROR, k], table[LIMIT, k]
        if least_measure > limit:
            limit = least_measure
        if table[RUINING, k] > limit and not error <= TOLERATED_SHARE * table[LARGEST, k]:
            so_far[WORST] = math.inf
            return share_of(error, limit), k, k
        if share_of(error, table[LARGEST, k]) > share:
            share, worst = share_of(error, table[LARGEST, k]), k
    return share, worst, -1


@jit
def assess_since_start(table, measure, so_far):
    """Assess errors since the start, which share one measure.

    Returns the largest ratio of an error to the measure, its index, and the index of the first
    ruining error or -1.
    """
    share, worst, ruining_index = 0.0, 0, -1
    for k in range(table.shape[1]):
        error = table[ERROR, k]
        if (
            ruining_index < 0
            and table[RUINING, k] > measure
            and not error <= TOLERATED_SHARE * measure
        ):
            ruining_index = k
        if share_of(error, measure) > share:
            share, worst = share_of(error, measure), k
        if error > so_far[WORST]:
            so_far[WORST] = error
    return share, worst, ruining_index


@jit
def assess_errors(table, are_single_steps, start_kinetic, floor, kick_energy, so_far):
    """Assess the errors of a table.

    Returns the largest ratio of an error to its measure, its index, the index of the first error
    that ruins the run or -1, whether an error is NaN, and the measure of the run.

    Parameters
    ----------
    table : array, shape (8, n)
        see above, in the order of the run
    are_single_steps
        whether these are errors of single steps. Such an error is measured by the samples up to it.
        An error since the start is measured by the whole run; for the measure to grow, it must also
        not exceed the measure before it, so that a run that jumps into a deep well is not measured
        by the depth of the well
    start_kinetic
        |T| at the start
    floor
        least value of ROUNDING
    kick_energy
        the kinetic energy that the forces at the start give in a step
    so_far : array, shape (4,)
        smallest and largest V, measure and largest error of the samples before; they are updated.
        The largest error becomes infinite if a single step ruins the run
    """
    worst_before = so_far[WORST]
    any_nan = grow_measures(table, are_single_steps, floor, so_far)
    measure, at_rest = so_far[MEASURE], start_kinetic <= REST_SHARE * kick_energy
    if are_single_steps:
        least_measure = kick_energy if at_rest else 0.0
        share, worst, ruining_index = assess_single_steps(table, least_measure, so_far)
        if ruining_index >= 0:
            return share, worst, ruining_index, any_nan, measure
    else:
        if at_rest and measure <= start_kinetic:
            measure = kick_energy
        share, worst, ruining_index = assess_since_start(table, measure, so_far)
    return max(share, share_of(worst_before, measure)), worst, ruining_index, any_nan, measure
