"""Kepler's motions to the stages of a step, and accelerations pulled back to its centre.

Orbits 1 to n are in the order of the frame; two are computed at a time.

numbers  h; the number of pairs of orbits for which |beta X^2| may exceed 0.9, one more if the last,
         single orbit may; n; the first body's mass times G; then blocks of n: the masses of the
         other bodies, M, five blocks that depend on the frame, and 1 / M; then lists of n + 1: the
         index in the problem of each body, in the frame's order, and the index of the first term of
         each pair; then the terms, see `galvi.lanes.celestial.add_in_frame`
W, k     (2 D n, P)  D blocks of n positions Q, D blocks of n velocities
guess    (n, P)      X
work     (.., LANES), in blocks of n rows: Q and Q' at the stages (2 D), 1 / r, r / M, 1 / r0, and
         G2, c and M G3 - t of `universal.pull_back`; then blocks that depend on the frame
"""

from __future__ import annotations

import math
from functools import reduce
from operator import and_

from llvmlite import ir
from numba import types
from numba.extending import intrinsic

from galvi.kernels.compile.internals import cgutils
from galvi.lanes.frames import universal
from galvi.lanes.frames.rows import OFFSET, WEIGHT
from galvi.lanes.functions import Reciprocals, square_root
from galvi.lanes.values import Lane, LaneTuple
from galvi.lanes.vectors import LANES, Lanes

STEP, NEAR_PAIRS, COUNT, FIRST_MASS, HEAD = range(5)  # indices of numbers; HEAD is their count
ARGUMENT_HALVINGS = 2  # of the argument of a series, for near planets
BODY_MASS, MASS, MASS_SHARE, INVERSE_MASS = 0, 1, 2, 7  # blocks of numbers of every frame
BLOCKS = INVERSE_MASS + 1
# Distance over the semi-major axis below which an orbit loses more than 1e-12 to round-off.
LEAST_DISTANCE_RATIO = 0.05
STORED_BLOCKS = 6  # blocks of work after those of Q and Q', see above
PASS_SERIES_TERMS = 6  # terms of a series in a pass
# Ratio to the X of a step up to which a correction of third order is the last one of a pass.
FIRST_PASS_TOLERANCE, SECOND_PASS_TOLERANCE, LATER_PASS_TOLERANCE = 2e-2, 5e-4, 3e-5
MAX_CORRECTIONS = 12  # largest number of corrections of X
NAN = math.nan


def dot(a, b):
    """a . b, in the plane or in space."""
    total = a[0] * b[0]
    for x, y in zip(a[1:], b[1:], strict=True):
        total = total + x * y
    return total


