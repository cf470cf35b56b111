"""The frame of Kepler's motions in Jacobi coordinates: its slopes at the stages of a step.

Planets 1 to n in the order of their orbits about the star 0, all masses times G; M_i = m_0 + .. +
m_i. Q_i is the place of planet i relative to the barycentre of all before it, and Q_i'' = -M_i Q_i /
|Q_i|^3 its motion in the frame. From the star, planets are at x_i = Q_i + d_i, with
d_(i+1) = d_i + (m_i / M_i) Q_i; what is left accelerates Q_i by

    M_i [Q_i / |Q_i|^3 - c_i x_i / |x_i|^3] + (M_i / M_(i-1)) p_i + sum_(k > i) m_k (p_k + f_k) / M_(i-1)

with c_i = m_0 / M_(i-1), f_k = -m_0 x_k / |x_k|^3 and p_k = sum_j m_j (x_j - x_k) / |x_j - x_k|^3 over
planets. The bracket is small, and computed without cancellation (Encke): with e = d.(2 Q + d) / |Q|^2
and f = 1 - (1 + e)^(-3/2) it is [(1 - c) Q + c (f x - d)] / |Q|^3.

numbers  h, m_0, then n each: M, m, m / M, c, 1 - c, M_i / M_(i-1), 1 / M_(i-1)
W, k     (2 D n, P)  D rows of n places Q, D rows of n velocities
work     (ROWS n, P), in blocks of n rows:
         Q and Q' at the stages (2 D), d (D), x (D), p (D), X, G1 to G5, r, 1 / r, 1 / r0, beta
"""

from __future__ import annotations

import math

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

from galvi.kernels.lanes.frames import universal
from galvi.kernels.lanes.frames.collocation import OFFSET, WEIGHT
from galvi.kernels.lanes.frames.reciprocals import Reciprocals
from galvi.kernels.lanes.values import Lane
from galvi.kernels.lanes.vectors import LANES, NOTHING, Lanes

HEAD = 2  # numbers before those of planets
MASS, OWN, SHARE, STAR, REST, RATIO, INSIDE = range(7)
KEPT = 10  # blocks of one row
TERMS = 7  # of a series
FIRST, LATER = 2e-2, 3e-5  # share of a step up to which a correction of X is the last one
MOST = 12  # corrections
NAN = math.nan


def rows_of_kepler(dimension):
    """Rows of work for one planet."""
    return 5 * dimension + KEPT


def dot(a, b):
    """a . b, in the plane or in space."""
    total = a[0] * b[0]
    for x, y in zip(a[1:], b[1:], strict=True):
        total = total + x * y
    return total


