"""Passages of two point masses that are too short for a step.

A step of size h whose curves have n coefficients resolves the attraction of two bodies along their
passage with an error of about

    error = kick min(rho^-2n, exp(-4 n tau / h))

tau   distance of the nearest complex time at which the bodies would meet from the real times, on
      the conic section of the two bodies alone: d / v for a straight passage at distance d with
      speed v, 4/3 of that for a parabolic one
rho   sum of the semi-axes of the ellipse through that time with foci at the step's ends, in units
      of half a step: the convergence of polynomials of degree n to a function with such a pole
kick  change of the relative velocity over that velocity, at most 1: 2 / e for eccentricity e > 1

The error is one of the relative velocity, over that velocity. Measured on planets that meet near
another star it is 1 to 10 times too small for the positions an orbit later
(tests/properties/test_ruined_runs.py).

masses   (bodies,)               G m; pairs of two massless bodies have no passages
Q, c     (bodies * dimension, s) positions at the stages, and the nodes (s,)
passage  (FOUND + 1 + bodies,)   largest error so far, its two bodies, their distance, and its step,
                                 in a clock its time; then, at FOUND, the dimension and the masses,
                                 which a run does not change
"""

from __future__ import annotations

import math
from functools import cache

from numba import types

from galvi.kernels.compile.jit import MATRIX, VECTOR, compiled_for, jit_inline, jit_noalloc

FOUND = 5  # number of entries of ``passage`` that a run changes
# Passages whose error exceeds ``UNRESOLVED`` are within PASSAGE_REACH h v / n at some stage.
PASSAGE_REACH = 3.0
PARABOLA_ECCENTRICITY = 1e-6  # |e - 1| below which a conic section is taken as a parabola
PARABOLA_ENERGY = 1e-3  # |v^2 d / 2 - G m| / G m below which its times are those of a parabola
UNRESOLVED = 1e-5  # error above which a passage is reported; e^(-4 n tau / h) for tau = 2.9 h / n
# Also in a clock: of 240 runs through 40 passages of planets it missed none that was wrong by more
# than 1e-3, and reported 4 that were right to 1e-6; in problems that clocks solve the error stays
# below 4e-7 up to steps of 0.8 (tests/properties/test_passages_in_a_clock.py).
# In a frame errors are as large as this estimate where bodies pass fast, up to 300 times as large
# where they pass slowly or are bound for a while: of 208 runs of comets past Jupiter 154 were wrong
# by more than 1e-4 au; all but one, wrong by 4e-4, were reported, and none that was right to 1e-7
# (tests/properties/test_passages_in_frames.py has some of them).
SLOW_PASSAGE_WEIGHT = 60.0  # weight, in a frame, of a passage with d v^2 = G m
UNRESOLVED_IN_A_FRAME = 6e-7


