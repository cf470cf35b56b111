"""The arrays of galvi.lanes.group_pass, sums over the stages of a step, and its chart.

Rows of work, (rows, P):

xi, eta, f, defect  (d, P) each: coordinates, rates, forces and defects D with the multipliers' part
low_xi, low_f, low_n  (d, P) each: what the low parts of the tables add to sums of eta, f and n
before              (d, P)       not used here
n, v, mu, pulled    (d, P) each: impulses, velocities, dL/dv, and Q
end                 (d, P)       xi(1) in each lane; if s = P, else lane s has the step's end
t                   (P,)         times
factors             of the mass, as in galvi.lanes.law_pass, or a constant mass's inverse
response            the same of the multipliers' response
multipliers         (l d, P)     m, the same in each lane

tables      ((4 + l) P + 3, P)  h A^T, its low part, h (B - 1 b^T)^T and its low part, P rows each,
                       those after the s-th zeros; h b and its low part, and the mean of the b Y^2;
                       for r = 1 .. l the extrapolation of velocities that keeps r Legendre terms
complement  (2 l, P)   l functions Y at the stages and b Y, orthonormal in the rule's inner product
                       and orthogonal to the rates of all curves; l = 0 with as many points as
                       coefficients
numbers     (3 d + 4 + r,)  mu0 (d,), 1 over the sizes of xi (d,) and pi (d,), the pass's largest
                       relative change, which part to do, the Legendre terms kept, g (r,), h
"""

from __future__ import annotations

from functools import reduce
from typing import Any

from llvmlite import ir

from galvi.kernels.compile.internals import cgutils
from galvi.kernels.lie.arithmetic import larger_size
from galvi.kernels.lie.product import COUPLED, DIMENSION, ENTRIES, GROUPS, NUMBER, ROTATIONS
from galvi.kernels.on_group.scale import LEAST_COUPLED_MOTION
from galvi.lanes.dense import is_zero
from galvi.lanes.law_pass import Pass
from galvi.lanes.values import Lane, Truth
from galvi.lanes.vectors import DOUBLE, everywhere

(XI, ETA, F, DEFECT, LOW_XI, LOW_F, LOW_N, BEFORE, N, VELOCITY, MU, PULLED, END,
 TIMES) = range(14)  # fmt: skip  # times d
CHANGE, PART, KEPT, PLACE = range(4)  # numbers after the sizes


def rows_of_group_work(d, extra):
    """Rows of work for d coordinates and ``extra`` functions Y."""
    return TIMES * d + 1 + d * (d + 1) + extra * d


