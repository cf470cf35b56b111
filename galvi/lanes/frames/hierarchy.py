"""The frame of Kepler's motions in a hierarchy of bodies: its slopes at the stages of a step.

Bodies 0 to n are the leaves of a binary tree, n pairs of subsystems its nodes, inner ones first:
pair i joins the bodies first <= a < middle, of mass A, and middle <= b < end, of mass B, all masses
times G. Q_i is the position of the barycentre of the latter from that of the former (generalised
Jacobi coordinates) and Q_i'' = -M_i Q_i / |Q_i|^3 its motion in the frame, M_i = A + B. Any two
bodies a, b are on opposite sides of one pair, at x_b - x_a = Q_i + d; their attraction beyond that
motion accelerates b by m_a g and a by -m_b g, where

    g = Q / |Q|^3 - (Q + d) / |Q + d|^3 = [f (Q + d) - d] / |Q|^3,  f as in `encke`,

and Q_i by the difference of the mean accelerations of its two sides: an acceleration that all
bodies of a side share has no effect on the pairs inside it. Other forces are added to the same
means.

Arrays as in `galvi.lanes.frames.kepler_motion`. The blocks of numbers are m, M, B / M, A / M,
first, middle, end and 1 / M. The last blocks of work have n + 1 rows: the bodies' positions from
the barycentre of the pairs that were added before (D), and their accelerations (D).
"""

from __future__ import annotations

from galvi.kernels.compile.internals import cgutils
from galvi.lanes.celestial import add_in_frame
from galvi.lanes.frames.kepler_motion import (
    HEAD,
    MASS_SHARE,
    STORED_BLOCKS,
    dot,
    encke,
    rates_of_orbits,
)
from galvi.lanes.values import Lane, LaneTuple
from galvi.lanes.vectors import DOUBLE, ZEROS

SECOND_SHARE, FIRST, MIDDLE, END = 3, 4, 5, 6  # blocks of numbers


def rows_of_hierarchy(dimension):
    """The number of rows of work for each pair; for any n >= 1 pairs these suffice for the n + 1
    bodies."""
    return 6 * dimension + STORED_BLOCKS


class Bodies:
    """Positions and accelerations of the bodies at eight stages."""

    def __init__(self, orbits, lanes):
        self.orbits, self.lanes, self.row = orbits, lanes, orbits.row
        self.count = orbits.builder.add(orbits.n, self.row(1))

    def at(self, block, body):
        """The row of work of a body in a block; positions begin at block 0, accelerations at D."""
        builder, orbits = self.orbits.builder, self.orbits
        first = builder.mul(orbits.n, self.row(2 * orbits.D + STORED_BLOCKS))
        return builder.add(first, builder.add(builder.mul(self.count, self.row(block)), body))

    def load(self, half, body):
        """The position (half = 0) or the acceleration (half = 1) of a body."""
        orbits = self.orbits
        blocks = range(half * orbits.D, (half + 1) * orbits.D)
        return [
            LaneTuple(
                [Lane(orbits.builder, orbits.work_lanes.load(orbits.work, self.at(block, body)))]
            )
            for block in blocks
        ]

    def store(self, half, body, vector):
        orbits = self.orbits
        for x, several in enumerate(vector):
            row = self.at(half * orbits.D + x, body)
            orbits.work_lanes.store(several.lanes[0].value, orbits.work, row)

    def mass(self, body):
        """m of a body, in all lanes."""
        orbits = self.orbits
        index = orbits.builder.add(body, self.row(HEAD - 1))
        return LaneTuple(
            [Lane(orbits.builder, self.lanes.spread(self.lanes.number(orbits.numbers, index)))]
        )

    def limit_of(self, pair, k):
        """The limit k of a pair's bodies, an LLVM integer; k is FIRST, MIDDLE or END."""
        orbits = self.orbits
        return orbits.integer(self.lanes, orbits.builder.add(orbits.at(k, pair), self.row(HEAD)))

    def loop(self, begin, end):
        builder = self.orbits.builder
        return cgutils.for_range(builder, end, begin, intp=self.row)


