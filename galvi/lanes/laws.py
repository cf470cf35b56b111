"""Built-in laws of motion, made of the functions of galvi.kernels.forces.

For laws see galvi.lanes.elementary, and on groups galvi.lanes.group_collocation. The constants are
those of the functions.
"""

from __future__ import annotations

from galvi.kernels.forces.lagrangian_derivatives import free_body_slopes, rigid_body_slopes
from galvi.kernels.forces.planar_chain import planar_chain_slopes
from galvi.lanes import elementary


def returning_slopes(slopes):
    """A function (q, t, constants) that returns dV/dq, from one of galvi.kernels.forces.potentials
    that writes it into its last argument."""

    def law(q, t, c):
        out = [0.0] * len(q)
        slopes(q, c, out)
        return out

    return law


def planar_chain(n):
    """The law of galvi.kernels.forces.planar_chain for n links."""

    def law(q, v, t, c):
        sines, cosines, momenta, forces = ([0.0] * n for _ in range(4))
        mass = [[0.0] * (i + 1) for i in range(n)]
        planar_chain_slopes(q, v, c, sines, cosines, momenta, forces, mass)
        return forces, momenta, mass

    return law


def body(d, has_torque):
    """The law of a rigid body, d = 3, or of a free one, d = 6, with the constants of
    galvi.kernels.forces.lagrangian_derivatives; without ``has_torque`` the forces are 0."""
    slopes = rigid_body_slopes if d == 3 else free_body_slopes

    def law(g, v, t, c):
        momenta, forces = [0.0] * d, [0.0] * d
        slopes(g, v, c, momenta, forces)
        mass = [[c[3 * i + j] for j in range(i + 1)] for i in range(3)]
        mass += [[0.0] * i + [c[9]] for i in range(3, d)]
        return forces if has_torque else [0.0] * d, momenta, mass

    return law


def canonical(slopes, d, diagonal):
    """The law of L = v.Mv/2 - V. Constants: M by rows, then those of V.

    Parameters
    ----------
    slopes
        (q, t, constants) -> dV/dq
    diagonal
        whether M is diagonal
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

    Constants: M^-1, by rows if ``coupled`` and else its diagonal, then those of V and of the force.

    Parameters
    ----------
    slopes
        (q, t, constants) -> dV/dq
    force
        (q, v, t, constants) -> d values; None without an external force
    forced_from
        index of the first constant of the force
    """
    first = d * d if coupled else d

    def law(q, v, t, c):
        pulls = [-x for x in slopes(q, t, From(c, first))]
        if force is not None:
            external_forces = force(q, v, t, From(c, forced_from))
            pulls = [f + x for f, x in zip(pulls, external_forces, strict=True)]
        return times_mass(pulls, d, coupled, c), list(v), unit_mass(d)

    return law


def times_mass(x, d, coupled, c):
    """The product of x with the matrix in the first constants: by rows if ``coupled``, else its
    diagonal."""
    if not coupled:
        return [c[i] * x[i] for i in range(d)]
    products = []
    for i in range(d):
        total = c[i * d] * x[0]
        for j in range(1, d):
            total = total + c[i * d + j] * x[j]
        products.append(total)
    return products


def unit_mass(d):
    """The rows of the unit matrix up to its diagonal."""
    return [[0.0] * i + [1.0] for i in range(d)]


def point_masses(bodies, dimension):
    """The law of bodies that attract each other, with v as momenta; constants: G m of each.

    q and v are the coordinates of the first body, then those of the others.
    """

    def law(q, v, t, c):
        positions = [q[dimension * i : dimension * (i + 1)] for i in range(bodies)]
        accelerations = [[0.0] * dimension for _ in range(bodies)]
        for i in range(bodies):
            for j in range(i):
                gap = [x - y for x, y in zip(positions[j], positions[i], strict=True)]
                square = gap[0] * gap[0]
                for x in gap[1:]:
                    square = square + x * x
                pull = elementary.over_cube(1.0, square)
                onto_i, onto_j = c[j] * pull, c[i] * pull
                for k, x in enumerate(gap):
                    accelerations[i][k] = onto_i * x + accelerations[i][k]
                    accelerations[j][k] = accelerations[j][k] - onto_j * x
        return [a for body in accelerations for a in body], list(v), unit_mass(bodies * dimension)

    return law


def forced(law, force, first):
    """The law with an external force (q, v, t, constants) -> d values.

    Parameters
    ----------
    first
        number of constants of the law, after which those of the force follow
    """

    def forced_law(q, v, t, c):
        forces, momenta, mass = law(q, v, t, c)
        external_forces = force(q, v, t, From(c, first))
        return [f + x for f, x in zip(forces, external_forces, strict=True)], momenta, mass

    return forced_law


class From:
    """The constants from index ``first`` on."""

    def __init__(self, constants, first):
        self.constants, self.first = constants, first

    def __getitem__(self, k):
        return self.constants[self.first + k]
