"""Built-in laws of motion, forces, and slopes dV/dq of potentials, (q, t, constants) -> d values.

See galvi.lanes.elementary, and for laws on groups galvi.lanes.group_collocation; constants are
those of galvi.kernels.forces.
"""

from __future__ import annotations

from galvi.kernels.forces.celestial_velocity import LEAST_SQUARE
from galvi.kernels.forces.rotor_wind import (
    CORE,
    DESCENT,
    HIGH,
    INERTIAL_DRAG,
    INERTIAL_DRAG_POWER,
    LOW,
    SHARES,
    STRENGTH,
    R,
)
from galvi.kernels.lie.arithmetic import cross, dot
from galvi.lanes import elementary


def central_force(q, t, c):
    """mu q / |q|^3."""
    square = q[0] * q[0]
    for x in q[1:]:
        square = square + x * x
    pull = elementary.over_cube(c[0], square)
    return [pull * x for x in q]


def linear_spring(q, t, c):
    """stiffness q."""
    return [c[0] * x for x in q]


def pendulum(q, t, c):
    """weight sin(q)."""
    return [c[0] * elementary.sin(x) for x in q]


def spring_chain(q, t, c):
    """Differences of the springs' forces r (1 + r (alpha + r beta))."""
    springs = [q[0], *(q[i] - q[i - 1] for i in range(1, len(q))), -q[-1]]
    forces = [r * (1.0 + r * (c[0] + r * c[1])) for r in springs]
    return [forces[i] - forces[i + 1] for i in range(len(q))]


def uniform_field(q, t, c):
    """The opposite of the force."""
    return [-c[i] for i in range(len(q))]


def planar_chain(n):
    """The law of galvi.kernels.forces.planar_chain for n links, with its constants."""

    def law(q, v, t, c):
        seen = [elementary.sine_cosine(x) for x in q]
        forces, momenta, mass = [], [], []
        aligned = [[0.0] * n for _ in range(n)]
        crossed = [[0.0] * n for _ in range(n)]
        for i in range(n):
            aligned[i][i] = c[n * i + i]
            for j in range(i):
                A = c[n * i + j]
                (si, ci), (sj, cj) = seen[i], seen[j]
                aligned[i][j] = aligned[j][i] = A * (ci * cj + si * sj)
                crossed[i][j] = A * (si * cj - ci * sj)
                crossed[j][i] = -crossed[i][j]
        for i in range(n):
            momentum, across = aligned[i][i] * v[i], 0.0
            for j in range(n):
                if j != i:
                    momentum = momentum + aligned[i][j] * v[j]
                    across = across + crossed[i][j] * v[j]
            momenta.append(momentum)
            forces.append(-(v[i] * across) - c[n * n + i] * seen[i][0])
            mass.append(aligned[i][: i + 1])
        return forces, momenta, mass

    return law


def canonical(slopes, d, diagonal):
    """The law of L = v.Mv/2 - V. Constants: M by rows, then those of V.

    slopes    dV/dq, as above
    diagonal  whether M is diagonal
    """

    def law(q, v, t, c):
        forces = [-x for x in slopes(q, t, From(c, d * d))]
        if diagonal:
            mass = [[0.0] * i + [c[d * i + i]] for i in range(d)]
            return forces, [mass[i][i] * v[i] for i in range(d)], mass
        momenta = times_mass(v, d, True, c)
        return forces, momenta, [[c[d * i + j] for j in range(i + 1)] for i in range(d)]

    return law


def of_unit_mass(slopes, force, d, coupled, forced_from):
    """The law of a canonical system in velocities: M^-1 times its forces, v and the unit mass.

    Constants: M^-1, diagonal unless ``coupled``, then those of V and those of the force.

    slopes       dV/dq, as above
    force        (q, v, t, constants) -> d values; None without one
    forced_from  number of the first constant of the force
    """
    first = d * d if coupled else d

    def law(q, v, t, c):
        pulls = [-x for x in slopes(q, t, From(c, first))]
        if force is not None:
            added = force(q, v, t, From(c, forced_from))
            pulls = [f + x for f, x in zip(pulls, added, strict=True)]
        return times_mass(pulls, d, coupled, c), list(v), unit_mass(d)

    return law


def times_mass(x, d, coupled, c):
    """M x, with M the first constants, or its inverse; diagonal unless ``coupled``."""
    if not coupled:
        return [c[i] * x[i] for i in range(d)]
    found = []
    for i in range(d):
        total = c[i * d] * x[0]
        for j in range(1, d):
            total = total + c[i * d + j] * x[j]
        found.append(total)
    return found


def unit_mass(d):
    """The rows of the unit matrix up to its diagonal."""
    return [[0.0] * i + [1.0] for i in range(d)]


