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

# Largest difference between the changes of the eccentric and of the mean anomaly, radians.
LARGEST_ANOMALY_LEAD = 2.0
SERIES_TERMS = 10  # of each series, for full accuracy
LARGEST_SERIES_ARGUMENT = 1.0  # largest |beta X^2| 4^-halvings; there six terms err by 1e-12


def _series(first, terms):
    """The coefficients (-1)^k / (first + 2 k)!, k < terms."""
    return tuple((-1.0) ** k / math.factorial(first + 2 * k) for k in range(terms))


FOURTH, FIFTH = _series(4, 10), _series(5, 10)
SIXTH = 1.0 / 6.0
# The rounding errors of 1 / 6, 1 / 24 and 1 / 120.
COEFFICIENT_LOW_PARTS = tuple(float(Fraction(1, n) - Fraction(1.0 / n)) for n in (6, 24, 120))


def universal(beta, X, terms, halvings=2, exact=False):
    """G1 to G5 at X, from series at X / 2^halvings and the formulas for twice the argument.

    Parameters
    ----------
    terms
        of each series
    exact
        whether the rounding errors of the first coefficients are added, so that errors are random
    """
    X = X * 0.5**halvings
    square = X * X
    z = beta * square
    cube = square * X
    fourth, fifth = polynomial(FOURTH[1:terms], z) * z, polynomial(FIFTH[1:terms], z) * z
    lost_cube = 0.0
    if exact:
        fourth, fifth, lost_cube = (
            fourth + COEFFICIENT_LOW_PARTS[1],
            fifth + COEFFICIENT_LOW_PARTS[2],
            cube * COEFFICIENT_LOW_PARTS[0],
        )
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


def shifted(beta, G, step):
    """G1 to G5 at X + step from those at X; the error is of third order in the small step."""
    G1, G2, G3, G4, G5 = G
    G0 = 1.0 - beta * G2
    functions = [-(beta * G1), G0, G1, G2, G3, G4, G5]
    half = 0.5 * step
    return tuple(
        functions[n] + step * (functions[n - 1] + half * functions[n - 2]) for n in range(2, 7)
    )


def correction(beta, r0, eta, zeta, X, G, t, reciprocal):
    """The change of X that solves Kepler's equation, with an error of third order in it."""
    G1, G2, G3, _, _ = G
    gap = r0 * X - t + (eta * G2 + zeta * G3)
    inverse = reciprocal(r0 + (eta * G1 + zeta * G2))
    first = gap * inverse
    second = 0.5 * inverse * (eta - eta * beta * G2 + zeta * G1)
    return -(first + first * first * second)


def far_correction(beta, r0, eta, zeta, X, G, t, quotient, root):
    """The change of X by Laguerre's method of degree 5, which converges from distant guesses
    (Conway 1986)."""
    G1, G2, G3, _, _ = G
    gap = r0 * X - t + (eta * G2 + zeta * G3)
    r = r0 + (eta * G1 + zeta * G2)
    slope_of_r = eta - eta * beta * G2 + zeta * G1
    return quotient(-5.0 * gap, r + root(abs(16.0 * r * r - 20.0 * gap * slope_of_r)))


def bracketed(X, step, low, high, where):
    """X + step, or the middle of the interval where X + step is outside it; and the new interval.

    Kepler's equation is monotone in X, so that the sign of ``step`` tells on which side of X its
    solution is; steps without an interval may cycle. An end of the interval that is not known is
    NaN.

    Parameters
    ----------
    where
        a function (condition, x, y): x where the condition is true, else y
    """
    is_forward = step > 0.0
    low, high, moved = where(is_forward, X, low), where(is_forward, high, X), X + step
    outside = (moved < low) | (moved > high)
    return where(outside, 0.5 * (low + high), moved), low, high


def lag(mu, X, G, t):
    """c = mu (3 G5 - X G4) - t G2, of `pull_back`."""
    return mu * (3.0 * G[4] - X * G[3]) - t * G[1]


def pull_back(mu, G2, c, back, r_over_mu, inverse_0, q0, v0, q, v, a, dot):
    """D phi_-t(z) (0, a): the change of a motion's start (q0, v0) for the change a of v at its end.

    Parameters
    ----------
    G2, c
        of the motion from start to end in time t, see ``lag`` for c
    back
        mu G3 - t
    r_over_mu
        |q| / mu
    inverse_0
        1 / |q0|

    Notes
    -----
    From the transition matrix of the motion back (Battin (1999), section 9.7):

        dq0 = G2 [(q0 - q) v.a - (v0 - v) q.a] - c v.a v0 + (mu G3 - t) a
        dv0 = (r / mu) (v0 - v) (v0 - v).a + (mu / r0^3) (G2 q.a + c v.a) q0 + (1 - mu G2 / r0) a
    """
    position_change = [x - y for x, y in zip(q0, q, strict=True)]
    velocity_change = [x - y for x, y in zip(v0, v, strict=True)]
    s, y, z = dot(v, a), dot(q, a), dot(velocity_change, a)
    G2_s, G2_y, c_s = G2 * s, G2 * y, c * s
    mu_over_r0 = mu * inverse_0
    z_r_over_mu = r_over_mu * z
    start_factor, a_factor = (
        mu_over_r0 * (inverse_0 * inverse_0) * (G2_y + c_s),
        1.0 - mu_over_r0 * G2,
    )
    dq0, dv0 = [], []
    for k in range(len(a)):
        dq0.append(
            G2_s * position_change[k] - G2_y * velocity_change[k] + (back * a[k] - c_s * v0[k])
        )
        dv0.append(z_r_over_mu * velocity_change[k] + start_factor * q0[k] + a_factor * a[k])
    return dq0, dv0
