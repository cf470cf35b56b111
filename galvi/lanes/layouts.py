"""How the numbers of a step's stages lie in vectors: the stages of one run, or eight runs.

A kernel's arrays are

record      (rows, 1) or (rows, 8)  the numbers of each run, see ``Fields``
constants   (c, 1) or (c, 8)        constants of the law
work        (rows, P) or (rows, s, 8)  scratch: a number for each stage, and run
tables      (rows, P) or (rows, s)  of the method, for the step h or for a step of 1, see ``Tables``
complement  as tables
reals       growth (l,), the Legendre polynomials at the end of the next step, then the tolerance

and its argument is the address of ARGUMENTS integers: the addresses of these six; s, the number of
stages; l, that of Legendre terms; the number of multipliers or, on R^d, of rows of the complement;
the part of galvi.lanes.step to run; the number of the step; and whether work holds the velocities
of the step before.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from llvmlite import ir

from galvi.kernels.compile.internals import cgutils
from galvi.kernels.lie.arithmetic import larger_size
from galvi.lanes.functions import Reciprocals, two_product
from galvi.lanes.nbody import STEPS_BETWEEN_CHOICES
from galvi.lanes.stopping import Variable
from galvi.lanes.values import Lane, Truth
from galvi.lanes.vectors import DOUBLE, LANES, Lanes, everywhere, spread

ARGUMENTS = 12
(RECORD, CONSTANTS, WORK, TABLES, COMPLEMENT, REALS, STAGES, TERMS, EXTRA, PART, NUMBER,
 CONTINUES) = range(ARGUMENTS)  # fmt: skip
SHARED = ("step", "start", "alive", "failed", "code", "passes", "terms")
ROWS_TOGETHER = 6  # largest number of rows that are summed at once: the sums stay in registers


class Tables(NamedTuple):
    """First rows of the parts of ``tables``. A matrix has P rows for one run, of which those after
    the s-th are 0, and s rows for members.

    Attributes
    ----------
    drift, low_drift
        A^T and its low part
    back, low_back
        B^T and its low part; for groups those of B - 1 b^T
    kicks, low_kicks
        b and its low part, (1, s) each
    means
        for groups, the mean of b Y^2; with places_only, the low part of the nodes. With places_only
        drift and low_drift are A of the Nystrom method, and back and low_back begin with beta
    nodes
        c
    series
        Legendre coefficients from values at the stages
    ends
        for one run, the columns b, beta and the low parts of both; beta with places_only
    ahead
        for one run, a matrix for each r = 1 .. l: the extrapolation of values at the stages by r
        Legendre terms, with places_only followed by A; for members, the Legendre polynomials at the
        next step's stages, (l, s)
    """

    drift: int
    low_drift: int
    back: int
    low_back: int
    kicks: int
    low_kicks: int
    means: int
    nodes: int
    series: int
    ends: int
    ahead: int


# Numbers of matrices and of single rows before each part of the tables of one run. The tables of
# members have no ``ends``: there ``ahead`` takes its place.
FIRST_ROWS = (
    (0, 0),
    (1, 0),
    (2, 0),
    (3, 0),
    (4, 0),
    (4, 1),
    (4, 2),
    (4, 3),
    (4, 4),
    (5, 4),
    (6, 4),
)
ENDS = ("kicks", "back", "low_kicks", "low_back")  # columns of ``ends``


class Fields:
    """Rows of a record: the fields of a law, those of SHARED, and for members the velocities at the
    stages.

    step, start    h and the time of the problem's start alive          1, or 0 after a step that
    failed failed, code   the number of the step that failed, from 1, and its code; 0 if none failed
    passes         number of passes of all steps terms          number of terms of the velocities'
    series to extrapolate, 0 before the first choice
    """

    def __init__(self, own_fields, d):
        self.size = {**dict(own_fields), **dict.fromkeys(SHARED, 1)}
        self.first, self.d, row = {}, d, 0
        for name, size in self.size.items():
            self.first[name] = row
            row += size
        self.velocities = row

    def rows(self, s):
        """The number of rows of a member's record for s stages."""
        return self.velocities + self.d * s


