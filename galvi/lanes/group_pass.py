"""One pass of the iteration of galvi.lanes.group_law, as vector instructions for one law.

A law is a Python function (g, v, t, constants) -> (tau, mu, mass) of lanes or numbers: g holds the
entries of an element, tau the left-trivialised dL/dg, mu = dL/dv, and mass the rows of d2L/dv2 up
to its diagonal; zeros that do not depend on the state are the number 0.0.
The arrays are those of galvi.lanes.group_rows.
"""

from __future__ import annotations

import numpy as np
from llvmlite import ir

from galvi.kernels.compile.internals import cgutils
from galvi.lanes.dense import factored, inverse_of, is_written_out, is_zero, times_symmetric
from galvi.lanes.group_rows import (
    BEFORE,
    CHANGE,
    DEFECT,
    END,
    ETA,
    KEPT,
    LOW_F,
    LOW_N,
    LOW_XI,
    MU,
    PART,
    PLACE,
    PULLED,
    TIMES,
    VELOCITY,
    XI,
    Chart,
    F,
    GroupRows,
    N,
    total,
)
from galvi.lanes.law_pass import Constants, Generic
from galvi.lanes.values import Lane
from galvi.lanes.vectors import DOUBLE, of_words

PASS, PREPARE, AHEAD, BEGIN, SIZES, LOW, FINISH = range(7)  # parts, see GroupPass
# At most so many corrections of an initial guess by the chart's tangent map.
GUESS_CORRECTIONS_IN_LANES = 6
LAST_CORRECTION_ANGLE = 1e-4  # radians: smaller ones are the last
WRITTEN_OUT_COLUMNS = 6  # columns of the response; a loop over them is slower by a twentieth


def found_at(law, chart, state):
    """The momenta, the mass and the velocity at a state without special properties, which shares no
    number with those of other ``state``."""
    near = (np.linspace(0.3, 0.7, chart.entries + chart.dimension + 1) + 0.1 * state) ** 0.5
    g, v = list(near[: chart.entries]), list(near[chart.entries : -1])
    _, mu, mass = law(g, v, near[-1], Generic())
    return mu, [list(map(np.float64, row)) for row in mass], v


