"""The frame of a harmonic oscillator in its normal modes: a rotation for each mode.

q = F x with F^T M F = 1 and K F = M F diag(omega^2), K the frame's stiffness; x'' = -omega^2 x is
solved exactly, and F^T (K q - dV/dq) is the force in the frame. In a time t the rotation is
x = cos(omega t) x_0 + sin(omega t) / omega v_0, and slopes (0, f) are pulled back to
(-sin(omega t) / omega f, cos(omega t) f).

numbers  F by rows (d, d); omega^2 (d,); for a whole step, then for half a step, (6, d) each:
         cos(omega t) - 1, sin(omega t) / omega and -omega sin(omega t), then the low part of each;
         cos(omega t_j) (d, P), sin(omega t_j) / omega (d, P); the potential's constants
state    rows 4 to 7: x, its low part, x' and its low part, (d,) each
work     (2 d, LANES)  modes and positions at eight stages
"""

from __future__ import annotations

from numba import types
from numba.extending import intrinsic

from galvi.kernels.compile.internals import cgutils
from galvi.kernels.compile.jit import jit_noalloc
from galvi.kernels.lie.arithmetic import two_sum
from galvi.lanes.collocation import Constants
from galvi.lanes.frames.rows import WEIGHT
from galvi.lanes.gravity import fused
from galvi.lanes.laws import From
from galvi.lanes.values import Lane
from galvi.lanes.vectors import LANES, ZEROS, Lanes

ROTATION_ROWS = 6  # rows of a rotation


def first_indices(d, padded):
    """The indices of the first number of the stages, and of the potential's first constant."""
    stages = d * d + d + 2 * ROTATION_ROWS * d
    return stages, stages + 2 * d * padded


def harmonic_rates(slopes, d):
    """An intrinsic (numbers, nodes, W, work, k) that fills k, for a potential's slopes on R^d."""

    @intrinsic
    def rates_at_stages(typingctx, numbers, nodes, W, work, k):
        signature = types.void(numbers, nodes, W, work, k)

        def generate(context, builder, signature, values):
            arrays = [
                context.make_array(signature.args[i])(context, builder, values[i]) for i in range(5)
            ]
            coefficients, times, states, scratch, out = (array.data for array in arrays)
            padded = builder.extract_value(arrays[2].shape, 1)
            row = padded.type
            tables = builder.gep(coefficients, [row(first_indices(d, 0)[0])])
            constants = builder.gep(tables, [builder.mul(padded, row(2 * d))])

            def product(lanes, transposed, source, target):
                """d rows from ``target`` <- F or its transpose times d rows from ``source``."""
                output_stride, input_stride = (1, d) if transposed else (d, 1)
                for first in range(0, d, 4):
                    rows = range(first, min(first + 4, d))
                    totals = [lanes.variable(ZEROS) for _ in rows]
                    with cgutils.for_range(builder, row(d), intp=row) as loop:
                        value = lanes.load(scratch, builder.add(row(source), loop.index))
                        column = builder.mul(loop.index, row(input_stride))
                        for i, total in zip(rows, totals, strict=True):
                            index = builder.add(column, row(i * output_stride))
                            factor = lanes.spread(builder.load(builder.gep(coefficients, [index])))
                            term = lanes.mul(factor, value)
                            builder.store(lanes.add(builder.load(total), term), total)
                    for i, total in zip(rows, totals, strict=True):
                        lanes.store(builder.load(total), scratch, row(target + i))

            chunks = builder.udiv(padded, row(LANES))
            with cgutils.for_range(builder, chunks, intp=row) as loop:
                lanes = Lanes(context, builder, padded, loop.index)
                scratch_lanes = Lanes(context, builder, row(LANES), row(0))

                def load(array, i, lanes=lanes, scratch_lanes=scratch_lanes):
                    return Lane(
                        builder, (scratch_lanes if array is scratch else lanes).load(array, row(i))
                    )

                squares = Constants(lanes, coefficients)
                for i in range(d):
                    x = load(tables, i) * load(states, i) + load(tables, d + i) * load(
                        states, d + i
                    )
                    scratch_lanes.store(x.value, scratch, row(i))
                product(scratch_lanes, False, 0, d)
                positions = [load(scratch, d + i) for i in range(d)]
                potential_constants = From(Constants(lanes, constants), 0)
                gradient = slopes(positions, load(times, 0), potential_constants)
                for i, slope in enumerate(gradient):
                    scratch_lanes.store((-positions[0].same(slope)).value, scratch, row(d + i))
                modes = [load(scratch, i) for i in range(d)]
                product(scratch_lanes, True, d, 0)
                weight = load(times, WEIGHT)
                for i in range(d):
                    spring = modes[i].exact * squares[d * d + i]  # rounded as a built-in slope is
                    force = weight * (load(scratch, i).exact + spring)
                    position_slope = -(load(tables, d + i) * force)
                    lanes.store(position_slope.value, out, row(i))
                    lanes.store((load(tables, i) * force).value, out, row(d + i))
            return context.get_dummy_value()

        return signature, generate

    return rates_at_stages


@jit_noalloc
def drift(numbers, share, state):
    """Rotate all modes, in rows 4 to 7 of the state, over a step if ``share`` is 1, else over half
    a step.

    Sines and cosines are sums of two numbers: with a rounding error, the energies of the modes
    would drift.
    """
    d = state.shape[1]
    first = d * d + d + (0 if share == 1.0 else ROTATION_ROWS * d)
    for i in range(d):
        c, s, r = numbers[first + i], numbers[first + d + i], numbers[first + 2 * d + i]
        c_low, s_low = numbers[first + 3 * d + i], numbers[first + 4 * d + i]
        r_low = numbers[first + 5 * d + i]
        x, x_low, v, v_low = state[4, i], state[5, i], state[6, i], state[7, i]
        state[4, i], state[5, i] = rotate(x, x_low, c, c_low, v, v_low, s, s_low)
        state[6, i], state[7, i] = rotate(v, v_low, c, c_low, x, x_low, r, r_low)


@jit_noalloc
def rotate(x, x_low, c, c_low, v, v_low, s, s_low):
    """x + c x + s v, where each number and the sum have two parts."""
    cx, sv = c * x, s * v
    low = fused(c, x, -cx) + fused(s, v, -sv) + (c * x_low + s * v_low)
    low += c_low * x + s_low * v
    total, error = two_sum(x, cx)
    total, second_error = two_sum(total, sv)
    return two_sum(total, (error + second_error) + (low + x_low))


@jit_noalloc
def leave(numbers, state):
    """Set rows 0 to 3 of the state: q = F x, v = F x' and their low parts, from rows 4 to 7."""
    d = state.shape[1]
    for i in range(d):
        q, v, q_low, v_low = 0.0, 0.0, 0.0, 0.0
        for j in range(d):
            factor = numbers[d * i + j]
            q, error = two_sum(q, factor * state[4, j])
            q_low += error + factor * state[5, j]
            v, error = two_sum(v, factor * state[6, j])
            v_low += error + factor * state[7, j]
        state[0, i], state[1, i] = two_sum(q, q_low)
        state[2, i], state[3, i] = two_sum(v, v_low)
