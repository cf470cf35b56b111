"""Steps of a law on a Lie group for many members: galvi.lanes.group_law, eight at a time.

The passes are those of galvi.lanes.group_pass; their arrays and the step's length are those
of galvi.lanes.members.steps.
"""

from __future__ import annotations

import math

from llvmlite import ir

from galvi.kernels.compile.internals import cgutils
from galvi.kernels.lie.dispatch import REACHES
from galvi.lanes import group_rows as blocks
from galvi.lanes.group_law import HISTORY, begin_countdown, count_down
from galvi.lanes.group_pass import GUESS_CORRECTIONS_IN_LANES, LAST_CORRECTION_ANGLE, GroupPass
from galvi.lanes.members.steps import Fields, MemberSteps
from galvi.lanes.values import Lane
from galvi.lanes.vectors import NOTHING, of_words

# Blocks of work.
ITERATED = blocks.XI, blocks.ETA, blocks.F, blocks.DEFECT, blocks.N, blocks.VELOCITY
RULE = begin_countdown, count_down, HISTORY
PARTS = ("q", "memory", "low", "p", "nu", "nu_low")


def group_fields(d, entries):
    """The record of a member on a group: mu, 1 over sizes, g, what galvi.kernels.lie.product keeps
    beside them, and SHARED."""
    own = (
        ("p", d), ("xi_sizes", d), ("pi_sizes", d), ("spare", blocks.PLACE), ("q", entries),
        ("memory", entries), ("low", entries), ("nu", d), ("nu_low", d),
    )  # fmt: skip
    return Fields(own, d)


class MemberGroup(MemberSteps, GroupPass):
    """Steps of eight members."""

    def __init__(self, context, builder, words, law, chart):
        self.open(context, builder, words, group_fields(chart.dimension, chart.entries), RULE)
        d = self.d
        self.examine(law, chart)
        self.lay_out()
        self.begin_change()
        self.full = ir.Constant(ir.IntType(1), 1)
        self.velocity_row, self.time_row = blocks.VELOCITY * d, blocks.TIMES * d
        self.guarded = {block * d + i for block in ITERATED for i in range(d)}

    def spread_sums(self, rows, *weights, matrix=None):
        """As those of one member; with the tables, for a step of 1."""
        if matrix is not None:
            return [x.fused for x in self.weighted(rows, *weights, matrix=matrix)]
        step = self.field("step")
        return [(x * step).fused for x in self.weighted(rows, *weights)]

    def means(self, rows):
        return [x.fused for x in self.weighted(rows, self.tabled.means)]

    def one_pass(self):
        self.whole_pass(self.first)

    def prepare_block(self):
        """The inverse of a mass that does not depend on the state."""
        self.judgement.active.set(self.field("alive") > 0.0)
        self.chunks(self.prepare)

    def guess_places(self):
        """xi and eta from the velocities, corrected until they are settled."""
        builder, judgement = self.builder, self.judgement
        alive = self.field("alive") > 0.0
        self.begin_at_rest()
        with cgutils.for_range(
            builder, self.row(GUESS_CORRECTIONS_IN_LANES), intp=self.row
        ) as loop:
            self.pull()
            noted = Lane(builder, NOTHING, ()).of_bits(builder.load(self.largest))
            rest = judgement.active.value & ~(noted < LAST_CORRECTION_ANGLE)
            judgement.active.set(rest)
            with builder.if_then((~rest).every):
                loop.do_break()
        judgement.active.set(alive)
        self.begin_iteration()

    def step(self, number):
        """One step, the ``number``-th from 0."""
        builder, d = self.builder, self.d
        self.judgement.active.set(self.field("alive") > 0.0)
        with builder.if_then(builder.icmp_unsigned(">", number, self.row(0))):
            self.continue_velocities(blocks.BEFORE * d)
        self.times(number)
        self.measure_rotations()
        self.guess_places()
        self.iterate()
        near = self.sum_up_and_measure()
        before = {name: self.fields_of(name) for name in PARTS}
        now = {name: list(lanes) for name, lanes in before.items()}
        end, kick = ([x.exact for x in self.loaded(self.first_lanes(), block)]
                     for block in (blocks.END, blocks.PULLED))  # fmt: skip
        for group, own, entries, _ in self.chart.factors:
            g, memory, low = (now[name][entries] for name in PARTS[:3])
            mu, nu, nu_low = (now[name][own] for name in PARTS[3:])
            group.advance(self.chart.number, end[own], g, memory, low)
            group.carry(self.chart.number, before["q"][entries], g, end[own], kick[own], mu, nu,
                        nu_low)  # fmt: skip
            for name, lanes in zip(PARTS[:3], (g, memory, low), strict=True):
                now[name][entries] = lanes
            for name, lanes in zip(PARTS[3:], (mu, nu, nu_low), strict=True):
                now[name][own] = lanes
        total = Lane(builder, NOTHING, ())
        for lane in (*now["q"], *now["p"]):
            total = total + abs(lane)
        done, lost = self.judgement.end(near & (total < math.inf))
        for name in PARTS:
            for i, lane in enumerate(now[name]):
                self.keep_where(done, name, lane, i)
        self.conclude(number, done, lost)

    def fields_of(self, name):
        """All rows of a part of the record."""
        size = self.chart.entries if name in PARTS[:3] else self.d
        return [self.field(name, i) for i in range(size)]

    def sum_up_and_measure(self):
        """xi(1) and the impulse; returns whether the step's rotations are within the chart."""
        builder = self.builder
        self.forget()
        self.sum_up()
        self.chunks(lambda lanes: self.note_turns(self.loaded(lanes, blocks.XI)))
        self.note_turns(self.loaded(self.first_lanes(), blocks.END))
        noted = Lane(builder, NOTHING, ()).of_bits(builder.load(self.largest))
        reach = REACHES[self.chart.number]
        return noted <= reach * reach


def group_steps(law, layout, chart):
    """An intrinsic that advances members of a law on these groups in a chart, see
    galvi.lanes.members.steps.

    layout, chart  of galvi.kernels.lie.product
    """
    functions = blocks.Chart(layout, chart)
    return of_words(
        lambda context, builder, words: MemberGroup(
            context, builder, words, law, functions
        ).advance()
    )