def add_attraction(orbits, bodies, pair):
    """Add the attraction of a pair's two sides less that of its Kepler motion, and other forces
    between them; move the positions of its bodies to its barycentre."""
    lanes = bodies.lanes
    first, middle, end = (bodies.limit_of(pair, k) for k in (FIRST, MIDDLE, END))
    Q = orbits.load_vector(orbits.work_lanes, orbits.work, 0, (pair,))
    inverse = orbits.load(orbits.work_lanes, orbits.work, 2 * orbits.D, (pair,))
    square = inverse * inverse
    cube = square * inverse
    with bodies.loop(first, middle) as outer:
        a = outer.index
        position_a, mass_a = bodies.load(0, a), bodies.mass(a)
        pointers = orbits.variables(lanes, bodies.load(1, a))
        with bodies.loop(middle, end) as inner:
            b = inner.index
            d = [x - y for x, y in zip(bodies.load(0, b), position_a, strict=True)]
            gap = [x + y for x, y in zip(Q, d, strict=True)]
            e = dot(d, [2.0 * x + y for x, y in zip(Q, d, strict=True)]) * square
            f, _third = encke(orbits, e, dot(gap, gap) * square)
            g = [(f * x - y) * cube for x, y in zip(gap, d, strict=True)]
            bodies.store(1, b, [x + mass_a * y for x, y in zip(bodies.load(1, b), g, strict=True)])
            mass_b = bodies.mass(b)
            for pointer, y in zip(pointers, g, strict=True):
                orbits.keep(orbits.value_of(pointer) - mass_b * y, pointer)
        bodies.store(1, a, [orbits.value_of(pointer) for pointer in pointers])
    add_other_forces(orbits, bodies, pair, middle, Q)
    for begin, limit, share, sign in (
        (first, middle, MASS_SHARE, -1.0),
        (middle, end, SECOND_SHARE, 1.0),
    ):
        fraction = orbits.number(lanes, share, (pair,)) * sign
        with bodies.loop(begin, limit) as outer:
            position = bodies.load(0, outer.index)
            bodies.store(
                0, outer.index, [x + fraction * y for x, y in zip(position, Q, strict=True)]
            )


def add_other_forces(orbits, bodies, pair, middle, Q):
    """Add the accelerations of the bodies of a pair by other forces."""
    builder, lanes = orbits.builder, bodies.lanes

    def gap(source, target):
        is_first_side = builder.icmp_signed("<", source, middle)
        sign = Lane(builder, lanes.spread(builder.select(is_first_side, DOUBLE(1.0), DOUBLE(-1.0))))
        parts = zip(Q, bodies.load(0, target), bodies.load(0, source), strict=True)
        return [(x * sign + (y - z)).lanes[0] for x, y, z in parts]

    def add(body, pull):
        bodies.store(1, body, [x + y for x, y in zip(bodies.load(1, body), pull, strict=True)])

    add_in_frame(orbits, lanes, pair, builder.add(pair, orbits.row(1)), gap, add)


def hierarchy_pass(orbits, lanes):
    """Generate a pass of the hierarchy at eight stages."""
    builder, D = orbits.builder, orbits.D
    bodies, weight = Bodies(orbits, lanes), LaneTuple([orbits.weight(lanes)])
    zeros = [LaneTuple([Lane(builder, ZEROS)])] * D
    orbits.move(lanes, lambda pairs, Q: None)
    with bodies.loop(orbits.row(0), bodies.count) as loop:
        for half in range(2):
            bodies.store(half, loop.index, zeros)
    with bodies.loop(orbits.row(0), orbits.n) as loop:
        add_attraction(orbits, bodies, loop.index)
    with bodies.loop(orbits.row(0), orbits.n) as loop:
        pair = loop.index
        first, middle = (bodies.limit_of(pair, k) for k in (FIRST, MIDDLE))
        first_pull, middle_pull = bodies.load(1, first), bodies.load(1, middle)
        a = [x - y for x, y in zip(middle_pull, first_pull, strict=True)]
        share = orbits.number(lanes, MASS_SHARE, (pair,))
        bodies.store(1, first, [x + share * y for x, y in zip(first_pull, a, strict=True)])
        orbits.pull_back(lanes, (pair,), [weight * x for x in a])


nested_rates = rates_of_orbits(hierarchy_pass)
