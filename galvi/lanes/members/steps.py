"""Many steps of many members, eight at a time: what laws on R^d and on Lie groups share.

words        (14,) integers, of which the first six are addresses:
             records      (blocks, rows, 8)  one block for eight members, see ``Fields``
             constants    (blocks, c, 8)     of the law
             work         (rows, s, 8)       scratch
             tables       (rows, s)          of the method, for a step of 1: see ``Tables``
             complement   as in galvi.lanes.law_pass or galvi.lanes.group_rows
             reals        growth (l,), see galvi.lanes.law, then the tolerance
             blocks, s, the number of the first step, and how many to do
             l, the rows of complement, c, the rows of a record
"""

from __future__ import annotations

from typing import Any, NamedTuple

from galvi.kernels.compile.internals import cgutils
from galvi.kernels.lie.arithmetic import larger, larger_size
from galvi.kernels.nystrom.solve import FIXED_POINT_PASSES
from galvi.lanes.functions import Reciprocals
from galvi.lanes.law_pass import Pass
from galvi.lanes.members.rows import (
    Judgement,
    MemberLanes,
    Variable,
    splat,
    terms_kept,
    whole_number,
)
from galvi.lanes.values import Lane
from galvi.lanes.vectors import DOUBLE, LANES, NOTHING

WORDS = 14
(RECORDS, CONSTANTS, WORK, TABLES, COMPLEMENT, REALS, BLOCKS, STAGES, FIRST, TODO, TERMS, EXTRA,
 NUMBERS, ROWS) = range(WORDS)  # fmt: skip
SHARED = ("step", "start", "alive", "failed", "code", "passes", "age")


class Tables(NamedTuple):
    """First rows of the parts of ``tables`` for s stages.

    drift, low_drift    A^T and its low part, (s, s) each
    back, low_back      B^T and its low part; for groups those of B - 1 b^T
    kicks, low_kicks    b and its low part, (1, s) each
    nodes               c
    means               the mean of b Y^2, for groups; it stands before the nodes, whose low part it
                        is where places are iterated alone. Then drift and low_drift are A of the
                        Nystrom method, back and low_back begin with beta
    series              Legendre coefficients from stages, (s, s)
    ahead               Legendre polynomials at the next step's stages, (l, s)
    """

    drift: int
    low_drift: int
    back: int
    low_back: int
    kicks: int
    low_kicks: int
    nodes: int
    means: int
    series: int
    ahead: int


PLACES = ((0, 0), (1, 0), (2, 0), (3, 0), (4, 0), (4, 1), (4, 3), (4, 2), (4, 4), (5, 4))


class Fields:
    """Rows of a record: a law's own, those in SHARED, then its velocities at the stages.

    step, start    h and the time of the problem's start
    alive          1, or 0 for a member that has failed or ended
    failed, code   the step that failed, from 1, and why; 0 for none
    passes         of all steps
    age            steps done
    """

    def __init__(self, own, d):
        self.first, self.d, row = {}, d, 0
        for name, size in (*own, *((name, 1) for name in SHARED)):
            self.first[name] = row
            row += size
        self.velocities = row

    def rows(self, s):
        """Rows of a record for s stages."""
        return self.velocities + self.d * s