class Rows:
    """Rows of work and of the record: the operations that both layouts share.

    A layout defines the lanes of each row, sums over stages and over a step, and how a step begins.

    width       lanes of a vector of stage values
    runs        lanes of a vector of run values: 1, or 8
    choice_interval  steps from one choice of the number of terms to extrapolate to the next
    """

    at: Any
    chunks: Any
    store_row: Any
    spread: Any
    over_stages: Any
    over_stages_largest: Any
    summed: Any

    def __init__(self, context, builder, arguments, fields, width, runs):
        self.context, self.builder, self.fields, self.d = context, builder, fields, fields.d
        self.row, self.width, self.runs = arguments.type.pointee, width, runs
        loaded = [builder.load(builder.gep(arguments, [self.row(k)])) for k in range(ARGUMENTS)]
        self.record, self.constants, self.work, self.tables, self.complement, self.reals = (
            builder.inttoptr(word, DOUBLE.as_pointer()) for word in loaded[:6]
        )
        self.stages, self.terms, self.extra, self.part, self.number, self.continues = loaded[
            STAGES:
        ]
        self.projects = builder.icmp_unsigned("!=", self.extra, self.row(0))
        self.largest = cgutils.alloca_once(builder, ir.VectorType(ir.IntType(64), width))
        self.reset_change()

    def lay_out_tables(self, block, first_rows=FIRST_ROWS):
        """Set the first rows of the parts of the tables, for matrices of ``block`` rows."""
        builder, row = self.builder, self.row
        self.block, self.table_rows = (
            block,
            Tables(
                *(
                    builder.add(builder.mul(block, row(matrices)), row(rows))
                    for matrices, rows in first_rows
                )
            ),
        )

    def zero(self):
        """The number 0 in all lanes of stage values."""
        return Lane(self.builder, everywhere(ir.VectorType(DOUBLE, self.width), 0.0))

    def variable(self, number=0.0):
        """A new variable that holds one number for each run."""
        return Variable(self.builder, self.runs, number)

    def reset_change(self):
        """Set the largest change to 0."""
        self.builder.store(everywhere(self.largest.type.pointee, 0), self.largest)

    def note_bits(self, bits):
        """Raise the largest change to the numbers with these bits, which are not negative, where
        they are larger."""
        largest = self.builder.load(self.largest)
        # The bit patterns of nonnegative numbers are ordered like the numbers, with NaN last.
        exceeds = self.builder.icmp_signed(">", bits, largest)
        self.builder.store(self.builder.select(exceeds, bits, largest), self.largest)

    def real(self, index):
        """A number of ``reals`` in the lanes of all runs."""
        scalar = self.builder.load(self.builder.gep(self.reals, [index]))
        return Lane(self.builder, spread(self.builder, scalar, self.runs), ())

    def integer_as_real(self, integer):
        """An LLVM integer as a double in the lanes of all runs."""
        scalar = self.builder.uitofp(integer, DOUBLE)
        return Lane(self.builder, spread(self.builder, scalar, self.runs), ())

    def spread_bit(self, truth):
        """An LLVM truth value in the lanes of all runs."""
        return Truth(self.builder, spread(self.builder, truth, self.runs))

    def load_row(self, lanes, row):
        return Lane(self.builder, lanes.load(self.work, self.row(row)))

    def load_rows(self, lanes, first):
        """The d rows of work from ``first`` on."""
        return [self.load_row(lanes, first + i) for i in range(self.d)]

    def store_rows(self, lanes, values, row):
        for i, value in enumerate(values):
            self.store_row(lanes, value, row + i)

    def field(self, name, i=0):
        """Row i of a field of the record; operations on it are not fused."""
        return Lane(self.builder, self.builder.load(self._address(name, i), align=8), ())

    def fields_of(self, name, size):
        """The first ``size`` rows of a field of the record."""
        return [self.field(name, i) for i in range(size)]

    def keep(self, name, lane, i=0):
        """Store row i of a field of the record."""
        self.builder.store(lane.value, self._address(name, i), align=8)

    def _address(self, name, i):
        k = self.row((self.fields.first[name] + i) * self.runs)
        return self._of_runs(self.builder.gep(self.record, [k]))

    def keep_where(self, mask, name, lane, i=0):
        """Store row i of a field of the record for the runs of a mask."""
        old = self.field(name, i)
        self.keep(name, old.same(lane).where(mask, old), i)

    def _of_runs(self, pointer):
        return self.builder.bitcast(pointer, ir.VectorType(DOUBLE, self.runs).as_pointer())

    def at_stages(self, name, i=0):
        """Row i of a field of the record, in the lanes of stage values."""
        return self.spread(self.field(name, i))

    def largest_of(self, rows):
        """The largest |x| in rows of work over all stages, for each run."""
        pointer = cgutils.alloca_once(self.builder, ir.VectorType(DOUBLE, self.width))
        self.builder.store(self.zero().value, pointer)

        def raise_size(lanes):
            size = Lane(self.builder, self.builder.load(pointer), ())
            for row in rows:
                size = larger_size(size, self.load_row(lanes, row).exact)
            self.builder.store(size.value, pointer)

        self.chunks(raise_size)
        return self.over_stages_largest(Lane(self.builder, self.builder.load(pointer), ()))

    def weighted_sums(self, rows, *weights, matrix=None):
        """sum_j w_j x_j of rows x of work, for each run.

        Parameters
        ----------
        weights
            rows w of the tables, or of ``matrix``; their sums are added, so the row with the
            smallest weights comes first
        """
        builder, kind = self.builder, ir.VectorType(DOUBLE, self.width)
        sums = [cgutils.alloca_once(builder, kind) for _ in rows]
        for pointer in sums:
            builder.store(everywhere(kind, 0.0), pointer)

        def add(lanes, weight):
            factor = Lane(builder, lanes.factor(self.tables if matrix is None else matrix, weight))
            for row, pointer in zip(rows, sums, strict=True):
                total = Lane(builder, builder.load(pointer)) + self.load_row(lanes, row) * factor
                builder.store(total.value, pointer)

        for weight in weights:
            self.chunks(lambda lanes, weight=weight: add(lanes, weight))
        return [self.over_stages(Lane(builder, builder.load(pointer))) for pointer in sums]

    def store_times(self, row):
        """Store the times of the step's stages in a row of work."""

        def fill(lanes):
            count = self.spread(self.integer_as_real(self.number))
            node = Lane(self.builder, lanes.factor(self.tables, self.table_rows.nodes), ())
            time = self.at_stages("start") + (count + node) * self.at_stages("step")
            self.store_row(lanes, time, row)

        self.chunks(fill)

    def series_of(self, lanes, row):
        """The Legendre coefficients of d rows of work."""
        return self.sums(lanes, self.tables, self.table_rows.series, row)

    def sums(self, lanes, matrix, first_row, row, matrix_stride=None, count=None, start=None):
        """sum_k x_k (row k of a matrix) for each of d rows x of work, from ``row`` on.

        Parameters
        ----------
        first_row
            row of ``matrix`` where the matrix begins
        matrix_stride
            rows from the matrix of one coordinate to that of the next; None for one matrix
        count
            for members, number of rows of the matrix in the sum; None for all stages
        start
            first of d rows of work to which the sums are added; None for sums from 0
        """
        count, totals = self.stages if count is None else count, []
        first = [lanes.zero] * self.d
        if start is not None:
            first = [lanes.load(self.work, self.row(start + i)) for i in range(self.d)]
        together = self.d if matrix_stride is None else 1
        for i in range(0, self.d, together):
            matrix_row = (
                first_row
                if matrix_stride is None
                else self.builder.add(first_row, self.builder.mul(matrix_stride, self.row(i)))
            )
            totals += self.summed(
                lanes, first[i : i + together], matrix, matrix_row, row + i, count
            )
        return [Lane(self.builder, value) for value in totals]