def point_masses(bodies, dimension):
    """The law of bodies that attract each other, in velocities; constants: G m of each.

    q and v are the coordinates of the first body, then those of the others.
    """

    def law(q, v, t, c):
        places = [q[dimension * i : dimension * (i + 1)] for i in range(bodies)]
        found = [[0.0] * dimension for _ in range(bodies)]
        for i in range(bodies):
            for j in range(i):
                gap = [x - y for x, y in zip(places[j], places[i], strict=True)]
                square = gap[0] * gap[0]
                for x in gap[1:]:
                    square = square + x * x
                pull = elementary.over_cube(1.0, square)
                onto_i, onto_j = c[j] * pull, c[i] * pull
                for k, x in enumerate(gap):
                    found[i][k] = onto_i * x + found[i][k]
                    found[j][k] = found[j][k] - onto_j * x
        return [a for body in found for a in body], list(v), unit_mass(bodies * dimension)

    return law


def forced(law, force, first):
    """The law with an external force (q, v, t, constants) -> d values.

    first  number of the law's constants, which those of the force follow
    """

    def whole(q, v, t, c):
        forces, momenta, mass = law(q, v, t, c)
        added = force(q, v, t, From(c, first))
        return [f + x for f, x in zip(forces, added, strict=True)], momenta, mass

    return whole


class From:
    """Constants from a first one on."""

    def __init__(self, constants, first):
        self.constants, self.first = constants, first

    def __getitem__(self, k):
        return self.constants[self.first + k]


def rotor_wind(q, decay):
    """The wind of galvi.kernels.forces.rotor_wind.

    decay  exp(-t / DESCENT)
    """
    square = q[0] * q[0] + q[1] * q[1]
    height = LOW + (HIGH - LOW) * decay
    outwards, upwards = 0.0, 0.0
    for share in SHARES:
        for sign in (1.0, -1.0):  # a ring and its image
            zeta = q[2] - sign * share * height
            P = square + (R * R + CORE * CORE) + zeta * zeta
            scale = sign * elementary.inverse_quarters(P * P - 4.0 * R * R * square, 7)
            outwards = outwards + P * zeta * scale
            upwards = upwards + (P * (2.0 * P - 3.0 * square) - 2.0 * R * R * square) * scale
    outwards = 3.0 * STRENGTH * outwards
    return outwards * q[0], outwards * q[1], STRENGTH * upwards


def quadratic(square, c):
    """k |w|, and its change by |w| times |w|, from |w|^2.   constants [k]"""
    rate = c[0] * elementary.sqrt(square)
    return rate, rate


def schiller_naumann(square, c):
    """k (1 + 0.15 Re^0.687), Re = s |w|, as above.   constants [k, s]"""
    squared = c[1] * c[1] * square + LEAST_SQUARE
    inertial = c[0] * (
        INERTIAL_DRAG * elementary.exp(elementary.log(squared) * (0.5 * INERTIAL_DRAG_POWER))
    )
    return c[0] + inertial, INERTIAL_DRAG_POWER * inertial


def _in_rotor_wind(drag):
    """The force -rate w, w = v - wind, with the rate of a drag law."""

    def force(q, v, t, c):
        wind = rotor_wind(q, elementary.exp(t * (-1.0 / DESCENT)))
        w = [x - u for x, u in zip(v, wind, strict=True)]
        rate = -drag(w[0] * w[0] + w[1] * w[1] + w[2] * w[2], c)[0]
        return [rate * x for x in w]

    return force


quadratic_drag = _in_rotor_wind(quadratic)
schiller_naumann_drag = _in_rotor_wind(schiller_naumann)


def _symmetric(c):
    """The rows, and those up to the diagonal, of a matrix whose entries c begins with."""
    J = [[c[3 * max(i, j) + min(i, j)] for j in range(3)] for i in range(3)]
    return J, [J[i][: i + 1] for i in range(3)]


def _in_body(g, row, w):
    """A vector of space in the frame of a rotation whose rows are ``row`` entries apart."""
    return [dot((g[i], g[row + i], g[2 * row + i]), w) for i in range(3)]


def rigid_body(heavy):
    """The law of galvi.kernels.forces.lagrangian_derivatives.rigid_body, with its constants."""

    def law(g, v, t, c):
        J, mass = _symmetric(c)
        torque = [0.0, 0.0, 0.0]
        if heavy:
            torque = [*cross((c[12], c[13], c[14]), _in_body(g, 3, (c[9], c[10], c[11])))]
        return torque, [dot(row, v) for row in J], mass

    return law


def free_body(heavy):
    """The law of galvi.kernels.forces.lagrangian_derivatives.free_body, with its constants."""

    def law(g, v, t, c):
        J, mass = _symmetric(c)
        force = [0.0] * 6
        if heavy:
            force[3:] = [c[9] * a for a in _in_body(g, 4, (c[10], c[11], c[12]))]
        momenta = [dot(row, v) for row in J] + [c[9] * v[3 + i] for i in range(3)]
        return force, momenta, mass + [[0.0] * (3 + i) + [c[9]] for i in range(3)]

    return law
