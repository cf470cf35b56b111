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

A pass of the iteration takes the forces from the last places and velocities, p - lambda from the
forces, velocities from one step for (1 - C) dL/dv = p - lambda with the last mass M = d2L/dv2, and
places from the velocities. That step is v += (1 - C) M^-1 (1 - C) (p - dL/dv): Newton's if s = m,
or if M is the same at all stages and couples only components with the same C; its error is of
second order in the differences of M between stages. A step for which the iteration does not
converge is left to the general kernel.

A canonical system without an external force iterates places ``alone``, by the Nystrom method of
galvi.tableau and galvi.kernels.nystrom.advance, as a law of unit mass: Q = q + c h v + h^2 A a(Q).

A law is a function as described in galvi.lanes.elementary. Rows of work:

q, v, f, p      (d,) each: places, velocities, forces dL/dq and momenta at the stages
low_q, low_p    (d,) each: what low parts add to q and p, those of the state from the start, those
                of the tables once a pass changes little
series          (d,)      coefficients of the velocities' series
t               times
found           dL/dv (d,), then the factors of d2L/dv2 by rows: L D L^T without pivots, with 1 / D
                on the diagonal
steps           (d,)      changes of the velocities

The complement is C^T, a matrix for all components or one for each; without rows where C is 0.
Alone, v holds accelerations, p the ways c h v, and low_q what is added to these.
"""

from __future__ import annotations

import numpy as np

from galvi.kernels.lie.arithmetic import larger_size, where
from galvi.lanes.dense import Triangle, factored, is_written_out
from galvi.lanes.functions import two_product
from galvi.lanes.layouts import Fields, layout
from galvi.lanes.nbody import moved
from galvi.lanes.step import generated
from galvi.lanes.stopping import BY_CHANGES
from galvi.lanes.values import Lane

Q, V, F, P, LOW_Q, LOW_P, SERIES, T = range(8)  # times d, but for T, which has one row
UNKNOWN_CHANGE = 1e300  # says nothing


def law_fields(d):
    """The record of a run on R^d: q, p, 1 over their sizes, their low parts, and SHARED."""
    return Fields((("q", d), ("p", d), ("sizes", 2), ("q_low", d), ("p_low", d)), d)


def first_of_steps(d):
    """The first row of the changes of velocities, scratch of a pass."""
    return T * d + 1 + d + d * (d + 1) // 2


def rows_of_work(d):
    """Rows of work for d coordinates."""
    return first_of_steps(d) + d


def filled(law, d):
    """Indices (i, j), j < i, of the entries of L that are not 0 at a generic state."""
    sample = np.linspace(0.3, 0.7, 2 * d + 1) ** 0.5
    with np.errstate(all="ignore"):
        mass = law(list(sample[:d]), list(sample[d:-1]), sample[-1], Generic())[2]
        rows = factored([list(map(np.float64, row)) for row in mass])
    return [(i, j) for i in range(d) for j in range(i) if rows[i][j] != 0.0]


class Generic:
    """Generic constants, in no special relation."""

    def __getitem__(self, k):
        return np.float64(1.0 + 0.1 / (k + 1.5))


class Constants:
    """Constants of a law, spread over all lanes when they are first used.

    Parameters
    ----------
    lanes
        of a stage, a `galvi.lanes.vectors.Lanes`
    array
        their address
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
    """

    def __init__(self, rows, first, below, written_out=None):
        self.rows, self.first, self.below = rows, first, below
        self.written_out = is_written_out(below) if written_out is None else written_out
        self.constant = {}  # numbers that are the same for every state

    def triangle(self, lanes):
        """The factors that are not written out."""
        rows = self.rows
        return Triangle(rows.builder, lanes, rows.work, self.first, rows.d)

    def keep(self, lanes, mass, lane):
        """Factor a mass and store the factors; ``lane`` is any lane at these stages."""
        entries = [x for row in (factored(mass) if self.written_out else mass) for x in row]
        if self.written_out:
            self.constant = {k: x for k, x in enumerate(entries) if not isinstance(x, Lane)}
        for k, value in enumerate(entries):
            if k not in self.constant:
                self.rows.store_row(lanes, lane.same(value), self.first + k)
        if not self.written_out:
            self.triangle(lanes).factor()

    def solved(self, lanes, x):
        """The changes of v that change dL/dv by x."""
        if not self.written_out:
            return self.triangle(lanes).solve(x)
        for i, j in self.below:
            x[i] = x[i] - self.at(lanes, i, j) * x[j]
        x = [x[i] * self.at(lanes, i, i) for i in range(self.rows.d)]
        for i, j in reversed(self.below):
            x[j] = x[j] - self.at(lanes, i, j) * x[i]
        return x

    def at(self, lanes, i, j):
        """An entry of the factors."""
        k = i * (i + 1) // 2 + j
        return self.constant[k] if k in self.constant else self.rows.load_row(lanes, self.first + k)


class LawStep:
    """A step on R^d, see galvi.lanes.step.

    Parameters
    ----------
    places_only
        whether places alone are iterated
    """

    rule = BY_CHANGES

    def __init__(self, rows, law, below, places_only):
        d = rows.d
        self.rows, self.law, self.places_only = rows, law, places_only
        self.velocity_row, self.series_row, self.guess_row = V * d, SERIES * d, Q * d
        self.time_row = T * d
        self.momentum_row, self.steps = T * d + 1, first_of_steps(d)
        self.factors = Factors(rows, self.momentum_row + d, below)
        rows.guarded = range(0, 3 * d)  # q, v and f
        builder = rows.builder
        several = builder.icmp_unsigned(">", rows.extra, rows.block)
        self.matrix_stride = builder.select(several, rows.block, rows.row(0))

    def load(self, lanes, block):
        """The d rows of a block of work."""
        return self.rows.load_rows(lanes, block * self.rows.d)

    def store(self, lanes, values, block):
        self.rows.store_rows(lanes, values, block * self.rows.d)

    def at_stages(self, name):
        """The d rows of a field."""
        return [self.rows.at_stages(name, i) for i in range(self.rows.d)]

    def prepare(self):
        """Do nothing: no factors are common to all states."""

    def begin(self, convergence):
        """Set the first places, with the low parts of the state."""
        if self.places_only:
            self.coast_stages()
        else:
            self.project_velocities()
            self.place_stages()

    def project_velocities(self):
        """V <- (1 - C) V."""
        rows = self.rows

        def outside(lanes):
            rows.store_rows(lanes, self.outside(lanes, self.velocity_row), self.steps)

        def inside(lanes):
            lost = rows.load_rows(lanes, self.steps)
            self.store(lanes, differences(self.load(lanes, V), lost), V)

        with rows.builder.if_then(rows.projects):
            rows.chunks(outside)
            rows.chunks(inside)

    def outside(self, lanes, row):
        """C x, x in d rows of work."""
        rows = self.rows
        return rows.sums(lanes, rows.complement, rows.row(0), row, self.matrix_stride)

    def place_stages(self):
        """Set the first places at the stages; low parts are those of the state."""

        def first(lanes):
            self.store(lanes, self.at_stages("q_low"), LOW_Q)
            self.store(lanes, self.at_stages("p_low"), LOW_P)
            displacements = self.rows.scaled_sums(
                lanes, None, self.rows.tabled.drift, self.velocity_row
            )
            self.store(lanes, sums(self.at_stages("q"), displacements), Q)

        self.rows.chunks(first)

    def keep_size(self, k, size):
        """Store 1 / size, 0 where the size is 0."""
        self.rows.keep("sizes", (1.0 / size).where(size > 0.0, 0.0), k)

    def coast_stages(self):
        """Set the displacements without forces, their low parts, the first places, by the last
        accelerations, and their size, the larger of q and q + h v."""
        rows = self.rows
        size, step = rows.variable().lane, rows.field("step")
        for i in range(rows.d):
            q, displacement = rows.field("q", i), step * rows.field("p", i)
            size = larger_size(larger_size(size, q), q + displacement)
        self.keep_size(0, size)
        rows.chunks(self.coast)

    def coast(self, lanes):
        """As `coast_stages`, for a vector of stages."""
        rows, h = self.rows, self.rows.at_stages("step")
        node, low_node = (
            Lane(rows.builder, lanes.factor(rows.tables, row))
            for row in (rows.tabled.nodes, rows.tabled.means)
        )
        bent = rows.bent(lanes, self.velocity_row)
        paths, smalls = [], []
        for i in range(rows.d):
            displacement, displacement_low = two_product(h, rows.at_stages("p", i))
            displacement_low = displacement_low + h * rows.at_stages("p_low", i)
            path, error = two_product(displacement, node.exact)
            paths.append(path)
            small = low_node * displacement + node * displacement_low
            smalls.append((error + rows.at_stages("q_low", i)).fused + small)
        self.store(lanes, paths, P)
        self.store(lanes, smalls, LOW_Q)
        self.store(lanes, sums(self.at_stages("q"), sums(paths, sums(smalls, bent))), Q)

    def one_pass(self, first):
        """Forces from places and velocities, then momenta, velocities and places."""
        if self.places_only:
            self.rows.chunks(self.accelerate)
        else:
            self.rows.chunks(self.evaluate)
            self.rates()
        self.rows.chunks(self.drift)

    def evaluate(self, lanes):
        """f, dL/dv and the factors from q and v."""
        q, v = self.load(lanes, Q), self.load(lanes, V)
        time = self.rows.load_row(lanes, self.time_row)
        forces, momenta, mass = self.law(q, v, time, Constants(lanes, self.rows.constants))
        self.store(lanes, [q[0].same(force) for force in forces], F)
        self.rows.store_rows(lanes, [q[0].same(x) for x in momenta], self.momentum_row)
        self.factors.keep(lanes, mass, q[0])

    def accelerate(self, lanes):
        """The accelerations from q."""
        q, time = self.load(lanes, Q), self.rows.load_row(lanes, self.time_row)
        still = [0.0] * self.rows.d
        accelerations = self.law(q, still, time, Constants(lanes, self.rows.constants))[0]
        self.store(lanes, [q[0].same(acceleration) for acceleration in accelerations], V)

    def rates(self):
        """p from f, and one Newton step for v with dL/dv = p."""
        rows, solved = self.rows, self.factors.solved

        def newton(lanes):
            steps = solved(lanes, self.missing(lanes, self.kick(lanes)))
            self.store(lanes, sums(self.load(lanes, V), steps), V)

        def missing(lanes):
            rows.store_rows(lanes, self.missing(lanes, self.kick(lanes)), self.momentum_row)

        def steps(lanes):
            rows.store_rows(lanes, solved(lanes, self.inside(lanes, self.momentum_row)), self.steps)

        def landed(lanes):
            inside = self.inside(lanes, self.steps)
            self.store(lanes, sums(self.load(lanes, V), inside), V)

        with rows.builder.if_else(rows.projects) as (more_points, square):
            with more_points:
                for part in (missing, steps, landed):
                    rows.chunks(part)
            with square:
                rows.chunks(newton)

    def inside(self, lanes, row):
        """x - C x, x in d rows of work."""
        return differences(self.rows.load_rows(lanes, row), self.outside(lanes, row))

    def kick(self, lanes):
        """p from f."""
        rows = self.rows
        totals = rows.scaled_sums(lanes, LOW_P * rows.d, rows.tabled.back, F * rows.d)
        return self.moved(lanes, totals, P, "p", 1)

    def missing(self, lanes, p):
        """p - dL/dv."""
        return differences(p, self.rows.load_rows(lanes, self.momentum_row))

    def drift(self, lanes):
        """q from v, or from accelerations."""
        rows = self.rows
        totals = rows.scaled_sums(
            lanes, LOW_Q * rows.d, rows.tabled.drift, self.velocity_row, 1 + self.places_only
        )
        if self.places_only:
            totals = sums([way.exact for way in self.load(lanes, P)], totals)
        self.moved(lanes, totals, Q, "q", 0)

    def moved(self, lanes, totals, block, name, scale):
        """Store field ``name`` + totals in a block, and note its largest change over its size."""
        rows = self.rows
        size, places = rows.at_stages("sizes", scale), sums(self.at_stages(name), totals)
        for new, old in zip(places, self.load(lanes, block), strict=True):
            rows.note_bits(((new - old) * size).call("fabs").bits)
        self.store(lanes, places, block)
        return [new.fused for new in places]

    def after_first_pass(self, convergence, change):
        """Set the sizes of q and p."""
        rows, d = self.rows, self.rows.d
        step = rows.field("step")
        if self.places_only:  # at rest at the origin, its size is known after it
            has_size = rows.field("sizes") > 0.0
            size = rows.largest_of(range(Q * d, (Q + 1) * d))
            self.keep_size(0, where(has_size, 1.0 / rows.field("sizes"), size))
            convergence.judge(where(has_size, change, UNKNOWN_CHANGE), rows.real(rows.terms))
            return
        for k, (block, name) in enumerate(((V, "q"), (F, "p"))):
            size = abs(rows.largest_of(range(block * d, (block + 1) * d)) * step)
            for i in range(d):
                size = larger_size(size, rows.field(name, i))
            self.keep_size(k, size)

    def add_low_parts(self, chosen):
        """Add the low parts of the tables times the rates, for the runs ``chosen``."""
        rows, d = self.rows, self.rows.d
        parts = [(V, rows.tabled.low_drift, LOW_Q, 1 + self.places_only)]
        parts += [] if self.places_only else [(F, rows.tabled.low_back, LOW_P, 1)]
        chosen = rows.spread_truth(chosen)

        def add(lanes):
            for block, first, low, power in parts:
                increments = rows.scaled_sums(lanes, None, first, block * d, power)
                increments = [x.where(chosen, 0.0) for x in increments]
                self.store(lanes, sums(self.load(lanes, low), increments), low)

        rows.chunks(add)

    def ends(self):
        """The state at the step's end, by compensated sums, and which runs are valid."""
        rows, step, end_fields = self.rows, self.rows.field("step"), []
        for block, name in ((V, "q"), (V if self.places_only else F, "p")):
            bends = self.places_only and name == "q"
            parts = ("back", "low_back") if bends else ("kicks", "low_kicks")
            for i, pair in enumerate(rows.totals(block * rows.d, *parts)):
                way, remainder = rows.times_step(*pair, 1 + bends)
                low, displacement = rows.field(f"{name}_low", i), 0.0
                if bends:
                    displacement, error = two_product(step, rows.field("p", i))
                    remainder = remainder + (error + step * rows.field("p_low", i))
                high, low = moved(rows.field(name, i), low, displacement, way, remainder)
                end_fields += [(name, i, high), (f"{name}_low", i, low)]
        return end_fields, rows.field("alive") > 0.0


def sums(x, y):
    """x + y of several lanes."""
    return [a + b for a, b in zip(x, y, strict=True)]


def differences(x, y):
    """x - y of several lanes."""
    return [a - b for a, b in zip(x, y, strict=True)]


def generated_step(law, d, places_only, lanes=0, single_vector=False, stages=0):
    """An intrinsic of the address of the arguments of galvi.lanes.layouts: a step of a law on R^d.

    Parameters
    ----------
    places_only
        whether places alone are iterated
    lanes
        lanes of a vector of one run's stages; 0 for eight runs
    single_vector
        whether one vector holds all stages
    stages
        stages of eight runs, for which loops are written out; 0 for any
    """
    below = filled(law, d)

    def kind(context, builder, arguments):
        rows = layout(
            context, builder, arguments, law_fields(d), lanes, single_vector, stages, places_only
        )
        return LawStep(rows, law, below, places_only)

    return generated(kind)
