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
    """G1 to G5 at X + step, up to the third power of the small step."""
    G1, G2, G3, G4, G5 = G
    G0 = 1.0 - beta * G2
    below = [-(beta * G1), G0, G1, G2, G3, G4, G5]
    half = 0.5 * step
    return tuple(
        below[n] + step * (below[n - 1] + half * below[n - 2]) for n in range(2, 7)
    )


def correction(beta, r0, eta, zeta, X, G, t, reciprocal):
    """The change of X that solves Kepler's equation up to its third power."""
    G1, G2, G3, _, _ = G
    gap = r0 * X - t + (eta * G2 + zeta * G3)
    inverse = reciprocal(r0 + (eta * G1 + zeta * G2))
    first = gap * inverse
    second = 0.5 * inverse * (eta - eta * beta * G2 + zeta * G1)
    return -(first + first * first * second)


def pull_back(mu, beta, X, G, q, v, r, inverse, inverse_0, a, dot):
    """D phi_-t(z) (0, a): the change of the motion's start for the change a of v at its end.

    X, G       of the motion from start to end, in time t
    q, v, r    at its end, with inverse = 1 / r; inverse_0 = 1 / r0 at its start

    Returns c, with (c0 q + c1 v + (mu G3 - t) a, c2 q + c3 v + c4 a). With dg = dG(-X), from
    dG_n/dbeta = (n G_(n+2) - X G_(n+1)) / 2.
    """
    G1, G2, G3, G4, G5 = G
    eta, d_eta, s = dot(q, v), dot(q, a), dot(v, a)
    B1, B2, B3 = s * (X * G2 - G3), s * (X * G3 - 2.0 * G4), s * (X * G4 - 3.0 * G5)
    dX = inverse_0 * (r * B1 - eta * B2 + mu * B3 - G2 * d_eta)
    dg1 = dX - beta * G2 * dX - B1
    dg2, dg3 = B2 - G1 * dX, G2 * dX - B3
    d_r0 = eta * dg1 - G1 * d_eta + (mu - r * beta) * dg2 + 2.0 * (r * G2) * s
    pace, turn, fall = d_r0 * inverse_0, mu * inverse_0, mu * inverse
    rate_q = turn * inverse * (-dg1 - G1 * pace)
    return -(fall * dg2), -(mu * dg3), rate_q, turn * (G2 * pace - dg2), 1.0 - turn * G2
