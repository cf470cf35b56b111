"""Steps of any Lagrangian on R^d, or of a canonical system, in lanes.

With weights b_j > 0, s points and m coefficients per component, the stage equations of
galvi.kernels.on_group.stages are

    q_j = q0 + h sum_k A_jk v_k,                q1 = q0 + h sum_k b_k v_k,
    p_j = p0 + h sum_k B_jk f_k + lambda_j,     p1 = p0 + h sum_k b_k f_k,
    C v = 0,   (1 - C) lambda = 0,

with p = dL/dv and f = dL/dq at the stages, an external force added to f. 1 - C projects onto the
slopes of the space's functions at the points, orthogonally in the rule's inner product
sum_j b_j x_j y_j; b_j B_jk + b_k A_kj = b_j b_k. If s = m, C = 0 and lambda = 0: collocation. Else
lambda has s - m free numbers. m is the largest number of coefficients of a component; one with
fewer has its own C, and the same A and B.

A pass of the iteration takes the forces from the last positions and velocities, p - lambda from the
forces, velocities from one step for (1 - C) dL/dv = p - lambda with the last mass M = d2L/dv2, and
positions from the velocities. That step is v += (1 - C) M^-1 (1 - C) (p - dL/dv): Newton's if
s = m, or if M is the same at all stages and couples only components with the same C; its error is
of second order in the differences of M between stages. A step for which the iteration does not
converge is left to the general kernel.

For a canonical system without an external force only the positions are iterated (``places_only``),
by the Nystrom method of galvi.tableau and galvi.kernels.nystrom.advance, as for a law of unit mass:
Q = q + c h v + h^2 A a(Q).

A law is a function as described in galvi.lanes.elementary. Rows of work:

q, v, f, p      (d,) each: positions, velocities, forces dL/dq and momenta at the stages
low_q, low_p    (d,) each: the sum of the low parts that are added to q and p: from the start those
                of the state, and once a pass changes little those of the tables
series          (d,)      coefficients of the velocities' series
t               (1,)      times
momenta         (d,)      dL/dv
factors         (d (d + 1) / 2,)  factors of d2L/dv2 by rows: L D L^T without pivots, with 1 / D on
                the diagonal
steps           (d,)      changes of the velocities

The complement is C^T: one matrix for all components, or a matrix for each. It has no rows if
C = 0. With ``places_only``, v holds accelerations, p the displacements c h v, and low_q the low
parts of these and of q.
"""

from __future__ import annotations

import numpy as np

from galvi.kernels.lie.arithmetic import larger_size, where
from galvi.lanes.dense import Triangle, is_written_out, ldl_factors
from galvi.lanes.functions import two_product
from galvi.lanes.layouts import Fields, layout
from galvi.lanes.nbody import move_compensated
from galvi.lanes.step import step_intrinsic
from galvi.lanes.stopping import BY_CHANGES
from galvi.lanes.values import Lane

Q, V, F, P, LOW_Q, LOW_P, SERIES, T = range(8)  # times d, but for T, which has one row
UNMEASURED_CHANGE = 1e300  # stands for a change whose scale is not known yet


def law_fields(d):
    """The record of a run on R^d: q, p, the inverses of their sizes, their low parts, and
    SHARED."""
    return Fields((("q", d), ("p", d), ("sizes", 2), ("q_low", d), ("p_low", d)), d)


def first_step_row(d):
    """The first row of work for the changes of the velocities."""
    return T * d + 1 + d + d * (d + 1) // 2


def rows_of_work(d):
    """The number of rows of work for d coordinates."""
    return first_step_row(d) + d


def nonzero_factors(law, d):
    """Indices (i, j), j < i, of the entries of L that are not 0 at a generic state."""
    sample = np.linspace(0.3, 0.7, 2 * d + 1) ** 0.5
    with np.errstate(all="ignore"):
        mass = law(list(sample[:d]), list(sample[d:-1]), sample[-1], GenericConstants())[2]
        rows = ldl_factors([list(map(np.float64, row)) for row in mass])
    return [(i, j) for i in range(d) for j in range(i) if rows[i][j] != 0.0]


class GenericConstants:
    """Distinct constants, so that no entry of a mass vanishes by a special choice of them."""

    def __getitem__(self, k):
        return np.float64(1.0 + 0.1 / (k + 1.5))


class Constants:
    """Constants of a law; each is spread over all lanes when it is first used.

    Parameters
    ----------
    lanes
        a `galvi.lanes.vectors.Lanes`
    array
        pointer to the first constant
    """

    def __init__(self, lanes, array):
        self.lanes, self.data, self.loaded = lanes, array, {}

    def __getitem__(self, k):
        if k not in self.loaded:
            number = self.lanes.number(self.data, self.lanes.offset.type(k))
            self.loaded[k] = Lane(self.lanes.builder, self.lanes.spread(number))
        return self.loaded[k]