class GroupRows(Pass):
    """Loads, stores and sums, for one vector of stages (``one``) or several; heirs add a chart.

    width  lanes of a vector
    """

    chart: Any

    def __init__(self, context, builder, given, d, width, one):
        self.unpack(context, builder, given, d, width, one)
        self.lay_out()
        self.step_row = 3 * d + PLACE + self.chart.entries
        self.full = builder.icmp_unsigned("==", self.stages, self.padded)

    def lay_out(self):
        """First rows of the triangles and the multipliers."""
        d = self.d
        self.factors, self.fixed = TIMES * d + 1, {}
        self.response = self.factors + d * (d + 1) // 2
        self.multipliers = self.response + d * (d + 1) // 2

    def place(self):
        """Room for a lane."""
        return cgutils.alloca_once(self.builder, ir.VectorType(DOUBLE, self.width))

    def place_of(self, k):
        """Address of the k-th number after the sizes."""
        return self.builder.gep(self.numbers, [self.row(3 * self.d + k)])

    def whole(self, k):
        """The k-th number after the sizes as an integer."""
        return self.builder.fptoui(self.builder.load(self.place_of(k)), self.padded.type)

    def first_lanes(self):
        return self.at(self.row(0))

    def loaded(self, lanes, block):
        return [self.load(lanes, block, i) for i in range(self.d)]

    def stored(self, lanes, values, block):
        for i, value in enumerate(values):
            kept = value if isinstance(value, Lane) else Lane(self.builder, lanes.nothing)
            self.store(lanes, kept if is_zero(value) else kept.same(value), block, i)

    def keep_triangle(self, lanes, rows, first):
        for k, value in enumerate(value for row in rows for value in row):
            self.store_row(lanes, self.load(lanes, XI).same(value), first + k)

    def multiplier_rows(self, index):
        """The rows of work of one multiplier."""
        first = self.builder.add(
            self.row(self.multipliers), self.builder.mul(index, self.row(self.d))
        )
        return [self.builder.add(first, self.row(i)) for i in range(self.d)]

    def note(self, lanes, new, old, size):
        """Note the largest change, relative to 1 over the size that is the number ``size``."""
        self.note_bits(abs((new - old) * self.number(lanes, size)).bits)

    def note_turns(self, xi):
        """Note |xi|^2 of each rotation."""
        for _, own, _, rotations in self.chart.factors:
            if rotations:
                squares = [x * x for x in xi[own.start : own.start + rotations]]
                self.note_bits(abs(reduce(total, squares)).bits)

    def spread_sums(self, rows, *weights, matrix=None):
        """sum_j w_j x_j for some rows x of work, the same in all lanes.

        weights  a row w of the tables, or of ``matrix``; of several, the sum, added in their order
        """
        builder, sums = self.builder, [self.place() for _ in rows]
        for place in sums:
            builder.store(everywhere(place.type.pointee, 0.0), place)

        def add(lanes, weight):
            factor = lanes.factor(self.tables if matrix is None else matrix, weight)
            for row, place in zip(rows, sums, strict=True):
                value = lanes.load(self.work, self.row(row))
                builder.store(lanes.add(builder.load(place), lanes.mul(value, factor)), place)

        for weight in weights:
            self.chunks(lambda lanes, weight=weight: add(lanes, weight))
        return [self.spread_sum(builder.load(place)) for place in sums]

    def over_step(self, block):
        """h sum_j b_j x_j for a block of work.

        What the low part of h b adds is less than half an ulp of the sum, and always of the same
        sign: added to the sum it would be lost, so the sum begins with it.
        """
        rows = [block * self.d + i for i in range(self.d)]
        return self.spread_sums(rows, self.builder.add(self.kicks, self.row(1)), self.kicks)

    def means(self, rows):
        """The means of some rows, with the weights b Y^2."""
        return self.spread_sums(rows, self.builder.add(self.kicks, self.row(2)))

    def unit(self, index):
        """1 at an index of LLVM's, which may be a constant, and 0 elsewhere, in all lanes."""
        builder, one = self.builder, Lane(self.builder, self.first_lanes().nothing).same(1.0)
        places = [builder.icmp_unsigned("==", index, self.row(i)) for i in range(self.d)]
        return [one.where(Truth(builder, here), 0.0) for here in places]

    def keep_number(self, k, lane):
        """Change a number, to one that is the same in all lanes."""
        scalar = self.builder.extract_element(lane.value, ir.IntType(32)(0))
        self.builder.store(scalar, self.builder.gep(self.numbers, [self.row(k)]))

    def largest_of(self, rows):
        """The largest size in some rows of work at all stages, in all lanes."""
        lanes, place = self.first_lanes(), self.place()
        self.builder.store(lanes.nothing, place)

        def widen(lanes):
            size = Lane(self.builder, self.builder.load(place), ())
            for row in rows:
                size = larger_size(size, self.load_row(lanes, row).exact)
            self.builder.store(size.value, place)

        self.chunks(widen)
        bits = lanes.largest(Lane(self.builder, self.builder.load(place)).bits)
        return Lane(self.builder, lanes.spread(self.builder.bitcast(bits, DOUBLE)), ())

    def measure_rotations(self):
        """1 for rotations, and 0 for translations and momenta, as their inverse sizes."""
        nothing = Lane(self.builder, self.first_lanes().nothing, ())
        for _, own, _, rotations in self.chart.factors:
            for i in range(own.start, own.stop):
                size = 1.0 if i < own.start + rotations else 0.0
                self.keep_number(self.d + i, nothing + size)
                self.keep_number(2 * self.d + i, nothing)

    def measure(self):
        """1 over the sizes of xi and pi in numbers, 0 where all are 0.

        Rotations have size 1. All translations of a factor share a size, that of its positions and
        displacements, and so do the momenta of its translations and of its rotations. An angular
        momentum is at least as large as what the displacements make of a momentum. No momentum is
        below LEAST_COUPLED_MOTION of the largest one that a mass couples to it: it may be
        round-off of that.
        """
        lanes, d, chart = self.first_lanes(), self.d, self.chart
        step = self.number(lanes, self.step_row)
        g = [self.number(lanes, 3 * d + PLACE + i) for i in range(chart.entries)]
        momenta: list[Any] = []
        coupled: dict[int, list[int]] = {number: [] for number in chart.coupled}
        for number, (_, own, _, _) in zip(chart.coupled, chart.factors, strict=True):
            coupled[number] += [ETA * d + i for i in range(own.start, own.stop)]
        least = {number: LEAST_COUPLED_MOTION * abs(self.largest_of(rows) * step)
                 for number, rows in coupled.items()}  # fmt: skip
        for number, factor in zip(chart.coupled, chart.factors, strict=True):
            group, own, entries, rotations = factor
            turns = range(own.start, own.start + rotations)
            ways = range(own.start + rotations, own.stop)
            sizes = []
            for part in (turns, ways):
                size = abs(self.largest_of([F * d + i for i in part]) * step)
                for i in part:
                    size = larger_size(size, self.number(lanes, i))
                sizes.append(size)
            moment, moving = sizes
            if ways:
                way = abs(self.largest_of([ETA * d + i for i in ways]) * step)
                moment = larger_size(moment, moving * way)
                far = larger_size(least[number], way.same(group.position_scale(g[entries])))
                far = larger_size(far, way)
                far = larger_size(far, self.largest_of([XI * d + i for i in ways]))
                for i in ways:
                    self.keep_number(d + i, (1.0 / far).where(far > 0.0, 0.0))
            momenta += [(number, moment, turns), (number, moving, ways)]
        most: dict[int, Any] = {}
        for number, size, _ in momenta:
            most[number] = larger_size(most.get(number, 0.0), size)
        for number, size, part in momenta:
            size = larger_size(LEAST_COUPLED_MOTION * most[number], size)
            for i in part:
                self.keep_number(2 * d + i, (1.0 / size).where(size > 0.0, 0.0))

    def spread_sum(self, vector):
        """The sum of the lanes, in each of them."""
        name = f"llvm.vector.reduce.fadd.v{self.width}f64"
        kind = ir.FunctionType(DOUBLE, [DOUBLE, vector.type])
        reduce = cgutils.get_or_insert_function(self.builder.module, kind, name)
        zero = ir.Constant(DOUBLE, -0.0)
        whole = self.builder.call(reduce, [zero, vector], fastmath=("reassoc",))
        return Lane(self.builder, self.first_lanes().spread(whole))


