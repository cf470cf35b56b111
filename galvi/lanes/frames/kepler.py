"""The frame of Kepler's motions in Jacobi coordinates: its slopes at the stages of a step.

Planets 1 to n in the order of their orbits about the star 0, all masses times G; M_i = m_0 + .. +
m_i. Q_i is the place of planet i relative to the barycentre of all before it, and
Q_i'' = -M_i Q_i / |Q_i|^3 its motion in the frame. From the star, planets are at x_i = Q_i + d_i,
with d_(i+1) = d_i + (m_i / M_i) Q_i; what is left accelerates Q_i by

    M_i [Q_i / |Q_i|^3 - c_i x_i / |x_i|^3] + (M_i / M_(i-1)) p_i
    + sum_(k > i) m_k (p_k + f_k) / M_(i-1)

with c_i = m_0 / M_(i-1), f_k = -m_0 x_k / |x_k|^3, p_k the sum of m_j (x_j - x_k) / |x_j - x_k|^3
over planets j, with what forces beside gravity accelerate planet k by: they keep the momentum, so
that the star's share is known. The bracket is small, and computed without cancellation (Encke):
with e = d.(2 Q + d) / |Q|^2 and f = 1 - (1 + e)^(-3/2) it is [(1 - c) Q + c (f x - d)] / |Q|^3.

Arrays as in `galvi.lanes.frames.kepler_motion`; the blocks of numbers are m, M, m / M, c,
1 - c, M_i / M_(i-1), 1 / M_(i-1) and 1 / M, and the frame's own of work d (D), x (D) and p (D).
"""

from __future__ import annotations

from galvi.kernels.compile.internals import cgutils
from galvi.lanes.celestial import add_in_frame
from galvi.lanes.frames.kepler_motion import (
    BODY_MASS,
    FIRST_MASS,
    KEPT_BLOCKS,
    MASS,
    SHARE,
    dot,
    encke,
    rates_of_orbits,
)
from galvi.lanes.values import Lane, Several
from galvi.lanes.vectors import ZEROS

STAR, ONE_MINUS_C, RATIO, INSIDE = 3, 4, 5, 6  # blocks of numbers


def rows_of_planets(dimension):
    """Rows of work for one planet."""
    return 5 * dimension + KEPT_BLOCKS


def own_block(orbits, k):
    """The first block of d, x or p in the work."""
    return 2 * orbits.D + KEPT_BLOCKS + k * orbits.D


def places_from_star(orbits, lanes):
    """A function (planets, Q) that stores d and the places from the star, for `Orbits.move`."""
    builder, D = orbits.builder, orbits.D
    before = [lanes.variable(ZEROS) for _ in range(D)]

    def follow(planets, Q):
        share, d = orbits.number(lanes, SHARE, planets), []
        for pointer, y in zip(before, Q, strict=True):
            inner = [Lane(builder, builder.load(pointer))]
            for lane, weight in zip(y.lanes, share.lanes, strict=True):
                inner.append(inner[-1] + weight * lane)
            builder.store(inner[-1].value, pointer)
            d.append(Several(inner[:-1]))
        zero = Several(Lane(builder, ZEROS) for _ in planets)
        places = [x + y for x, y in zip(Q, d, strict=True)]
        for k, vector in enumerate((d, places, [zero] * D)):
            orbits.store_vector(
                orbits.work_lanes, vector, orbits.work, own_block(orbits, k), planets
            )

    return follow


