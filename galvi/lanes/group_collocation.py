"""Steps of a Lagrangian on a Lie group in lanes, as galvi.kernels.on_group.

With A and B those of galvi.lanes.collocation, rates eta and forces f in the chart at the step's
start, and n and mu as in galvi.kernels.on_group.stages, the stage equations are

    xi_j = h sum_k A_jk eta_k,                       xi(1) = h sum_k b_k eta_k,
    pi_j = p0 + h sum_k B_jk f_k + sum_l m_l Y_lj,   p1 = p0 + h sum_k b_k f_k = T(xi(1))^T mu1,
    mu1 = Ad*_{Phi(xi(1))} (mu0 + h sum_k b_k n_k),  sum_j b_j Y_lj eta_j = 0

p0 would be mu0 if the base point of the chart were fixed; it differs by the error of a step. With
more points than coefficients, rates of curves are orthogonal to the functions Y_l, and a multiplier
m_l is the momenta's part along Y_l. With the momenta in the frame of the step's start and their
pull-back

    nu_j = mu0 + h sum_k B_jk n_k,   Q_j = T(xi_j)^T Ad*_{Phi(xi_j)} nu_j = T(-xi_j)^T nu_j

and Q(1) at the step's end, pi_j = Q_j + D_j, where the defect

    D_j = Q(1) - Q_j + h sum_k (B_jk - b_k) f_k + sum_l m_l Y_lj

is the error of the rule for dQ/dt along a curve: as small as that of a step, and as little
changed by errors of the curve. A pass of the iteration takes n from xi, momenta T^-T (Q + D) with
the last D, velocities from these by one Newton step with the last mass, their rates eta, projected
to those of curves, f from the last xi and eta with these momenta, and from eta and f the next xi, D
and multipliers; p0 is not an unknown. A step for which the iteration does not converge, or whose
rotation exceeds LARGEST_ROTATIONS_IN_LANES, is left to the general kernel.

A law is a Python function (g, v, t, constants) -> (tau, mu, mass) of lanes or numbers: g holds the
entries of an element, tau the left-trivialised dL/dg, mu = dL/dv, and mass the rows of d2L/dv2 up
to its diagonal; zeros that do not depend on the state are the number 0.0. Rows of work:

xi, eta, f, defect  (d,) each: coordinates, rates, forces and defects D with the multipliers' part
low_xi, low_f, low_n  (d,) each: what the low parts of the tables add to sums of eta, f and n
series              (d,)      coefficients of the velocities' series
n, v, mu, pulled    (d,) each: impulses, velocities, dL/dv, and Q
end                 (d,)      xi(1), where no lane of one run has the step's end
t                   times
factors             of the mass, as in galvi.lanes.collocation; the inverse of a constant mass if
                    the momenta are linear in the velocities
response            factors of the multipliers' response, see ``store_response``
multipliers         (l d,)    m, at the first stage

complement  (2 l rows)  l functions Y at the stages and b Y, orthonormal in the rule's inner product
            and orthogonal to the rates of all curves; l = 0 with as many points as coefficients
"""

from __future__ import annotations

from functools import reduce
from typing import Any

import numpy as np

from galvi.kernels.compile.internals import cgutils
from galvi.kernels.lie.arithmetic import larger, larger_size
from galvi.kernels.lie.dispatch import LARGEST_ROTATIONS_IN_LANES
from galvi.kernels.lie.product import COUPLED, DIMENSION, ENTRIES, GROUPS, NUMBER, ROTATIONS
from galvi.kernels.on_group.scale import LEAST_COUPLED_MOTION
from galvi.lanes.collocation import Constants, Factors, GenericConstants, differences, sums
from galvi.lanes.dense import (
    inverse_from_factors,
    is_written_out,
    is_zero,
    ldl_factors,
    times_symmetric,
)
from galvi.lanes.layouts import Fields, layout
from galvi.lanes.step import step_intrinsic
from galvi.lanes.stopping import BY_COUNTDOWN
from galvi.lanes.values import Lane, Truth

