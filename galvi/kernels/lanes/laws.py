"""Built-in laws of motion, see galvi.kernels.lanes.elementary and galvi.kernels.lanes.group_pass."""

from __future__ import annotations

from galvi.kernels.lanes.elementary import sine_cosine
from galvi.kernels.lie.arithmetic import cross, dot


def planar_chain(n):
    """The law of galvi.kernels.forces.planar_chain for n links, with its constants."""

    def law(q, v, t, c):
        seen = [sine_cosine(x) for x in q]
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


def _symmetric(c):
    """The rows, and those up to the diagonal, of a matrix whose entries c begins with."""
    J = [[c[3 * i + j] for j in range(3)] for i in range(3)]
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
