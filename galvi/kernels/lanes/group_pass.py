"""One pass of the iteration of galvi.kernels.lanes.group_law, as vector instructions for one law.

A law is a Python function (g, v, t, constants) -> (tau, mu, mass) of lanes or numbers: g holds the
entries of an element, tau the left-trivialised dL/dg, mu = dL/dv, and mass the rows of d2L/dv2 up
to its diagonal; zeros that do not depend on the state are the number 0.0. Rows of work, (rows, P):

xi, eta, f, pi      (d, P) each: coordinates, rates, forces and momenta in the chart
low_xi, low_pi      (d, P) each: what the low parts of the tables add to xi and pi
before              (d, P)       not used here
n, v, mu, rest      (d, P) each: impulses, velocities T eta, dL/dv, scratch
t                   (P,)         times
factors             of the mass, as in galvi.kernels.lanes.law_pass

tables      (4 s, P)   h A^T, its low part, h B^T and its low part
complement  (2 l, P)   l functions Y at the stages and b Y, orthonormal in the rule's inner product
                       and orthogonal to the rates of all curves; l = 0 with as many points as
                       coefficients
numbers     (3 d + 2 + r,)  p0 (d,), 1 over the sizes of xi (d,) and pi (d,), the pass's largest
                       relative change, which part to do, g (r,)
"""

from __future__ import annotations

import numpy as np
from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

from galvi.kernels.lanes.law_pass import Constants, Generic, Pass, factored, is_zero
from galvi.kernels.lanes.values import Lane
from galvi.kernels.lanes.vectors import DOUBLE, NOTHING, VECTOR, Lanes
from galvi.kernels.lie.product import DIMENSION, ENTRIES, GROUPS, NUMBER

XI, ETA, F, PI, LOW_XI, LOW_PI, BEFORE, N, VELOCITY, MU, REST, TIMES = range(12)  # times d
PASS, GUESS, PREPARE = 0, 1, 2  # parts: a pass; eta from velocities, and xi; a constant mass


def rows_of_group_work(d):
    """Rows of work for d coordinates."""
    return TIMES * d + 1 + d * (d + 1) // 2


class Chart:
    """The functions of a product of groups in one chart, for lanes or numbers.

    layout  rows of numbers, see galvi.kernels.lie.product
    """

    def __init__(self, layout, chart):
        self.number, self.factors, start, first = chart, [], 0, 0
        for row in layout:
            here = slice(start, start + row[DIMENSION])
            self.factors.append((GROUPS[row[NUMBER]], here, slice(first, first + row[ENTRIES])))
            start, first = here.stop, first + row[ENTRIES]
        self.dimension, self.entries = start, first

    def place(self, g, xi):
        """The entries of g Phi(xi)."""
        found = []
        for group, own, entries in self.factors:
            out = [None] * (entries.stop - entries.start)
            group.place(self.number, g[entries], xi[own], out)
            found += out
        return found

    def left_derivative(self, g, slope):
        """The derivatives along g hat(e_a) of a function with Euclidean derivative slope."""
        found = []
        for group, own, entries in self.factors:
            out = [0.0] * (own.stop - own.start)
            group.left_derivative(g[entries], slope[entries], out)
            found += out
        return found

    def apply(self, name, xi, *vectors):
        """A function of galvi.kernels.lie.groups with d results; 0.0 where it is of zeros alone."""
        found = []
        for group, own, _ in self.factors:
            parts = [list(vector[own]) for vector in vectors]
            out = [0.0] * len(xi[own])
            if not all(is_zero(x) for x in parts[-1]):
                getattr(group, name)(self.number, xi[own], *parts, out)
            found += out
        return found


def total(x, y):
    """x + y, and one of them where the other is the number 0."""
    return y if is_zero(x) else (x if is_zero(y) else x + y)


def plain_mass(law, chart, state):
    """The mass at a state without special properties, one of several."""
    near = np.linspace(0.3, 0.7 + 0.1 * state, chart.entries + chart.dimension + 1) ** 0.5
    g, v = list(near[: chart.entries]), list(near[chart.entries : -1])
    return [list(map(np.float64, row)) for row in law(g, v, near[-1], Generic())[2]]


