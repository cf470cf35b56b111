"""Derivatives of a Lagrangian on a group at one stage: dL/dv and, left-trivialised, dL/dg.

g    (r,)  configuration; v (d,) velocity
out  (2, d)  rows dL/dv and the derivative of L along g hat(e_a)

A system has two functions: one for the Lagrangian, of one of these kinds, and its external force:

LAW        a built-in law (g, v, t, constants, out)
EUCLIDEAN  a user's (q, v) or (q, v, t) -> (d + r,): dL/dv and the Euclidean dL/dq
LEFT       a user's (q, v) or (q, v, t) -> (d + d,): dL/dv and the left-trivialised derivative
BODY_GRADIENT   for a rigid body with inertia in constants: a user's dV/dR of (R) or (R, t)
CANONICAL  L = v.Mv/2 - V on R^d, M by rows in constants: a law of galvi.kernels.forces.force_kinds
           for dV/dq, whose constants follow M
CANONICAL_GRADIENT  the same with a user's dV/dq of (q) or (q, t)

The external force is added to the second row: by the Lagrange-d'Alembert principle it acts on a
variation along g hat(e_a) as dL/dg does. It is built in, with the type of LAW and constants of its
own, or a user's (q, v) or (q, v, t) -> (d,).
"""

from __future__ import annotations

from functools import cache
from typing import Any, NamedTuple

import numpy as np
from numba import types

from galvi.kernels.compile.function_pointers import call_matrix, call_vector, call_void
from galvi.kernels.compile.jit import MATRIX, REAL, VECTOR, jit, jit_inline
from galvi.kernels.forces import force_kinds as fields
from galvi.kernels.forces.accelerations import accelerations
from galvi.kernels.lie import product
from galvi.kernels.lie.arithmetic import cross, generic
from galvi.kernels.lie.groups.so3 import columns, fill
from galvi.kernels.lie.rotations import times

LAW, EUCLIDEAN, LEFT, BODY_GRADIENT, CANONICAL, CANONICAL_GRADIENT = 0, 1, 2, 3, 4, 5
NO_FORCE, FORCE, TIMED_FORCE, FORCE_LAW = 0, 1, 2, 3  # kinds of external force


class Law(NamedTuple):
    """A Lagrangian and an external force.

    Attributes
    ----------
    functions : array, shape (2,)
        addresses of the functions of the Lagrangian and of the force
    kind
        kind of the Lagrangian, as above
    time_dependent
        whether a user's function takes the time
    matrix_rows
        rows of the matrix that a user's functions take; 0 for a vector
    constants : array, shape (c,)
        constants of the Lagrangian
    force_kind
        kind of external force
    force_constants : array, shape (c,)
        constants of a force of kind FORCE_LAW
    """

    functions: Any
    kind: int
    time_dependent: bool
    matrix_rows: int
    constants: Any
    force_kind: int
    force_constants: Any


LAW_TUPLE = types.Tuple(
    (types.int64[::1], types.int64, types.boolean, types.int64, VECTOR, types.int64, VECTOR)
)
LAW_TYPE = types.void(VECTOR, VECTOR, REAL, VECTOR, MATRIX)


@cache
def signature(kind, time_dependent, matrix_rows):
    """Signature of the Lagrangian's function; matrix_rows as in `Law`."""
    if kind == LAW:
        return LAW_TYPE
    if kind == BODY_GRADIENT:
        return MATRIX(MATRIX, REAL) if time_dependent else MATRIX(MATRIX)
    if kind >= CANONICAL:
        return fields.SIGNATURES[gradient_kind(kind, time_dependent)][0]
    return force_signature(TIMED_FORCE if time_dependent else FORCE, matrix_rows)


@cache
def force_signature(force_kind, matrix_rows):
    """Signature of the external force."""
    element_type = MATRIX if matrix_rows else VECTOR
    if force_kind == FORCE_LAW:
        return LAW_TYPE
    return (
        VECTOR(element_type, VECTOR, REAL)
        if force_kind == TIMED_FORCE
        else VECTOR(element_type, VECTOR)
    )


@jit
def gradient_kind(kind, time_dependent):
    """Kind of a canonical system's dV/dq in galvi.kernels.forces.force_kinds."""
    if kind == CANONICAL:
        return fields.BUILT_IN
    return fields.TIMED_GRADIENT if time_dependent else fields.GRADIENT


@generic
def symmetric(c):
    """The rows of the symmetric matrix (3, 3), by rows in c[:9]."""
    return (c[0], c[3], c[6]), (c[3], c[4], c[7]), (c[6], c[7], c[8])


@generic
def rigid_body_slopes(g, v, c, momenta, forces):
    """momenta and forces <- the slopes of L = v.Jv/2 + w . R c.

    Constants: J by rows (9,), w = mass g (3,), c = centre of mass (3,).
    """
    weight = times(columns(g, 3), (c[9], c[10], c[11]))
    fill(times(symmetric(c), v), momenta)
    fill(cross((c[12], c[13], c[14]), weight), forces)