@jit_noalloc
def passage_error(squared_distance, squared_speed, along, mu, fraction, h, n):
    """The error of a passage from |q|^2, |v|^2 and q . v of the pair at a time of the step.

    Parameters
    ----------
    mu
        G times the sum of the masses
    where
        that time in the step, in [0, 1]
    """
    distance = math.sqrt(squared_distance)
    energy = squared_speed - 2.0 * mu / distance
    squared_momentum = max(squared_distance * squared_speed - along * along, 0.0)
    e = math.sqrt(max(1.0 + energy * squared_momentum / (mu * mu), 0.0))
    pericentre = squared_momentum / (mu * (1.0 + e))
    if e == 0.0 or not e < math.inf:
        return 0.0
    inverse_mean_motion, axis = 0.0, 0.0
    if energy != 0.0:
        axis = mu / abs(energy)
        inverse_mean_motion = math.sqrt(axis / mu) * axis
    if abs(e - 1.0) < PARABOLA_ECCENTRICITY:
        tau = 2.0 / 3.0 * pericentre * math.sqrt(2.0 * pericentre / mu)
    elif e < 1.0:
        tau = inverse_mean_motion * (math.acosh(1.0 / e) - math.sqrt(1.0 - e * e))
    else:
        tau = inverse_mean_motion * (math.sqrt(e * e - 1.0) - math.acos(1.0 / e))
    if abs(energy) * distance < PARABOLA_ENERGY * mu:
        since_pericentre = along * (pericentre + along * along / (6.0 * mu)) / mu
    elif energy < 0.0:
        anomaly = math.atan2(along / math.sqrt(mu * axis), 1.0 - distance / axis)
        since_pericentre = inverse_mean_motion * (anomaly - e * math.sin(anomaly))
    else:
        anomaly = math.asinh(along / math.sqrt(mu * axis) / e)
        since_pericentre = inverse_mean_motion * (e * math.sinh(anomaly) - anomaly)
    x, y = 2.0 * (fraction - since_pericentre / h) - 1.0, 2.0 * tau / abs(h)
    semi_axis_sum = 0.5 * (math.hypot(x - 1.0, y) + math.hypot(x + 1.0, y))
    rho = semi_axis_sum + math.sqrt(max(semi_axis_sum * semi_axis_sum - 1.0, 0.0))
    return min(1.0, 2.0 / e) * math.exp(-2.0 * n * max(math.log(rho), y))


@jit_inline
def near_limit(passage, v, h, n):
    """(fast, slow): a passage is resolved if the squared distance at the stages exceeds fast, and
    its power 3/2 exceeds slow.

    Both are (PASSAGE_REACH h v / n)^2. For fast, v is the sum of the two largest speeds relative to
    the heaviest body, from the velocities v (d,); for slow it is that of a parabola, v^2 = 2 G m /
    d.
    """
    dimension, masses = int(passage[FOUND]), passage[FOUND + 1 :]
    star, first, second, heavy = 0, 0.0, 0.0, 0.0
    for body in range(masses.size):
        if masses[body] > masses[star]:
            star = body
    for body in range(masses.size):
        square = 0.0
        for x in range(dimension):
            speed = v[body * dimension + x] - v[star * dimension + x]
            square += speed * speed
        if square > first:
            first, second = square, first
        elif square > second:
            second = square
        if body != star:
            heavy = max(heavy, masses[body])
    reach = PASSAGE_REACH * h / n
    fast = reach * reach * (first + second + 2.0 * math.sqrt(first * second))
    slow = 2.0 * reach * reach * (masses[star] + heavy)
    return fast, slow


@jit_noalloc
def note_pair(passage, i, j, masses, Q, c, q0, q1, h, n, slow_weight, number):
    """Update ``passage`` by two bodies in a step from q0 to q1 by way of Q (bodies * dimension, s)
    at shares c of it. The path from one to the next is taken as straight where they are closest.

    Parameters
    ----------
    slow
        weight of a passage at the distance d with d v^2 = G m, see ``SLOW_PASSAGE_WEIGHT``; with 0
        all weights are 1
    """
    dimension, stages = int(passage[FOUND]), c.size
    row_i, row_j = i * dimension, j * dimension
    closest, squared_speed, along, fraction = math.inf, 0.0, 0.0, 0.0
    for k in range(stages + 1):
        first = c[k - 1] if k > 0 else 0.0
        last = c[k] if k < stages else 1.0
        if not last > first:
            continue
        start, moved, square = 0.0, 0.0, 0.0
        for x in range(dimension):
            gap = (
                Q[row_j + x, k - 1] - Q[row_i + x, k - 1]
                if k > 0
                else q0[row_j + x] - q0[row_i + x]
            )
            end = Q[row_j + x, k] - Q[row_i + x, k] if k < stages else q1[row_j + x] - q1[row_i + x]
            square += gap * gap
            start += gap * (end - gap)
            moved += (end - gap) * (end - gap)
        share = min(max(-start / moved, 0.0), 1.0) if moved > 0.0 else 0.0
        square += share * (2.0 * start + share * moved)
        if square < closest:
            time = (last - first) * h
            closest, squared_speed = max(square, 0.0), moved / (time * time)
            along, fraction = (start + share * moved) / time, first + share * (last - first)
    if not closest > 0.0:
        return
    mu = masses[i] + masses[j]
    error = passage_error(closest, squared_speed, along, mu, fraction, h, n)
    if slow_weight > 0.0 and squared_speed > 0.0:
        error = min(1.0, error * max(1.0, slow_weight * mu / (math.sqrt(closest) * squared_speed)))
    if error > passage[0]:
        passage[0], passage[1], passage[2] = error, i, j
        passage[3], passage[4] = math.sqrt(closest), number