class GroupPass(GroupRows):
    """The parts of a pass, each for one vector of stages."""

    def __init__(self, context, builder, given, law, chart, width, one):
        self.chart = chart
        super().__init__(context, builder, given, chart.dimension, width, one)
        self.examine(law, chart)

    def examine(self, law, chart):
        """What is known of a law: where its mass is filled, constant, and all of its momenta."""
        self.law, self.chart, d = law, chart, self.d
        with np.errstate(all="ignore"):
            states = [found_at(law, chart, state) for state in range(2)]
            rows = factored(states[0][1])
        self.below = [(i, j) for i in range(d) for j in range(i) if rows[i][j] != 0.0]
        inverse = inverse_of(rows)
        self.filled = {(i, j) for i in range(d) for j in range(i + 1) if inverse[i][j] != 0.0}
        self.constant_mass = states[0][1] == states[1][1]
        self.written_out = self.constant_mass or is_written_out(self.below)
        self.linear = self.constant_mass and all(
            np.allclose(mu, times_symmetric(mass, v), rtol=1e-12, atol=0.0)
            for mu, mass, v in states
        )
        self.pulls = True  # whether there are forces, known after ``fall``

    def state(self, lanes):
        """xi, the velocity, and what the law is there."""
        xi, eta = self.loaded(lanes, XI), self.loaded(lanes, ETA)
        first = 3 * self.d + PLACE
        g = [self.number(lanes, first + i).fused for i in range(self.chart.entries)]
        velocity = self.chart.apply("velocity", xi, eta)
        constants = Constants(self.builder, lanes, self.constants, self.row)
        time = self.load(lanes, TIMES)
        return xi, velocity, self.law(self.chart.place(g, xi), velocity, time, constants)

    def prepare(self, lanes):
        """The inverse of a mass that does not depend on the state, or its factors."""
        if self.constant_mass:
            rows = factored(self.state(lanes)[2][2])
            self.keep_triangle(lanes, inverse_of(rows) if self.linear else rows, self.factors)

    def fall(self, lanes):
        """The law at (xi, eta): f, n, velocity, dL/dv and the factored mass."""
        xi, velocity, (tau, mu, mass) = self.state(lanes)
        self.pulls = any(not is_zero(x) for x in tau)
        if self.pulls:
            swung = self.chart.apply("coadjoint_change", xi, tau)
            self.stored(lanes, self.chart.apply("momentum", xi, tau), F)
            self.stored(lanes, [total(*pair) for pair in zip(tau, swung, strict=True)], N)
        if not self.linear:
            self.stored(lanes, velocity, VELOCITY)
            self.stored(lanes, mu, MU)
        if not self.constant_mass:
            self.keep_factors(lanes, mass, self.factors)

    def keep_factors(self, lanes, rows, first):
        """Store the factors of a matrix in rows of work from ``first`` on."""
        self.keep_triangle(lanes, factored(rows) if self.written_out else rows, first)
        if not self.written_out:
            self.triangle(lanes, first).factor()

    def velocity_change(self, lanes, x):
        """The change of velocities that changes momenta by x."""
        if not self.linear:
            return self.solved(lanes, x)
        found = []
        for i in range(self.d):
            value = 0.0
            for j in range(self.d):
                row, column = max(i, j), min(i, j)
                if (row, column) in self.filled:
                    place = self.factors + row * (row + 1) // 2 + column
                    value = total(value, self.load_row(lanes, place) * x[j])
            found.append(value)
        return found

    def at_end(self, lanes):
        """mu0 and the impulse of the whole step, the same in all lanes."""
        momenta = [self.number(lanes, i).fused for i in range(self.d)]
        if self.pulls:
            kicks = self.over_step(N)
            momenta = [momenta[i] + kicks[i] for i in range(self.d)]
        return momenta

    def turn(self, lanes, ended):
        """Update the rates: f, and eta from the momenta."""
        xi, eta, defect = (self.loaded(lanes, block) for block in (XI, ETA, DEFECT))
        if self.pulls:
            kicks = self.sums(lanes, LOW_N, self.tables, self.back, N * self.d)
            ended = [ended[i] + kicks[i].fused for i in range(self.d)]
        pulled = self.chart.apply("momentum", [-x for x in xi], ended)
        pi = [pulled[i] + defect[i] for i in range(self.d)]
        momenta = self.chart.apply("covector", xi, pi)
        velocity = momenta
        if not self.linear:
            mu = self.loaded(lanes, MU)
            velocity = [momenta[i] - mu[i] for i in range(self.d)]
        velocity = self.velocity_change(lanes, velocity)
        if not self.linear:
            last = self.loaded(lanes, VELOCITY)
            velocity = [last[i] + velocity[i] for i in range(self.d)]
        f = self.chart.apply("momentum_slope", xi, eta, momenta)
        if self.pulls:
            f = [total(x, y) for x, y in zip(f, self.loaded(lanes, F), strict=True)]
        self.stored(lanes, f, F)
        self.stored(lanes, pulled, PULLED)
        self.stored(lanes, velocity, VELOCITY)
        self.stored(lanes, self.chart.apply("rate", xi, velocity), ETA)

    def guess(self, lanes):
        """eta from the velocities, which are not changed."""
        xi, velocity = self.loaded(lanes, XI), self.loaded(lanes, VELOCITY)
        self.stored(lanes, self.chart.apply("rate", xi, velocity), ETA)

    def drift(self, lanes):
        """xi from eta."""
        found = self.sums(lanes, LOW_XI, self.tables, self.row(0), ETA * self.d)
        for i, place in enumerate(found):
            self.note(lanes, place, self.load(lanes, XI, i), self.d + i)
            self.store(lanes, place, XI, i)

    def correct(self, lanes, asked):
        """The defect from f, with the multipliers' part; ``asked`` is Q at the end."""
        found = self.sums(lanes, LOW_F, self.tables, self.back, F * self.d)
        places = [self.place() for _ in range(self.d)]
        for i, place in enumerate(places):
            defect = (asked[i] - self.load(lanes, PULLED, i)) + found[i]
            self.builder.store(defect.value, place)
        with cgutils.for_range(self.builder, self.extra, intp=self.row) as loop:
            Y = Lane(self.builder, lanes.factor(self.complement, loop.index))
            for place, m in zip(places, self.multiplier_rows(loop.index), strict=True):
                first = lanes.number(self.work, m, self.row(0))
                part = Y * Lane(self.builder, lanes.spread(first))
                total = Lane(self.builder, self.builder.load(place)) + part
                self.builder.store(total.value, place)
        for i, place in enumerate(places):
            new = Lane(self.builder, self.builder.load(place), ())
            self.note(lanes, new, self.load(lanes, DEFECT, i), 2 * self.d + i)
            self.store(lanes, new, DEFECT, i)

    def project(self, corrects):
        """Project eta to the rates of curves, and correct the multipliers by what was lost."""
        builder = self.builder
        with cgutils.for_range(builder, self.extra, intp=self.row) as loop:
            weights = builder.add(self.extra, loop.index)
            lost = self.spread_sums(
                [ETA * self.d + i for i in range(self.d)], weights, matrix=self.complement
            )

            def subtract(lanes):
                Y = Lane(builder, lanes.factor(self.complement, loop.index))
                for i, x in enumerate(lost):
                    self.store(lanes, self.load(lanes, ETA, i) - Y * x, ETA, i)

            self.chunks(subtract)
            if corrects:
                lanes, first = self.first_lanes(), self.response
                lower = [(i, j) for i in range(self.d) for j in range(i)]
                steps = self.solved(lanes, list(lost), lower, first)
                for m, step in zip(self.multiplier_rows(loop.index), steps, strict=True):
                    new = Lane(builder, lanes.load(self.work, m)) - step
                    lanes.store(new.value, self.work, m)

    def respond(self):
        """The factors of the mean response of eta to the multipliers."""
        d, builder = self.d, self.builder
        vector = self.first_lanes().kind
        found = [cgutils.alloca_once(builder, vector, self.row(d)) for _ in range(d)]

        def respond_to(column):
            def answer(lanes):
                xi = self.loaded(lanes, XI)
                pi = self.unit(column)
                velocity = self.velocity_change(lanes, self.chart.apply("covector", xi, pi))
                self.stored(lanes, self.chart.apply("rate", xi, velocity), PULLED)

            self.chunks(answer)
            for i, x in enumerate(self.means([PULLED * d + i for i in range(d)])):
                builder.store(x.value, builder.gep(found[i], [column]))

        if d <= WRITTEN_OUT_COLUMNS:
            for column in range(d):
                respond_to(self.row(column))
        else:
            with cgutils.for_range(builder, self.row(d), intp=self.row) as loop:
                respond_to(loop.index)
        places = [[builder.gep(found[i], [self.row(j)]) for j in range(i + 1)] for i in range(d)]
        rows = [[Lane(builder, builder.load(place)) for place in row] for row in places]
        self.keep_factors(self.first_lanes(), rows, self.response)

    def keep_end(self):
        """xi at the step's end, where no lane has it."""
        with self.builder.if_then(self.full):
            self.stored(self.first_lanes(), self.over_step(ETA), END)

    def pulled_end(self, ended):
        """Q at the step's end, the same in all lanes."""
        places, lanes = [self.place() for _ in range(self.d)], self.first_lanes()
        with self.builder.if_else(self.full) as (computed, kept):
            with computed:
                far = [-x for x in self.loaded(lanes, END)]
                for place, x in zip(places, self.chart.apply("momentum", far, ended), strict=True):
                    self.builder.store(x.value, place)
            with kept:
                self.reload()
                for i, place in enumerate(places):
                    row = self.row(PULLED * self.d + i)
                    value = lanes.spread(lanes.number(self.work, row, self.stages))
                    self.builder.store(value, place)
        return [Lane(self.builder, self.builder.load(place)) for place in places]

    def whole_pass(self, first):
        """All parts of a pass, ``first`` of a step or not; the largest change is noted."""
        self.chunks(self.fall)
        if not self.constant_mass:
            with self.builder.if_then(self.builder.and_(first, self.projects)):
                self.respond()
        lanes = self.first_lanes()
        ended = self.at_end(lanes)
        self.chunks(lambda lanes: self.turn(lanes, ended))
        asked = self.pulled_end(ended)
        self.project(corrects=True)
        self.chunks(self.drift)
        self.chunks(lambda lanes: self.correct(lanes, asked))
        self.keep_end()

    def one_pass(self):
        self.whole_pass(self.first_pass())
        self.builder.store(self.change(), self.place_of(CHANGE))

    def prepare_run(self):
        """Factors a constant mass, once a run."""
        self.chunks(self.prepare)

    def extrapolate(self):
        """The velocities, from those of the last step, which are kept as ``before``."""
        blocks = self.builder.sub(self.builder.add(self.whole(KEPT), self.row(4)), self.row(1))
        first = self.builder.add(self.builder.mul(self.padded, blocks), self.row(3))
        self.chunks(lambda lanes: self.stored(lanes, self.loaded(lanes, VELOCITY), BEFORE))
        self.chunks(lambda lanes: self.stored(
            lanes, self.sums(lanes, None, self.tables, first, BEFORE * self.d), VELOCITY
        ))  # fmt: skip

    def begin(self):
        """xi, eta and more from the velocities, at the start of a step."""
        self.measure_rotations()
        self.begin_at_rest()
        with cgutils.for_range(
            self.builder, self.row(GUESS_CORRECTIONS_IN_LANES), intp=self.row
        ) as loop:
            self.pull()
            settled = ir.Constant(DOUBLE, LAST_CORRECTION_ANGLE)
            with self.builder.if_then(self.builder.fcmp_ordered("<", self.change(), settled)):
                loop.do_break()
        self.begin_iteration()

    def begin_at_rest(self):
        """xi by the velocities alone, and no defect."""
        nothing, d = Lane(self.builder, self.first_lanes().nothing), self.d

        def place(lanes):
            for block in (DEFECT, LOW_XI, LOW_F, LOW_N):
                self.stored(lanes, [nothing] * d, block)
            found = self.sums(lanes, None, self.tables, self.row(0), VELOCITY * d)
            self.stored(lanes, found, XI)

        self.chunks(place)
        with cgutils.for_range(self.builder, self.extra, intp=self.row) as loop:
            for row in self.multiplier_rows(loop.index):
                self.first_lanes().store(nothing.value, self.work, row)

    def pull(self):
        """Correct xi by the chart's tangent map."""
        self.forget()
        self.chunks(self.guess)
        self.project(corrects=False)
        self.chunks(self.drift)

    def begin_iteration(self):
        """The end of the step, and the response to the multipliers where the mass is constant."""
        self.keep_end()
        if self.constant_mass:
            with self.builder.if_then(self.projects):
                self.respond()

    def add_low_parts(self, chosen=None):
        """The low parts of sums; only in the lanes chosen, if some are."""
        parts = [(ETA, self.low_drift, LOW_XI), (F, self.low_back, LOW_F)]
        parts += [(N, self.low_back, LOW_N)] if self.pulls else []

        def add(lanes, block, first, low):
            sums = self.sums(lanes, None, self.tables, first, block * self.d)
            if chosen is not None:
                sums = [
                    x.where(chosen, old)
                    for x, old in zip(sums, self.loaded(lanes, low), strict=True)
                ]
            self.stored(lanes, sums, low)

        for part in parts:
            self.chunks(lambda lanes, part=part: add(lanes, *part))

    def after_first_pass(self, _noted=None):
        """The sizes of xi and pi."""
        self.measure()

    def finish(self):
        """As ``sum_up``; the largest |xi|^2 of a rotation is the change."""
        self.sum_up()
        self.chunks(lambda lanes: self.note_turns(self.loaded(lanes, XI)))
        self.builder.store(self.change(), self.place_of(CHANGE))

    def sum_up(self):
        """xi(1) in ``end`` and the impulse in ``pulled``."""
        for block, found in ((ETA, END), (N, PULLED)):
            if block == ETA or self.pulls:
                sums = self.over_step(block)
            else:
                sums = [Lane(self.builder, self.first_lanes().nothing)] * self.d
            self.stored(self.first_lanes(), sums, found)


def group_pass(law, layout, chart, width, one):
    """An intrinsic of the address of the words of galvi.lanes.law_pass.one_pass, for a law on
    these groups; the last one is the number of functions Y.

    width, one  as there
    """
    functions = Chart(layout, chart)

    def do(context, builder, words):
        made = GroupPass(context, builder, words, law, functions, width, one)
        part = builder.load(made.place_of(PART))
        for number, do in enumerate((
            made.one_pass, made.prepare_run, made.extrapolate, made.begin, made.after_first_pass,
            made.add_low_parts, made.finish,
        )):  # fmt: skip
            asked = builder.fcmp_ordered("==", part, ir.Constant(DOUBLE, float(number)))
            with builder.if_then(asked):
                made.forget()
                do()

    return of_words(do)