class Factors:
    """The factors of a mass at the stages, in rows of work.

    Parameters
    ----------
    first
        row of the first factor
    below
        indices (i, j), j < i, of the entries of L that are not 0
    written_out
        whether the factorisation is written out; None to decide by ``below``
    """

    def __init__(self, rows, first, below, written_out=None):
        self.rows, self.first, self.below = rows, first, below
        self.written_out = is_written_out(below) if written_out is None else written_out
        self.constant = {}  # numbers that are the same for every state

    def triangle(self, lanes):
        """The factors as rows of work, for loops."""
        rows = self.rows
        return Triangle(rows.builder, lanes, rows.work, self.first, rows.d)

    def keep(self, lanes, mass, lane):
        """Factor a mass and store the factors; ``lane`` is any lane at these stages."""
        entries = [x for row in (ldl_factors(mass) if self.written_out else mass) for x in row]
        if self.written_out:
            self.constant = {k: x for k, x in enumerate(entries) if not isinstance(x, Lane)}
        for k, value in enumerate(entries):
            if k not in self.constant:
                self.rows.store_row(lanes, lane.same(value), self.first + k)
        if not self.written_out:
            self.triangle(lanes).factor()

    def solved(self, lanes, x):
        """M^-1 x, the changes of v that change dL/dv by x; ``x`` may be overwritten."""
        if not self.written_out:
            return self.triangle(lanes).solve(x)
        for i, j in self.below:
            x[i] = x[i] - self.at(lanes, i, j) * x[j]
        x = [x[i] * self.at(lanes, i, i) for i in range(self.rows.d)]
        for i, j in reversed(self.below):
            x[j] = x[j] - self.at(lanes, i, j) * x[i]
        return x

    def at(self, lanes, i, j):
        """Entry (i, j) of the factors."""
        k = i * (i + 1) // 2 + j
        return self.constant[k] if k in self.constant else self.rows.load_row(lanes, self.first + k)


