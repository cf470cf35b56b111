"""Steps of a law on R^d for many members: galvi.lanes.law for eight at a time.

The passes are those of galvi.lanes.law_pass; their arrays and the step's length are those
of galvi.lanes.members.steps.
"""

from __future__ import annotations

import math

from galvi.kernels.lie.arithmetic import larger_size, where
from galvi.kernels.nystrom.solve import decide, reset_history
from galvi.lanes.functions import two_product
from galvi.lanes.law_pass import BEFORE, LOW_P, LOW_Q, F, Q, T, V, filled
from galvi.lanes.members.steps import Fields, MemberSteps
from galvi.lanes.nbody import moved
from galvi.lanes.values import Lane
from galvi.lanes.vectors import NOTHING, of_words

RULE = reset_history, decide, 4
UNKNOWN = 1e300  # a change that says nothing


def law_fields(d):
    """The record of a member on R^d: q, p, 1 over their sizes, their low parts, and SHARED."""
    own = (("q", d), ("p", d), ("sizes", 2), ("spare", 1), ("q_low", d), ("p_low", d))
    return Fields(own, d)


class MemberLaw(MemberSteps):
    """Steps of eight members."""

    def __init__(self, context, builder, words, law, d, below, stages, alone):
        self.open(context, builder, words, law_fields(d), RULE, stages)
        self.law, self.below, self.alone = law, below, alone
        self.nodes, self.first_drift = (self.tabled.nodes, self.tabled.means), self.tabled.drift
        self.lay_out_space()
        self.velocity_row, self.time_row = V * d, T * d
        self.guarded = range(0, 3 * d)  # q, v and f
        self.begin_change()

    def project_velocities(self):
        """V <- (1 - C) V."""

        def outside(lanes):
            found = self.sums(lanes, None, self.complement, self.row(0), V * self.d, self.apart)
            self.store_rows(lanes, found, self.steps)

        def inside(lanes):
            for i in range(self.d):
                rest = self.load(lanes, V, i) - self.load_row(lanes, self.steps + i)
                self.store(lanes, rest, V, i)

        with self.builder.if_then(self.projects):
            self.chunks(outside)
            self.chunks(inside)

    def place_stages(self):
        """First places at the stages; low parts are those of the state."""

        def first(lanes):
            for block, name in ((LOW_Q, "q_low"), (LOW_P, "p_low")):
                low = [self.field(name, i) for i in range(self.d)]
                self.store_rows(lanes, low, block * self.d)
            found = self.sums(lanes, None, self.tables, self.tabled.drift, V * self.d)
            for i, way in enumerate(found):
                self.store(lanes, self.field("q", i) + way, Q, i)

        self.chunks(first)

    def keep_size(self, k, size):
        """Keep 1 over a size, 0 where that is 0."""
        self.keep("sizes", (1.0 / size).where(size > 0.0, 0.0), k)

    def coast_stages(self):
        """First places by the last accelerations, and their size: that of q and q + h v."""
        size, step = Lane(self.builder, NOTHING, ()), self.field("step")
        for i in range(self.d):
            q, far = self.field("q", i), step * self.field("p", i)
            size = larger_size(larger_size(size, q), q + far)
        self.keep_size(0, size)
        self.chunks(lambda lanes: self.coast(lanes, self.tabled.drift))

    def after_first_pass(self, noted):
        """The sizes of q and p."""
        d, step = self.d, self.field("step")
        if self.alone:  # at rest at the origin, its size is known after it
            known = self.field("sizes") > 0.0
            size = self.largest_of(range(Q * d, (Q + 1) * d))
            self.keep_size(0, where(known, 1.0 / self.field("sizes"), size))
            self.judgement.judge(where(known, noted, UNKNOWN), self.tolerance)
            return
        for k, (block, name) in enumerate(((V, "q"), (F, "p"))):
            size = abs(self.largest_of(range(block * d, (block + 1) * d)) * step)
            for i in range(d):
                size = larger_size(size, self.field(name, i))
            self.keep_size(k, size)

    def add_low_parts(self, chosen):
        """Adds what the low parts of the tables make of the rates, for the members chosen."""
        parts = [(V, self.tabled.low_drift, LOW_Q)]
        parts += [] if self.alone else [(F, self.tabled.low_back, LOW_P)]

        def add(lanes):
            for block, first, low in parts:
                sums = self.sums(lanes, None, self.tables, first, block * self.d)
                for i, more in enumerate(sums):
                    self.store(lanes, self.load(lanes, low, i) + more.where(chosen, 0.0), low, i)

        self.chunks(add)

    def step(self, number):
        """One step, the ``number``-th from 0."""
        builder, d = self.builder, self.d
        self.judgement.active.set(self.field("alive") > 0.0)
        with builder.if_then(builder.icmp_unsigned(">", number, self.row(0))):
            self.continue_velocities(BEFORE * d)
        self.times(number)
        if self.alone:
            self.coast_stages()
        else:
            self.project_velocities()
            self.place_stages()
        self.iterate()
        ends, total = self.ends(), Lane(builder, NOTHING, ())
        for _, _, high, _ in ends:
            total = total + abs(high)
        done, lost = self.judgement.end(total < math.inf)
        for name, i, high, low in ends:
            self.keep_where(done, name, high, i)
            self.keep_where(done, f"{name}_low", low, i)
        self.conclude(number, done, lost)

    def ends(self):
        """What a field is at the step's end, and its low part: (its name, i, both)."""
        step, tabled, found = self.field("step"), self.tabled, []
        for block, name in ((V, "q"), (V if self.alone else F, "p")):
            rows = range(block * self.d, (block + 1) * self.d)
            bends = self.alone and name == "q"
            weights = (tabled.back, tabled.low_back) if bends else (tabled.kicks, tabled.low_kicks)
            for i, pair in enumerate(zip(*(self.weighted(rows, w) for w in weights), strict=True)):
                (way, rest), low = two_product(pair[0], step), self.field(f"{name}_low", i)
                rest, far = rest + pair[1] * step, 0.0
                if bends:
                    (way, lost), rest = two_product(way, step), rest * step
                    far, error = two_product(step, self.field("p", i))
                    rest = rest + (lost + (error + step * self.field("p_low", i)))
                found.append((name, i, *moved(self.field(name, i), low, far, way, rest)))
        return found


def law_steps(law, d, stages, alone):
    """An intrinsic that advances members of a law on R^d, see galvi.lanes.members.steps.

    stages  s, for which loops are written out; 0 for any
    alone   whether places alone are iterated, see galvi.lanes.law_pass
    """
    below = filled(law, d)
    return of_words(lambda context, builder, words: MemberLaw(
        context, builder, words, law, d, below, stages, alone
    ).advance())  # fmt: skip
