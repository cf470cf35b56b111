"""One pass of the iteration of galvi.lanes.law, as vector instructions for one law.

A law is a function as described in galvi.lanes.elementary. Rows of work, (rows, P):

q, v, f, p      (d, P) each: places, velocities, forces dL/dq and momenta at the stages
low_q, low_p    (d, P) each: what low parts add to q and p, those of the state from the start, those
                of the matrices once a pass changes little
before          (d, P)       not used here
t               (P,)         times
found           dL/dv (d, P), then the factors of d2L/dv2 by rows: L D L^T without pivots, with
                1 / D on the diagonal
steps           (d, P)       changes of the velocities

tables      (4 P, P)    h A^T, its low part, h B^T and its low part; rows after the s-th are 0
complement  (P, P)      C^T, see galvi.lanes.law; (d P, P) with one for each component;
                        (0, P) where C is 0
numbers     (4 d + 4,)  q and p at the start, 1 over their sizes; the pass adds its largest
                        relative change; low parts of q and p, h

Where *places alone* are iterated, the law's mass is 1 and its forces know no velocities. v then
holds accelerations, p the ways c h v, and low_q what is added to these; tables ((l + 2) P + 2, P)
are c, its low part, h^2 A^T of galvi.tableau, then for r = 1 .. l the same after extrapolation to
the next step with r Legendre terms, then the low part of h^2 A^T. Where the number for the change
is -1 - r, a pass begins a step: it places the stages by the last accelerations.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from llvmlite import ir

from galvi.kernels.compile.internals import cgutils
from galvi.kernels.lie.arithmetic import generic
from galvi.lanes.dense import Triangle, factored, is_written_out
from galvi.lanes.functions import two_product
from galvi.lanes.values import Lane
from galvi.lanes.vectors import DOUBLE, Lanes, everywhere, of_words

Q, V, F, P, LOW_Q, LOW_P, BEFORE, T = range(8)  # times d, but for T, which has one row


@generic
def first_of_steps(d):
    """The first row of the changes of velocities, which nothing but a pass needs."""
    return T * d + 1 + d + d * (d + 1) // 2


def rows_of_work(d):
    """Rows of work for d coordinates."""
    return first_of_steps(d) + d


def filled(law, d):
    """The places (i, j), j < i, of L that are not 0 at a state without special properties."""
    near = np.linspace(0.3, 0.7, 2 * d + 1) ** 0.5
    with np.errstate(all="ignore"):
        mass = law(list(near[:d]), list(near[d:-1]), near[-1], Generic())[2]
        rows = factored([list(map(np.float64, row)) for row in mass])
    return [(i, j) for i in range(d) for j in range(i) if rows[i][j] != 0.0]


class Generic:
    """Constants without special properties."""

    def __getitem__(self, k):
        return np.float64(1.0 + 0.1 / (k + 1.5))


class Constants:
    """Constants of a law, spread over all lanes when they are first used."""

    def __init__(self, builder, lanes, data, row):
        self.builder, self.lanes, self.data, self.row = builder, lanes, data, row
        self.loaded = {}

    def __getitem__(self, k):
        if k not in self.loaded:
            scalar = self.lanes.number(self.data, self.row(k))
            self.loaded[k] = Lane(self.builder, self.lanes.spread(scalar))
        return self.loaded[k]


class Pass:
    """The three parts of a pass, each for one vector of stages."""

    alone = False  # whether places alone are iterated
    first_drift: Any  # row of tables

    def __init__(self, context, builder, given, law, below, d, width, one, alone):
        self.unpack(context, builder, given, d, width, one)
        self.law, self.below, self.alone = law, below, alone
        self.nodes, self.first_drift = (self.row(0), self.row(1)), self.row(2 if alone else 0)
        self.lay_out_space()

    def unpack(self, context, builder, given, d, width, one):
        """The words of `one_pass` at the address ``given``."""
        self.context, self.builder, self.d = context, builder, d
        self.width, self.one, self.row = width, one, given.type.pointee
        words = [builder.load(builder.gep(given, [self.row(k)])) for k in range(8)]
        self.work, self.tables, self.complement, self.constants, self.numbers = (
            builder.inttoptr(word, DOUBLE.as_pointer()) for word in words[:5]
        )
        self.padded, self.stages, self.extra = self.row(width) if one else words[5], *words[6:]
        self.projects = builder.icmp_unsigned("!=", self.extra, self.row(0))
        self.low_drift, self.back, self.low_back, self.kicks = (
            builder.mul(self.padded, self.row(k)) for k in range(1, 5)
        )
        self.begin_change()

    def lay_out_space(self):
        """First rows of what a law on R^d keeps, and the rows of a component's own C."""
        self.found, self.steps = T * self.d + 1, first_of_steps(self.d)
        self.factors, self.fixed = self.found + self.d, {}
        self.written_out = is_written_out(self.below)
        builder, length = self.builder, self.length_of_a_matrix
        several = builder.icmp_unsigned(">", self.extra, length)
        self.apart = builder.select(several, length, self.row(0))

    @property
    def length_of_a_matrix(self):
        """Rows of a matrix of ``tables`` or ``complement``."""
        return self.padded

    def begin_change(self):
        """Room for the largest change, of which there is none yet."""
        self.largest = cgutils.alloca_once(self.builder, ir.VectorType(ir.IntType(64), self.width))
        self.forget()

    def forget(self):
        """Forget the largest change."""
        self.builder.store(everywhere(self.largest.type.pointee, 0), self.largest)

    def chunks(self, part):
        """Do one part for all stages."""
        if self.one:
            part(self.at(self.row(0)))
            return
        chunks = self.builder.udiv(self.padded, self.row(self.width))
        with cgutils.for_range(self.builder, chunks, intp=self.row) as loop:
            part(self.at(loop.index))

    def at(self, chunk):
        """The lanes of one of the chunks."""
        return Lanes(self.context, self.builder, self.padded, chunk, self.width)

    def load(self, lanes, block, i=0):
        return self.load_row(lanes, block * self.d + i)

    def store(self, lanes, lane, block, i=0):
        self.store_row(lanes, lane, block * self.d + i)

    def load_row(self, lanes, row):
        return Lane(self.builder, lanes.load(self.work, self.row(row)))

    def store_row(self, lanes, lane, row):
        lanes.store(lane.value, self.work, self.row(row))

    def number(self, lanes, k):
        return Lane(self.builder, lanes.spread(lanes.number(self.numbers, self.row(k))), ())

    def first_pass(self):
        """Whether this is the first pass of a step, when sizes are not known."""
        size = self.builder.load(self.builder.gep(self.numbers, [self.row(2 * self.d)]))
        return self.builder.fcmp_unordered("==", size, ir.Constant(DOUBLE, 0.0))

    def evaluate(self, lanes):
        """f, dL/dv and the factors from q and v."""
        d = self.d
        q, v = ([self.load(lanes, block, i) for i in range(d)] for block in (Q, V))
        constants = Constants(self.builder, lanes, self.constants, self.row)
        forces, momenta, mass = self.law(q, v, self.load(lanes, T), constants)
        rows = factored(mass) if self.written_out else mass
        factors = [factor for row in rows for factor in row]
        if self.written_out:
            self.fixed = {k: x for k, x in enumerate(factors) if not isinstance(x, Lane)}
        for i in range(d):
            self.store(lanes, q[0].same(forces[i]), F, i)
        for k, value in enumerate([*momenta, *factors]):
            if k - d not in self.fixed:
                self.store(lanes, q[0].same(value), T, 1 + k)
        if not self.written_out:
            self.triangle(lanes, self.factors).factor()

    def accelerate(self, lanes):
        """The accelerations from q."""
        q = [self.load(lanes, Q, i) for i in range(self.d)]
        constants = Constants(self.builder, lanes, self.constants, self.row)
        found = self.law(q, [0.0] * self.d, self.load(lanes, T), constants)[0]
        for i, acceleration in enumerate(found):
            self.store(lanes, q[0].same(acceleration), V, i)

    def coast(self, lanes, drift):
        """The ways without forces, their low parts, and first places."""
        d, h = self.d, self.number(lanes, 4 * self.d + 3)
        node, low_node = (Lane(self.builder, lanes.factor(self.tables, row)) for row in self.nodes)
        bent = self.sums(lanes, None, self.tables, drift, V * d)
        for i in range(d):
            far, rest = two_product(h, self.number(lanes, d + i))
            rest = rest + h * self.number(lanes, 3 * d + 3 + i)
            way, error = two_product(far, node.exact)
            small = low_node * far + node * rest
            small = (error + self.number(lanes, 2 * d + 3 + i)).fused + small
            self.store(lanes, way, P, i)
            self.store(lanes, small, LOW_Q, i)
            self.store(lanes, self.number(lanes, i) + (way + (small + bent[i])), Q, i)

    def triangle(self, lanes, first):
        """The matrix that lies in work from a row on."""
        return Triangle(self.builder, lanes, self.work, first, self.d)

    def reload(self):
        """Compiler barrier: a broadcast load is free, a forwarded store costs a shuffle."""
        nothing = ir.FunctionType(ir.VoidType(), [])
        self.builder.asm(nothing, "", "~{memory}", [], True)

    def sums(self, lanes, start, matrix, first_row, row, apart=None):
        """start + sum_k (rows of a matrix) (columns of d rows of work), for each coordinate.

        apart  rows between the matrices of one coordinate and the next; None for the same matrix
        """
        builder, d = self.builder, self.d
        first = [lanes.nothing] * d if start is None else [
            lanes.load(self.work, self.row(start * d + i)) for i in range(d)
        ]  # fmt: skip
        rows = [first_row] * d if apart is None else [
            builder.add(first_row, builder.mul(apart, self.row(i))) for i in range(d)
        ]  # fmt: skip
        if self.one:
            totals = [first, [lanes.nothing] * d]
            self.reload()
            for j in range(self.width):
                factors = [lanes.load(matrix, builder.add(own, self.row(j))) for own in
                           (rows[:1] if apart is None else rows)]  # fmt: skip
                for i in range(d):
                    value = lanes.number(self.work, self.row(row + i), self.row(j))
                    term = lanes.mul(lanes.spread(value), factors[i % len(factors)])
                    totals[j % 2][i] = lanes.add(totals[j % 2][i], term)
            found = [lanes.add(*pair) for pair in zip(*totals, strict=True)]
        else:
            found, together = [], d if apart is None else 1
            for i in range(0, d, together):
                found += lanes.sums(first[i : i + together], matrix, rows[i], self.work,
                                    self.row(row + i), self.stages)  # fmt: skip
        return [Lane(builder, value, ()) for value in found]

    def moved(self, lanes, totals, block, origin, scale):
        """Store origin + total in a block, and note the largest change over its size."""
        new = []
        size = self.number(lanes, 2 * self.d + scale)
        for i, total in enumerate(totals):
            place = self.number(lanes, origin + i) + total
            self.note_bits(((place - self.load(lanes, block, i)) * size).call("fabs").bits)
            self.store(lanes, place, block, i)
            new.append(place.fused)
        return new

    def note_bits(self, far):
        """Note the largest of nonnegative numbers, from their bits."""
        largest = self.builder.load(self.largest)
        # The bit patterns of nonnegative numbers are ordered like the numbers, with NaN last.
        more = self.builder.icmp_signed(">", far, largest)
        self.builder.store(self.builder.select(more, far, largest), self.largest)

    def kick(self, lanes):
        """p from f."""
        d = self.d
        totals = self.sums(lanes, LOW_P, self.tables, self.back, F * d)
        return self.moved(lanes, totals, P, d, 1)

    def missing(self, lanes, p):
        """p - dL/dv."""
        return [p[i] - self.load_row(lanes, self.found + i) for i in range(self.d)]

    def solved(self, lanes, x, below=None, first=None):
        """The changes of v that change dL/dv by x.

        below  places of L that are not 0; None: those of the mass
        first  row of work where the factors begin; None: those of the mass
        """
        d, below = self.d, self.below if below is None else below
        if not self.written_out:
            return self.triangle(lanes, self.factors if first is None else first).solve(x)
        start = self.factors if first is None else first

        def factor(i, j):
            k = i * (i + 1) // 2 + j
            if first is None and k in self.fixed:
                return self.fixed[k]
            return self.load_row(lanes, start + k)

        L = {(i, j): factor(i, j) for i, j in below}
        for i, j in below:
            x[i] = x[i] - L[i, j] * x[j]
        x = [x[i] * factor(i, i) for i in range(d)]
        for i, j in reversed(below):
            x[j] = x[j] - L[i, j] * x[i]
        return x

    def store_rows(self, lanes, values, row):
        for i, value in enumerate(values):
            self.store_row(lanes, value, row + i)

    def projected(self, lanes, row):
        """x - C x, x in d rows of work."""
        outside = self.sums(lanes, None, self.complement, self.row(0), row, self.apart)
        return [self.load_row(lanes, row + i) - outside[i] for i in range(self.d)]

    def rates(self):
        """p from f, and one Newton step for v with dL/dv = p."""
        d, builder = self.d, self.builder

        def newton(lanes):
            steps = self.solved(lanes, self.missing(lanes, self.kick(lanes)))
            self.store_rows(lanes, [self.load(lanes, V, i) + steps[i] for i in range(d)], V * d)

        def missing(lanes):
            self.store_rows(lanes, self.missing(lanes, self.kick(lanes)), self.found)

        def steps(lanes):
            inside = self.projected(lanes, self.found)
            self.store_rows(lanes, self.solved(lanes, inside), self.steps)

        def landed(lanes):
            inside = self.projected(lanes, self.steps)
            self.store_rows(lanes, [self.load(lanes, V, i) + inside[i] for i in range(d)], V * d)

        with builder.if_else(self.projects) as (more_points, square):
            with more_points:
                for part in (missing, steps, landed):
                    self.chunks(part)
            with square:
                self.chunks(newton)

    def drift(self, lanes):
        """q from v, or from accelerations."""
        totals = self.sums(lanes, LOW_Q, self.tables, self.first_drift, V * self.d)
        if self.alone:
            totals = [self.load(lanes, P, i).exact + total for i, total in enumerate(totals)]
        self.moved(lanes, totals, Q, 0, 0)

    def one_pass(self):
        """All parts, the largest change noted."""
        if self.alone:
            self.chunks(self.accelerate)
        else:
            self.chunks(self.evaluate)
            self.rates()
        self.chunks(self.drift)

    def change(self):
        """The largest relative change of q and p."""
        lanes = self.at(self.row(0))
        return self.builder.bitcast(lanes.largest(self.builder.load(self.largest)), DOUBLE)


def one_pass(law, d, width, one, alone):
    """An intrinsic of the address of these words, for a law on R^d: the addresses of work, tables,
    complement, constants and numbers, then P, s and the rows of complement.

    width  lanes of a vector, of which P is a multiple
    one    whether the arrays are of one vector of stages; the word P is not read then
    alone  whether places alone are iterated
    """
    below = filled(law, d)

    def do(context, builder, words):
        made = Pass(context, builder, words, law, below, d, width, one, alone)
        place = builder.gep(made.numbers, [made.row(2 * d + 2)])
        if alone:
            begins = builder.load(place)
            terms = builder.fptoui(builder.fsub(ir.Constant(DOUBLE, -1.0), begins), made.row)
            drift = builder.add(made.first_drift, builder.mul(terms, made.padded))
            begins = builder.fcmp_ordered("<", begins, ir.Constant(DOUBLE, 0.0))
            with builder.if_else(begins) as (first, later):
                with first:
                    made.chunks(lambda lanes: made.coast(lanes, drift))
                with later:
                    made.one_pass()
        else:
            made.one_pass()
        builder.store(made.change(), place)

    return of_words(do)