@jit_noalloc
def note_passages(passage, Q, c, q0, q1, h, n, limit, number):
    """Update ``passage`` by the pairs of the step from q0 to q1, the run's ``number``-th.

    Parameters
    ----------
    limit
        squared distance at the stages above which a pair is left out
    """
    dimension, masses, stages = int(passage[FOUND]), passage[FOUND + 1 :], c.size
    for i in range(masses.size):
        for j in range(i + 1, masses.size):
            if masses[i] + masses[j] == 0.0:
                continue
            row_i, row_j = i * dimension, j * dimension
            is_close = limit == math.inf
            for k in range(stages):
                square = 0.0
                for x in range(dimension):
                    gap = Q[row_j + x, k] - Q[row_i + x, k]
                    square += gap * gap
                is_close = is_close or square < limit
            if is_close:
                note_pair(passage, i, j, masses, Q, c, q0, q1, h, n, 0.0, number)


@jit_inline
def note_states(passage, q, v, t, n):
    """Update ``passage`` by the pairs in the steps between states q and v (k + 1, bodies *
    dimension) at times t (k + 1,), each with its own length.

    A step that ends close to another body errs most, and the closest approach may lie beyond it:
    so the conic section of the end with the smaller distance is evaluated. A pair whose path along
    the chord stays farther away than PASSAGE_REACH h v / n is skipped.
    """
    dimension, masses = int(passage[FOUND]), passage[FOUND + 1 :]
    for step in range(t.size - 1):
        h = t[step + 1] - t[step]
        reach = PASSAGE_REACH / n
        for i in range(masses.size):
            for j in range(i + 1, masses.size):
                mu = masses[i] + masses[j]
                if mu == 0.0:
                    continue
                row_i, row_j = i * dimension, j * dimension
                square, end, start, moved = 0.0, 0.0, 0.0, 0.0
                for x in range(dimension):
                    gap = q[step, row_j + x] - q[step, row_i + x]
                    last = q[step + 1, row_j + x] - q[step + 1, row_i + x]
                    square += gap * gap
                    end += last * last
                    start += gap * (last - gap)
                    moved += (last - gap) * (last - gap)
                share = min(max(-start / moved, 0.0), 1.0) if moved > 0.0 else 0.0
                closest = max(square + share * (2.0 * start + share * moved), 0.0)
                slow = 2.0 * (reach * h) * (reach * h) * mu
                if closest > reach * reach * moved and closest * closest * closest > slow * slow:
                    continue
                k = step if square < end else step + 1
                end_square, squared_speed, along = min(square, end), 0.0, 0.0
                for x in range(dimension):
                    gap, rate = q[k, row_j + x] - q[k, row_i + x], v[k, row_j + x] - v[k, row_i + x]
                    squared_speed += rate * rate
                    along += gap * rate
                if not end_square > 0.0:
                    continue
                error = passage_error(end_square, squared_speed, along, mu, float(k - step), h, n)
                if error > passage[0]:
                    passage[0], passage[1], passage[2] = error, i, j
                    passage[3], passage[4] = math.sqrt(closest), t[k]