(XI, ETA, F, DEFECT, LOW_XI, LOW_F, LOW_N, SERIES, N, VELOCITY, MU, PULLED, END, TIMES) = range(
    14
)  # times d
ITERATED = XI, ETA, F, DEFECT, N, VELOCITY
# Largest number of corrections of an initial guess by the chart's tangent map.
MAX_GUESS_CORRECTIONS_IN_LANES = 6
LAST_CORRECTION_ANGLE = 1e-4  # radians; no correction follows a smaller one
# Largest number of columns of the response without a loop, which is slower by a twentieth.
WRITTEN_OUT_COLUMNS = 6
STATE_FIELDS = ("q", "memory", "low", "p", "nu", "nu_low")  # three of entries, three of momenta


def rows_of_group_work(d, extra):
    """The number of rows of work for d coordinates and ``extra`` functions Y."""
    return TIMES * d + 1 + d * (d + 1) + extra * d


def group_fields(d, entries):
    """The record of a run on a group: p = mu, the inverses of the sizes of xi and pi, q = g, the
    numbers that galvi.kernels.lie.product keeps beside g and mu, and SHARED."""
    own_fields = (
        ("p", d),
        ("xi_sizes", d),
        ("pi_sizes", d),
        ("q", entries),
        ("memory", entries),
        ("low", entries),
        ("nu", d),
        ("nu_low", d),
    )
    return Fields(own_fields, d)


def law_at_generic_state(law, chart, state):
    """The momenta, the mass and the velocity at a generic state; each number of the state depends
    on its index ``state``."""
    sample = (np.linspace(0.3, 0.7, chart.entries + chart.dimension + 1) + 0.1 * state) ** 0.5
    g, v = list(sample[: chart.entries]), list(sample[chart.entries : -1])
    _, mu, mass = law(g, v, sample[-1], GenericConstants())
    return mu, [list(map(np.float64, row)) for row in mass], v