class LawStep:
    """A step on R^d, see galvi.lanes.step.

    Parameters
    ----------
    below
        indices (i, j), j < i, of the entries of L that are not 0
    places_only
        whether only the positions are iterated
    """

    rule = BY_CHANGES

    def __init__(self, rows, law, below, places_only):
        d = rows.d
        self.rows, self.law, self.places_only = rows, law, places_only
        self.velocity_row, self.series_row, self.guess_row = V * d, SERIES * d, Q * d
        self.time_row = T * d
        self.momentum_row, self.steps = T * d + 1, first_step_row(d)
        self.factors = Factors(rows, self.momentum_row + d, below)
        rows.guarded_rows = range(0, 3 * d)  # q, v and f
        builder = rows.builder
        several = builder.icmp_unsigned(">", rows.extra, rows.block)
        self.matrix_stride = builder.select(several, rows.block, rows.row(0))

    def load(self, lanes, block):
        """The d rows of a block of work."""
        return self.rows.load_rows(lanes, block * self.rows.d)

    def store(self, lanes, values, block):
        self.rows.store_rows(lanes, values, block * self.rows.d)

    def at_stages(self, name):
        """The d rows of a field of the record, in the lanes of the stages."""
        return [self.rows.at_stages(name, i) for i in range(self.rows.d)]

    def prepare(self):
        """Do nothing: no factors are common to all states."""

    def begin(self, convergence):
        """Set the initial positions at the stages, with the low parts of the state."""
        if self.places_only:
            self.coast_stages()
        else:
            self.project_velocities()
            self.place_stages()

    def project_velocities(self):
        """Replace V by (1 - C) V."""
        rows = self.rows

        def store_complement(lanes):
            rows.store_rows(lanes, self.outside(lanes, self.velocity_row), self.steps)

        def subtract_complement(lanes):
            complement_part = rows.load_rows(lanes, self.steps)
            self.store(lanes, differences(self.load(lanes, V), complement_part), V)

        with rows.builder.if_then(rows.projects):
            rows.chunks(store_complement)
            rows.chunks(subtract_complement)

    def outside(self, lanes, row):
        """C x for x in d rows of work from ``row`` on."""
        rows = self.rows
        return rows.sums(lanes, rows.complement, rows.row(0), row, self.matrix_stride)

    def place_stages(self):
        """Set the initial positions at the stages, and the low parts to those of the state."""

        def set_positions(lanes):
            self.store(lanes, self.at_stages("q_low"), LOW_Q)
            self.store(lanes, self.at_stages("p_low"), LOW_P)
            displacements = self.rows.scaled_sums(
                lanes, None, self.rows.table_rows.drift, self.velocity_row
            )
            self.store(lanes, sums(self.at_stages("q"), displacements), Q)

        self.rows.chunks(set_positions)

    def keep_size(self, k, size):
        """Store 1 / size, or 0 where the size is 0, as entry k of the field ``sizes``."""
        self.rows.keep("sizes", (1.0 / size).where(size > 0.0, 0.0), k)

    def coast_stages(self):
        """Set the displacements without forces, their low parts, and the initial positions by the
        last accelerations; and the size of the positions, the largest |q_i| or |q_i + h v_i|."""
        rows = self.rows
        size, step = rows.variable().lane, rows.field("step")
        for i in range(rows.d):
            q, displacement = rows.field("q", i), step * rows.field("p", i)
            size = larger_size(larger_size(size, q), q + displacement)
        self.keep_size(0, size)
        rows.chunks(self.coast)

    def coast(self, lanes):
        """Do the work of `coast_stages` for a vector of stages."""
        rows, h = self.rows, self.rows.at_stages("step")
        node, low_node = (
            Lane(rows.builder, lanes.factor(rows.tables, row))
            for row in (rows.table_rows.nodes, rows.table_rows.means)
        )
        bent = rows.force_displacements(lanes, self.velocity_row)
        path_displacements, low_displacements = [], []
        for i in range(rows.d):
            displacement, displacement_low = two_product(h, rows.at_stages("p", i))
            displacement_low = displacement_low + h * rows.at_stages("p_low", i)
            path_displacement, error = two_product(displacement, node.exact)
            path_displacements.append(path_displacement)
            low_displacement = low_node * displacement + node * displacement_low
            low_displacements.append((error + rows.at_stages("q_low", i)).fused + low_displacement)
        self.store(lanes, path_displacements, P)
        self.store(lanes, low_displacements, LOW_Q)
        self.store(
            lanes,
            sums(self.at_stages("q"), sums(path_displacements, sums(low_displacements, bent))),
            Q,
        )

    def one_pass(self, first):
        """Update the forces, then momenta, velocities and positions."""
        if self.places_only:
            self.rows.chunks(self.accelerate)
        else:
            self.rows.chunks(self.evaluate)
            self.update_velocities()
        self.rows.chunks(self.drift)

    def evaluate(self, lanes):
        """Store f, dL/dv and the factors of d2L/dv2 at q and v."""
        q, v = self.load(lanes, Q), self.load(lanes, V)
        time = self.rows.load_row(lanes, self.time_row)
        forces, momenta, mass = self.law(q, v, time, Constants(lanes, self.rows.constants))
        self.store(lanes, [q[0].same(force) for force in forces], F)
        self.rows.store_rows(lanes, [q[0].same(x) for x in momenta], self.momentum_row)
        self.factors.keep(lanes, mass, q[0])

    def accelerate(self, lanes):
        """Store the accelerations at q."""
        q, time = self.load(lanes, Q), self.rows.load_row(lanes, self.time_row)
        zero_velocity = [0.0] * self.rows.d
        accelerations = self.law(q, zero_velocity, time, Constants(lanes, self.rows.constants))[0]
        self.store(lanes, [q[0].same(acceleration) for acceleration in accelerations], V)

    def update_velocities(self):
        """Update p from f, and v by one Newton step for dL/dv = p."""
        rows, solved = self.rows, self.factors.solved

        def newton_step(lanes):
            steps = solved(lanes, self.missing(lanes, self.update_momenta(lanes)))
            self.store(lanes, sums(self.load(lanes, V), steps), V)

        def store_missing(lanes):
            rows.store_rows(
                lanes, self.missing(lanes, self.update_momenta(lanes)), self.momentum_row
            )

        def store_steps(lanes):
            rows.store_rows(lanes, solved(lanes, self.inside(lanes, self.momentum_row)), self.steps)

        def add_steps(lanes):
            projected_steps = self.inside(lanes, self.steps)
            self.store(lanes, sums(self.load(lanes, V), projected_steps), V)

        with rows.builder.if_else(rows.projects) as (more_points, square):
            with more_points:
                for part in (store_missing, store_steps, add_steps):
                    rows.chunks(part)
            with square:
                rows.chunks(newton_step)

    def inside(self, lanes, row):
        """x - C x for x in d rows of work from ``row`` on."""
        return differences(self.rows.load_rows(lanes, row), self.outside(lanes, row))

    def update_momenta(self, lanes):
        """Update p from f; returns p."""
        rows = self.rows
        totals = rows.scaled_sums(lanes, LOW_P * rows.d, rows.table_rows.back, F * rows.d)
        return self.store_moved(lanes, totals, P, "p", 1)

    def missing(self, lanes, p):
        """p - dL/dv."""
        return differences(p, self.rows.load_rows(lanes, self.momentum_row))

    def drift(self, lanes):
        """Update q from v, or from accelerations with ``places_only``."""
        rows = self.rows
        totals = rows.scaled_sums(
            lanes, LOW_Q * rows.d, rows.table_rows.drift, self.velocity_row, 1 + self.places_only
        )
        if self.places_only:
            totals = sums([path.exact for path in self.load(lanes, P)], totals)
        self.store_moved(lanes, totals, Q, "q", 0)

    def store_moved(self, lanes, totals, block, name, size_index):
        """Store field ``name`` + totals in a block, and note the largest change relative to the
        size with index ``size_index``; returns the new rows."""
        rows = self.rows
        size, moved_rows = rows.at_stages("sizes", size_index), sums(self.at_stages(name), totals)
        for new, old in zip(moved_rows, self.load(lanes, block), strict=True):
            rows.note_bits(((new - old) * size).call("fabs").bits)
        self.store(lanes, moved_rows, block)
        return [new.fused for new in moved_rows]

    def after_first_pass(self, convergence, change):
        """Set the sizes of q and p.

        With ``places_only`` the size of q is 0 only at rest at the origin; it is then set from the
        positions of this pass, and the change of the pass is not used.
        """
        rows, d = self.rows, self.rows.d
        step = rows.field("step")
        if self.places_only:
            has_size = rows.field("sizes") > 0.0
            size = rows.largest_of(range(Q * d, (Q + 1) * d))
            self.keep_size(0, where(has_size, 1.0 / rows.field("sizes"), size))
            convergence.update(where(has_size, change, UNMEASURED_CHANGE), rows.real(rows.terms))
            return
        for k, (block, name) in enumerate(((V, "q"), (F, "p"))):
            size = abs(rows.largest_of(range(block * d, (block + 1) * d)) * step)
            for i in range(d):
                size = larger_size(size, rows.field(name, i))
            self.keep_size(k, size)

    def add_low_parts(self, chosen):
        """Add the low parts of the tables times the slopes, for the runs ``chosen``."""
        rows, d = self.rows, self.rows.d
        parts = [(V, rows.table_rows.low_drift, LOW_Q, 1 + self.places_only)]
        parts += [] if self.places_only else [(F, rows.table_rows.low_back, LOW_P, 1)]
        chosen = rows.spread_truth(chosen)

        def add(lanes):
            for block, first, low, power in parts:
                increments = rows.scaled_sums(lanes, None, first, block * d, power)
                increments = [x.where(chosen, 0.0) for x in increments]
                self.store(lanes, sums(self.load(lanes, low), increments), low)

        rows.chunks(add)

    def ends(self):
        """[(field, i, number at the step's end), ...], by compensated sums, and which runs are
        alive."""
        rows, step, end_rows = self.rows, self.rows.field("step"), []
        for block, name in ((V, "q"), (V if self.places_only else F, "p")):
            curves_forward = self.places_only and name == "q"
            parts = ("back", "low_back") if curves_forward else ("kicks", "low_kicks")
            for i, pair in enumerate(rows.sums_over_step(block * rows.d, *parts)):
                increment, remainder = rows.times_step(*pair, 1 + curves_forward)
                low, displacement = rows.field(f"{name}_low", i), 0.0
                if curves_forward:
                    displacement, error = two_product(step, rows.field("p", i))
                    remainder = remainder + (error + step * rows.field("p_low", i))
                high, low = move_compensated(
                    rows.field(name, i), low, displacement, increment, remainder
                )
                end_rows += [(name, i, high), (f"{name}_low", i, low)]
        return end_rows, rows.field("alive") > 0.0


def sums(x, y):
    """The sums x_i + y_i."""
    return [a + b for a, b in zip(x, y, strict=True)]


def differences(x, y):
    """The differences x_i - y_i."""
    return [a - b for a, b in zip(x, y, strict=True)]


def generated_step(law, d, places_only, lanes=0, single_vector=False, stages=0):
    """An intrinsic of the address of the arguments of galvi.lanes.layouts: a step of a law on R^d.

    Parameters
    ----------
    places_only
        whether only the positions are iterated
    lanes
        number of stages of one run in a vector; 0 for vectors of eight runs
    single_vector
        whether one vector holds all stages
    stages
        number of stages of eight runs, so that loops are written out; 0 for a number that is only
        known at run time
    """
    below = nonzero_factors(law, d)

    def make_step(context, builder, arguments):
        rows = layout(
            context, builder, arguments, law_fields(d), lanes, single_vector, stages, places_only
        )
        return LawStep(rows, law, below, places_only)

    return step_intrinsic(make_step)