@jit_inline
def bodies_of(passage):
    """The number of bodies of a ``passage`` in a frame, which ends with bodies^2 further numbers: 1
    for pairs whose motion about each other is exact in the frame, else 0."""
    numbers = passage.size - FOUND - 1
    return int(0.5 * (math.sqrt(1.0 + 4.0 * numbers) - 1.0) + 0.5)


@jit_inline
def may_pass(passage, q, v, h, n):
    """Whether two bodies may pass in a step of a frame, of size h, with the state q, v (bodies *
    dimension,) at its centre.

    Paths are those about the heaviest body, to the second order in time. True also for a pair whose
    relative motion in half a step exceeds its distance from that body, for which this is no bound.
    """
    dimension, bodies = int(passage[FOUND]), bodies_of(passage)
    masses, is_kepler_pair = passage[FOUND + 1 : FOUND + 1 + bodies], passage[FOUND + 1 + bodies :]
    reach, star = 2.0 * PASSAGE_REACH * abs(h) / n, 0
    for body in range(bodies):
        if masses[body] > masses[star]:
            star = body
    for i in range(bodies):
        for j in range(i + 1, bodies):
            if masses[i] + masses[j] == 0.0 or is_kepler_pair[i * bodies + j] > 0.0:
                continue
            row_i, row_j, sun = i * dimension, j * dimension, star * dimension
            square_i, square_j, square, squared_speed, along = 0.0, 0.0, 0.0, 0.0, 0.0
            for x in range(dimension):
                q_i, q_j = q[row_i + x] - q[sun + x], q[row_j + x] - q[sun + x]
                gap, rate = q_j - q_i, v[row_j + x] - v[row_i + x]
                square_i += q_i * q_i
                square_j += q_j * q_j
                square += gap * gap
                squared_speed += rate * rate
                along += gap * rate
            if not 0.0 < 0.25 * squared_speed * h * h < min(square_i, square_j):
                return True
            pull_i, pull_j = masses[star] / square_i**1.5, masses[star] / square_j**1.5
            squared_acceleration = 0.0
            for x in range(dimension):
                q_i, q_j = q[row_i + x] - q[sun + x], q[row_j + x] - q[sun + x]
                relative_acceleration = pull_i * q_i - pull_j * q_j
                squared_acceleration += relative_acceleration * relative_acceleration
            time_to_closest = min(max(-along / squared_speed, -0.5 * abs(h)), 0.5 * abs(h))
            closest = max(
                square + time_to_closest * (2.0 * along + time_to_closest * squared_speed), 0.0
            )
            parabolic_reach = (2.0 * reach * reach * (masses[i] + masses[j])) ** (1.0 / 3.0)
            if (
                math.sqrt(closest)
                <= reach * math.sqrt(squared_speed)
                + parabolic_reach
                + 0.125 * math.sqrt(squared_acceleration) * h * h
            ):
                return True
    return False


@jit_inline
def note_paths(passage, Q, h, n, number):
    """Update ``passage`` by all pairs that a frame does not move about each other, in a step by way
    of Q (bodies * dimension or more, s) at shares of it, from 0 to 1, in the last row."""
    bodies = bodies_of(passage)
    masses, is_kepler_pair = passage[FOUND + 1 : FOUND + 1 + bodies], passage[FOUND + 1 + bodies :]
    for i in range(bodies):
        for j in range(i + 1, bodies):
            if masses[i] + masses[j] > 0.0 and is_kepler_pair[i * bodies + j] == 0.0:
                note_pair(
                    passage,
                    i,
                    j,
                    masses,
                    Q,
                    Q[-1],
                    Q[:, 0],
                    Q[:, 0],
                    h,
                    n,
                    SLOW_PASSAGE_WEIGHT,
                    number,
                )


@cache
def compiled_note_states():
    """The compiled ``note_states``."""
    return compiled_for(
        note_states, types.void(VECTOR, MATRIX, MATRIX, VECTOR, types.int64), jit_inline
    )