class Stages(Rows):
    """The stages of one run in the lanes of a vector, or of several.

    Parameters
    ----------
    single_vector
        whether one vector holds all stages
    ahead_holds_A
        whether the matrices ``ahead`` are A after extrapolation

    Attributes
    ----------
    lanes_are_full
        LLVM truth value: whether s = P, so that no lane follows the last stage
    """

    choice_interval = STEPS_BETWEEN_CHOICES

    def __init__(self, context, builder, arguments, fields, width, single_vector, ahead_holds_A):
        super().__init__(context, builder, arguments, fields, width, 1)
        row, self.single_vector, self.ahead_holds_A = self.row, single_vector, ahead_holds_A
        chunks = builder.udiv(builder.add(self.stages, row(width - 1)), row(width))
        self.padded = row(width) if single_vector else builder.mul(chunks, row(width))
        self.lanes_are_full = builder.icmp_unsigned("==", self.stages, self.padded)
        self.lay_out_tables(self.padded)

    def at(self, chunk):
        """The `Lanes` of the chunk-th vector of stages."""
        return Lanes(self.context, self.builder, self.padded, chunk, self.width)

    def chunks(self, part):
        """Call ``part(lanes)`` for each vector of stages."""
        if self.single_vector:
            part(self.at(self.row(0)))
            return
        chunks = self.builder.udiv(self.padded, self.row(self.width))
        with cgutils.for_range(self.builder, chunks, intp=self.row) as loop:
            part(self.at(loop.index))

    def store_row(self, lanes, lane, row):
        lanes.store(lane.value, self.work, self.row(row))

    def spread(self, lane):
        """The number of the run in all lanes of stage values."""
        scalar = self.builder.extract_element(lane.value, ir.IntType(32)(0))
        return Lane(self.builder, spread(self.builder, scalar, self.width), lane.flags)

    def spread_truth(self, truth):
        """The truth value of the run in all lanes of stage values."""
        scalar = self.builder.extract_element(truth.value, ir.IntType(32)(0))
        return Truth(self.builder, spread(self.builder, scalar, self.width))

    def stage_number(self, row, index):
        """The number in a row of work at a stage."""
        number = self.builder.add(self.builder.mul(self.row(row), self.padded), index)
        pointer = self._of_runs(self.builder.gep(self.work, [number]))
        return Lane(self.builder, self.builder.load(pointer, align=8), ())

    def over_stages(self, lane):
        """The sum of the lanes."""
        name = f"llvm.vector.reduce.fadd.v{self.width}f64"
        kind = ir.FunctionType(DOUBLE, [DOUBLE, lane.value.type])
        reduce = cgutils.get_or_insert_function(self.builder.module, kind, name)
        zero = ir.Constant(DOUBLE, -0.0)
        total = self.builder.call(reduce, [zero, lane.value], fastmath=("reassoc",))
        return Lane(self.builder, spread(self.builder, total, 1), ())

    def over_stages_largest(self, lane):
        """The largest |x| in the lanes."""
        return self._of_bits(self.at(self.row(0)).largest(abs(lane).bits))

    def change(self):
        """The largest change that was noted."""
        return self._of_bits(self.at(self.row(0)).largest(self.builder.load(self.largest)))

    def _of_bits(self, bits):
        scalar = self.builder.bitcast(bits, DOUBLE)
        return Lane(self.builder, spread(self.builder, scalar, 1), ())

    def reload(self):
        """Emit a compiler barrier: a broadcast load is free, a forwarded store costs a shuffle."""
        signature = ir.FunctionType(ir.VoidType(), [])
        self.builder.asm(signature, "", "~{memory}", [], True)

    def scaled_sums(self, lanes, start, first_row, row, power=1):
        """`sums` with the tables, which contain the factor h^power."""
        return self.sums(lanes, self.tables, first_row, row, start=start)

    def times_step(self, high, low, power):
        """The sum (high, low) itself: the tables contain the factor h^power."""
        return high, low

    def sums_over_step(self, row, *parts):
        """For each of d rows x of work, the sums sum_j w_j x_j with the columns ``parts`` of
        ENDS."""
        lanes, columns = self.at(self.row(0)), [ENDS.index(part) for part in parts]
        sums = self.sums(lanes, self.tables, self.table_rows.ends, row)
        index = ir.IntType(32)
        return [
            [
                Lane(
                    self.builder,
                    spread(self.builder, self.builder.extract_element(x.value, index(column)), 1),
                    (),
                )
                for column in columns
            ]
            for x in sums
        ]

    def over_step(self, rows):
        """h sum_j b_j x_j of rows x of work.

        The sum begins with the low part of h b, which adds less than half an ulp, always with the
        same sign: added last, it would be lost.
        """
        return self.weighted_sums(rows, self.table_rows.low_kicks, self.table_rows.kicks)

    def remember(self, velocities, last):
        """Copy the velocities of the last step to d rows of work: if this step fails, the run ends
        with them."""
        self.chunks(lambda lanes: self.store_rows(lanes, self.load_rows(lanes, velocities), last))

    def keep_series(self, lanes, series, row):
        """Do nothing: the velocities themselves are extrapolated."""

    def extrapolate(self, velocities, series, guess):
        """Store in d rows of work the extrapolated velocities at the next step's stages."""
        first = self.first_ahead()
        self.chunks(
            lambda lanes: self.store_rows(
                lanes, self.sums(lanes, self.tables, first, velocities), guess
            )
        )

    def first_ahead(self):
        """The first row of the matrix that extrapolates the chosen number of terms."""
        scalar = self.builder.extract_element(self.field("terms").value, ir.IntType(32)(0))
        terms = self.builder.sub(self.builder.fptoui(scalar, self.row), self.row(1))
        return self.builder.add(self.table_rows.ahead, self.builder.mul(self.padded, terms))

    def force_displacements(self, lanes, accelerations):
        """h^2 A times the accelerations, which are extrapolated if work holds those of the step
        before."""
        builder = self.builder
        has_guess = builder.icmp_unsigned("!=", self.continues, self.row(0))
        first = builder.select(has_guess, self.first_ahead(), self.table_rows.drift)
        return self.sums(lanes, self.tables, first, accelerations)

    def summed(self, lanes, first, matrix, first_row, row, count):
        """The sums of `Rows.sums` for rows of work that share a matrix."""
        builder = self.builder
        if not self.single_vector:
            return lanes.sums(first, matrix, first_row, self.work, self.row(row), count)
        totals = [first, [lanes.zero] * len(first)]
        self.reload()
        for j in range(self.width):  # rows of a matrix after the last are 0
            factor = lanes.load(matrix, builder.add(first_row, self.row(j)))
            for i in range(len(first)):
                value = lanes.number(self.work, self.row(row + i), self.row(j))
                term = lanes.mul(lanes.spread(value), factor)
                totals[j % 2][i] = lanes.add(totals[j % 2][i], term)
        return [lanes.add(*pair) for pair in zip(*totals, strict=True)]


