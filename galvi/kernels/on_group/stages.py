"""One step on a group: the residual of its stage equations.

The curve of a step is g Phi(xi(tau)), xi = sum_i x_i psi_i(tau), and L along it is a Lagrangian
l(xi, xi', t) in the algebra, with pi = dl/dxi' and f = dl/dxi at the stages. The discrete
Lagrangian L_d(g, g1) = h sum_j b_j l_j is stationary over all such curves from g to g1 (H 3.2.2).
Its derivative by g1 is mu1 = T(xi(1))^-T p1. The derivative by g moves the base point of the chart
with g: the whole curve moves, except its end, which gives the impulses n_j:

    R_i = sum_j b_j (h f_j psi_ji + pi_j psi_ji') - p1 e_i = 0,     p1 = T(xi(1))^T mu1,
    mu1 = Ad*_{Phi(xi(1))} (mu0 + h sum_j b_j n_j),                 n_j = Ad*_{Phi(xi_j)^-1} tau_j,

where tau_j is the left-trivialised dL/dg at the stage. (With -dl/dxi at a fixed base point, as H
3.2.2 may be read, momentum and energy drift.) On R^d, Ad* = T = 1, and these are the equations of
H chapter 2.

d components, s stages, m coefficients per component; rows are components.
x            (d, m)     coefficients
coordinates, rate  (d, s)   xi and xi' at the stages
forces       (3, d, s)  pi, f and n
basis        a ``Basis``; the unknowns of component a are x[a, i] with i < first[a + 1] - first[a],
             the others are 0
law          a ``Law`` of galvi.kernels.forces.lagrangian_derivatives
scale        (d,)       1 for rotations; for translations the size of positions and displacements
rate_scale              size of xi'; not 0
scratch      a ``Scratch``
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numba import types

from galvi.kernels.compile.jit import jit, jit_inline, jit_noalloc
from galvi.kernels.forces.lagrangian_derivatives import slopes
from galvi.kernels.lie import product
from galvi.kernels.lie.product import is_flat
from galvi.kernels.nystrom.step import FIXED_MATRIX, FIXED_VECTOR


class Basis(NamedTuple):
    """The space's basis and the rule of a method.

    Attributes
    ----------
    psi, slope : array, shape (s, m)
        basis functions and their derivatives at the stages
    end : array, shape (m,)
        basis functions at 1
    b, c : array, shape (s,)
        weights and nodes of the rule
    first : array, shape (d + 1,)
        index of the first unknown of each component
    projection : array, shape (m, s)
        maps rates at the stages to x / h
    analysis, extrapolation, growth
        as in galvi.kernels.nystrom.step.NystromTableau
    """

    psi: Any
    slope: Any
    end: Any
    b: Any
    c: Any
    first: Any
    projection: Any
    analysis: Any
    extrapolation: Any
    growth: Any


BASIS = types.Tuple(
    (FIXED_MATRIX, FIXED_MATRIX, FIXED_VECTOR, FIXED_VECTOR, FIXED_VECTOR, types.int64[::1],
     FIXED_MATRIX, FIXED_MATRIX, FIXED_MATRIX, FIXED_VECTOR))  # fmt: skip


@jit_noalloc
def place_curve(basis, h, x, coordinates, rate):
    """coordinates and rate (d, s) <- xi_j = sum_i psi_ji x_i and xi'_j = sum_i psi_ji' x_i / h."""
    psi, slope = basis.psi, basis.slope
    for a in range(x.shape[0]):
        for j in range(psi.shape[0]):
            coordinate, rate_sum = 0.0, 0.0
            for i in range(psi.shape[1]):
                coordinate += psi[j, i] * x[a, i]
                rate_sum += slope[j, i] * x[a, i]
            coordinates[a, j], rate[a, j] = coordinate, rate_sum / h


class Discretisation(NamedTuple):
    """The group, as layout and chart of galvi.kernels.lie.product, and the basis of a method.

    The law is not included, since compiled kernels cannot take one that is in Python.
    """

    layout: Any
    chart: Any
    basis: Any


class Start(NamedTuple):
    """The start of a step: its size h, the times t (s,) of its stages, g (r,) and mu0 (d,)."""

    h: Any
    t: Any
    g: Any
    mu0: Any


class Curve(NamedTuple):
    """The curve of a step: x, coordinates, rate and forces as above, and velocities (d, s)."""

    x: Any
    coordinates: Any
    rate: Any
    forces: Any
    velocities: Any


class Scratch(NamedTuple):
    """Scratch arrays.

    xi, eta, velocity (d,), element (r,), slopes (2, d), local (3, d); for the derivative:
    blocks (2, 3, d, d), kicks (d, d, m), by_end and by_momentum (d, d), stage_forces (3, d)
    """

    xi: Any
    eta: Any
    velocity: Any
    element: Any
    slopes: Any
    local: Any
    blocks: Any
    kicks: Any
    by_end: Any
    by_momentum: Any
    stage_forces: Any


@jit
def new_scratch(d, r, m):
    """A ``Scratch`` for d components, r entries of an element and m coefficients."""
    return Scratch(
        np.empty(d),
        np.empty(d),
        np.empty(d),
        np.empty(r),
        np.empty((2, d)),
        np.empty((3, d)),
        np.empty((2, 3, d, d)),
        np.empty((d, d, m)),
        np.empty((d, d)),
        np.empty((d, d)),
        np.empty((3, d)),
    )


@jit_inline
def local_slopes(law, layout, chart, scratch, g, xi, eta, t, velocity, out):
    """out (3, d) <- pi, f and n of the Lagrangian in the chart at g; velocity (d,) <- T xi'."""
    element, gradient, d, flat = scratch.element, scratch.slopes, xi.size, is_flat(layout)
    if flat:
        for i in range(d):
            element[i], velocity[i] = g[i] + xi[i], eta[i]
    else:
        product.place(layout, chart, g, xi, element)
        product.velocity(layout, chart, xi, eta, velocity)
    slopes(law, layout, element, velocity, t, gradient)
    if flat:
        for i in range(d):
            out[0, i], out[1, i], out[2, i] = gradient[0, i], gradient[1, i], gradient[1, i]
        return
    product.momentum(layout, chart, xi, gradient[0], out[0])
    product.momentum_slope(layout, chart, xi, eta, gradient[0], out[1])
    product.momentum(layout, chart, xi, gradient[1], out[2])
    for i in range(d):
        out[1, i] += out[2, i]
    product.coadjoint_inverse(layout, chart, xi, gradient[1], out[2])


