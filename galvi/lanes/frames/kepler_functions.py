"""The functions of Kepler's frame that the kernel of collocation calls, in the plane and in space.

Numbers and state as in `galvi.lanes.frames.kepler_drift`.
"""

from __future__ import annotations

from galvi.kernels.compile.jit import jit_inline, jit_noalloc
from galvi.kernels.lie.arithmetic import two_sum
from galvi.lanes.frames.hierarchy import FIRST, MIDDLE, nested_rates
from galvi.lanes.frames.kepler import kepler_rates
from galvi.lanes.frames.kepler_drift import kepler_drift, planets_of
from galvi.lanes.frames.kepler_motion import BLOCKS, HEAD, MASS_SHARE
from galvi.lanes.gravity import fused

PLANE, SPACE = (0, 0), (0, 0, 0)


@jit_inline
def move_barycentre(numbers, share, state, first, D):
    """Move the barycentre, in D columns of the state from ``first`` on, along its straight line."""
    t = share * numbers[0]
    for i in range(first, first + D):
        displacement = t * state[6, i]
        low = fused(t, state[6, i], -displacement) + (t * state[7, i] + state[5, i])
        position, error = two_sum(state[4, i], displacement)
        state[4, i], state[5, i] = two_sum(position, error + low)


@jit_inline
def leave(numbers, state, D):
    """Set rows 0 and 2 of the state to the positions and velocities of the bodies, from rows 4 to
    7; rows 1 and 3 to 0."""
    n = planets_of(numbers)
    share, bodies = HEAD + MASS_SHARE * n, HEAD + BLOCKS * n
    for half in range(2):
        out, source = 2 * half, 4 + 2 * half
        for x in range(D):
            inner_centre = 0.0  # barycentre of the star and the planets before i, from the star
            for i in range(n):
                inner_centre += numbers[share + i] * state[source, x * n + i]
            centre = D * n + x
            star = state[source, centre] + (state[source + 1, centre] - inner_centre)
            state[out, D * int(numbers[bodies]) + x] = star
            inner_centre = 0.0
            for i in range(n):
                position = state[source, x * n + i]
                body = D * int(numbers[bodies + 1 + i]) + x
                state[out, body] = star + (inner_centre + (position + state[source + 1, x * n + i]))
                inner_centre += numbers[share + i] * position
    for i in range(D * (n + 1)):
        state[1, i], state[3, i] = 0.0, 0.0


@jit_inline
def leave_pairs(numbers, state, D):
    """`leave` for a hierarchy: from the outermost pair on, the centre of each pair is replaced by
    those of its two sides."""
    n = planets_of(numbers)
    share, first = HEAD + MASS_SHARE * n, HEAD + FIRST * n
    middle, bodies = HEAD + MIDDLE * n, HEAD + BLOCKS * n
    for half in range(2):
        out, source = 2 * half, 4 + 2 * half
        low = out + 1
        for x in range(D):
            top, centre = D * int(numbers[bodies]) + x, D * n + x
            state[out, top], state[low, top] = state[source, centre], state[source + 1, centre]
            for i in range(n - 1, -1, -1):
                first_column = D * int(numbers[bodies + int(numbers[first + i])]) + x
                second_column = D * int(numbers[bodies + int(numbers[middle + i])]) + x
                position, position_low = state[source, x * n + i], state[source + 1, x * n + i]
                share_i = numbers[share + i]
                state[out, first_column], lost = two_sum(
                    state[out, first_column], -(share_i * position)
                )
                state[low, first_column] += lost - share_i * position_low
                state[out, second_column], lost = two_sum(state[out, first_column], position)
                state[low, second_column] = state[low, first_column] + (lost + position_low)
        for i in range(D * (n + 1)):
            state[out, i], state[low, i] = state[out, i] + state[low, i], 0.0


@jit_noalloc
def rates_in_space(numbers, nodes, W, work, guess, k, pass_number):
    """RATES of galvi.lanes.frames.collocation, in space."""
    kepler_rates(SPACE, numbers, nodes, W, work, guess, k, pass_number)


@jit_noalloc
def rates_in_plane(numbers, nodes, W, work, guess, k, pass_number):
    """RATES of galvi.lanes.frames.collocation, in the plane."""
    kepler_rates(PLANE, numbers, nodes, W, work, guess, k, pass_number)


@jit_noalloc
def nested_rates_in_space(numbers, nodes, W, work, guess, k, pass_number):
    """RATES of bodies in a hierarchy."""
    nested_rates(SPACE, numbers, nodes, W, work, guess, k, pass_number)


@jit_noalloc
def nested_rates_in_plane(numbers, nodes, W, work, guess, k, pass_number):
    """RATES of bodies in a hierarchy."""
    nested_rates(PLANE, numbers, nodes, W, work, guess, k, pass_number)


@jit_noalloc
def rates_of_two(numbers, nodes, W, work, guess, k, pass_number):
    """RATES of two bodies, which are 0: their attraction is all in the frame."""
    for i in range(k.shape[0]):
        for j in range(k.shape[1]):
            k[i, j] = 0.0 * W[i, j]  # NaN where the state is NaN


@jit_noalloc
def drift_in_space(numbers, share, state):
    """DRIFT."""
    kepler_drift(SPACE, numbers, share, state)
    move_barycentre(numbers, share, state, 3 * planets_of(numbers), 3)


@jit_noalloc
def drift_in_plane(numbers, share, state):
    """DRIFT."""
    kepler_drift(PLANE, numbers, share, state)
    move_barycentre(numbers, share, state, 2 * planets_of(numbers), 2)


@jit_noalloc
def leave_space(numbers, state):
    """LEAVE."""
    leave(numbers, state, 3)


@jit_noalloc
def leave_plane(numbers, state):
    """LEAVE."""
    leave(numbers, state, 2)


@jit_noalloc
def leave_pairs_in_space(numbers, state):
    """LEAVE of bodies in a hierarchy."""
    leave_pairs(numbers, state, 3)


@jit_noalloc
def leave_pairs_in_plane(numbers, state):
    """LEAVE of bodies in a hierarchy."""
    leave_pairs(numbers, state, 2)


PLANETS = {
    2: (rates_in_plane, drift_in_plane, leave_plane),
    3: (rates_in_space, drift_in_space, leave_space),
}
NESTED = {
    2: (nested_rates_in_plane, drift_in_plane, leave_pairs_in_plane),
    3: (nested_rates_in_space, drift_in_space, leave_pairs_in_space),
}
