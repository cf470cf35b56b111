"""One step on a group: the residual of its stage equations and their derivative.

The curve of a step is g Phi(xi(tau)), xi = sum_i x_i psi_i(tau), and L along it is a Lagrangian
l(xi, xi', t) in the algebra, with pi = dl/dxi' and f = dl/dxi at the stages. The discrete
Lagrangian L_d(g, g1) = h sum_j b_j l_j is stationary over all such curves from g to g1 (H 3.2.2).
Its derivative by g1 is mu1 = T(xi(1))^-T p1, and its derivative by g moves the base point of the
chart along with g: the curve is carried along, only its end stays. What carries it is the force:

    R_i = sum_j b_j (h f_j psi_ji + pi_j psi_ji') - p1 e_i = 0,     p1 = T(xi(1))^T mu1,
    mu1 = Ad*_{Phi(xi(1))} (mu0 + h sum_j b_j n_j),                 n_j = Ad*_{Phi(xi_j)^-1} tau_j,

where tau_j is the left-trivialised dL/dg at the stage. (With -dl/dxi at a base that stays, as
H 3.2.2 may be read, momentum and energy drift.) On R^d, Ad* = T = 1, and these are the equations
of chapter 2.

d components, s stages, m coefficients a component; rows are components.
x        (d, m)
place    (d, s) and rate (d, s)   xi and xi' at the stages
forces   (3, d, s)   pi, f and n
basis    (psi (s, m), slope (s, m), end (m,), b (s,), c (s,), first (d + 1,)); the unknowns of
         component a are x[a, i] with i < first[a + 1] - first[a], the others are 0
law      (functions, kind, timed, side, constants, pushed, push_constants), see
         galvi.kernels.slopes
scale    (d,)  1 for rotations, the size of places and of moves for translations; not 0
pace     of xi', not 0
"""

from __future__ import annotations

import numpy as np

from galvi.kernels import charts, covectors
from galvi.kernels.jit import jit
from galvi.kernels.slopes import slopes

NUDGE = 2.0**-20  # of a difference, where slopes are accurate to round-off


@jit
def place_curve(basis, h, x, place, rate):
    """xi_j = sum_i psi_ji x_i,  xi'_j = sum_i psi_ji' x_i / h."""
    psi, slope = basis[0], basis[1]
    for a in range(x.shape[0]):
        for j in range(psi.shape[0]):
            where, pace = 0.0, 0.0
            for i in range(psi.shape[1]):
                where += psi[j, i] * x[a, i]
                pace += slope[j, i] * x[a, i]
            place[a, j], rate[a, j] = where, pace / h


@jit
def local_slopes(law, layout, chart, g, xi, eta, t, velocity, out):
    """out (3, d) <- pi, f and n of the Lagrangian in the chart at g; velocity (d,) <- T xi'."""
    functions, kind, timed, side, constants, pushed, push_constants = law
    d = xi.size
    T, G = np.empty((d, d)), np.empty((d, d))
    there, own = np.empty(g.size), np.empty((2, d))
    charts.place(layout, chart, g, xi, there)
    charts.tangent(layout, chart, xi, eta, T, G)
    for i in range(d):
        velocity[i] = 0.0
        for j in range(d):
            velocity[i] += T[i, j] * eta[j]
    slopes(functions, kind, timed, side, constants, pushed, push_constants, layout, there,
           velocity, t, own)  # fmt: skip
    for i in range(d):
        out[0, i] = out[1, i] = 0.0
        for j in range(d):
            out[0, i] += T[j, i] * own[0, j]
            out[1, i] += G[j, i] * own[0, j] + T[j, i] * own[1, j]
    covectors.to_base(layout, chart, xi, own[1], out[2])


@jit
def stage_slopes(law, layout, chart, g, t, place, rate, forces, velocities):
    """forces (3, d, s) and the velocities (d, s) at all stages."""
    d, s = place.shape
    xi, eta, velocity, out = np.empty(d), np.empty(d), np.empty(d), np.empty((3, d))
    for j in range(s):
        for a in range(d):
            xi[a], eta[a] = place[a, j], rate[a, j]
        local_slopes(law, layout, chart, g, xi, eta, t[j], velocity, out)
        for a in range(d):
            forces[0, a, j], forces[1, a, j], forces[2, a, j] = out[0, a], out[1, a], out[2, a]
            velocities[a, j] = velocity[a]


@jit
def end_place(basis, x, xi):
    """xi <- xi(1), (d,)."""
    end = basis[2]
    for a in range(x.shape[0]):
        xi[a] = 0.0
        for i in range(end.size):
            xi[a] += end[i] * x[a, i]


@jit
def carried(basis, h, mu0, forces, out):
    """out <- mu0 + h sum_j b_j n_j, the momentum at the end, seen from the frame of g."""
    b = basis[3]
    for a in range(mu0.size):
        kick = 0.0
        for j in range(b.size):
            kick += b[j] * forces[2, a, j]
        out[a] = mu0[a] + h * kick


