"""Flights of many grains, eight at a time, each in a lane of its own from its start to its end.

A lane whose grain has landed, or has reached its last time, takes the next grain. Each lane is in
its own step and iteration: a pass serves all eight, and none waits for another, so that a grain's
numbers depend on nothing but the grain. A step leads to the next multiple of the grain's step; the
first one, from the start, may be shorter. Passes begin the following steps themselves; this module
handles starts, contacts and ends, lane by lane.

Contact with the ground z = 0: where the curve of a solved step comes down to it, or the step ends
below it, the step is repeated up to the first root of the curve, or its end, and then, if
requested, up to the root of the repeated step's end, by Newton's method: the curve is of order
s + 1 inside the step, the end of order 2 s. A grain that moves upwards there flies on. Another
stays, or its vertical velocity is multiplied by -e, and the remaining step is solved again.

starts     (n, 6)    q and v                      clocks  (n, 2)  time of the start, step
constants  (n, 2)    numbers of the drag law      counts  (n, 2)  the first step's end, and the last
                     time, in steps from 0; a grain whose first is beyond its last does not start
numbers              as in benchmarks.applications.brownout.grain_pass
rules      (3,)      e, below 0: grains stay; the speed up to which they stay; whether the root of
                     the step's end is found
save_every           steps between saved positions
ends       (n, 13)   q, v, time, impulses of the drag and of contacts over the mass
codes      (n, 4)    end (FLYING and following codes), contacts, steps, passes
saved      (n, r, 3) positions after save_every k steps, k = 0, 1, ...; NaN before the start, after
                     a failure, and of a grain that does not start
"""

import math
from functools import cache

import numpy as np
from numba import types

from benchmarks.applications.brownout.grain_pass import (
    CONSTANTS,
    DECAY,
    DRAG,
    END,
    GOES_ON,
    HAS_EARLIER,
    INDEX,
    LOWEST,
    MOST_PASSES_A_STEP,
    PASSES_DONE,
    PUSH,
    SOLVED,
    STATE,
    STEP,
    STEPS_TAKEN,
    TIME,
    TIME_LEFT,
    TRIES,
    H,
    Q,
    V,
    curve_at,
    nodes_at,
    rate_at,
)
from galvi.kernels.compile.function_pointers import call_void
from galvi.kernels.compile.jit import MATRIX, TENSOR3, VECTOR, compiled_for, jit, jit_inline
from galvi.lanes.vectors import LANES

FLYING, ALOFT, LANDED, FAILED, BOUNCING = range(5)  # codes; at the end 0: it has not started
ABOVE, DOWN, AGAIN = range(3)  # what a solved step leads to
MOST_SOLVES = 8  # of one contact
MOST_CONTACTS = 1000  # of one grain
EXTRA_SOLVES = 2 + MOST_CONTACTS * (
    MOST_SOLVES + 2
)  # more solves than the contacts of one grain can ask for
HALVINGS = 80  # halvings that find a root of the curve
ROOT_TOLERANCE = 1e-15  # of the height over the step, at the root of the step's end
NO_GRAIN = -1
FULL_STEP, SHORTENED, LAST_TRY = 0, 1, 2  # what a lane is solving
END_TIME, IMPULSE, CONTACT = 6, 7, 10  # columns of ends
GRAIN, PHASE, ROOTS, TRIED_TWICE, MOST_PASSES = range(5)  # rows of `lane`


@jit_inline
def value_at(coefficients, tau):
    """sum_l coefficients_l tau^l."""
    total = 0.0
    for l in range(coefficients.size - 1, -1, -1):
        total = total * tau + coefficients[l]
    return total


