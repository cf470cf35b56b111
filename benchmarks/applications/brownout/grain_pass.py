"""A pass of the stage equations of eight grains, one in each lane, in vector instructions.

A grain moves by v' = g - k w, with w = v - wind(q, t) and a rate k = k(|w|). With as many points as
coefficients the stage equations are, for accelerations a_j at the stages,

    V_j = v0 + h sum_k B_jk a_k,    Q_j = q0 + h c_j v0 + h^2 sum_k (A B)_jk a_k,
    a_j = g - k(|w_j|) w_j.

A pass is a step of Newton's method with one derivative for all stages and without that of the wind:
-k across the mean w and -(k + |w| k') along it. The error shrinks by a factor of the order of h
times the wind's gradient, however short the grain's relaxation time 1 / k is, and two systems of s
equations are solved instead of one of 3 s.

In lanes whose STATE is not GOES_ON a pass first begins the next step; a caller that prepares
another solve sets STATE to GOES_ON.

wind        (q, decay) -> 3 values, and
drag        (|w|^2, constants) -> (k, |w| k'), written as in galvi.lanes.elementary
work        (rows, 8), rows as below; one column for each grain
numbers     B (s, s), A B (s, s), c (s,), b (s,), g, the tolerance of the iteration,
            -1 / DESCENT, then
            (s, s)  row l: the coefficient of tau^(l + 1) of the curve from velocities at stages
            (s, s)  accelerations at the next step's stages from those at the last
            (s, 2 s) the same from the last two steps, the earlier one first
"""

from __future__ import annotations

import math
from typing import Any

from llvmlite import ir
from numba import types
from numba.extending import intrinsic

from galvi.kernels.compile.jit import MATRIX, VECTOR, jit_inline
from galvi.kernels.lie.arithmetic import where
from galvi.lanes.elementary import exp, inverse
from galvi.lanes.functions import Reciprocals
from galvi.lanes.values import Lane
from galvi.lanes.vectors import LANES, Lanes

Q, V, H, CONSTANTS, STATE, TRIES, CHANGE, HAS_EARLIER = (
    0,
    3,
    6,
    7,
    9,
    10,
    11,
    12,
)  # first row of each quantity
END = 13  # q and v at the step's end
DRAG = 19  # impulse of the drag over the mass
LOWEST = 22  # a lower bound of the curve's height
INDEX, STEP = 23, 24  # the step's end is at their product
TIME, TIME_LEFT = 25, 26  # at the state, and from there to the step's end
STEPS_TAKEN, PASSES_DONE, PUSH = 27, 28, 29  # PUSH: sum of DRAG over the steps
DECAY = 32  # exp(-t / DESCENT) at the stages, then its ratio to that at the start of a whole step,
# s each; then accelerations at the stages, and where HAS_EARLIER is 1 those of the step before,
# 3 s each
GOES_ON, SOLVED, GIVEN_UP = 0.0, 1.0, 2.0  # of STATE
MOST_PASSES_A_STEP = 64  # at most
FULL_STEP_FRACTION = 0.999  # of a step: a shorter one is the remainder of a step
SMALL_CHANGE = 3e-13  # smaller changes are assumed to shrink further at their last rate
ROUNDING_CHANGE = 1e-11  # smaller changes that are not halved are rounding errors of the wind
PASS_OF_GRAINS = types.void(MATRIX, VECTOR)
TINY = 1e-300


def rows_of_grains(s):
    """Rows of work for s stages."""
    return DECAY + 8 * s


@jit_inline
def nodes_at(s):
    """Index of c in numbers."""
    return 2 * s * s


@jit_inline
def rate_at(s):
    """Index of -1 / DESCENT in numbers."""
    return 2 * s * s + 2 * s + 2


@jit_inline
def curve_at(s):
    """Index of the curve's coefficients in numbers; starts for the next step follow them."""
    return 2 * s * s + 2 * s + 3


def solutions(B, z, right):
    """x with (1 + z B) x = r for each right-hand side r, in all lanes.

    No pivoting is needed for z >= 0 and the matrices B of Gauss points: the leading minors of
    1 + z B are positive.
    """
    s = len(B)
    rows = [[z * B[i][j] + (1.0 if i == j else 0.0) for j in range(s)] for i in range(s)]
    sides = [list(r) for r in right]
    pivots: list[Any] = []
    for i in range(s):
        for k in range(i):
            factor = rows[i][k] * pivots[k]
            for j in range(k + 1, s):
                rows[i][j] = rows[i][j] - factor * rows[k][j]
            for r in sides:
                r[i] = r[i] - factor * r[k]
        pivots.append(inverse(rows[i][i]))
    for i in reversed(range(s)):
        for r in sides:
            for j in range(i + 1, s):
                r[i] = r[i] - rows[i][j] * r[j]
            r[i] = r[i] * pivots[i]
    return sides