@jit
def end_momentum(layout, chart, xi, momentum, mu1, p1):
    """mu1 and p1 = T^T mu1 from xi(1) and the momentum seen from the frame of g."""
    d = xi.size
    T, G = np.empty((d, d)), np.empty((d, d))
    covectors.from_base(layout, chart, xi, momentum, mu1)
    charts.tangent(layout, chart, xi, xi, T, G)
    for i in range(d):
        p1[i] = 0.0
        for j in range(d):
            p1[i] += T[j, i] * mu1[j]


@jit
def residual(layout, chart, basis, h, mu0, forces, x, R):
    """R (d, m), as above."""
    psi, slope, end, b, c, first = basis
    d = x.shape[0]
    xi, momentum, mu1, p1 = np.empty(d), np.empty(d), np.empty(d), np.empty(d)
    end_place(basis, x, xi)
    carried(basis, h, mu0, forces, momentum)
    end_momentum(layout, chart, xi, momentum, mu1, p1)
    for a in range(d):
        for i in range(first[a + 1] - first[a]):
            total = -p1[a] * end[i]
            for j in range(b.size):
                total += b[j] * (h * forces[1, a, j] * psi[j, i] + forces[0, a, j] * slope[j, i])
            R[a, i] = total


@jit
def curvature(law, layout, chart, scale, pace, g, t, xi, eta, blocks):
    """blocks (2, 3, d, d) <- derivatives by xi and by xi' of pi, f and n, by central differences.

    They only steer Newton's iteration; what it converges to does not depend on them.
    """
    d = xi.size
    ahead, behind, velocity = np.empty((3, d)), np.empty((3, d)), np.empty(d)
    for a in range(d):
        for kind in range(2):
            moved = xi if kind == 0 else eta
            kept = moved[a]
            nudge = NUDGE * (scale[a] if kind == 0 else pace)
            moved[a] = kept + nudge
            local_slopes(law, layout, chart, g, xi, eta, t, velocity, ahead)
            moved[a] = kept - nudge
            local_slopes(law, layout, chart, g, xi, eta, t, velocity, behind)
            moved[a] = kept
            for row in range(3):
                for i in range(d):
                    blocks[kind, row, i, a] = 0.5 * (ahead[row, i] - behind[row, i]) / nudge


@jit
def end_curvature(layout, chart, scale, xi, momentum, by_place, by_momentum):
    """Derivatives (d, d) of p1 by xi(1) and by the momentum, by central differences."""
    d = xi.size
    mu1, ahead, behind = np.empty(d), np.empty(d), np.empty(d)
    size = 0.0
    for a in range(d):
        size = max(size, abs(momentum[a]))
    for a in range(d):
        for kind in range(2):
            moved = xi if kind == 0 else momentum
            out = by_place if kind == 0 else by_momentum
            kept = moved[a]
            nudge = NUDGE * (scale[a] if kind == 0 else max(size, 1e-100))
            moved[a] = kept + nudge
            end_momentum(layout, chart, xi, momentum, mu1, ahead)
            moved[a] = kept - nudge
            end_momentum(layout, chart, xi, momentum, mu1, behind)
            moved[a] = kept
            for i in range(d):
                out[i, a] = 0.5 * (ahead[i] - behind[i]) / nudge


@jit
def derivative(
    law, layout, chart, basis, scale, pace, h, g, mu0, t, x, place, rate, forces, matrix
):
    """matrix <- dR/dx, (unknowns, unknowns), that of x[a, i] and equation R[a, i] first[a] + i."""
    psi, slope, end, b, c, first = basis
    d, s = place.shape
    m = end.size
    xi, eta, blocks = np.empty(d), np.empty(d), np.empty((2, 3, d, d))
    kicks = np.zeros((d, d, m))
    matrix[:, :] = 0.0
    for j in range(s):
        for a in range(d):
            xi[a], eta[a] = place[a, j], rate[a, j]
        curvature(law, layout, chart, scale, pace, g, t[j], xi, eta, blocks)
        for a in range(d):
            for k in range(d):
                for l in range(m):
                    kicks[a, k, l] += b[j] * (
                        h * blocks[0, 2, a, k] * psi[j, l] + blocks[1, 2, a, k] * slope[j, l]
                    )
                for i in range(first[a + 1] - first[a]):
                    late, bend = h * b[j] * psi[j, i], b[j] * slope[j, i]
                    by_place = late * blocks[0, 1, a, k] + bend * blocks[0, 0, a, k]
                    by_rate = (late * blocks[1, 1, a, k] + bend * blocks[1, 0, a, k]) / h
                    for l in range(first[k + 1] - first[k]):
                        matrix[first[a] + i, first[k] + l] += (
                            by_place * psi[j, l] + by_rate * slope[j, l]
                        )
    momentum, by_end, by_momentum = np.empty(d), np.empty((d, d)), np.empty((d, d))
    end_place(basis, x, xi)
    carried(basis, h, mu0, forces, momentum)
    end_curvature(layout, chart, scale, xi, momentum, by_end, by_momentum)
    for a in range(d):
        for k in range(d):
            for l in range(first[k + 1] - first[k]):
                moved = by_end[a, k] * end[l]
                for n in range(d):
                    moved += by_momentum[a, n] * kicks[n, k, l]
                for i in range(first[a + 1] - first[a]):
                    matrix[first[a] + i, first[k] + l] -= end[i] * moved