class Stages:
    """The parts of a pass."""

    def __init__(self, context, builder, signature, values, dimension):
        self.context, self.builder, self.D = context, builder, dimension
        arrays = [
            context.make_array(signature.args[k])(context, builder, values[k]) for k in range(5)
        ]
        self.numbers, self.nodes, self.W, self.work, self.k = (array.data for array in arrays)
        self.padded = builder.extract_value(arrays[2].shape, 1)
        self.row = self.padded.type
        rows = builder.extract_value(arrays[2].shape, 0)
        self.n = builder.udiv(rows, self.row(2 * dimension))
        self.first_pass = builder.fcmp_ordered("==", values[5], ir.Constant(values[5].type, 0.0))
        self.tolerance = builder.select(
            self.first_pass, ir.Constant(values[5].type, FIRST), ir.Constant(values[5].type, LATER)
        )
        inverse = Reciprocals(context, builder)
        self.reciprocal, self.root = inverse.reciprocal, inverse.root

    def at(self, block, i):
        """Row i of a block of n."""
        return self.builder.add(self.builder.mul(self.n, self.row(block)), i)

    def number(self, lanes, k, i):
        """The k-th number of planet i, in all lanes."""
        place = self.builder.add(self.at(k, i), self.row(HEAD))
        return Lane(self.builder, lanes.spread(lanes.number(self.numbers, place)))

    def load(self, lanes, data, block, i):
        return Lane(self.builder, lanes.load(data, self.at(block, i)))

    def load_vector(self, lanes, data, block, i):
        return [self.load(lanes, data, block + x, i) for x in range(self.D)]

    def store(self, lanes, lane, data, block, i):
        lanes.store(lane.value, data, self.at(block, i))

    def store_vector(self, lanes, vector, data, block, i):
        for x, lane in enumerate(vector):
            self.store(lanes, lane, data, block + x, i)

    def scalar(self, lanes, k):
        """One of the first numbers, in all lanes."""
        return Lane(self.builder, lanes.spread(lanes.number(self.numbers, self.row(k))))

    def planets(self, count):
        return cgutils.for_range(self.builder, count, intp=self.row)

    def move(self, lanes):
        """Kepler's motions to the stages, and the places from the star."""
        builder, D = self.builder, self.D
        t = Lane(builder, lanes.load(self.nodes, self.row(OFFSET)))
        h = abs(self.scalar(lanes, 0))
        before = [lanes.variable(NOTHING) for _ in range(D)]
        with self.planets(self.n) as loop:
            i = loop.index
            mu = self.number(lanes, MASS, i)
            q, v = (self.load_vector(lanes, self.W, block, i) for block in (0, D))
            square = dot(q, q)
            inverse_0 = self.root(square)
            r0, eta = square * inverse_0, dot(q, v)
            beta = 2.0 * mu * inverse_0 - dot(v, v)
            zeta = mu - beta * r0
            X, G = self.solved(lanes, i, mu, beta, r0, eta, zeta, t, h)
            r = r0 + (eta * G[0] + zeta * G[1])
            inverse = self.reciprocal(r)
            f, g = -(mu * inverse_0) * G[1], t - mu * G[2]
            rate_f, rate_g = -(mu * inverse_0) * inverse * G[0], -(mu * inverse) * G[1]
            Q = [x + (f * x + g * y) for x, y in zip(q, v, strict=True)]
            V = [y + (rate_f * x + rate_g * y) for x, y in zip(q, v, strict=True)]
            d = [Lane(builder, builder.load(x)) for x in before]
            share = self.number(lanes, SHARE, i)
            for place, x, y in zip(before, d, Q, strict=True):
                builder.store((x + share * y).value, place)
            self.store_vector(lanes, Q, self.work, 0, i)
            self.store_vector(lanes, V, self.work, D, i)
            self.store_vector(lanes, d, self.work, 2 * D, i)
            self.store_vector(lanes, [x + y for x, y in zip(Q, d, strict=True)], self.work, 3 * D, i)
            nothing = Lane(builder, NOTHING)
            self.store_vector(lanes, [nothing] * D, self.work, 4 * D, i)
            for k, lane in enumerate((X, *G, r, inverse, inverse_0, beta)):
                self.store(lanes, lane, self.work, 5 * D + k, i)

    def solved(self, lanes, i, mu, beta, r0, eta, zeta, t, h):
        """X and G1 to G5 at the times t, from the last pass's X or in the first from the mean motion.

        NaN where Kepler's equation was not solved, or X is too large for the series.
        """
        builder, D = self.builder, self.D
        mean = t * beta * self.reciprocal(mu)
        known = self.load(lanes, self.work, 5 * D, i)
        start = builder.select(self.first_pass, mean.value, known.value)
        place, changed = lanes.variable(start), lanes.variable(NOTHING)
        found = [lanes.variable(NOTHING) for _ in range(5)]
        limit = h * Lane(builder, lanes.spread(self.tolerance))
        with cgutils.for_range(builder, self.row(MOST)) as loop:
            X = Lane(builder, builder.load(place))
            G = universal.universal(beta, X, TERMS)
            step, _r = universal.correction(beta, r0, eta, zeta, X, G, t, self.reciprocal)
            for variable, value in zip(found, G, strict=True):
                builder.store(value.value, variable)
            builder.store((X + step).value, place)
            builder.store(step.value, changed)
            small = abs(step) * r0 <= limit
            every = builder.icmp_unsigned(
                "==", builder.bitcast(small, ir.IntType(LANES)), ir.IntType(LANES)(-1)
            )
            with builder.if_then(every):
                loop.do_break()
        X, step = (Lane(builder, builder.load(one)) for one in (place, changed))
        G = universal.moved(beta, [Lane(builder, builder.load(one)) for one in found], step)
        inside = abs(beta) * X * X <= 16.0 * universal.FARTHEST
        solved = builder.and_(abs(step) * r0 <= limit, inside)
        return X.where(solved, NAN), G

    def pull(self, lanes):
        """p from all pairs of planets."""
        builder, D = self.builder, self.D
        with self.planets(self.n) as outer:
            i = outer.index
            here, mass = self.load_vector(lanes, self.work, 3 * D, i), self.number(lanes, OWN, i)
            pulled = [
                lanes.variable(x.value) for x in self.load_vector(lanes, self.work, 4 * D, i)
            ]
            with self.planets(i) as inner:
                j = inner.index
                gap = [
                    x - y
                    for x, y in zip(self.load_vector(lanes, self.work, 3 * D, j), here, strict=True)
                ]
                near = self.root(dot(gap, gap))
                cube = near * near * near
                onto_i, onto_j = self.number(lanes, OWN, j) * cube, mass * cube
                for x in range(D):
                    other = self.load(lanes, self.work, 4 * D + x, j)
                    self.store(lanes, other - onto_j * gap[x], self.work, 4 * D + x, j)
                    total = Lane(builder, builder.load(pulled[x])) + onto_i * gap[x]
                    builder.store(total.value, pulled[x])
            own = [Lane(builder, builder.load(x)) for x in pulled]
            self.store_vector(lanes, own, self.work, 4 * D, i)

    def finish(self, lanes):
        """What is left of the accelerations, pulled back to the step's centre."""
        builder, D = self.builder, self.D
        star = self.scalar(lanes, 1)
        weight = Lane(builder, lanes.load(self.nodes, self.row(WEIGHT)))
        t = Lane(builder, lanes.load(self.nodes, self.row(OFFSET)))
        beyond = [lanes.variable(NOTHING) for _ in range(D)]
        with self.planets(self.n) as loop:
            i = builder.sub(builder.sub(self.n, self.row(1)), loop.index)
            Q, V, d, x, p = (
                self.load_vector(lanes, self.work, block * D, i) for block in range(5)
            )
            X, *G, r, inverse, inverse_0, beta = (
                self.load(lanes, self.work, 5 * D + k, i) for k in range(KEPT)
            )
            mu, own, c, rest, ratio, inside = (
                self.number(lanes, k, i) for k in (MASS, OWN, STAR, REST, RATIO, INSIDE)
            )
            square = inverse * inverse
            cube = square * inverse
            e = dot(d, [2.0 * a + b for a, b in zip(Q, d, strict=True)]) * square
            root = self.root(1.0 + e)
            third = root * root * root
            f = e * (3.0 + e * (3.0 + e)) * (third * third) * self.reciprocal(1.0 + third)
            pull, fall = mu * cube, star * third * cube
            outside = [Lane(builder, builder.load(one)) for one in beyond]
            a = [
                pull * (rest * Q[k] + c * (f * x[k] - d[k])) + (ratio * p[k] + inside * outside[k])
                for k in range(D)
            ]
            for k, place in enumerate(beyond):
                builder.store((outside[k] + own * (p[k] - fall * x[k])).value, place)
            along_q, along_v, rate_q, rate_v, rate_a = universal.pull_back(
                mu, beta, X, G, Q, V, r, inverse, inverse_0, a, dot
            )
            back = mu * G[2] - t
            weighted = [weight * one for one in (along_q, along_v, back, rate_q, rate_v, rate_a)]
            for k in range(D):
                Qk, Vk, ak = Q[k], V[k], a[k]
                place = weighted[0] * Qk + weighted[1] * Vk + weighted[2] * ak
                speed = weighted[3] * Qk + weighted[4] * Vk + weighted[5] * ak
                self.store(lanes, place, self.k, k, i)
                self.store(lanes, speed, self.k, D + k, i)


@intrinsic
def kepler_rates(typingctx, axes, numbers, nodes, W, work, k, number):
    """A pass for as many dimensions as ``axes`` has entries; arrays as in the module."""
    dimension = axes.count

    def generate(context, builder, signature, values):
        inner = types.void(*signature.args[1:])
        made = Stages(context, builder, inner, values[1:], dimension)
        chunks = builder.udiv(made.padded, made.row(LANES))
        with cgutils.for_range(builder, chunks, intp=made.row) as loop:
            lanes = Lanes(context, builder, made.padded, loop.index)
            made.move(lanes)
            made.pull(lanes)
            made.finish(lanes)
        return context.get_dummy_value()

    return types.void(axes, numbers, nodes, W, work, k, number), generate