class Chart:
    """The functions of a product of groups in one chart, for lanes or numbers.

    layout  rows of numbers, see galvi.kernels.lie.product
    """

    def __init__(self, layout, chart):
        self.number, self.factors, start, first = chart, [], 0, 0
        self.coupled = [(*row, 0)[COUPLED] for row in layout]
        for row in layout:
            here = slice(start, start + row[DIMENSION])
            entries = slice(first, first + row[ENTRIES])
            self.factors.append((GROUPS[row[NUMBER]], here, entries, row[ROTATIONS]))
            start, first = here.stop, first + row[ENTRIES]
        self.dimension, self.entries = start, first

    def place(self, g, xi):
        """The entries of g Phi(xi)."""
        found = []
        for group, own, entries, _ in self.factors:
            out = [None] * (entries.stop - entries.start)
            group.place(self.number, g[entries], xi[own], out)
            found += out
        return found

    def left_derivative(self, g, slope):
        """The derivatives along g hat(e_a) of a function with Euclidean derivative slope."""
        found = []
        for group, own, entries, _ in self.factors:
            out = [0.0] * (own.stop - own.start)
            group.left_derivative(g[entries], slope[entries], out)
            found += out
        return found

    def apply(self, name, xi, *vectors):
        """A function of galvi.kernels.lie.groups with d results; 0.0 where it is of zeros alone."""
        found = []
        for group, own, _, _ in self.factors:
            parts = [list(vector[own]) for vector in vectors]
            out = [0.0] * len(xi[own])
            if not all(is_zero(x) for x in parts[-1]):
                getattr(group, name)(self.number, xi[own], *parts, out)
            found += out
        return found


def total(x, y):
    """x + y, and one of them where the other is the number 0."""
    return y if is_zero(x) else (x if is_zero(y) else x + y)
