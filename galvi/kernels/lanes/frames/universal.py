"""Kepler's motion by universal variables, for lanes and arrays alike (Battin (1999), section 4.5).

q'' = -mu q / |q|^3 from (q, v) at distance r0, with eta = q.v, beta = 2 mu / r0 - v.v, zeta = mu -
beta r0 and G_n(X) = X^n sum_k (-beta X^2)^k / (n + 2 k)!, so that dG_n/dX = G_(n-1):

    t = r0 X + eta G2 + zeta G3,  r = r0 + eta G1 + zeta G2
    q(t) = f q + g v,  f = 1 - mu G2 / r0,  g = t - mu G3
    v(t) = f' q + g' v,  f' = -mu G1 / (r r0),  g' = 1 - mu G2 / r
"""

from __future__ import annotations

import math
from fractions import Fraction

from galvi.kernels.lie.arithmetic import polynomial

FARTHEST = 0.9  # largest |beta X^2| 4^-halvings for which six terms err by 6e-13


def _series(first, terms):
    return tuple((-1.0) ** k / math.factorial(first + 2 * k) for k in range(terms))


FOURTH, FIFTH = _series(4, 10), _series(5, 10)
SIXTH = 1.0 / 6.0
# What rounding lost of 1 / 6, 1 / 24 and 1 / 120.
LOST = tuple(float(Fraction(1, n) - Fraction(1.0 / n)) for n in (6, 24, 120))


def universal(beta, X, terms, halvings=2, exact=False):
    """G1 to G5 at X, from series at X / 2^halvings by the formulas for twice the argument.

    terms  of each series
    exact  whether what rounding lost of the first coefficients is added, so that errors are random
    """
    X = X * 0.5**halvings
    square = X * X
    z = beta * square
    cube = square * X
    fourth, fifth = polynomial(FOURTH[1:terms], z) * z, polynomial(FIFTH[1:terms], z) * z
    lost_cube = 0.0
    if exact:
        fourth, fifth, lost_cube = fourth + LOST[1], fifth + LOST[2], cube * LOST[0]
    G4 = square * square * (FOURTH[0] + fourth)
    G5 = square * cube * (FIFTH[0] + fifth)
    G3 = cube * SIXTH - (beta * G5 - lost_cube)
    G2 = square * 0.5 - beta * G4
    G1 = X - beta * G3
    for _ in range(halvings):
        G5 = 2.0 * (G5 + X * G4 + G2 * G3)
        G4 = 4.0 * G4 + 2.0 * (G2 * G2)
        G3 = 2.0 * (G3 + G1 * G2)
        G1, G2 = 2.0 * ((1.0 - beta * G2) * G1), 2.0 * (G1 * G1)
        X = 2.0 * X
    return G1, G2, G3, G4, G5


def moved(beta, G, step):
    """G1 to G5 at X + step, up to the fourth power of the small step."""
    G1, G2, G3, G4, G5 = G
    G0 = 1.0 - beta * G2
    below = [-(beta * G0), -(beta * G1), G0, G1, G2, G3, G4, G5]
    half, third = 0.5 * step, step * (1.0 / 3.0)
    return tuple(
        below[n] + step * (below[n - 1] + half * (below[n - 2] + third * below[n - 3]))
        for n in range(3, 8)
    )


def correction(beta, r0, eta, zeta, X, G, t, reciprocal):
    """The change of X that solves Kepler's equation up to its fourth power, and dt/dX there."""
    G1, G2, G3, _, _ = G
    gap = r0 * X - t + (eta * G2 + zeta * G3)
    r = r0 + (eta * G1 + zeta * G2)
    G0 = 1.0 - beta * G2
    inverse = reciprocal(r)
    first = -(gap * inverse)
    second = 0.5 * inverse * (eta * G0 + zeta * G1)
    third = (1.0 / 6.0) * inverse * (zeta * G0 - beta * (eta * G1))
    return first - first * first * (second - first * (2.0 * (second * second) - third)), r


def pull_back(mu, beta, X, G, q, v, r, inverse, inverse_0, a, dot):
    """D phi_-t(z) (0, a): the change of the motion's start for the change a of v at its end.

    X, G       of the motion from start to end, in time t
    q, v, r    at its end, with inverse = 1 / r; inverse_0 = 1 / r0 at its start
    Derived from the motion back, whose X, G1, G3 and G5 have the other sign.
    """
    X, G1, G2, G3, G4, G5 = -X, -G[0], G[1], -G[2], G[3], -G[4]
    eta, d_eta, d_beta = dot(q, v), dot(q, a), -2.0 * dot(v, a)
    half = 0.5 * d_beta
    G1_beta = half * (G3 - X * G2)
    G2_beta = half * (2.0 * G4 - X * G3)
    G3_beta = half * (3.0 * G5 - X * G4)
    dX = -(inverse_0 * (G2 * d_eta + (r * G1_beta + eta * G2_beta + mu * G3_beta)))
    G0 = 1.0 - beta * G2
    dG1, dG2, dG3 = G0 * dX + G1_beta, G1 * dX + G2_beta, G2 * dX + G3_beta
    d_r0 = eta * dG1 + G1 * d_eta + mu * dG2 - r * (G2 * d_beta + beta * dG2)
    pace = d_r0 * inverse_0
    along_q, along_v = -(mu * inverse) * dG2, -(mu * dG3)
    turn = -(mu * inverse_0)
    rate_q, rate_v = turn * inverse * (dG1 - G1 * pace), turn * (dG2 - G2 * pace)
    return along_q, along_v, rate_q, rate_v, 1.0 + turn * G2
