"""The frame of Kepler's motions in Jacobi coordinates: its slopes at the stages of a step.

Planets are numbered 1 to n in the order of their orbits about the star, 0. All masses are
multiplied by G, and M_i = m_0 + .. + m_i. Q_i is the position of planet i relative to the
barycentre of all bodies before it, and Q_i'' = -M_i Q_i / |Q_i|^3 its motion in the frame. From the
star, planets are at x_i = Q_i + d_i, with d_(i+1) = d_i + (m_i / M_i) Q_i; Q_i is accelerated in
the frame by

    M_i [Q_i / |Q_i|^3 - c_i x_i / |x_i|^3] + (M_i / M_(i-1)) p_i
    + sum_(k > i) m_k (p_k + f_k) / M_(i-1)

with d_1 = 0, c_i = m_0 / M_(i-1), f_k = -m_0 x_k / |x_k|^3, and p_k the sum of m_j (x_j - x_k) /
|x_j - x_k|^3 over planets j != k plus the acceleration of planet k by other forces. All forces
conserve the momentum, so that the acceleration of the star follows and is not stored. The bracket
is small, and computed without cancellation (Encke): with e = d.(2 Q + d) / |Q|^2 and f = 1 -
(1 + e)^(-3/2) it is [(1 - c) Q + c (f x - d)] / |Q|^3.

Arrays as in `galvi.lanes.frames.kepler_motion`. The blocks of numbers are m, M, m / M, c, 1 - c,
M_i / M_(i-1), 1 / M_(i-1) and 1 / M; the last blocks of work are d (D), x (D) and p (D).
"""

from __future__ import annotations

from galvi.kernels.compile.internals import cgutils
from galvi.lanes.celestial import add_in_frame
from galvi.lanes.frames.kepler_motion import (
    BODY_MASS,
    FIRST_MASS,
    MASS,
    MASS_SHARE,
    STORED_BLOCKS,
    dot,
    encke,
    rates_of_orbits,
)
from galvi.lanes.values import Lane, LaneTuple
from galvi.lanes.vectors import ZEROS

OF_D, OF_X, OF_P = 0, 1, 2  # order of d, x and p in the work, see frame_block
STAR_SHARE, ONE_MINUS_C, MASS_RATIO, INVERSE_INNER_MASS = 3, 4, 5, 6  # blocks of numbers


def work_rows_per_planet(dimension):
    """Rows of work for each planet: Q and Q', STORED_BLOCKS, and d, x and p."""
    return 5 * dimension + STORED_BLOCKS


def frame_block(orbits, k):
    """The first block of work for d, x or p: k = OF_D, OF_X or OF_P."""
    return 2 * orbits.D + STORED_BLOCKS + k * orbits.D


def positions_from_star(orbits, lanes):
    """A function (planets, Q) for `Orbits.move` that stores d, x and p = 0.

    It has to be called outwards, since d sums over the planets inside.
    """
    builder, D = orbits.builder, orbits.D
    inner_sums = [lanes.variable(ZEROS) for _ in range(D)]

    def store_positions(planets, Q):
        share, d = orbits.number(lanes, MASS_SHARE, planets), []
        for pointer, y in zip(inner_sums, Q, strict=True):
            inner = [Lane(builder, builder.load(pointer))]
            for lane, weight in zip(y.lanes, share.lanes, strict=True):
                inner.append(inner[-1] + weight * lane)
            builder.store(inner[-1].value, pointer)
            d.append(LaneTuple(inner[:-1]))
        zero = LaneTuple(Lane(builder, ZEROS) for _ in planets)
        positions = [x + y for x, y in zip(Q, d, strict=True)]
        for k, vector in zip((OF_D, OF_X, OF_P), (d, positions, [zero] * D), strict=True):
            orbits.store_vector(
                orbits.work_lanes, vector, orbits.work, frame_block(orbits, k), planets
            )

    return store_positions


