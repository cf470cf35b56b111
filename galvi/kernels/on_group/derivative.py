"""The derivative of a step's equations on a group; notation of galvi.kernels.on_group.stages.

It affects only the convergence of Newton's iteration, not its limit. Its linear equations are
solved by Gaussian elimination with partial pivoting, without allocation.
"""

import numpy as np

from galvi.kernels.compile.jit import jit_noalloc
from galvi.kernels.lie.product import is_flat
from galvi.kernels.on_group.stages import (
    end_coordinates,
    end_momentum,
    end_momentum_in_frame,
    local_slopes,
)


@jit_noalloc
def factor(matrix, pivots):
    """Replace a matrix by its LU factors, with partial pivoting; returns False if it is singular or
    not finite."""
    n = matrix.shape[0]
    for k in range(n):
        best, row = 0.0, k
        for i in range(k, n):
            if abs(matrix[i, k]) > best:
                best, row = abs(matrix[i, k]), i
        if not 0.0 < best < np.inf:
            return False
        pivots[k] = row
        if row != k:
            for j in range(n):
                matrix[k, j], matrix[row, j] = matrix[row, j], matrix[k, j]
        for i in range(k + 1, n):
            ratio = matrix[i, k] / matrix[k, k]
            matrix[i, k] = ratio
            if ratio != 0.0:
                for j in range(k + 1, n):
                    matrix[i, j] -= ratio * matrix[k, j]
    return True


@jit_noalloc
def substitute(matrix, pivots, rhs):
    """rhs <- A^-1 rhs, from the factors of A by ``factor``."""
    n = matrix.shape[0]
    for k in range(n):
        rhs[k], rhs[pivots[k]] = rhs[pivots[k]], rhs[k]
    for k in range(n):
        for i in range(k + 1, n):
            rhs[i] -= matrix[i, k] * rhs[k]
    for k in range(n - 1, -1, -1):
        for j in range(k + 1, n):
            rhs[k] -= matrix[k, j] * rhs[j]
        rhs[k] /= matrix[k, k]


# Relative difference step: slopes may themselves be differenced, to 1e-11.
SLOPE_DIFFERENCE = 2.0**-22


@jit_noalloc
def curvature(law, layout, chart, scratch, scale, rate_scale, g, t, xi, eta, stage_forces, blocks):
    """blocks (2, 3, d, d) <- derivatives by xi and xi' of pi, f and n, by forward differences from
    their values ``stage_forces`` (3, d)."""
    d = xi.size
    velocity, moved_slopes = scratch.velocity, scratch.local
    for a in range(d):
        for kind in range(2):
            argument = xi if kind == 0 else eta
            centre = argument[a]
            argument[a] = centre + SLOPE_DIFFERENCE * (scale[a] if kind == 0 else rate_scale)
            difference = argument[a] - centre
            local_slopes(law, layout, chart, scratch, g, xi, eta, t, velocity, moved_slopes)
            argument[a] = centre
            for row in range(3):
                for i in range(d):
                    blocks[kind, row, i, a] = (
                        moved_slopes[row, i] - stage_forces[row, i]
                    ) / difference


@jit_noalloc
def end_curvature(layout, chart, scratch, scale, xi, momentum, by_place, by_momentum):
    """by_place, by_momentum (d, d) <- derivatives of p1 by xi(1) and by the momentum, by central
    differences."""
    d = xi.size
    if is_flat(layout):
        by_place[:, :] = 0.0
        by_momentum[:, :] = 0.0
        for a in range(d):
            by_momentum[a, a] = 1.0
        return
    mu1 = scratch.velocity
    ahead, behind = scratch.slopes[0], scratch.slopes[1]
    size = 0.0
    for a in range(d):
        size = max(size, abs(momentum[a]))
    for a in range(d):
        for kind in range(2):
            argument = xi if kind == 0 else momentum
            out = by_place if kind == 0 else by_momentum
            centre = argument[a]
            difference = SLOPE_DIFFERENCE * (scale[a] if kind == 0 else max(size, 1e-100))
            argument[a] = centre + difference
            end_momentum(layout, chart, xi, momentum, mu1, ahead)
            argument[a] = centre - difference
            end_momentum(layout, chart, xi, momentum, mu1, behind)
            argument[a] = centre
            for i in range(d):
                out[i, a] = 0.5 * (ahead[i] - behind[i]) / difference


@jit_noalloc
def derivative(law, method, scratch, start, curve, scale, rate_scale, matrix):
    """matrix <- dR/dx, (unknowns, unknowns); x[a, i] and R[a, i] have the index first[a] + i."""
    layout, chart, basis = method.layout, method.chart, method.basis
    h, coordinates, rate, forces = start.h, curve.coordinates, curve.rate, curve.forces
    psi, slope, end, b, first = basis.psi, basis.slope, basis.end, basis.b, basis.first
    blocks, kicks, stage_forces = scratch.blocks, scratch.kicks, scratch.stage_forces
    by_end, by_momentum = scratch.by_end, scratch.by_momentum
    d, s = coordinates.shape
    xi, eta, momentum = scratch.xi, scratch.eta, scratch.eta
    matrix[:, :] = 0.0
    kicks[:, :, :] = 0.0
    for j in range(s):
        for a in range(d):
            xi[a], eta[a] = coordinates[a, j], rate[a, j]
            for row in range(3):
                stage_forces[row, a] = forces[row, a, j]
        curvature(
            law,
            layout,
            chart,
            scratch,
            scale,
            rate_scale,
            start.g,
            start.t[j],
            xi,
            eta,
            stage_forces,
            blocks,
        )
        for a in range(d):
            for k in range(d):
                value_factor, slope_factor = (
                    h * b[j] * blocks[0, 2, a, k],
                    b[j] * blocks[1, 2, a, k],
                )
                for l in range(end.size):
                    kicks[a, k, l] += value_factor * psi[j, l] + slope_factor * slope[j, l]
                for i in range(first[a + 1] - first[a]):
                    value_factor, slope_factor = h * b[j] * psi[j, i], b[j] * slope[j, i]
                    by_place = value_factor * blocks[0, 1, a, k] + slope_factor * blocks[0, 0, a, k]
                    by_rate = (
                        value_factor * blocks[1, 1, a, k] + slope_factor * blocks[1, 0, a, k]
                    ) / h
                    for l in range(first[k + 1] - first[k]):
                        matrix[first[a] + i, first[k] + l] += (
                            by_place * psi[j, l] + by_rate * slope[j, l]
                        )
    end_coordinates(basis, curve.x, xi)
    end_momentum_in_frame(basis, h, start.mu0, forces, momentum)
    end_curvature(layout, chart, scratch, scale, xi, momentum, by_end, by_momentum)
    for a in range(d):
        for k in range(d):
            for l in range(first[k + 1] - first[k]):
                end_derivative = by_end[a, k] * end[l]
                for n in range(d):
                    end_derivative += by_momentum[a, n] * kicks[n, k, l]
                for i in range(first[a + 1] - first[a]):
                    matrix[first[a] + i, first[k] + l] -= end[i] * end_derivative