class Members(Rows):
    """Eight runs in the lanes of a vector, one stage after another.

    Parameters
    ----------
    stages
        s, so that loops are written out; 0 for a number that is only known at run time

    Attributes
    ----------
    guarded_rows
        rows of work that are stored only for the active runs
    active
        a `galvi.lanes.stopping.Mask` of the runs whose iteration goes on
    """

    choice_interval = 1  # one of eight runs needs a new choice sooner than a single run

    def __init__(self, context, builder, arguments, fields, stages=0):
        super().__init__(context, builder, arguments, fields, LANES, LANES)
        self.stages = self.row(stages) if stages else self.stages
        self.padded = builder.mul(self.stages, self.row(LANES))
        self.lay_out_tables(self.stages, (*FIRST_ROWS[:-1], FIRST_ROWS[-2]))
        self.lanes_are_full = ir.Constant(ir.IntType(1), 1)
        self.guarded_rows: Any = ()
        self.active: Any = None
        self.ahead_holds_A = False

    def at(self, chunk):
        """The `MemberLanes` of a stage."""
        return MemberLanes(self.context, self.builder, self.stages, chunk)

    def chunks(self, part):
        """Call ``part(lanes)`` for each stage."""
        with cgutils.for_range(self.builder, self.stages, intp=self.row) as loop:
            part(self.at(loop.index))

    def store_row(self, lanes, lane, row):
        value = lane.value
        if row in self.guarded_rows:
            old = lanes.load(self.work, self.row(row))
            value = self.builder.select(self.active.value.value, value, old)
        lanes.store(value, self.work, self.row(row))

    def spread(self, lane):
        return lane

    def spread_truth(self, truth):
        return truth

    def stage_number(self, row, index):
        """The numbers of the runs in a row of work at a stage."""
        return self.load_row(self.at(index), row).exact

    def over_stages(self, lane):
        """The lane itself, which is a sum over all stages already."""
        return lane.exact

    def over_stages_largest(self, lane):
        """The lane itself, which is the largest over all stages already."""
        return lane

    def change(self):
        """The largest change that was noted."""
        return Lane(self.builder, self.zero().value, ()).of_bits(self.builder.load(self.largest))

    def reload(self):
        """Do nothing: numbers of work are not broadcast."""

    def scaled_sums(self, lanes, start, first_row, row, power=1):
        """`sums` with the tables, times h^power."""
        totals, step = self.sums(lanes, self.tables, first_row, row), self.field("step")
        for _ in range(power):  # a rounded h^2 would be wrong by the same in each step
            totals = [total * step for total in totals]
        if start is None:
            return totals
        return [self.load_row(lanes, start + i).exact + x for i, x in enumerate(totals)]

    def sums_over_step(self, row, *parts):
        """As for one run."""
        rows = range(row, row + self.d)
        sums = [self.weighted_sums(rows, getattr(self.table_rows, part)) for part in parts]
        return list(zip(*sums, strict=True))

    def over_step(self, rows):
        """h sum_j b_j x_j of rows x of work."""
        sums = self.weighted_sums(rows, self.table_rows.low_kicks, self.table_rows.kicks)
        return [x * self.field("step") for x in sums]

    def times_step(self, high, low, power):
        """The sum (high, low) times h^power, in two parts."""
        step = self.field("step")
        for _ in range(power):
            high, error = two_product(high, step)
            low = low * step + error
        return high, low

    def remember(self, velocities, last):
        """Do nothing: a member that fails takes no further step."""

    def keep_series(self, lanes, series, row):
        """Store the Legendre coefficients of the velocities for `extrapolate`."""
        self.store_rows(lanes, series, row)

    def extrapolate(self, velocities, series, guess):
        """Store in d rows of work the extrapolated velocities at the next step's stages."""
        terms = self.field("terms")

        def shorten(lanes):
            is_kept = terms > self.integer_as_real(lanes.stage)
            shortened = [x.where(is_kept, 0.0) for x in self.load_rows(lanes, series)]
            self.store_rows(lanes, shortened, series)

        def continue_series(lanes):
            extrapolated = self.sums(
                lanes, self.tables, self.table_rows.ahead, series, count=self.terms
            )
            self.store_rows(lanes, extrapolated, guess)

        self.chunks(shorten)
        self.chunks(continue_series)

    def force_displacements(self, lanes, accelerations):
        """h^2 A times the accelerations."""
        return self.scaled_sums(lanes, None, self.table_rows.drift, accelerations, 2)

    def summed(self, lanes, first, matrix, first_row, row, count):
        """The sums of `Rows.sums` for rows of work that share a matrix."""
        totals = []
        for k in range(0, len(first), ROWS_TOGETHER):
            part = first[k : k + ROWS_TOGETHER]
            totals += lanes.sums(part, matrix, first_row, self.work, self.row(row + k), count)
        return totals