def add_planet_attraction(orbits, lanes):
    """Add to p the attraction of all pairs of planets."""
    builder, row, D = orbits.builder, orbits.row, orbits.D
    position_block, p_block = frame_block(orbits, OF_X), frame_block(orbits, OF_P)
    with cgutils.for_range(builder, orbits.n, intp=row) as outer:
        i = (outer.index,)
        x_i, mass = (
            orbits.load_vector(orbits.work_lanes, orbits.work, position_block, i),
            orbits.number(lanes, BODY_MASS, i),
        )
        p_pointers = orbits.variables(
            lanes, orbits.load_vector(orbits.work_lanes, orbits.work, p_block, i)
        )
        with cgutils.for_range(builder, outer.index, intp=row) as inner:
            j = (inner.index,)
            x_j = orbits.load_vector(orbits.work_lanes, orbits.work, position_block, j)
            gap = [x - y for x, y in zip(x_j, x_i, strict=True)]
            inverse = orbits.root(dot(gap, gap))
            cube = inverse * inverse * inverse
            onto_i, onto_j = orbits.number(lanes, BODY_MASS, j) * cube, mass * cube
            for axis in range(D):
                p_j = orbits.load(orbits.work_lanes, orbits.work, p_block + axis, j)
                new_p = p_j - onto_j * gap[axis]
                orbits.store(orbits.work_lanes, new_p, orbits.work, p_block + axis, j)
                new_p_i = orbits.value_of(p_pointers[axis]) + onto_i * gap[axis]
                orbits.keep(new_p_i, p_pointers[axis])
        p_i = [orbits.value_of(pointer) for pointer in p_pointers]
        orbits.store_vector(orbits.work_lanes, p_i, orbits.work, p_block, i)


def add_other_forces(orbits, lanes):
    """Add to p the accelerations of the planets by other forces."""
    builder, row = orbits.builder, orbits.row

    def load(k, body):
        planet = (builder.sub(body, row(1)),)
        return orbits.load_vector(orbits.work_lanes, orbits.work, frame_block(orbits, k), planet)

    def is_planet(body):
        return builder.icmp_signed(">", body, row(0))

    def position_of(body):  # for the star, the row before the first is loaded and not selected
        positions = (x.lanes[0].value for x in load(OF_X, body))
        return [Lane(builder, builder.select(is_planet(body), x, ZEROS)) for x in positions]

    def gap(source, target):
        return [x - y for x, y in zip(position_of(target), position_of(source), strict=True)]

    def add(body, acceleration):  # that of the star follows from the momentum
        with builder.if_then(is_planet(body)):
            p = [x + y for x, y in zip(load(OF_P, body), acceleration, strict=True)]
            planet = (builder.sub(body, row(1)),)
            orbits.store_vector(
                orbits.work_lanes, p, orbits.work, frame_block(orbits, OF_P), planet
            )

    add_in_frame(orbits, lanes, row(0), orbits.n, gap, add)


def store_slopes(orbits, lanes):
    """Store the slopes: accelerations in the frame times the stages' weights, pulled back to the
    centre of the step. Planets are taken inwards, since sums are over those outside."""
    builder, D = orbits.builder, orbits.D
    shared = orbits.scalar(lanes, FIRST_MASS), orbits.weight(lanes)
    outer_sums = [lanes.variable(ZEROS) for _ in range(D)]

    def part(planets):
        star, weight = (LaneTuple([lane] * len(planets)) for lane in shared)
        Q, d, x, p = (
            orbits.load_vector(orbits.work_lanes, orbits.work, block, planets)
            for block in (0, *(frame_block(orbits, k) for k in (OF_D, OF_X, OF_P)))
        )
        inverse = orbits.load(orbits.work_lanes, orbits.work, 2 * D, planets)  # 1 / |Q|
        mu, m, c, one_minus_c, ratio, inverse_inner_mass = (
            orbits.number(lanes, k, planets)
            for k in (MASS, BODY_MASS, STAR_SHARE, ONE_MINUS_C, MASS_RATIO, INVERSE_INNER_MASS)
        )
        square = inverse * inverse
        cube = square * inverse
        e = dot(d, [2.0 * a + b for a, b in zip(Q, d, strict=True)]) * square
        f, cubed_ratio = encke(orbits, e, 1.0 + e)  # cubed_ratio: |Q|^3 / |x|^3
        mu_over_cube, star_over_cube = mu * cube, star * cubed_ratio * cube
        a = []
        for k, pointer in enumerate(outer_sums):
            sums_outside = [Lane(builder, builder.load(pointer))]
            mass_times_acceleration = m * (p[k] - star_over_cube * x[k])
            for lane in mass_times_acceleration.lanes:
                sums_outside.append(sums_outside[-1] + lane)
            builder.store(sums_outside[-1].value, pointer)
            encke_term = mu_over_cube * (one_minus_c * Q[k] + c * (f * x[k] - d[k]))
            a.append(
                weight
                * (encke_term + (ratio * p[k] + inverse_inner_mass * LaneTuple(sums_outside[:-1])))
            )
        orbits.pull_back(lanes, planets, a)

    orbits.inwards(part)


def planets_pass(orbits, lanes):
    """Generate a pass of the star and its planets at eight stages."""
    orbits.move(lanes, positions_from_star(orbits, lanes))
    add_planet_attraction(orbits, lanes)
    add_other_forces(orbits, lanes)
    store_slopes(orbits, lanes)


kepler_rates = rates_of_orbits(planets_pass)