class Orbits:
    """The parts of a pass, for one or two orbits at a time, see `LaneTuple`."""

    def __init__(self, context, builder, signature, values, dimension):
        self.context, self.builder, self.D = context, builder, dimension
        arrays = [
            context.make_array(signature.args[k])(context, builder, values[k]) for k in range(6)
        ]
        self.numbers, self.nodes, self.W, self.work, self.guess, self.k = (
            array.data for array in arrays
        )
        self.padded = builder.extract_value(arrays[2].shape, 1)
        self.row = self.padded.type
        rows = builder.extract_value(arrays[2].shape, 0)
        self.n = builder.udiv(rows, self.row(2 * dimension))
        real = values[6].type
        self.first_pass = builder.fcmp_ordered("==", values[6], ir.Constant(real, 0.0))
        second_pass = builder.fcmp_ordered("==", values[6], ir.Constant(real, 1.0))
        self.tolerance = ir.Constant(real, LATER_PASS_TOLERANCE)
        for condition, tolerance in (
            (second_pass, SECOND_PASS_TOLERANCE),
            (self.first_pass, FIRST_PASS_TOLERANCE),
        ):
            self.tolerance = builder.select(condition, ir.Constant(real, tolerance), self.tolerance)
        inverse = Reciprocals(context, builder)
        self.reciprocal = lambda x: x.map(inverse.reciprocal)
        self.root = lambda x: x.map(inverse.root)
        self.work_lanes = Lanes(context, builder, self.row(LANES), self.row(0))  # in the work

    def at(self, block, i):
        """The index of row i of a block."""
        return self.builder.add(self.builder.mul(self.n, self.row(block)), i)

    def number(self, lanes, k, planets):
        """The numbers of ``planets`` in block k, in all lanes."""

        def entry(i):
            index = self.builder.add(self.at(k, i), self.row(HEAD))
            return Lane(self.builder, lanes.spread(lanes.number(self.numbers, index)))

        return LaneTuple(entry(i) for i in planets)

    def list_index(self, k, i):
        """The index of entry i of the k-th list, from 0, after the blocks of numbers."""
        return self.builder.add(self.at(BLOCKS + k, i), self.row(HEAD + k))

    def integer(self, lanes, index):
        """The number at ``index``, as an LLVM integer."""
        return self.builder.fptosi(lanes.number(self.numbers, index), self.row)

    def load(self, lanes, array, block, planets):
        return LaneTuple(Lane(self.builder, lanes.load(array, self.at(block, i))) for i in planets)

    def load_vector(self, lanes, array, block, planets):
        return [self.load(lanes, array, block + x, planets) for x in range(self.D)]

    def store(self, lanes, several, array, block, planets):
        for lane, i in zip(several.lanes, planets, strict=True):
            lanes.store(lane.value, array, self.at(block, i))

    def store_vector(self, lanes, vector, array, block, planets):
        for x, several in enumerate(vector):
            self.store(lanes, several, array, block + x, planets)

    def scalar(self, lanes, k):
        """The number with index k, in all lanes."""
        return Lane(self.builder, lanes.spread(lanes.number(self.numbers, self.row(k))))

    def variables(self, lanes, values):
        """For each value, stack variables that hold it, one for each planet."""
        return [[lanes.variable(lane.value) for lane in value.lanes] for value in values]

    def value_of(self, pointers):
        """The values of stack variables, one for each planet."""
        return LaneTuple(Lane(self.builder, self.builder.load(pointer)) for pointer in pointers)

    def keep(self, value, pointers):
        for lane, pointer in zip(value.lanes, pointers, strict=True):
            self.builder.store(lane.value, pointer)

    def outwards(self, lanes, part):
        """Call ``part(planets, halvings)`` for all orbits, in their order.

        The last orbits turn so little in a step that their series need no halving.
        """
        builder, row = self.builder, self.row
        pairs = builder.lshr(self.n, row(1))
        near_pairs = self.integer(lanes, row(NEAR_PAIRS))
        all_near = builder.icmp_signed(">", near_pairs, pairs)
        halved_pairs = builder.select(all_near, pairs, near_pairs)

        def call_for_pairs(begin, end, halvings):
            with cgutils.for_range(builder, builder.sub(end, begin), intp=row) as loop:
                first = builder.shl(builder.add(begin, loop.index), row(1))
                part((first, builder.add(first, row(1))), halvings)

        call_for_pairs(row(0), halved_pairs, ARGUMENT_HALVINGS)
        call_for_pairs(halved_pairs, pairs, 0)
        with builder.if_then(builder.trunc(self.n, ir.IntType(1))):
            last = (builder.sub(self.n, row(1)),)
            with builder.if_else(all_near) as (halved, unhalved):
                with halved:
                    part(last, ARGUMENT_HALVINGS)
                with unhalved:
                    part(last, 0)

    def inwards(self, part):
        """Call ``part(planets)`` for all orbits, in reverse order."""
        builder, row = self.builder, self.row
        pairs = builder.lshr(self.n, row(1))
        with builder.if_then(builder.trunc(self.n, ir.IntType(1))):
            part((builder.sub(self.n, row(1)),))
        with cgutils.for_range(builder, pairs, intp=row) as loop:
            pair = builder.sub(builder.sub(pairs, row(1)), loop.index)
            first = builder.shl(pair, row(1))
            part((builder.add(first, row(1)), first))

    def move(self, lanes, follow):
        """Store Kepler's motions to the stages; calls ``follow(planets, Q)`` with the positions."""
        offset, D = Lane(self.builder, lanes.load(self.nodes, self.row(OFFSET))), self.D
        h = abs(self.scalar(lanes, STEP))

        def part(planets, halvings):
            t = LaneTuple([offset] * len(planets))
            mu = self.number(lanes, MASS, planets)
            q, v = (self.load_vector(lanes, self.W, block, planets) for block in (0, D))
            square = dot(q, q)
            inverse_0 = self.root(square)
            r0, eta = square * inverse_0, dot(q, v)
            beta = 2.0 * mu * inverse_0 - dot(v, v)
            zeta = mu - beta * r0
            X, G = self.solve_anomaly(lanes, planets, halvings, mu, beta, r0, eta, zeta, t, h)
            r = r0 + (eta * G[0] + zeta * G[1])
            X = X.map(_nan_if_near, mu, beta, r0, r)
            inverse = self.reciprocal(r)
            f, g = -(mu * inverse_0) * G[1], t - mu * G[2]
            rate_f, rate_g = -(mu * inverse_0) * inverse * G[0], -(mu * inverse) * G[1]
            Q = [x + (f * x + g * y) for x, y in zip(q, v, strict=True)]
            V = [y + (rate_f * x + rate_g * y) for x, y in zip(q, v, strict=True)]
            for block, vector in enumerate((Q, V)):
                self.store_vector(self.work_lanes, vector, self.work, block * D, planets)
            self.store(lanes, X, self.guess, 0, planets)
            r_over_M = r * self.number(lanes, INVERSE_MASS, planets)
            lag = universal.lag(mu, X, G, t)
            for k, lane in enumerate((inverse, r_over_M, inverse_0, G[1], lag, -g)):
                self.store(self.work_lanes, lane, self.work, 2 * D + k, planets)
            follow(planets, Q)

        self.outwards(lanes, part)

    def solve_anomaly(self, lanes, planets, halvings, mu, beta, r0, eta, zeta, t, h):
        """X and G1 to G5 at the times t; the iteration starts from the X of the last pass, or in
        the first pass from that of the mean motion.

        X is NaN where it did not converge, or is too large for the series.
        """
        builder = self.builder
        mean = t * beta * self.number(lanes, INVERSE_MASS, planets)
        last_X = self.load(lanes, self.guess, 0, planets)
        initial_X = mean.map(
            lambda a, b: Lane(builder, builder.select(self.first_pass, a.value, b.value)), last_X
        )
        reach = universal.LARGEST_ANOMALY_LEAD * self.root(beta)
        anomaly, low, high, last_step, *functions = self.variables(
            lanes, [initial_X, mean - reach, mean + reach] + [initial_X * 0.0] * 6
        )
        limit = h * Lane(builder, lanes.spread(self.tolerance))
        elapsed = abs(t)

        def is_small(step, x, time):
            return abs(step) * time <= limit * abs(x)

        with cgutils.for_range(builder, self.row(MAX_CORRECTIONS)) as loop:
            X = self.value_of(anomaly)
            G = universal.universal(beta, X, PASS_SERIES_TERMS, halvings)
            step = universal.correction(beta, r0, eta, zeta, X, G, t, self.reciprocal)
            for variable, value in zip(functions, G, strict=True):
                self.keep(value, variable)
            self.keep(step, last_step)
            solved = reduce(and_, step.map(is_small, X, elapsed).lanes)
            with builder.if_then(solved.all):
                loop.do_break()
            correction = universal.far_correction(
                beta,
                r0,
                eta,
                zeta,
                X,
                G,
                t,
                lambda a, b: a.map(lambda x, y: x / y, b),
                lambda a: a.map(square_root),
            )
            limits = X.lanes, correction.lanes, self.value_of(low).lanes, self.value_of(high).lanes
            brackets = (
                universal.bracketed(*limit, lambda c, x, y: x.where(c, y))
                for limit in zip(*limits, strict=True)
            )
            ends = zip((anomaly, low, high), zip(*brackets, strict=True), strict=True)
            for variable, value in ends:
                self.keep(LaneTuple(value), variable)
        before, step = self.value_of(anomaly), self.value_of(last_step)
        X = before + step
        G = universal.shifted(beta, [self.value_of(pointers) for pointers in functions], step)

        def x_or_nan(x, step, old, time, b):
            inside = abs(b) * x * x <= 4.0**halvings * universal.LARGEST_SERIES_ARGUMENT
            return x.where(is_small(step, old, time) & inside, NAN)

        return X.map(x_or_nan, step, before, elapsed, beta), G

    def pull_back(self, lanes, planets, a):
        """Store the slopes of orbits whose accelerations at the stages, times weights, are a."""
        D = self.D
        Q, V = (self.load_vector(self.work_lanes, self.work, block, planets) for block in (0, D))
        _, r_over_M, inverse_0, G2, lag, back = (
            self.load(self.work_lanes, self.work, 2 * D + k, planets) for k in range(STORED_BLOCKS)
        )
        mu = self.number(lanes, MASS, planets)
        start = [self.load_vector(lanes, self.W, block, planets) for block in (0, D)]
        changes = universal.pull_back(mu, G2, lag, back, r_over_M, inverse_0, *start, Q, V, a, dot)
        for half, vector in enumerate(changes):
            self.store_vector(lanes, vector, self.k, half * D, planets)

    def weight(self, lanes):
        """The stages' weights."""
        return Lane(self.builder, lanes.load(self.nodes, self.row(WEIGHT)))