def pull(orbits, lanes):
    """Set p from all pairs of planets."""
    builder, row, D = orbits.builder, orbits.row, orbits.D
    place_of, pull_of = own_block(orbits, 1), own_block(orbits, 2)
    with cgutils.for_range(builder, orbits.n, intp=row) as outer:
        i = (outer.index,)
        x_i, mass = (
            orbits.load_vector(orbits.work_lanes, orbits.work, place_of, i),
            orbits.number(lanes, BODY_MASS, i),
        )
        pulled = orbits.variables(
            lanes, orbits.load_vector(orbits.work_lanes, orbits.work, pull_of, i)
        )
        with cgutils.for_range(builder, outer.index, intp=row) as inner:
            j = (inner.index,)
            x_j = orbits.load_vector(orbits.work_lanes, orbits.work, place_of, j)
            gap = [x - y for x, y in zip(x_j, x_i, strict=True)]
            inverse = orbits.root(dot(gap, gap))
            cube = inverse * inverse * inverse
            onto_i, onto_j = orbits.number(lanes, BODY_MASS, j) * cube, mass * cube
            for x in range(D):
                pull_j = orbits.load(orbits.work_lanes, orbits.work, pull_of + x, j)
                changed = pull_j - onto_j * gap[x]
                orbits.store(orbits.work_lanes, changed, orbits.work, pull_of + x, j)
                orbits.keep(orbits.value_of(pulled[x]) + onto_i * gap[x], pulled[x])
        pull_i = [orbits.value_of(x) for x in pulled]
        orbits.store_vector(orbits.work_lanes, pull_i, orbits.work, pull_of, i)


def act(orbits, lanes):
    """Add to p the accelerations of the planets by forces beside gravity."""
    builder, row = orbits.builder, orbits.row

    def load(k, body):
        planet = (builder.sub(body, row(1)),)
        return orbits.load_vector(orbits.work_lanes, orbits.work, own_block(orbits, k), planet)

    def moves(body):
        return builder.icmp_signed(">", body, row(0))

    def place_of(body):
        places = (x.lanes[0].value for x in load(1, body))
        return [Lane(builder, builder.select(moves(body), x, ZEROS)) for x in places]

    def gap(source, target):
        return [x - y for x, y in zip(place_of(target), place_of(source), strict=True)]

    def add(body, pull):
        with builder.if_then(moves(body)):
            p = [x + y for x, y in zip(load(2, body), pull, strict=True)]
            planet = (builder.sub(body, row(1)),)
            orbits.store_vector(orbits.work_lanes, p, orbits.work, own_block(orbits, 2), planet)

    add_in_frame(orbits, lanes, row(0), orbits.n, gap, add)


def finish(orbits, lanes):
    """Perturbing accelerations, pulled back to the centre of the step."""
    builder, D = orbits.builder, orbits.D
    shared = orbits.scalar(lanes, FIRST_MASS), orbits.weight(lanes)
    beyond = [lanes.variable(ZEROS) for _ in range(D)]

    def part(planets):
        star, weight = (Several([lane] * len(planets)) for lane in shared)
        Q, d, x, p = (
            orbits.load_vector(orbits.work_lanes, orbits.work, block, planets)
            for block in (0, *(own_block(orbits, k) for k in range(3)))
        )
        inverse = orbits.load(orbits.work_lanes, orbits.work, 2 * D, planets)
        mu, m, c, one_minus_c, ratio, inside = (
            orbits.number(lanes, k, planets)
            for k in (MASS, BODY_MASS, STAR, ONE_MINUS_C, RATIO, INSIDE)
        )
        square = inverse * inverse
        cube = square * inverse
        e = dot(d, [2.0 * a + b for a, b in zip(Q, d, strict=True)]) * square
        f, third = encke(orbits, e, 1.0 + e)
        pull, fall = mu * cube, star * third * cube
        a = []
        for k, pointer in enumerate(beyond):
            outside = [Lane(builder, builder.load(pointer))]
            pulled = m * (p[k] - fall * x[k])
            for lane in pulled.lanes:
                outside.append(outside[-1] + lane)
            builder.store(outside[-1].value, pointer)
            bracket = pull * (one_minus_c * Q[k] + c * (f * x[k] - d[k]))
            a.append(weight * (bracket + (ratio * p[k] + inside * Several(outside[:-1]))))
        orbits.pull_back(lanes, planets, a)

    orbits.inwards(part)


def planets_alone(orbits, lanes):
    """A pass at eight stages."""
    orbits.move(lanes, places_from_star(orbits, lanes))
    pull(orbits, lanes)
    act(orbits, lanes)
    finish(orbits, lanes)


kepler_rates = rates_of_orbits(planets_alone)
