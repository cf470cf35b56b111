"""Slopes dV/dq of built-in potentials, as functions (q, t, constants) -> d values.

Written in galvi.fast.lanes.elementary, for lanes, numbers and arrays alike; V and its constants
are those of the file of the same name in galvi.kernels.forces.
"""

from __future__ import annotations

from galvi.fast.lanes.elementary import over_cube, sin


def central_force(q, t, c):
    """mu q / |q|^3."""
    square = q[0] * q[0]
    for x in q[1:]:
        square = square + x * x
    pull = over_cube(c[0], square)
    return [pull * x for x in q]


def linear_spring(q, t, c):
    """stiffness q."""
    return [c[0] * x for x in q]


def pendulum(q, t, c):
    """weight sin(q)."""
    return [c[0] * sin(x) for x in q]


def spring_chain(q, t, c):
    """Differences of the springs' forces r (1 + r (alpha + r beta))."""
    springs = [q[0], *(q[i] - q[i - 1] for i in range(1, len(q))), -q[-1]]
    forces = [r * (1.0 + r * (c[0] + r * c[1])) for r in springs]
    return [forces[i] - forces[i + 1] for i in range(len(q))]


def uniform_field(q, t, c):
    """The opposite of the force."""
    return [-c[i] for i in range(len(q))]
