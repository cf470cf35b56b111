"""Derivatives of a Lagrangian on a group at one stage: dL/dv and, left-trivialised, dL/dg.

g    (r,)  configuration; v (d,) velocity
out  (2, d)  rows dL/dv and the derivative of L along g hat(e_a)

A kernel takes functions of several types; a system fills those it has, as in galvi.kernels.laws.

LAW        a built-in one, (g, v, t, constants, out)
EUCLIDEAN  a user's (q, v) or (q, v, t) -> (d + r,): dL/dv and the Euclidean dL/dq
LEFT       the same with the left-trivialised derivative, (d + d,)
GRADIENT   of a rigid body with inertia in constants: a user's dV/dR of (R) or (R, t)
CANONICAL  L = v.Mv/2 - V on R^d, M by rows in constants: a law of galvi.kernels.laws for dV/dq,
           its numbers after M
CANONICAL_GRADIENT  likewise, dV/dq a user's of (q) or (q, t)

An external force is added to the second row: by the principle of Lagrange and d'Alembert it acts on
a variation along g hat(e_a) as dL/dg does. It is a built-in one, of LAW's type with constants of
its own, or a user's (q, v) or (q, v, t) -> (d,).
"""

from __future__ import annotations

import numpy as np
from numba import types

from galvi.kernels import covectors
from galvi.kernels import laws as fields
from galvi.kernels.accelerations import accelerations
from galvi.kernels.jit import inlined, jit
from galvi.kernels.laws import MATRIX, VECTOR

LAW, EUCLIDEAN, LEFT, GRADIENT, CANONICAL, CANONICAL_GRADIENT = 0, 1, 2, 3, 4, 5
FREE, PUSHED, TIMED_PUSHED, PUSHED_BY_LAW = 0, 1, 2, 3  # which force acts

LAW_TYPE = types.FunctionType(types.void(VECTOR, VECTOR, types.float64, VECTOR, MATRIX))
SLOPES_TYPE = types.FunctionType(VECTOR(VECTOR, VECTOR))
TIMED_SLOPES_TYPE = types.FunctionType(VECTOR(VECTOR, VECTOR, types.float64))
MATRIX_SLOPES_TYPE = types.FunctionType(VECTOR(MATRIX, VECTOR))
TIMED_MATRIX_SLOPES_TYPE = types.FunctionType(VECTOR(MATRIX, VECTOR, types.float64))
GRADIENT_TYPE = types.FunctionType(MATRIX(MATRIX))
TIMED_GRADIENT_TYPE = types.FunctionType(MATRIX(MATRIX, types.float64))


@jit
def no_law(g, v, t, constants, out):
    """Stand-in for a law."""


@jit
def no_slopes(q, v):
    """Stand-in for a user's slopes(q, v), q a vector."""
    return v.copy()


@jit
def no_timed_slopes(q, v, t):
    """Stand-in for a user's slopes(q, v, t), q a vector."""
    return v.copy()


@jit
def no_matrix_slopes(q, v):
    """Stand-in for a user's slopes(q, v), q a matrix."""
    return v.copy()


@jit
def no_timed_matrix_slopes(q, v, t):
    """Stand-in for a user's slopes(q, v, t), q a matrix."""
    return v.copy()


@jit
def no_gradient(R):
    """Stand-in for a user's gradient(R)."""
    return R.copy()


@jit
def no_timed_gradient(R, t):
    """Stand-in for a user's gradient(R, t)."""
    return R.copy()


@jit
def rigid_body(g, v, t, constants, out):
    """L = v.Jv/2 + w . R c.   constants: J by rows (9,), w = mass g (3,), c = centre (3,)."""
    weight, centre = np.empty(3), constants[12:15]
    for i in range(3):
        out[0, i] = 0.0
        weight[i] = 0.0
        for j in range(3):
            out[0, i] += constants[3 * i + j] * v[j]
            weight[i] += g[3 * j + i] * constants[9 + j]
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        out[1, i] = centre[j] * weight[k] - centre[k] * weight[j]


@jit
def free_body(g, v, t, constants, out):
    """L = w.Jw/2 + m |v|^2/2 + m x.a.   constants: J by rows (9,), m, a (3,)."""
    mass = constants[9]
    for i in range(3):
        out[0, i] = 0.0
        out[0, i + 3] = mass * v[i + 3]
        out[1, i] = 0.0
        out[1, i + 3] = 0.0
        for j in range(3):
            out[0, i] += constants[3 * i + j] * v[j]
            out[1, i + 3] += mass * g[4 * j + i] * constants[10 + j]