def newton_step(wind, drag, s, q, v, h, constants, decay, a, tables):
    """Corrected accelerations, those by the forces at the given ones, and the relative change.

    q, v (3,) at the start, h, decay (s,) and a (s, 3) are lanes, or arrays of one shape.
    """
    B, AB, c, b, g = tables
    axes, stages = range(3), range(s)
    w, forced, rates, slopes = [], [], [], []
    for j in stages:
        Vj = [v[i] + h * total(B[j], [a[k][i] for k in stages]) for i in axes]
        Qj = [q[i] + h * (c[j] * v[i] + h * total(AB[j], [a[k][i] for k in stages])) for i in axes]
        air = wind(Qj, decay[j])
        wj = [x - u for x, u in zip(Vj, air, strict=True)]
        rate, slope = drag(wj[0] * wj[0] + wj[1] * wj[1] + wj[2] * wj[2], constants)
        w.append(wj)
        rates.append(rate)
        slopes.append(slope)
        forced.append([-rate * wj[0], -rate * wj[1], g - rate * wj[2]])
    mean = [total(b, [w[j][i] for j in stages]) for i in axes]
    across, steeper = h * total(b, rates), h * total(b, slopes)
    inverse_square = inverse(mean[0] * mean[0] + mean[1] * mean[1] + mean[2] * mean[2] + TINY)
    residual = [[forced[j][i] - a[j][i] for i in axes] for j in stages]
    along = [inverse_square * total(mean, residual[j]) for j in stages]
    crosswise = [[residual[j][i] - along[j] * mean[i] for j in stages] for i in axes]
    aside = solutions(B, across, crosswise)
    (ahead,) = solutions(B, across + steeper, [along])
    new, change = [], 0.0
    for j in stages:
        step = [aside[i][j] + ahead[j] * mean[i] for i in axes]
        new.append([a[j][i] + step[i] for i in axes])
        change = change + (abs(step[0]) + abs(step[1]) + abs(step[2]))
    size = abs(h) * abs(g) + TINY
    for i in axes:
        size = size + (abs(v[i]) + abs(mean[i]))
    return new, forced, abs(h) * change * inverse(size)


def end_of_step(s, q, v, h, a, forced, tables, curve):
    """The end of a solved step.

    a, forced (s, 3): accelerations at the stages, and those by the forces before a was corrected

    Returns q and v at the end and the impulse of the drag over the mass, 9 values, and a height
    that no point of the curve is below.
    """
    B, _, c, b, g = tables
    axes, stages = range(3), range(s)
    columns = [[a[j][i] for j in stages] for i in axes]
    late = [b[j] * (1.0 - c[j]) for j in stages]
    end = [q[i] + h * (v[i] + h * total(late, columns[i])) for i in axes]
    end += [v[i] + h * total(b, columns[i]) for i in axes]
    end += [h * total(b, [forced[j][i] for j in stages]) for i in axes]
    end[8] = end[8] - h * g
    rising, lowest = [v[2] + h * total(B[j], columns[2]) for j in stages], q[2]
    for row in curve:
        part = h * total(row, rising)
        lowest = lowest + 0.5 * (part - abs(part))
    return end, lowest


def state_of(change, last, tries, tolerance):
    """GOES_ON, SOLVED or GIVEN_UP, from the changes of this pass and the last one; in lanes.

    A step is also solved where a small change predicts that the next one is below the tolerance.
    """
    will_converge = (change <= SMALL_CHANGE) & (change * change <= tolerance * last)
    is_rounding = (change <= ROUNDING_CHANGE) & (change >= 0.5 * last)
    is_solved = (change <= tolerance) | ((tries > 1.0) & (will_converge | is_rounding))
    may_go_on = (change < math.inf) & (tries < MOST_PASSES_A_STEP)
    return where(is_solved, SOLVED, where(may_go_on, GOES_ON, GIVEN_UP))


def total(factors, values):
    """The sum of products."""
    accumulator = factors[0] * values[0]
    for factor, value in zip(factors[1:], values[1:], strict=True):
        accumulator = accumulator + factor * value
    return accumulator


class Rows:
    """Access to the rows of work, and to the numbers, in an intrinsic for s stages."""

    def __init__(self, s, context, builder, work, numbers):
        self.s, self.builder, self.work, self.numbers = s, builder, work.data, numbers.data
        self.row = builder.extract_value(work.shape, 1).type
        one_row, first = (ir.Constant(self.row, k) for k in (LANES, 0))
        self.lanes = Lanes(context, builder, one_row, first)

    def at(self, k):
        return Lane(self.builder, self.lanes.load(self.work, ir.Constant(self.row, k)))

    def axes(self, k):
        return [self.at(k + i) for i in range(3)]

    def stages(self, k):
        return [self.axes(k + 3 * j) for j in range(self.s)]

    def put(self, k, values):
        for i, value in enumerate(values):
            self.lanes.store(value.value, self.work, ir.Constant(self.row, k + i))

    def put_where(self, condition, k, values):
        self.put(k, [x.where(condition, self.at(k + i)) for i, x in enumerate(values)])

    def number(self, k):
        index = ir.Constant(self.row, k)
        return Lane(self.builder, self.lanes.spread(self.lanes.number(self.numbers, index)))

    def block(self, k, columns):
        return [[self.number(k + columns * j + i) for i in range(columns)] for j in range(self.s)]