class MemberSteps(Pass):
    """The loops over blocks, steps and passes, around the parts of a pass for eight stages.

    Its attributes are those of `Pass`, or of its heirs, where a row of ``numbers`` is that of a
    record; an heir adds ``velocity_row``, ``time_row`` and ``guarded``, rows of work, ``step``,
    ``one_pass``, ``after_first_pass`` and ``add_low_parts``.
    """

    velocity_row: int
    time_row: int
    guarded: Any
    one_pass: Any
    after_first_pass: Any
    add_low_parts: Any  # (the members chosen)
    step: Any
    first: Any  # whether a pass is the first of its step
    one = False

    def open(self, context, builder, words, fields, rule, stages=0):
        """What all members share; ``words`` is the address of these.

        rule    what ends the iteration of a member, see `Judgement`
        stages  s, for which loops are written out; 0 for any
        """
        self.context, self.builder, self.fields = context, builder, fields
        self.d, self.row, self.width = fields.d, words.type.pointee, LANES
        self.step_row = fields.first["step"]
        builder.reciprocals = Reciprocals(context, builder)
        found = [builder.load(builder.gep(words, [self.row(k)])) for k in range(WORDS)]
        addresses = [builder.inttoptr(word, DOUBLE.as_pointer()) for word in found[:6]]
        self.records, self.all_constants, self.work, self.tables, self.complement, self.reals = (
            addresses
        )
        (self.blocks, self.stages, self.first_step, self.todo, self.kept_terms, self.extra,
         self.given_constants, self.record_rows) = found[6:]  # fmt: skip
        self.stages = self.row(stages) if stages else self.stages
        self.padded = builder.mul(self.stages, self.row(LANES))
        self.tabled = Tables(*(
            builder.add(builder.mul(self.stages, self.row(a)), self.row(b)) for a, b in PLACES
        ))  # fmt: skip
        self.low_drift, self.back = self.tabled.low_drift, self.tabled.back
        self.low_back, self.kicks = self.tabled.low_back, self.tabled.kicks
        self.projects = builder.icmp_unsigned("!=", self.extra, self.row(0))
        self.judgement = Judgement(builder, rule)
        self.tolerance = self.real(self.kept_terms)

    def at(self, chunk):
        """The lanes at a stage."""
        return MemberLanes(self.context, self.builder, self.stages, chunk)

    @property
    def length_of_a_matrix(self):
        """Rows of a matrix of the tables."""
        return self.stages

    def real(self, index):
        """A number of ``reals`` in all lanes."""
        return splat(self.builder, self.builder.load(self.builder.gep(self.reals, [index])))

    def field(self, name, i=0):
        """A row of the record, a lane whose operations are rounded one by one."""
        row = self.row(self.fields.first[name] + i)
        return Lane(self.builder, self.at(self.row(0)).number(self.numbers, row), ())

    def keep(self, name, lane, i=0):
        """Change a row of the record."""
        self.keep_number(self.fields.first[name] + i, lane)

    def keep_number(self, k, lane):
        """Change a row of the record by its number."""
        self.at(self.row(0)).keep(lane.value, self.numbers, self.row(k))

    def keep_where(self, mask, name, lane, i=0):
        """Change a row of the record for some members."""
        old = self.field(name, i)
        self.keep(name, old.same(lane).where(mask, old), i)

    def sums(self, lanes, start, matrix, first_row, row, apart=None):
        """As those of one member; the tables are for a step of 1."""
        d, builder = self.d, self.builder
        if apart is None:
            found = lanes.sums([NOTHING] * d, matrix, first_row, self.work, self.row(row),
                               self.stages)  # fmt: skip
        else:
            found = [
                lanes.sums([NOTHING], matrix, builder.add(first_row, builder.mul(apart,
                           self.row(i))), self.work, self.row(row + i), self.stages)[0]
                for i in range(d)
            ]  # fmt: skip
        totals = [Lane(builder, value, ()) for value in found]
        if matrix is self.tables:
            step = self.field("step")
            totals = [total * step for total in totals]
            if self.alone:  # a rounded h^2 would be wrong by the same in each step
                totals = [total * step for total in totals]
        if start is not None:
            totals = [self.load(lanes, start, i).exact + total for i, total in enumerate(totals)]
        return totals

    def largest_of(self, rows):
        """The largest size in some rows of work at all stages."""
        found = Variable(self.builder)
        self.chunks(lambda lanes: [
            found.set(larger_size(found.lane, self.load_row(lanes, row).exact)) for row in rows
        ])  # fmt: skip
        return found.lane

    def weighted(self, rows, *weights, matrix=None):
        """sum_j w_j x_j for some rows x of work, where w is a row of the tables or of a matrix.

        With several rows w, those of the smallest first, the sum of all these.
        """
        matrix = self.tables if matrix is None else matrix
        sums = [Variable(self.builder) for _ in rows]

        def add(lanes, weight):
            factor = Lane(self.builder, lanes.factor(matrix, weight))
            for row, total in zip(rows, sums, strict=True):
                total.set(total.lane.fused + self.load_row(lanes, row) * factor)

        for weight in weights:
            self.chunks(lambda lanes, weight=weight: add(lanes, weight))
        return [total.lane for total in sums]

    def advance(self):
        """All steps of all blocks."""
        builder = self.builder
        with cgutils.for_range(builder, self.blocks, intp=self.row) as loop:
            self.numbers = self.block(self.records, loop.index, self.record_rows)
            self.constants = self.block(self.all_constants, loop.index, self.given_constants)
            self.copy_velocities(into_work=True)
            self.prepare_block()
            with cgutils.for_range(builder, self.todo, intp=self.row) as steps:
                self.step(builder.add(self.first_step, steps.index))
            self.copy_velocities(into_work=False)

    def prepare_block(self):
        """Factors a constant mass, once a run."""

    def block(self, data, index, rows):
        """The address of a block of eight members."""
        size = self.builder.mul(rows, self.row(LANES))
        return self.builder.gep(data, [self.builder.mul(index, size)])

    def copy_velocities(self, into_work):
        """Copy the velocities at the stages between record and work."""
        first = self.row(self.fields.velocities)

        def copy(lanes):
            for i in range(self.d):
                row = self.builder.add(self.builder.mul(self.stages, self.row(i)), lanes.stage)
                row = self.builder.add(first, row)
                if into_work:
                    value = lanes.number(self.numbers, row)
                    lanes.store(value, self.work, self.row(self.velocity_row + i))
                else:
                    value = lanes.load(self.work, self.row(self.velocity_row + i))
                    lanes.keep(value, self.numbers, row)

        self.chunks(copy)

    def times(self, number):
        """The times of the stages of a step."""
        step, start, count = self.field("step"), self.field("start"), whole_number(
            self.builder, number
        )  # fmt: skip

        def fill(lanes):
            node = Lane(self.builder, lanes.factor(self.tables, self.tabled.nodes), ())
            self.store_row(lanes, start + (count + node) * step, self.time_row)

        self.chunks(fill)

    def continue_velocities(self, scratch):
        """The velocities from those of the last step; ``scratch`` is the first of d rows."""
        d, sizes = self.d, self.time_row

        def analyse(lanes):
            found = lanes.sums([NOTHING] * d, self.tables, self.tabled.series, self.work,
                               self.row(self.velocity_row), self.stages)  # fmt: skip
            largest = Lane(self.builder, NOTHING)
            for i, value in enumerate(found):
                coefficient = Lane(self.builder, value)
                self.store_row(lanes, coefficient, scratch + i)
                largest = larger(abs(coefficient), largest)
            self.store_row(lanes, largest, sizes)

        def size(index):
            return self.load_row(self.at(index), sizes)

        self.chunks(analyse)
        terms = terms_kept(self.builder, self.row, self.kept_terms, size, self.real)

        def shorten(lanes):
            keeps = terms > whole_number(self.builder, lanes.stage)
            for i in range(d):
                kept = self.load_row(lanes, scratch + i).where(keeps, 0.0)
                self.store_row(lanes, kept, scratch + i)

        def continue_series(lanes):
            found = lanes.sums([NOTHING] * d, self.tables, self.tabled.ahead, self.work,
                               self.row(scratch), self.kept_terms)  # fmt: skip
            for i, value in enumerate(found):
                self.store_row(lanes, Lane(self.builder, value), self.velocity_row + i)

        self.chunks(shorten)
        self.chunks(continue_series)

    def iterate(self):
        """Passes until no member is active."""
        builder, judgement = self.builder, self.judgement
        judgement.begin(self.field("alive") > 0.0)
        passes = Variable(builder)
        with cgutils.for_range(builder, self.row(FIXED_POINT_PASSES), intp=self.row) as loop:
            counted = passes.lane
            passes.set((counted + 1.0).where(judgement.active.value, counted))
            self.forget()
            self.first = builder.icmp_unsigned("==", loop.index, self.row(0))
            self.one_pass()
            noted = Lane(builder, NOTHING, ()).of_bits(builder.load(self.largest))
            with builder.if_else(self.first) as (at_first, later):
                with at_first:
                    self.after_first_pass(noted)
                with later:
                    judgement.judge(noted, self.tolerance)
            with builder.if_then(judgement.settles.value.any):
                self.add_low_parts(judgement.settles.value)
            with builder.if_then((~judgement.active.value).every):
                loop.do_break()
        self.keep("passes", self.field("passes") + passes.lane)

    def conclude(self, number, done, lost):
        """Note which members have done the step, and which failed."""
        self.keep_where(done, "age", self.field("age") + 1.0)
        self.keep_where(lost, "alive", 0.0)
        self.keep_where(lost, "failed", whole_number(self.builder, number) + 1.0)
        self.keep_where(lost, "code", self.judgement.code.lane)

    def store_row(self, lanes, lane, row):
        """Store a lane; the rows that an iteration changes only for members that are active."""
        value = lane.value
        if row in self.guarded:
            old = lanes.load(self.work, self.row(row))
            value = self.builder.select(self.judgement.active.value.value, value, old)
        lanes.store(value, self.work, self.row(row))
