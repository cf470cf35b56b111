"""One pass of the stage equations of eight grains, one in each lane, as vector instructions.

A grain moves by v' = g - k w, with w = v - wind(q, t) and a rate k = k(|w|). With as many points as
coefficients the stage equations are, for accelerations a_j at the stages,

    V_j = v0 + h sum_k B_jk a_k,    Q_j = q0 + h c_j v0 + h^2 sum_k (A B)_jk a_k,
    a_j = g - k(|w_j|) w_j.

A pass is a step of Newton's method with one derivative for all stages and without that of the wind:
-k across the mean w and -(k + |w| k') along it. What is left shrinks by a factor of the order of h
times the wind's gradient, however short the grain's relaxation time 1 / k is, and two systems of s
equations are solved instead of one of 3 s.

wind        (q, decay) -> 3 values, and
drag        (|w|^2, constants) -> (k, |w| k'), written as in galvi.kernels.lanes.elementary
work        (rows, 8), rows as below; one column for each grain
numbers     B (s, s), A B (s, s), c (s,), b (s,), g
"""

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba import types
from numba.extending import intrinsic

from galvi.kernels.compile.array_types import MATRIX, VECTOR
from galvi.kernels.lanes.values import Lane
from galvi.kernels.lanes.vectors import LANES, Lanes

Q, V, H, CHANGE, CONSTANTS = 0, 3, 6, 7, 8  # first rows
DECAY = 10  # exp(-t / DESCENT) at the stages, then the accelerations, then g - k w, 3 s each
PASS_OF_GRAINS = types.void(MATRIX, VECTOR)
TINY = 1e-300


def rows_of_grains(s):
    """Rows of work for s stages."""
    return DECAY + 7 * s


def solved(B, z, right):
    """x with (1 + z B) x = r for each r of several right-hand sides, all lanes.

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
        pivots.append(1.0 / rows[i][i])
    for i in reversed(range(s)):
        for r in sides:
            for j in range(i + 1, s):
                r[i] = r[i] - rows[i][j] * r[j]
            r[i] = r[i] * pivots[i]
    return sides


def corrected(wind, drag, s, q, v, h, constants, decay, a, tables):
    """New accelerations, the accelerations by the forces at the old ones, and the relative change.

    q, v (3,) at the start, h; decay (s,), a (s, 3): lanes, or arrays of any one shape
    """
    B, AB, c, b, g = tables
    axes, stages = range(3), range(s)
    w, found, rates, slopes = [], [], [], []
    for j in stages:
        Vj = [v[i] + h * total(B[j], [a[k][i] for k in stages]) for i in axes]
        Qj = [q[i] + h * (c[j] * v[i] + h * total(AB[j], [a[k][i] for k in stages])) for i in axes]
        air = wind(Qj, decay[j])
        wj = [x - u for x, u in zip(Vj, air, strict=True)]
        rate, slope = drag(wj[0] * wj[0] + wj[1] * wj[1] + wj[2] * wj[2], constants)
        w.append(wj)
        rates.append(rate)
        slopes.append(slope)
        found.append([-rate * wj[0], -rate * wj[1], g - rate * wj[2]])
    mean = [total(b, [w[j][i] for j in stages]) for i in axes]
    across, steeper = h * total(b, rates), h * total(b, slopes)
    inverse = 1.0 / (mean[0] * mean[0] + mean[1] * mean[1] + mean[2] * mean[2] + TINY)
    missing = [[found[j][i] - a[j][i] for i in axes] for j in stages]
    along = [inverse * total(mean, missing[j]) for j in stages]
    rest = [[missing[j][i] - along[j] * mean[i] for j in stages] for i in axes]
    aside = solved(B, across, rest)
    (ahead,) = solved(B, across + steeper, [along])
    new, change = [], 0.0
    for j in stages:
        step = [aside[i][j] + ahead[j] * mean[i] for i in axes]
        new.append([a[j][i] + step[i] for i in axes])
        change = change + (abs(step[0]) + abs(step[1]) + abs(step[2]))
    size = abs(h) * abs(g) + TINY
    for i in axes:
        size = size + (abs(v[i]) + abs(mean[i]))
    return new, found, abs(h) * change / size


def total(factors, values):
    """The sum of products."""
    result = factors[0] * values[0]
    for factor, value in zip(factors[1:], values[1:], strict=True):
        result = result + factor * value
    return result


def grain_pass(wind, drag, s):
    """An intrinsic (work, numbers) that does a pass for a wind and a drag law."""

    @intrinsic
    def one_pass(typingctx, work, numbers):
        signature = types.void(work, numbers)

        def generate(context, builder, signature, values):
            kinds = signature.args
            work, numbers = (
                context.make_array(kinds[k])(context, builder, values[k]) for k in range(2)
            )
            row = builder.extract_value(work.shape, 1).type
            lanes = Lanes(context, builder, ir.Constant(row, LANES), ir.Constant(row, 0))

            def at(k):
                return Lane(builder, lanes.load(work.data, ir.Constant(row, k)))

            def number(k):
                place = ir.Constant(row, k)
                return Lane(builder, lanes.spread(lanes.number(numbers.data, place)))

            def block(start):
                return [[number(start + s * j + k) for k in range(s)] for j in range(s)]

            first = 2 * s * s
            tables = (
                block(0),
                block(s * s),
                [number(first + j) for j in range(s)],
                [number(first + s + j) for j in range(s)],
                number(first + 2 * s),
            )
            new, found, change = corrected(
                wind, drag, s,
                [at(Q + i) for i in range(3)], [at(V + i) for i in range(3)], at(H),
                [at(CONSTANTS), at(CONSTANTS + 1)], [at(DECAY + j) for j in range(s)],
                [[at(DECAY + s + 3 * j + i) for i in range(3)] for j in range(s)], tables,
            )  # fmt: skip
            for j in range(s):
                for i in range(3):
                    place = DECAY + s + 3 * j + i
                    lanes.store(new[j][i].value, work.data, ir.Constant(row, place))
                    place += 3 * s
                    lanes.store(found[j][i].value, work.data, ir.Constant(row, place))
            lanes.store(change.value, work.data, ir.Constant(row, CHANGE))
            return context.get_dummy_value()

        return signature, generate

    return one_pass