def begin_next_step(rows, ready, rate, from_one_step, from_two_steps):
    """Begin the next step in the lanes that are ready for it.

    Parameters
    ----------
    rate
        -1 / DESCENT
    once, twice
        coefficients of the accelerations at its stages, from those of one step or of two; after a
        shortened step the accelerations at its last stage are the guess
    """
    s = rows.s
    last, before, has_earlier = (
        rows.stages(DECAY + 2 * s),
        rows.stages(DECAY + 5 * s),
        rows.at(HAS_EARLIER),
    )
    h, index, step = rows.at(H), rows.at(INDEX), rows.at(STEP)
    is_full_step, time = h > FULL_STEP_FRACTION * step, index * step
    time_left = (index + 1.0) * step - time
    start = exp(rate * time)
    ratios = [rows.at(DECAY + s + j) for j in range(s)]
    guess = [
        total(from_two_steps[j], [a[i] for a in before + last])
        .where(has_earlier > 0.0, total(from_one_step[j], [a[i] for a in last]))
        .where(is_full_step, last[-1][i])
        for j in range(s)
        for i in range(3)
    ]
    steps_taken = rows.at(STEPS_TAKEN) + has_earlier.same(1.0).where(h > 0.0, 0.0)
    push = [x + y for x, y in zip(rows.axes(PUSH), rows.axes(DRAG), strict=True)]
    new = {
        Q: rows.axes(END),
        V: rows.axes(END + 3),
        H: [time_left],
        TRIES: [has_earlier.same(0.0)],
        HAS_EARLIER: [has_earlier.same(1.0).where(is_full_step, 0.0)],
        INDEX: [index + 1.0],
        TIME: [time, time_left],
        STEPS_TAKEN: [steps_taken],
        PUSH: push,
        DECAY: [start * x for x in ratios],
        DECAY + 2 * s: guess,
        DECAY + 5 * s: [x for a in last for x in a],
    }
    for k, values in new.items():
        rows.put_where(ready, k, values)


def grain_pass(wind, drag, s):
    """An intrinsic (work, numbers) that does a pass for a wind and a drag law."""

    @intrinsic
    def one_pass(typingctx, work, numbers):
        signature = types.void(work, numbers)

        def generate(context, builder, signature, values):
            array_types = signature.args
            work, numbers = (
                context.make_array(array_types[k])(context, builder, values[k]) for k in range(2)
            )
            builder.reciprocals = Reciprocals(context, builder)
            rows = Rows(s, context, builder, work, numbers)
            at, number, block = rows.at, rows.number, rows.block
            nodes, rate_index, curve = (f.py_func(s) for f in (nodes_at, rate_at, curve_at))
            tables = (
                block(0, s),
                block(s * s, s),
                [number(nodes + j) for j in range(s)],
                [number(nodes + s + j) for j in range(s)],
                number(nodes + 2 * s),
            )
            tolerance, rate = number(rate_index - 1), number(rate_index)
            ready = at(STATE) > GOES_ON
            with builder.if_then(ready.any):
                from_one_step, from_two_steps = (
                    block(curve + s * s, s),
                    block(curve + 2 * s * s, 2 * s),
                )
                begin_next_step(rows, ready, rate, from_one_step, from_two_steps)
            q, v, h = rows.axes(Q), rows.axes(V), at(H)
            new, forced, change = newton_step(
                wind,
                drag,
                s,
                q,
                v,
                h,
                [at(CONSTANTS), at(CONSTANTS + 1)],
                [at(DECAY + j) for j in range(s)],
                rows.stages(DECAY + 2 * s),
                tables,
            )
            rows.put(DECAY + 2 * s, [x for stage in new for x in stage])
            tries = at(TRIES) + 1.0
            state = state_of(change, at(CHANGE), tries, tolerance)
            rows.put(STATE, [state, tries, change])
            rows.put(PASSES_DONE, [at(PASSES_DONE) + 1.0])
            with builder.if_then((state > GOES_ON).any):
                end, lowest = end_of_step(s, q, v, h, new, forced, tables, block(curve, s))
                rows.put(END, [*end, lowest])
            return context.get_dummy_value()

        return signature, generate

    return one_pass