@jit_inline
def first_root(coefficients, scratch):
    """The first root in (0, 1] of a polynomial that is positive at 0; 2 where there is none.

    Between roots of its derivative it is monotone, so that the roots of its derivatives are found
    first, from the highest order on. scratch (at least 3, at least size + 1) is overwritten.
    """
    n = coefficients.size
    derivative, roots, new = scratch[0], scratch[1], scratch[2]
    root_count = 0
    for order in range(n - 1, -1, -1):
        for l in range(n - order):
            factor = 1.0
            for k in range(l + 1, l + order + 1):
                factor *= k
            derivative[l] = factor * coefficients[l + order]
        part = derivative[: n - order]
        new_count, low = 0, 0.0
        for piece in range(root_count + 1):
            high = roots[piece] if piece < root_count else 1.0
            at_low, at_high = value_at(part, low), value_at(part, high)
            if (at_low > 0.0) != (at_high > 0.0):
                a, b = low, high
                for _ in range(HALVINGS):
                    middle = 0.5 * (a + b)
                    if (value_at(part, middle) > 0.0) == (at_low > 0.0):
                        a = middle
                    else:
                        b = middle
                new[new_count] = b
                new_count += 1
            low = high
        for k in range(new_count):
            roots[k] = new[k]
        root_count = new_count
    return roots[0] if root_count > 0 else 2.0


@jit_inline
def contact_fraction(work, l, numbers, s, scratch):
    """The first fraction of the step at which the curve meets the ground; 2 where it does not."""
    h, z, curve = work[H, l], work[Q + 2, l], curve_at(s)
    coefficients = scratch[3, : s + 1]
    coefficients[:] = 0.0
    coefficients[0] = z
    for k in range(s):
        v = work[V + 2, l]
        for j in range(s):
            v += h * numbers[k * s + j] * work[DECAY + 2 * s + 3 * j + 2, l]
        for m in range(s):
            coefficients[m + 1] += h * numbers[curve + m * s + k] * v
    if z == 0.0:  # from the ground: z / tau, whose value at 0 is that of the velocity there
        if not work[V + 2, l] > 0.0:
            return 0.0
        scratch[3, s + 1] = 0.0
        coefficients = scratch[3, 1 : s + 2]
        correction = h * work[V + 2, l] - coefficients[0]  # as large as the curve's error
        coefficients[0] = h * work[V + 2, l]
        coefficients[1] -= correction  # so that the end is that of the curve
    lowest = coefficients[0]
    for m in range(1, coefficients.size):
        lowest += min(0.0, coefficients[m])
    return 2.0 if lowest > 0.0 else first_root(coefficients, scratch)


@jit_inline
def set_step(work, l, h, numbers, s):
    """Prepare the solve of a step of size h from the state in work."""
    work[H, l], work[STATE, l], work[TRIES, l] = h, GOES_ON, 0.0
    rate, nodes = numbers[rate_at(s)], nodes_at(s)
    start = math.exp(rate * work[TIME, l])
    for j in range(s):
        work[DECAY + j, l] = start * math.exp(rate * numbers[nodes + j] * h)


@jit_inline
def set_guess(work, l, s):
    """Set all accelerations to 0, and mark those of the step before as missing."""
    work[HAS_EARLIER, l] = 0.0
    for k in range(3 * s):
        work[DECAY + 2 * s + k, l] = 0.0


@jit_inline
def advance(work, l):
    """Move the state to the end of the solved step."""
    for i in range(3):
        work[Q + i, l], work[V + i, l] = work[END + i, l], work[END + 3 + i, l]
        work[PUSH + i, l] += work[DRAG + i, l]
    if work[H, l] > 0.0:
        work[STEPS_TAKEN, l] += 1.0


@jit_inline
def start_grain(work, l, start, t, step, index, constants, numbers, s):
    """Give a lane to a grain; its first step ends at `index` times its step."""
    work[:, l] = 0.0
    for i in range(6):
        work[Q + i, l] = start[i]
    work[CONSTANTS, l], work[CONSTANTS + 1, l] = constants[0], constants[1]
    work[INDEX, l], work[STEP, l] = index, step
    work[TIME, l], work[TIME_LEFT, l] = t, index * step - t
    rate, nodes = numbers[rate_at(s)], nodes_at(s)
    for j in range(s):
        work[DECAY + s + j, l] = math.exp(rate * numbers[nodes + j] * step)
    set_step(work, l, work[TIME_LEFT, l], numbers, s)


@jit_inline
def finish_grain(work, lane, l, outcome, ends, codes):
    """Write the end and the counts of a grain, and set its lane idle."""
    grain = lane[GRAIN, l]
    codes[grain, 0] = outcome
    codes[grain, 2], codes[grain, 3] = int(work[STEPS_TAKEN, l]), int(work[PASSES_DONE, l])
    for i in range(3):
        ends[grain, i], ends[grain, 3 + i] = work[Q + i, l], work[V + i, l]
        ends[grain, IMPULSE + i] = work[PUSH + i, l]
    ends[grain, END_TIME] = work[TIME, l]
    set_idle(work, lane, l)


