"""Scales of the motion in one step on a group; notation of galvi.kernels.on_group.stages.

scale  (d,)  scale of each component: 1 for rotations; the same for all positions of a factor, 0 if
             it is not known. A known scale is at least LEAST_NORMAL, below which changes lose their
             relative accuracy, and LEAST_COUPLED_MOTION times the largest motion that the mass
             couples to the factor, since a smaller motion may be round-off of that one
"""

import numpy as np

from galvi.kernels.compile.jit import jit_noalloc
from galvi.kernels.constants import LEAST_NORMAL
from galvi.kernels.lie.product import COUPLED, DIMENSION, ROTATIONS

QUIET_RATE = 2.0**-47  # ratio of a rate to the largest up to which it may be round-off
BAD_SCALE_RATIO = 16.0  # ratio of scales above which the larger one was a bad guess
# Least ratio of a scale to the largest coupled motion: changes that are round-off of this motion
# are then below ROUND_OFF_CHANGE of galvi.kernels.nystrom.solve.
LEAST_COUPLED_MOTION = 2.0**-12
# Ratio of the last two Legendre terms to the largest from which on a motion is not resolved.
UNRESOLVED_SHARE = 0.1


@jit_noalloc
def largest_coupled(layout, number, sizes):
    """The largest |size| in ``sizes`` (d,) of the factors with this number in column COUPLED."""
    start, size = 0, 0.0
    for factor in range(layout.shape[0]):
        end = start + layout[factor, DIMENSION]
        if layout[factor, COUPLED] == number:
            for i in range(start, end):
                size = max(size, abs(sizes[i]))
        start = end
    return size


@jit_noalloc
def grow_scale(layout, coordinates, rate, h, scale):
    """Raise the scales (d,) of translations to the largest |coordinate| and |h rate| (d, s) of
    their factor."""
    start, number, floor = 0, -1, 0.0
    for factor in range(layout.shape[0]):
        first, end = start + layout[factor, ROTATIONS], start + layout[factor, DIMENSION]
        start = end
        if first == end:
            continue
        if layout[factor, COUPLED] != number:
            number = layout[factor, COUPLED]
            first_rate = largest_coupled(layout, number, rate[:, 0])
            last_rate = largest_coupled(layout, number, rate[:, rate.shape[1] - 1])
            floor = LEAST_COUPLED_MOTION * abs(h) * max(first_rate, last_rate)
        size = floor
        for i in range(first, end):
            for j in range(coordinates.shape[1]):
                size = max(size, abs(coordinates[i, j]), abs(h * rate[i, j]))
        for i in range(first, end):
            scale[i] = max(scale[i], size)
            if 0.0 < scale[i] < LEAST_NORMAL:
                scale[i] = LEAST_NORMAL


@jit_noalloc
def amplification(layout, coordinates, rate, h):
    """The largest of 1 and |xi|, |h xi'| of rotations, (d, s).

    Near the limit of a chart these coordinates, and with them their rounding errors, grow without
    bound.
    """
    size, start = 1.0, 0
    for factor in range(layout.shape[0]):
        for i in range(start, start + layout[factor, ROTATIONS]):
            for j in range(coordinates.shape[1]):
                size = max(size, abs(coordinates[i, j]), abs(h * rate[i, j]))
        start += layout[factor, DIMENSION]
    return size


@jit_noalloc
def is_resolved(analysis, velocities):
    """Whether the last two Legendre terms of the velocities (d, s) at the stages are small; False
    for less than three stages.

    Near the limit of a chart the stage equations have roots that are no motions: a steady turning
    by 4 radians in a step "ends" at 178.7 degrees, at velocities from 0.008 to 1.2 times the true
    one.

    Parameters
    ----------
    analysis : array, shape (s, s)
        row j holds the contribution of the value at stage j to each term
    """
    d, s = velocities.shape
    if s < 3:
        return False
    size, tail = 0.0, 0.0
    for a in range(d):
        for l in range(s):
            term = 0.0
            for j in range(s):
                term += analysis[j, l] * velocities[a, j]
            size = max(size, abs(term))
            if l >= s - 2:
                tail = max(tail, abs(term))
    return tail < UNRESOLVED_SHARE * size


@jit_noalloc
def largest(values):
    """The largest absolute value of (d, s)."""
    size = 0.0
    for a in range(values.shape[0]):
        for j in range(values.shape[1]):
            size = max(size, abs(values[a, j]))
    return size


@jit_noalloc
def relative_size(coordinates, rate, h, scale, rate_scale):
    """The largest ratio of |coordinate| and |h rate| (d, s) to the scale, 1 for a scale of 0; 0 if
    all are 0, NaN if one is not finite.

    Rates are included, since only they depend on every function of a space (M lemma 1), but not
    those up to QUIET_RATE times rate_scale, which may be round-off.
    """
    size, total = 0.0, 0.0
    for a in range(coordinates.shape[0]):
        for j in range(coordinates.shape[1]):
            motion = abs(coordinates[a, j])
            if abs(rate[a, j]) > QUIET_RATE * rate_scale:
                motion = max(motion, abs(h * rate[a, j]))
            if motion > 0.0:
                size = max(size, motion / scale[a] if scale[a] > 0.0 else 1.0)
            total += abs(coordinates[a, j]) + abs(rate[a, j])
    return size if total < np.inf else np.nan


@jit_noalloc
def shrink_scale(new_scale, scale):
    """Set the components of scale (d,) that exceed BAD_SCALE_RATIO times a positive ``new_scale``
    to that; returns whether there were any."""
    has_shrunk = False
    for a in range(scale.size):
        if scale[a] > BAD_SCALE_RATIO * new_scale[a] > 0.0:
            scale[a], has_shrunk = new_scale[a], True
    return has_shrunk