class GroupStep:
    """A step on a group, see galvi.lanes.step."""

    rule = BY_COUNTDOWN

    def __init__(self, rows, law, chart):
        d = rows.d
        self.rows, self.law, self.chart, self.builder = rows, law, chart, rows.builder
        self.velocity_row, self.series_row, self.guess_row = VELOCITY * d, SERIES * d, MU * d
        self.time_row = TIMES * d
        rows.guarded_rows = {block * d + i for block in ITERATED for i in range(d)}
        self.has_forces = True  # set by ``store_law``
        self.examine(law)

    def examine(self, law):
        """Set which entries of the inverse mass are not 0, whether the mass is constant, and
        whether the momenta are the constant mass times the velocities."""
        d, first = self.rows.d, self.time_row + 1
        with np.errstate(all="ignore"):
            states = [law_at_generic_state(law, self.chart, state) for state in range(2)]
            factors = ldl_factors(states[0][1])
        below = [(i, j) for i in range(d) for j in range(i) if factors[i][j] != 0.0]
        inverse = inverse_from_factors(factors)
        self.nonzero_inverse = {
            (i, j) for i in range(d) for j in range(i + 1) if inverse[i][j] != 0.0
        }
        self.constant_mass = states[0][1] == states[1][1]
        written_out = self.constant_mass or is_written_out(below)
        self.momenta_are_linear = self.constant_mass and all(
            np.allclose(mu, times_symmetric(mass, v), rtol=1e-12, atol=0.0)
            for mu, mass, v in states
        )
        lower = [(i, j) for i in range(d) for j in range(i)]
        triangle_size = d * (d + 1) // 2
        self.factors = Factors(self.rows, first, below, written_out)
        self.response = Factors(self.rows, first + triangle_size, lower, written_out)
        self.multipliers = first + 2 * triangle_size

    def load(self, lanes, block):
        """The d rows of a block of work."""
        return self.rows.load_rows(lanes, block * self.rows.d)

    def store(self, lanes, values, block):
        """Store d lanes or numbers."""
        zero = self.rows.zero()
        self.rows.store_rows(lanes, [zero.same(x) for x in values], block * self.rows.d)

    def block(self, block):
        """The indices of the d rows of a block of work."""
        return range(block * self.rows.d, (block + 1) * self.rows.d)

    def first_lanes(self):
        return self.rows.at(self.rows.row(0))

    def evaluate_law(self, lanes):
        """xi, the velocity, and (tau, mu, mass) of the law at both."""
        rows, xi, eta = self.rows, self.load(lanes, XI), self.load(lanes, ETA)
        g = [rows.at_stages("q", i).fused for i in range(self.chart.entries)]
        velocity = self.chart.apply("velocity", xi, eta)
        time = rows.load_row(lanes, self.time_row)
        evaluated = self.law(
            self.chart.place(g, xi), velocity, time, Constants(lanes, rows.constants)
        )
        return xi, velocity, evaluated

    def prepare(self):
        """Store the inverse of a constant mass, or its factors."""
        if self.constant_mass:
            self.rows.chunks(self.keep_constant_mass)

    def keep_constant_mass(self, lanes):
        """Do the work of `prepare` for a vector of stages."""
        mass = self.evaluate_law(lanes)[2][2]
        if self.momenta_are_linear:
            inverse = [x for row in inverse_from_factors(ldl_factors(mass)) for x in row]
            zero = self.rows.zero()
            self.rows.store_rows(lanes, [zero.same(x) for x in inverse], self.factors.first)
        else:
            self.factors.keep(lanes, mass, self.rows.zero())

    def store_law(self, lanes):
        """Evaluate the law at (xi, eta), and store f and n if there are forces, the velocity and
        dL/dv unless the momenta are linear, and the factors of a mass that varies."""
        xi, velocity, (tau, mu, mass) = self.evaluate_law(lanes)
        self.has_forces = any(not is_zero(x) for x in tau)
        if self.has_forces:
            coadjoint_part = self.chart.apply("coadjoint_change", xi, tau)
            self.store(lanes, self.chart.apply("momentum", xi, tau), F)
            self.store(lanes, [total(*pair) for pair in zip(tau, coadjoint_part, strict=True)], N)
        if not self.momenta_are_linear:
            self.store(lanes, velocity, VELOCITY)
            self.store(lanes, mu, MU)
        if not self.constant_mass:
            self.factors.keep(lanes, mass, self.rows.zero())

    def velocity_change(self, lanes, x):
        """The change of the velocities that changes the momenta by x."""
        if not self.momenta_are_linear:
            return self.factors.solved(lanes, x)
        change = []
        for i in range(self.rows.d):
            value = 0.0
            for j in range(self.rows.d):
                row, column = max(i, j), min(i, j)
                if (row, column) in self.nonzero_inverse:
                    factor_row = self.factors.first + row * (row + 1) // 2 + column
                    value = total(value, self.rows.load_row(lanes, factor_row) * x[j])
            change.append(value)
        return change

    def momenta_at_end(self):
        """mu0 plus the impulse of the whole step, in all lanes."""
        rows = self.rows
        momenta = [rows.at_stages("p", i).fused for i in range(rows.d)]
        if self.has_forces:
            kicks = rows.over_step(self.block(N))
            momenta = sums(momenta, [rows.spread(kick) for kick in kicks])
        return momenta

    def update_rates(self, lanes, end_momenta):
        """Update f, Q, the velocities and eta, from the momenta at the stages."""
        rows = self.rows
        xi, eta, defect = (self.load(lanes, block) for block in (XI, ETA, DEFECT))
        if self.has_forces:
            kicks = rows.scaled_sums(lanes, LOW_N * rows.d, rows.table_rows.back, N * rows.d)
            end_momenta = sums(end_momenta, [kick.fused for kick in kicks])
        pulled = self.chart.apply("momentum", [-x for x in xi], end_momenta)
        momenta = self.chart.apply("covector", xi, sums(pulled, defect))
        velocity = momenta
        if not self.momenta_are_linear:
            velocity = differences(momenta, self.load(lanes, MU))
        velocity = self.velocity_change(lanes, velocity)
        if not self.momenta_are_linear:
            velocity = sums(self.load(lanes, VELOCITY), velocity)
        f = self.chart.apply("momentum_slope", xi, eta, momenta)
        if self.has_forces:
            f = [total(x, y) for x, y in zip(f, self.load(lanes, F), strict=True)]
        self.store(lanes, f, F)
        self.store(lanes, pulled, PULLED)
        self.store(lanes, velocity, VELOCITY)
        self.store(lanes, self.chart.apply("rate", xi, velocity), ETA)

    def store_rates(self, lanes):
        """Store eta, from the velocities."""
        xi, velocity = self.load(lanes, XI), self.load(lanes, VELOCITY)
        self.store(lanes, self.chart.apply("rate", xi, velocity), ETA)

    def drift(self, lanes):
        """Store xi, from eta, and note its largest change."""
        rows = self.rows
        coordinates = rows.scaled_sums(lanes, LOW_XI * rows.d, rows.table_rows.drift, ETA * rows.d)
        self.note(coordinates, self.load(lanes, XI), "xi_sizes")
        self.store(lanes, coordinates, XI)

    def note(self, new, old, sizes):
        """Note the largest change, times the inverse sizes in the field ``sizes``."""
        for i, (x, y) in enumerate(zip(new, old, strict=True)):
            self.rows.note_bits(abs((x - y) * self.rows.at_stages(sizes, i)).bits)

    def update_defects(self, lanes, end_Q):
        """Store the defects with the multipliers' part, from f and ``end_Q``, Q at the step's
        end."""
        rows, builder = self.rows, self.builder
        force_sums = rows.scaled_sums(lanes, LOW_F * rows.d, rows.table_rows.back, F * rows.d)
        missing = sums(differences(end_Q, self.load(lanes, PULLED)), force_sums)
        pointers = [lanes.variable(x.value) for x in missing]
        with cgutils.for_range(builder, rows.extra, intp=rows.row) as loop:
            Y = Lane(builder, lanes.factor(rows.complement, loop.index))
            for pointer, m in zip(pointers, self.multiplier_rows(loop.index), strict=True):
                first = lanes.number(rows.work, m, rows.row(0))
                part = Y * Lane(builder, lanes.spread(first))
                builder.store((Lane(builder, builder.load(pointer)) + part).value, pointer)
        defects = [Lane(builder, builder.load(pointer), ()) for pointer in pointers]
        self.note(defects, self.load(lanes, DEFECT), "pi_sizes")
        self.store(lanes, defects, DEFECT)

    def multiplier_rows(self, index):
        """The rows of work of one multiplier."""
        row, builder = self.rows.row, self.builder
        first = builder.add(row(self.multipliers), builder.mul(index, row(self.rows.d)))
        return [builder.add(first, row(i)) for i in range(self.rows.d)]

    def project(self, updates_multipliers):
        """Project eta to the rates of curves, and, if asked, correct the multipliers by the
        components that this removes."""
        rows, builder = self.rows, self.builder
        with cgutils.for_range(builder, rows.extra, intp=rows.row) as loop:
            weights = builder.add(rows.extra, loop.index)
            components = rows.weighted_sums(self.block(ETA), weights, matrix=rows.complement)
            components = [rows.spread(x).fused for x in components]

            def subtract(lanes):
                Y = Lane(builder, lanes.factor(rows.complement, loop.index))
                projected_rates = [
                    eta - Y * x for eta, x in zip(self.load(lanes, ETA), components, strict=True)
                ]
                self.store(lanes, projected_rates, ETA)

            rows.chunks(subtract)
            if updates_multipliers:
                lanes = self.first_lanes()
                steps = self.response.solved(lanes, list(components))
                for m, step in zip(self.multiplier_rows(loop.index), steps, strict=True):
                    new = Lane(builder, lanes.load(rows.work, m)) - step
                    lanes.store(new.value, rows.work, m)

    def store_response(self):
        """Store the factors of the response of eta to the multipliers, its weighted mean over the
        stages."""
        rows, d, builder = self.rows, self.rows.d, self.builder
        vector = rows.zero().value.type
        responses = [cgutils.alloca_once(builder, vector, rows.row(d)) for _ in range(d)]

        def store_column(column):
            def store_rates_of(lanes):
                xi = self.load(lanes, XI)
                pi = self.chart.apply("covector", xi, self.unit(column))
                velocity = self.velocity_change(lanes, pi)
                self.store(lanes, self.chart.apply("rate", xi, velocity), PULLED)

            rows.chunks(store_rates_of)
            for i, x in enumerate(rows.weighted_sums(self.block(PULLED), rows.table_rows.means)):
                builder.store(rows.spread(x).value, builder.gep(responses[i], [column]))

        if d <= WRITTEN_OUT_COLUMNS:
            for column in range(d):
                store_column(rows.row(column))
        else:
            with cgutils.for_range(builder, rows.row(d), intp=rows.row) as loop:
                store_column(loop.index)
        mean = [
            [
                Lane(builder, builder.load(builder.gep(responses[i], [rows.row(j)])))
                for j in range(i + 1)
            ]
            for i in range(d)
        ]
        self.response.keep(self.first_lanes(), mean, rows.zero())

    def unit(self, index):
        """The unit vector of an index, an LLVM integer, in all lanes."""
        builder, ones = self.builder, self.rows.zero().same(1.0)
        matches_by_row = [
            builder.icmp_unsigned("==", index, self.rows.row(i)) for i in range(self.rows.d)
        ]
        return [ones.where(Truth(builder, matches), 0.0) for matches in matches_by_row]

    def keep_end(self):
        """Store xi at the step's end if all lanes hold stages; else a lane after them holds it."""
        rows = self.rows
        with self.builder.if_then(rows.lanes_are_full):
            ends = [rows.spread(x) for x in rows.over_step(self.block(ETA))]
            self.store(self.first_lanes(), ends, END)

    def pulled_end(self, end_momenta):
        """Q at the step's end, in all lanes."""
        rows, lanes = self.rows, self.first_lanes()
        pointers = [lanes.variable(lanes.zero) for _ in range(rows.d)]
        with self.builder.if_else(rows.lanes_are_full) as (computed, stored):
            with computed:
                minus_end = [-x for x in self.load(lanes, END)]
                for pointer, x in zip(
                    pointers, self.chart.apply("momentum", minus_end, end_momenta), strict=True
                ):
                    self.builder.store(x.value, pointer)
            with stored:
                rows.reload()
                for pointer, row in zip(pointers, self.block(PULLED), strict=True):
                    value = lanes.number(rows.work, rows.row(row), rows.stages)
                    self.builder.store(lanes.spread(value), pointer)
        return [Lane(self.builder, self.builder.load(pointer)) for pointer in pointers]

    def one_pass(self, first):
        """Do one pass, and note the largest change."""
        rows = self.rows
        rows.chunks(self.store_law)
        if not self.constant_mass:
            with self.builder.if_then(self.builder.and_(first, rows.projects)):
                self.store_response()
        end_momenta = self.momenta_at_end()
        rows.chunks(lambda lanes: self.update_rates(lanes, end_momenta))
        end_Q = self.pulled_end(end_momenta)
        self.project(updates_multipliers=True)
        rows.chunks(self.drift)
        rows.chunks(lambda lanes: self.update_defects(lanes, end_Q))
        self.keep_end()

    def begin(self, convergence):
        """Set xi, eta, defects and multipliers from the velocities at the stages; xi and eta are
        corrected by the tangent map."""
        rows, builder = self.rows, self.builder
        self.set_rotation_sizes()
        self.begin_at_rest()
        with cgutils.for_range(
            builder, rows.row(MAX_GUESS_CORRECTIONS_IN_LANES), intp=rows.row
        ) as loop:
            rows.reset_change()
            rows.chunks(self.store_rates)
            self.project(updates_multipliers=False)
            rows.chunks(self.drift)
            changes_much = convergence.active.value & ~(rows.change() < LAST_CORRECTION_ANGLE)
            convergence.active.set(changes_much)
            with builder.if_then((~changes_much).all):
                loop.do_break()
        convergence.active.set(rows.field("alive") > 0.0)
        self.keep_end()
        if self.constant_mass:
            with builder.if_then(rows.projects):
                self.store_response()

    def begin_at_rest(self):
        """Set xi from the velocities as if these were eta, and all else to zero."""
        rows, zero = self.rows, self.rows.zero()

        def reset(lanes):
            for block in (DEFECT, LOW_XI, LOW_F, LOW_N):
                self.store(lanes, [zero] * rows.d, block)
            self.store(
                lanes, rows.scaled_sums(lanes, None, rows.table_rows.drift, self.velocity_row), XI
            )

        rows.chunks(reset)
        with cgutils.for_range(self.builder, rows.extra, intp=rows.row) as loop:
            for row in self.multiplier_rows(loop.index):
                self.first_lanes().store(zero.value, rows.work, row)

    def add_low_parts(self, chosen):
        """Set the low parts of the sums over stages for the runs ``chosen``."""
        rows, d, chosen = self.rows, self.rows.d, self.rows.spread_truth(chosen)
        parts = [(ETA, rows.table_rows.low_drift, LOW_XI), (F, rows.table_rows.low_back, LOW_F)]
        parts += [(N, rows.table_rows.low_back, LOW_N)] if self.has_forces else []

        def add(lanes):
            for block, first, low in parts:
                new = rows.scaled_sums(lanes, None, first, block * d)
                pairs = zip(new, self.load(lanes, low), strict=True)
                self.store(lanes, [x.where(chosen, old) for x, old in pairs], low)

        rows.chunks(add)

    def set_rotation_sizes(self):
        """Set inverse sizes: 1 for rotations, 0 for translations and momenta."""
        zero = self.rows.variable().lane
        for _, components, _, rotations in self.chart.factors:
            for i in range(components.start, components.stop):
                size = 1.0 if i < components.start + rotations else 0.0
                self.rows.keep("xi_sizes", zero + size, i)
                self.rows.keep("pi_sizes", zero, i)

    def after_first_pass(self, convergence, change):
        """Set the inverse sizes of xi and pi, 0 where a size is 0.

        Rotations have size 1. The translations of a factor share one size, the largest of its
        positions and displacements. The momenta of its translations share another, and those of its
        rotations a third, which is at least a displacement times a momentum. The size of a momentum
        is at least LEAST_COUPLED_MOTION times the largest size of the momenta that the mass couples
        to it, since smaller ones may be round-off of these.
        """
        rows, d, chart = self.rows, self.rows.d, self.chart
        step = rows.field("step")
        g = rows.fields_of("q", chart.entries)
        momenta: list[Any] = []
        coupled: dict[int, list[int]] = {number: [] for number in chart.coupled}
        for number, (_, components, _, _) in zip(chart.coupled, chart.factors, strict=True):
            coupled[number] += [ETA * d + i for i in range(components.start, components.stop)]
        floors = {
            number: LEAST_COUPLED_MOTION * abs(rows.largest_of(rate_rows) * step)
            for number, rate_rows in coupled.items()
        }
        for number, (group, components, entries, rotations) in zip(
            chart.coupled, chart.factors, strict=True
        ):
            rotation_range = range(components.start, components.start + rotations)
            translation_range = range(components.start + rotations, components.stop)
            sizes = []
            for part in (rotation_range, translation_range):
                size = abs(rows.largest_of([F * d + i for i in part]) * step)
                for i in part:
                    size = larger_size(size, rows.field("p", i))
                sizes.append(size)
            rotation_size, translation_size = sizes
            if translation_range:
                displacement = abs(rows.largest_of([ETA * d + i for i in translation_range]) * step)
                rotation_size = larger_size(rotation_size, translation_size * displacement)
                extent = larger_size(
                    floors[number], displacement.same(group.position_scale(g[entries]))
                )
                extent = larger_size(extent, displacement)
                extent = larger_size(
                    extent, rows.largest_of([XI * d + i for i in translation_range])
                )
                for i in translation_range:
                    rows.keep("xi_sizes", (1.0 / extent).where(extent > 0.0, 0.0), i)
            momenta += [
                (number, rotation_size, rotation_range),
                (number, translation_size, translation_range),
            ]
        largest: dict[int, Any] = {}
        for number, size, _ in momenta:
            largest[number] = larger_size(largest.get(number, 0.0), size)
        for number, size, part in momenta:
            size = larger_size(LEAST_COUPLED_MOTION * largest[number], size)
            for i in part:
                rows.keep("pi_sizes", (1.0 / size).where(size > 0.0, 0.0), i)

    def ends(self):
        """[(field, i, number at the step's end), ...], and for which runs all rotations, at the
        stages and at the end, are within the chart."""
        rows, chart = self.rows, self.chart
        end = rows.over_step(self.block(ETA))
        zero = rows.variable().lane
        kick = rows.over_step(self.block(N)) if self.has_forces else [zero] * rows.d
        rows.reset_change()

        def note_squares(lanes):
            for square in chart.squared_rotations(self.load(lanes, XI)):
                rows.note_bits(abs(square).bits)

        rows.chunks(note_squares)
        largest_square = rows.change()
        for square in chart.squared_rotations(end):
            largest_square = larger(square, largest_square)
        before = {name: rows.fields_of(name, rows.fields.size[name]) for name in STATE_FIELDS}
        after = {name: list(lanes) for name, lanes in before.items()}
        for group, components, entries, _ in chart.factors:
            g, memory, low = (after[name][entries] for name in STATE_FIELDS[:3])
            mu, nu, nu_low = (after[name][components] for name in STATE_FIELDS[3:])
            group.advance(chart.number, end[components], g, memory, low)
            group.carry(
                chart.number,
                before["q"][entries],
                g,
                end[components],
                kick[components],
                mu,
                nu,
                nu_low,
            )
            for name, lanes in zip(STATE_FIELDS[:3], (g, memory, low), strict=True):
                after[name][entries] = lanes
            for name, lanes in zip(STATE_FIELDS[3:], (mu, nu, nu_low), strict=True):
                after[name][components] = lanes
        reach = LARGEST_ROTATIONS_IN_LANES[chart.number]
        end_rows = [(name, i, lane) for name in STATE_FIELDS for i, lane in enumerate(after[name])]
        return end_rows, largest_square <= reach * reach