def _nan_if_near(X, mu, beta, r0, r):
    """X, or NaN where the distance at the start or the end is too small for the size of the
    orbit."""
    return X.where(abs(beta) * r0.call("minnum", r) >= LEAST_DISTANCE_RATIO * mu, NAN)


def encke(orbits, e, ratio):
    """f = 1 - (1 + e)^(-3/2) without cancellation, and 1 - f; ``ratio`` is 1 + e."""
    root = orbits.root(ratio)
    third = root * root * root
    return e * (3.0 + e * (3.0 + e)) * (third * third) * orbits.reciprocal(1.0 + third), third


def rates_of_orbits(run_pass):
    """An intrinsic (axes, numbers, nodes, W, work, guess, k, pass) for RATES.

    Parameters
    ----------
    run_pass
        (orbits, lanes) -> None, which generates a pass at eight stages

    Notes
    -----
    ``axes`` is a tuple whose length is the dimension.
    """

    @intrinsic
    def rates_at_stages(typingctx, axes, numbers, nodes, W, work, guess, k, pass_number):
        dimension = axes.count

        def generate(context, builder, signature, values):
            inner = types.void(*signature.args[1:])
            orbits = Orbits(context, builder, inner, values[1:], dimension)
            chunks = builder.udiv(orbits.padded, orbits.row(LANES))
            with cgutils.for_range(builder, chunks, intp=orbits.row) as loop:
                run_pass(orbits, Lanes(context, builder, orbits.padded, loop.index))
            return context.get_dummy_value()

        return types.void(axes, numbers, nodes, W, work, guess, k, pass_number), generate

    return rates_at_stages