@jit_inline
def set_idle(work, lane, l):
    """Set a lane idle: it integrates a resting particle with h = 0."""
    work[:, l] = 0.0
    work[Q + 2, l] = 1.0
    lane[GRAIN, l] = NO_GRAIN


@jit_inline
def save_at(saved, grain, index, save_every, x, y, z):
    """Save a position if the end of step `index` is a saved time."""
    if saved.shape[1] and index % save_every == 0 and index // save_every < saved.shape[1]:
        row = index // save_every
        saved[grain, row, 0], saved[grain, row, 1], saved[grain, row, 2] = x, y, z


@jit_inline
def save_from(saved, grain, index, save_every, x, y, z):
    """Save a position at all saved times from the end of step `index` on."""
    for row in range((index + save_every - 1) // save_every, saved.shape[1]):
        saved[grain, row, 0], saved[grain, row, 1], saved[grain, row, 2] = x, y, z


@jit_inline
def after_step(work, lane, l, numbers, s, finds_root, scratch):
    """ABOVE or DOWN after a solved step, or AGAIN where another solve was prepared."""
    h, phase = work[H, l], lane[PHASE, l]
    if phase == FULL_STEP:
        tau = 2.0
        if not work[LOWEST, l] > 0.0:  # also from the ground
            tau = contact_fraction(work, l, numbers, s, scratch)
        low, speed = work[END + 2, l], work[END + 5, l]
        if tau > 1.0 and (low < 0.0 or (low == 0.0 and speed < 0.0)):  # the curve stays above
            tau = 1.0
        if tau == 0.0:
            work[H, l] = 0.0
            return DOWN
        if tau > 1.0:
            return ABOVE
        lane[PHASE, l], lane[ROOTS, l] = SHORTENED, 0
        set_step(work, l, tau * h, numbers, s)
        return AGAIN
    if phase == LAST_TRY:
        return DOWN if work[END + 2, l] <= 0.0 else ABOVE
    lane[ROOTS, l] += 1
    z, speed = work[END + 2, l], work[END + 5, l]
    on_ground = abs(z) <= ROOT_TOLERANCE * (work[Q + 2, l] + h * abs(speed))
    if finds_root > 0.0 and not on_ground and lane[ROOTS, l] < MOST_SOLVES and speed < 0.0:
        longer = h - z / speed
        if longer >= work[TIME_LEFT, l]:  # not within the step
            lane[PHASE, l] = LAST_TRY
            set_step(work, l, work[TIME_LEFT, l], numbers, s)
            return AGAIN
        if longer > 0.0:
            set_step(work, l, longer, numbers, s)
            return AGAIN
    return DOWN


@jit_inline
def make_contact(work, grain, l, rules, ends, codes):
    """Apply a contact at the end of the solved step; returns FLYING, LANDED or BOUNCING."""
    restitution, slowest, _ = rules
    h = work[H, l]
    if h > 0.0:
        advance(work, l)
    work[TIME, l] += h
    work[TIME_LEFT, l] -= h
    if h > 0.0 and work[V + 2, l] > 0.0:  # the curve came down, the step does not
        work[Q + 2, l] = max(work[Q + 2, l], 0.0)
        return FLYING
    codes[grain, 1] += 1
    work[Q + 2, l] = 0.0
    vertical_velocity = work[V + 2, l]
    if restitution < 0.0 or not -restitution * vertical_velocity > slowest:
        for i in range(3):
            ends[grain, CONTACT + i] -= work[V + i, l]
            work[V + i, l] = 0.0
        return LANDED
    work[V + 2, l] = -restitution * vertical_velocity
    ends[grain, CONTACT + 2] -= (1.0 + restitution) * vertical_velocity
    return BOUNCING if codes[grain, 1] >= MOST_CONTACTS else FLYING


@jit_inline
def after_solve(work, lane, l, numbers, s, rules, save_every, last, scratch, records):
    """Continue after a pass that ends a lane's solve; returns FLYING, or how its grain ended."""
    ends, codes, saved = records
    grain, index, is_solved = lane[GRAIN, l], int(work[INDEX, l]), work[STATE, l] == SOLVED
    if not is_solved and lane[TRIED_TWICE, l] == 0:  # once more, without an extrapolated guess
        lane[TRIED_TWICE, l] = 1
        set_guess(work, l, s)
        set_step(work, l, work[H, l], numbers, s)
        return FLYING
    if not is_solved or work[PASSES_DONE, l] > lane[MOST_PASSES, l]:
        for i in range(6):
            work[Q + i, l] = np.nan
        save_from(saved, grain, index, save_every, np.nan, np.nan, np.nan)
        return FAILED
    lane[TRIED_TWICE, l] = 0
    event = after_step(work, lane, l, numbers, s, rules[2], scratch)
    if event == AGAIN:
        return FLYING
    lane[PHASE, l] = FULL_STEP
    if event == ABOVE:
        save_at(saved, grain, index, save_every, work[END, l], work[END + 1, l], work[END + 2, l])
        if index < last:
            return FLYING  # the next pass begins the next step
        advance(work, l)
        work[TIME, l] = index * work[STEP, l]
        return ALOFT
    outcome = make_contact(work, grain, l, rules, ends, codes)
    if outcome == FLYING:
        set_guess(work, l, s)
        set_step(work, l, work[TIME_LEFT, l], numbers, s)  # the rest, which may be 0
    elif outcome == LANDED:
        save_from(saved, grain, index, save_every, work[Q, l], work[Q + 1, l], 0.0)
    else:
        save_from(saved, grain, index, save_every, np.nan, np.nan, np.nan)
    return outcome


@jit
def fly(law, grains, s, numbers, rules, save_every, work, records):
    """Do all flights of a batch; writes ends, codes and saved."""
    starts, clocks, constants, counts = grains
    ends, codes, saved = records
    n = starts.shape[0]
    lane, scratch = np.zeros((5, LANES), np.int64), np.zeros((4, s + 2))
    for l in range(LANES):
        set_idle(work, lane, l)
    next_grain, busy = 0, 0
    while True:
        if busy < LANES and next_grain < n:
            for l in range(LANES):
                while lane[GRAIN, l] == NO_GRAIN and next_grain < n:
                    grain = next_grain
                    next_grain += 1
                    t, step = clocks[grain, 0], clocks[grain, 1]
                    index, last = counts[grain, 0], counts[grain, 1]
                    for i in range(6):
                        ends[grain, i] = starts[grain, i]
                    ends[grain, END_TIME] = t
                    if index > last:
                        continue
                    if t == (index - 1) * step:
                        save_at(
                            saved,
                            grain,
                            index - 1,
                            save_every,
                            starts[grain, 0],
                            starts[grain, 1],
                            starts[grain, 2],
                        )
                    lane[:, l] = 0
                    lane[GRAIN, l], lane[MOST_PASSES, l] = (
                        grain,
                        (last - index + 1 + EXTRA_SOLVES) * 2 * MOST_PASSES_A_STEP,
                    )
                    start_grain(
                        work, l, starts[grain], t, step, index, constants[grain], numbers, s
                    )
                    busy += 1
        if busy == 0:
            break
        call_void(law[0], work, numbers)
        for l in range(LANES):
            grain = lane[GRAIN, l]
            if grain == NO_GRAIN or work[STATE, l] == GOES_ON:
                continue
            last = counts[grain, 1]
            outcome = after_solve(
                work, lane, l, numbers, s, rules, save_every, last, scratch, records
            )
            if outcome != FLYING:
                finish_grain(work, lane, l, outcome, ends, codes)
                busy -= 1


@cache
def compiled_fly():
    """The compiled or cached ``fly``, one kernel for all winds and drag laws."""
    signature = types.void(
        types.int64[::1],
        types.Tuple((MATRIX, MATRIX, MATRIX, types.int64[:, ::1])),
        types.int64,
        VECTOR,
        types.UniTuple(types.float64, 3),
        types.int64,
        MATRIX,
        types.Tuple((MATRIX, types.int64[:, ::1], TENSOR3)),
    )
    return compiled_for(fly, signature)