class Chart:
    """The functions of a product of groups in one chart, for lanes or numbers.

    Parameters
    ----------
    layout
        rows of numbers, see galvi.kernels.lie.product
    chart
        number of the chart, see galvi.kernels.lie.dispatch
    """

    def __init__(self, layout, chart):
        self.number, self.factors, start, first = chart, [], 0, 0
        self.coupled = [(*row, 0)[COUPLED] for row in layout]
        for row in layout:
            components = slice(start, start + row[DIMENSION])
            entries = slice(first, first + row[ENTRIES])
            self.factors.append((GROUPS[row[NUMBER]], components, entries, row[ROTATIONS]))
            start, first = components.stop, first + row[ENTRIES]
        self.dimension, self.entries = start, first

    def place(self, g, xi):
        """The entries of g Phi(xi)."""
        element = []
        for group, components, entries, _ in self.factors:
            out = [None] * (entries.stop - entries.start)
            group.place(self.number, g[entries], xi[components], out)
            element += out
        return element

    def left_derivative(self, g, slope):
        """The derivatives along g hat(e_a) of a function with derivatives ``slope`` by the entries
        of g."""
        derivatives = []
        for group, components, entries, _ in self.factors:
            out = [0.0] * (components.stop - components.start)
            group.left_derivative(g[entries], slope[entries], out)
            derivatives += out
        return derivatives

    def squared_rotations(self, xi):
        """|xi|^2 of the rotation of each factor that has one."""
        return [
            reduce(total, [x * x for x in xi[components.start : components.start + rotations]])
            for _, components, _, rotations in self.factors
            if rotations
        ]

    def apply(self, name, xi, *vectors):
        """The d numbers of the function ``name`` of galvi.kernels.lie.groups at xi; 0.0 for a
        factor whose part of the last vector is 0."""
        image = []
        for group, components, _, _ in self.factors:
            parts = [list(vector[components]) for vector in vectors]
            out = [0.0] * len(xi[components])
            if not all(is_zero(x) for x in parts[-1]):
                getattr(group, name)(self.number, xi[components], *parts, out)
            image += out
        return image


def total(x, y):
    """x + y; where x or y is the number 0, the other itself."""
    return y if is_zero(x) else (x if is_zero(y) else x + y)


def generated_step(law, groups, chart, lanes=0, single_vector=False):
    """An intrinsic of the address of the arguments of galvi.lanes.layouts: a step on groups.

    Parameters
    ----------
    groups, chart
        layout and chart of galvi.kernels.lie.product
    lanes, single_vector
        as for galvi.lanes.collocation.generated_step
    """
    functions = Chart(groups, chart)

    def make_step(context, builder, arguments):
        fields = group_fields(functions.dimension, functions.entries)
        rows = layout(context, builder, arguments, fields, lanes, single_vector, 0)
        return GroupStep(rows, law, functions)

    return step_intrinsic(make_step)