class MemberLanes(Lanes):
    """Loads and stores of eight members at one stage, with the interface of `Lanes`."""

    def __init__(self, context, builder, stages, stage):
        self.stages, self.stage = stages, stage
        width = builder.mul(stages, ir.Constant(stages.type, LANES))
        super().__init__(context, builder, width, stage)

    def factor(self, matrix, row):
        """The number in a row of a matrix at this stage, in all lanes."""
        index = self.builder.add(self.builder.mul(row, self.stages), self.stage)
        return super().spread(self.builder.load(self.builder.gep(matrix, [index])))

    def number(self, array, row, column=None):
        """The numbers of the members: a row (8,), or column ``column`` of a row (s, 8)."""
        eight = ir.Constant(row.type, LANES)
        index = self.builder.mul(row, eight)
        if column is not None:
            column = self.builder.mul(column, eight)
            index = self.builder.add(self.builder.mul(row, self.padded), column)
        address = self.builder.bitcast(self.builder.gep(array, [index]), self.kind.as_pointer())
        return self.builder.load(address, align=8)

    def spread(self, vector):
        return vector


def layout(context, builder, arguments, fields, lanes, single_vector, stages, ahead_holds_A=False):
    """A `Stages` layout of one run in vectors of ``lanes`` lanes; for 0 one of `Members`."""
    if lanes:
        return Stages(context, builder, arguments, fields, lanes, single_vector, ahead_holds_A)
    builder.reciprocals = Reciprocals(context, builder)
    return Members(context, builder, arguments, fields, stages)