@generic
def free_body_slopes(g, v, c, momenta, forces):
    """momenta and forces <- the slopes of L = w.Jw/2 + m |v|^2/2 + m x.a.

    Constants: J by rows (9,), m, a (3,).
    """
    gravity = times(columns(g, 4), (c[10], c[11], c[12]))
    fill(times(symmetric(c), v), momenta)
    for i in range(3):
        momenta[3 + i] = c[9] * v[3 + i]
        forces[i], forces[3 + i] = 0.0, c[9] * gravity[i]


@jit
def rigid_body(g, v, t, constants, out):
    """out <- the slopes of a rigid body."""
    rigid_body_slopes(g, v, constants, out[0], out[1])


@jit
def free_body(g, v, t, constants, out):
    """out <- the slopes of a free body."""
    free_body_slopes(g, v, constants, out[0], out[1])


@jit
def rotation_slopes(gradient, v, constants, layout, g, out):
    """out <- J v, with J from constants, and the torque of -dV/dR; NaN if ``gradient``, dV/dR, is
    not (3, 3)."""
    slope = np.empty(9)
    fits = gradient.shape[0] == 3 and gradient.shape[1] == 3
    for i in range(9):
        slope[i] = -gradient[i // 3, i % 3] if fits else np.nan
    product.left_derivative(layout, g, slope, out[1])
    fill(times(symmetric(constants), v), out[0])


@jit
def enter_slopes(values, kind, layout, g, out):
    """out <- the values of a user's slopes; NaN if they have another length than expected."""
    d = out.shape[1]
    size = d + (d if kind == LEFT else g.size)
    if values.size != size:
        for i in range(d):
            out[0, i] = out[1, i] = np.nan
        return
    for i in range(d):
        out[0, i] = values[i]
    if kind == LEFT:
        for i in range(d):
            out[1, i] = values[d + i]
    else:
        product.left_derivative(layout, g, values[d:], out[1])


@jit
def canonical(kind, functions, constants, g, v, t, out):
    """out <- the slopes of L = v.Mv/2 - V(q, t); kind as in galvi.kernels.forces.force_kinds."""
    d = v.size
    Q, time, pull = np.empty((d, 1)), np.empty(1), np.empty((d, 1))
    time[0] = t
    for i in range(d):
        Q[i, 0] = g[i]
    accelerations(kind, functions, constants[d * d :], np.empty((0, 0)), Q, time, pull)
    for i in range(d):
        out[0, i], out[1, i] = 0.0, -pull[i, 0]
        for j in range(d):
            out[0, i] += constants[d * i + j] * v[j]


@jit
def external_force(law, g, v, t, out):
    """out[1] <- out[1] + the external force."""
    force, takes_time = law.functions[1], law.force_kind == TIMED_FORCE
    if law.force_kind == FORCE_LAW:
        call_void(force, g, v, t, law.force_constants, out)
    elif law.matrix_rows == 0:
        q = g.copy()
        add_force(
            call_vector(force, q, v.copy(), t) if takes_time else call_vector(force, q, v.copy()),
            out,
        )
    else:
        R = g.copy().reshape((law.matrix_rows, law.matrix_rows))
        add_force(
            call_vector(force, R, v.copy(), t) if takes_time else call_vector(force, R, v.copy()),
            out,
        )


@jit
def add_force(values, out):
    """out[1] <- out[1] + values of a user's force; NaN if they are not (d,)."""
    for i in range(out.shape[1]):
        out[1, i] += values[i] if values.size == out.shape[1] else np.nan


@jit_inline
def slopes(law, layout, g, v, t, out):
    """out (2, d) <- dL/dv and the derivative along g hat(e_a) plus the external force.

    Parameters
    ----------
    law
        a ``Law``
    """
    if law.kind == LAW:
        call_void(law.functions[0], g, v, t, law.constants, out)
    else:
        slopes_by_kind(law, layout, g, v, t, out)
    if law.force_kind > 0:
        external_force(law, g, v, t, out)


@jit
def slopes_by_kind(law, layout, g, v, t, out):
    """`slopes` without the external force, for a Lagrangian of a kind other than LAW."""
    functions, kind, time_dependent, matrix_rows, constants, _, _ = law
    if kind >= CANONICAL:
        canonical(gradient_kind(kind, time_dependent), functions, constants, g, v, t, out)
    elif kind == BODY_GRADIENT:
        R = g.copy().reshape((3, 3))
        if time_dependent:
            rotation_slopes(call_matrix(functions[0], R, t), v, constants, layout, g, out)
        else:
            rotation_slopes(call_matrix(functions[0], R), v, constants, layout, g, out)
    elif matrix_rows == 0:
        q = g.copy()
        if time_dependent:
            enter_slopes(call_vector(functions[0], q, v.copy(), t), kind, layout, g, out)
        else:
            enter_slopes(call_vector(functions[0], q, v.copy()), kind, layout, g, out)
    else:
        R = g.copy().reshape((matrix_rows, matrix_rows))
        if time_dependent:
            enter_slopes(call_vector(functions[0], R, v.copy(), t), kind, layout, g, out)
        else:
            enter_slopes(call_vector(functions[0], R, v.copy()), kind, layout, g, out)