@jit
def rotation_slopes(gradient, v, constants, layout, g, out):
    """Of a rigid body: J v from constants, and -dV/dR turned into a torque."""
    slope = np.empty(9)
    fits = gradient.shape[0] == 3 and gradient.shape[1] == 3
    for i in range(9):
        slope[i] = -gradient[i // 3, i % 3] if fits else np.nan
    covectors.pull(layout, g, slope, out[1])
    for i in range(3):
        out[0, i] = 0.0
        for j in range(3):
            out[0, i] += constants[3 * i + j] * v[j]


@jit
def spread(values, kind, layout, g, out):
    """out <- what a user's slopes returned; NaN when it has another length."""
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
        covectors.pull(layout, g, values[d:], out[1])


@jit
def canonical(kind, law, gradient, timed_gradient, constants, g, v, t, out):
    """L = v.Mv/2 - V(q, t); kind is that of the force in galvi.kernels.laws."""
    d = v.size
    place, when, pull = np.empty((d, 1)), np.empty(1), np.empty((d, 1))
    when[0] = t
    for i in range(d):
        place[i, 0] = g[i]
    accelerations(kind, law, gradient, timed_gradient, constants[d * d :], np.empty((0, 0)), place,
                  when, pull)  # fmt: skip
    for i in range(d):
        out[0, i], out[1, i] = 0.0, -pull[i, 0]
        for j in range(d):
            out[0, i] += constants[d * i + j] * v[j]


@jit
def push(forces, constants, pushed, side, g, v, t, out):
    """out[1] <- out[1] + the external force; NaN when a user's function has another length."""
    _, law, plain, timed_plain, matrix, timed_matrix = forces
    d, timed = v.size, pushed == TIMED_PUSHED
    if pushed == PUSHED_BY_LAW:
        law(g, v, t, constants, out)
        return
    if side == 0:
        force = timed_plain(g.copy(), v.copy(), t) if timed else plain(g.copy(), v.copy())
    else:
        q = g.copy().reshape((side, side))
        force = timed_matrix(q, v.copy(), t) if timed else matrix(q, v.copy())
    for i in range(d):
        out[1, i] += force[i] if force.size == d else np.nan


@inlined
def slopes(functions, kind, timed, side, constants, pushed, push_constants, layout, g, v, t, out):
    """out (2, d) at one configuration; side = 0 when the user takes a vector, else its rows."""
    lagrangian, fields_, forces = functions
    if kind == LAW:
        lagrangian[1](g, v, t, constants, out)
    else:
        own_slopes(lagrangian, fields_, kind, timed, side, constants, layout, g, v, t, out)
    if pushed > 0:
        push(forces, push_constants, pushed, side, g, v, t, out)


@jit
def own_slopes(functions, fields_, kind, timed, side, constants, layout, g, v, t, out):
    """As ``slopes``, of the Lagrangian alone."""
    _, law, plain, timed_plain, matrix, timed_matrix, gradient, timed_gradient = functions
    if kind >= CANONICAL:
        _, field_law, field_gradient, timed_field_gradient = fields_
        of_field = fields.BUILT_IN if kind == CANONICAL else fields.GRADIENT
        canonical(fields.TIMED_GRADIENT if timed else of_field, field_law, field_gradient,
                  timed_field_gradient, constants, g, v, t, out)  # fmt: skip
    elif kind == LAW:
        law(g, v, t, constants, out)
    elif kind == GRADIENT:
        R = g.copy().reshape((3, 3))
        if timed:
            rotation_slopes(timed_gradient(R, t), v, constants, layout, g, out)
        else:
            rotation_slopes(gradient(R), v, constants, layout, g, out)
    elif side == 0:
        if timed:
            spread(timed_plain(g.copy(), v.copy(), t), kind, layout, g, out)
        else:
            spread(plain(g.copy(), v.copy()), kind, layout, g, out)
    else:
        q = g.copy().reshape((side, side))
        if timed:
            spread(timed_matrix(q, v.copy(), t), kind, layout, g, out)
        else:
            spread(matrix(q, v.copy()), kind, layout, g, out)