@jit_noalloc
def stage_slopes(law, layout, chart, scratch, start, curve):
    """Set the curve's forces and velocities at all stages."""
    coordinates, rate, forces, velocities = (
        curve.coordinates,
        curve.rate,
        curve.forces,
        curve.velocities,
    )
    d, s = coordinates.shape
    xi, eta, velocity, out = scratch.xi, scratch.eta, scratch.velocity, scratch.local
    for j in range(s):
        for a in range(d):
            xi[a], eta[a] = coordinates[a, j], rate[a, j]
        local_slopes(law, layout, chart, scratch, start.g, xi, eta, start.t[j], velocity, out)
        for a in range(d):
            forces[0, a, j], forces[1, a, j], forces[2, a, j] = out[0, a], out[1, a], out[2, a]
            velocities[a, j] = velocity[a]


@jit_noalloc
def end_coordinates(basis, x, xi):
    """xi <- xi(1), (d,)."""
    end = basis.end
    for a in range(x.shape[0]):
        xi[a] = 0.0
        for i in range(end.size):
            xi[a] += end[i] * x[a, i]


@jit_noalloc
def end_momentum_in_frame(basis, h, mu0, forces, out):
    """out <- mu0 + h sum_j b_j n_j, the final momentum in the frame of g."""
    b = basis.b
    for a in range(mu0.size):
        kick = 0.0
        for j in range(b.size):
            kick += b[j] * forces[2, a, j]
        out[a] = mu0[a] + h * kick


@jit_noalloc
def end_momentum(layout, chart, xi, momentum, mu1, p1):
    """Set mu1 and p1 = T^T mu1, from xi(1) and the final momentum in the frame of g."""
    if is_flat(layout):
        for i in range(xi.size):
            mu1[i] = p1[i] = momentum[i]
        return
    product.coadjoint(layout, chart, xi, momentum, mu1)
    product.momentum(layout, chart, xi, mu1, p1)


@jit_noalloc
def residual(method, scratch, start, curve, R):
    """R (d, m) <- the residual of the stage equations."""
    layout, chart, basis = method.layout, method.chart, method.basis
    x, forces, h, mu0 = curve.x, curve.forces, start.h, start.mu0
    psi, slope, end, b, first = basis.psi, basis.slope, basis.end, basis.b, basis.first
    xi, momentum, mu1, p1 = scratch.xi, scratch.eta, scratch.velocity, scratch.slopes[0]
    end_coordinates(basis, x, xi)
    end_momentum_in_frame(basis, h, mu0, forces, momentum)
    end_momentum(layout, chart, xi, momentum, mu1, p1)
    for a in range(x.shape[0]):
        for i in range(first[a + 1] - first[a]):
            total = -p1[a] * end[i]
            for j in range(b.size):
                total += b[j] * (h * forces[1, a, j] * psi[j, i] + forces[0, a, j] * slope[j, i])
            R[a, i] = total