class GroupPass(Pass):
    """The parts of a pass, each for eight stages."""

    def __init__(self, context, builder, signature, values, law, chart):
        super().__init__(context, builder, signature, values, law, chart.dimension)
        self.chart, self.found = chart, (TIMES - 1) * self.d + 1  # the factors begin d rows later
        shape = context.make_array(signature.args[2])(context, builder, values[2]).shape
        self.extra = builder.udiv(builder.extract_value(shape, 0), self.row(2))
        with np.errstate(all="ignore"):
            masses = [plain_mass(law, chart, state) for state in range(2)]
            rows = factored(masses[0])
        self.constant_mass = masses[0] == masses[1]
        self.below = [(i, j) for i in range(self.d) for j in range(i) if rows[i][j] != 0.0]

    def place_of(self, k):
        """Address of the k-th number after the sizes."""
        return self.builder.gep(self.numbers, [self.row(3 * self.d + k)])

    def loaded(self, lanes, block):
        return [self.load(lanes, block, i) for i in range(self.d)]

    def stored(self, lanes, values, block):
        for i, value in enumerate(values):
            kept = value if isinstance(value, Lane) else Lane(self.builder, NOTHING)
            self.store(lanes, kept if is_zero(value) else kept.same(value), block, i)

    def state(self, lanes):
        """xi, eta, the velocity, and what the law is there."""
        xi, eta = self.loaded(lanes, XI), self.loaded(lanes, ETA)
        first = 3 * self.d + 2
        g = [self.number(lanes, first + i).fused for i in range(self.chart.entries)]
        velocity = self.chart.apply("velocity", xi, eta)
        constants = Constants(self.builder, lanes, self.constants, self.row)
        time = self.load(lanes, TIMES)
        return xi, eta, velocity, self.law(self.chart.place(g, xi), velocity, time, constants)

    def keep_factors(self, lanes, mass):
        for k, factor in enumerate(value for row in factored(mass) for value in row):
            self.store(lanes, self.load(lanes, XI).same(factor), TIMES, 1 + k)

    def prepare(self, lanes):
        """The factors of a mass that does not depend on the state."""
        if self.constant_mass:
            self.keep_factors(lanes, self.state(lanes)[3][2])

    def evaluate(self, lanes):
        """f, n, velocities, momenta and factors from xi and eta."""
        xi, eta, velocity, (tau, mu, mass) = self.state(lanes)
        f = self.chart.apply("momentum_slope", xi, eta, mu)
        pulled, swung = (self.chart.apply(x, xi, tau) for x in ("momentum", "coadjoint_change"))
        f = [
            y if is_zero(x) else (x if is_zero(y) else x + y)
            for x, y in zip(f, pulled, strict=True)
        ]
        n = [
            y if is_zero(x) else (x if is_zero(y) else x + y)
            for x, y in zip(tau, swung, strict=True)
        ]
        self.stored(lanes, f, F)
        self.stored(lanes, n, N)
        self.stored(lanes, velocity, VELOCITY)
        self.stored(lanes, mu, MU)
        if not self.constant_mass:
            self.keep_factors(lanes, mass)

    def moved_to(self, lanes, totals, block, origin, sizes):
        """As ``moved``, with an origin, or None for 0, and a size for each row."""
        new = []
        for i, total in enumerate(totals):
            place = total if origin is None else self.number(lanes, origin + i) + total
            size = self.number(lanes, sizes + i)
            far = ((place - self.load(lanes, block, i)) * size).call("fabs").bits
            largest = self.builder.load(self.largest)
            # The bit patterns of nonnegative numbers are ordered like the numbers, with NaN last.
            more = self.builder.icmp_signed(">", far, largest)
            self.builder.store(self.builder.select(more, far, largest), self.largest)
            self.store(lanes, place, block, i)
            new.append(place.fused)
        return new

    def kick(self, lanes):
        """pi from f."""
        start = self.builder.mul(self.stages, self.row(2))
        return self.moved_to(
            lanes, self.sums(lanes, LOW_PI, self.tables, start, F * self.d), PI, 0, 2 * self.d
        )

    def lack(self, lanes):
        """What the momenta T^T mu lack."""
        pi = self.kick(lanes)
        own = self.chart.apply("momentum", self.loaded(lanes, XI), self.loaded(lanes, MU))
        self.stored(lanes, [pi[i] - own[i] for i in range(self.d)], REST)

    def turn(self, lanes):
        """pi from f and eta by one Newton step, with as many points as coefficients."""
        xi, mu, eta = (self.loaded(lanes, block) for block in (XI, MU, ETA))
        asked = self.chart.apply("covector", xi, self.kick(lanes))
        lacking = [asked[i] - mu[i] for i in range(self.d)]
        more = self.chart.apply("rate", xi, self.solved(lanes, lacking, self.below))
        self.stored(lanes, [eta[i] + more[i] for i in range(self.d)], ETA)

    def solve(self, lanes):
        """The change of eta that the momenta ask for."""
        xi = self.loaded(lanes, XI)
        asked = self.chart.apply("covector", xi, self.loaded(lanes, REST))
        more = self.solved(lanes, asked, self.below)
        self.stored(lanes, self.chart.apply("rate", xi, more), REST)

    def add_rest(self, lanes):
        """eta by its change."""
        eta, more = self.loaded(lanes, ETA), self.loaded(lanes, REST)
        self.stored(lanes, [eta[i] + more[i] for i in range(self.d)], ETA)

    def guess(self, lanes):
        """eta from the velocities."""
        xi, velocity = self.loaded(lanes, XI), self.loaded(lanes, VELOCITY)
        self.stored(lanes, self.chart.apply("rate", xi, velocity), ETA)

    def drift(self, lanes):
        """xi from eta."""
        totals = self.sums(lanes, LOW_XI, self.tables, self.row(0), ETA * self.d)
        self.moved_to(lanes, totals, XI, None, self.d)

    def project(self, block):
        """Subtract from a block of rows their parts along the functions Y."""
        builder, row = self.builder, self.row
        sums = [cgutils.alloca_once(builder, VECTOR) for _ in range(self.d)]
        reduce = cgutils.get_or_insert_function(
            builder.module, ir.FunctionType(DOUBLE, [DOUBLE, VECTOR]),
            f"llvm.vector.reduce.fadd.v{VECTOR.count}f64",
        )  # fmt: skip
        with cgutils.for_range(builder, self.extra, intp=row) as loop:
            for total in sums:
                builder.store(NOTHING, total)

            def add(lanes):
                Y = lanes.load(self.complement, builder.add(self.extra, loop.index))
                for i, total in enumerate(sums):
                    value = lanes.load(self.work, row(block * self.d + i))
                    builder.store(lanes.add(builder.load(total), lanes.mul(value, Y)), total)

            def subtract(lanes):
                Y = lanes.load(self.complement, loop.index)
                for i, total in enumerate(sums):
                    value = lanes.load(self.work, row(block * self.d + i))
                    far = lanes.mul(builder.load(total), Y)
                    lanes.store(lanes.sub(value, far), self.work, row(block * self.d + i))

            self.chunks(add)
            lanes = Lanes(self.context, builder, self.padded, row(0))
            for total in sums:
                whole = builder.call(
                    reduce, [ir.Constant(DOUBLE, 0.0), builder.load(total)], fastmath=("reassoc",)
                )
                builder.store(lanes.spread(whole), total)
            self.chunks(subtract)

    def one_pass(self):
        self.chunks(self.evaluate)
        with self.builder.if_else(self.projects) as (more_points, square):
            with square:
                self.chunks(self.turn)
            with more_points:
                self.chunks(self.lack)
                self.project(REST)
                self.chunks(self.solve)
                self.project(REST)
                self.chunks(self.add_rest)
        self.chunks(self.drift)
        self.builder.store(self.change(), self.place_of(0))

    def one_guess(self):
        self.chunks(self.guess)
        self.project(ETA)
        self.chunks(self.drift)


def group_pass(law, layout, chart):
    """An intrinsic (work, tables, complement, constants, numbers) for a law on these groups."""
    functions = Chart(layout, chart)

    @intrinsic
    def whole_pass(typingctx, work, tables, complement, constants, numbers):
        signature = types.void(work, tables, complement, constants, numbers)

        def generate(context, builder, signature, values):
            made = GroupPass(context, builder, signature, values, law, functions)
            part = builder.load(made.place_of(1))

            def asked(number):
                return builder.fcmp_ordered("==", part, ir.Constant(DOUBLE, float(number)))

            with builder.if_then(asked(PASS)):
                made.one_pass()
            with builder.if_then(asked(GUESS)):
                made.one_guess()
            with builder.if_then(asked(PREPARE)):
                made.chunks(made.prepare)
            return context.get_dummy_value()

        return signature, generate

    return whole_pass
