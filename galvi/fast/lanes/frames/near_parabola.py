"""Kepler's motion of one orbit in double-doubles, for orbits near a parabola.

Where the distance r is small beside the semi-major axis a, doubles lose all of an orbit: 2 mu / r -
v.v cancels to a share r / a of its terms, and f q + g v of a motion to such a place likewise. Here
every sum is carried with 106 bits, the anomaly too, and g is r0 G1 + eta G2, which does not cancel.
What is left would change the energy by a share 2^-104 (a / r)^2, and is taken from the speed.

Formulas as in `galvi.fast.lanes.frames.universal`. A number is (high, low).
"""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np

from galvi.fast.lanes.gravity import fused
from galvi.kernels.compile.jit import jit, jit_inline, jit_noalloc
from galvi.kernels.lie.arithmetic import two_sum

SMALL = 0.25  # |beta X^2| 4^-halvings up to which the series are used
TERMS = 13  # of a series, which leave 1e-34
MOST = 200  # corrections of the anomaly, each at least half of an interval at worst
MOST_PAIRS = 4  # corrections in double-doubles
FARTHEST = 8.0  # radians of mean anomaly
ZERO = (0.0, 0.0)


def _series(first):
    """1 / (first + 2 k)!, and what rounding lost of them, (TERMS, 2)."""
    exact = [Fraction(1, math.factorial(first + 2 * k)) for k in range(TERMS)]
    return np.array([(float(x), float(x - Fraction(float(x)))) for x in exact])


FOURTH, FIFTH = _series(4), _series(5)


@jit_inline
def added(x, y):
    """x + y."""
    total, rest = two_sum(x[0], y[0])
    low, lost = two_sum(x[1], y[1])
    total, rest = two_sum(total, rest + low)
    return two_sum(total, rest + lost)


@jit_inline
def negated(x):
    """-x."""
    return -x[0], -x[1]


@jit_inline
def scaled(x, k):
    """x k for a power of two k."""
    return x[0] * k, x[1] * k


@jit_inline
def times(x, y):
    """x y."""
    high = x[0] * y[0]
    low = fused(x[0], y[0], -high) + (x[0] * y[1] + x[1] * y[0])
    return two_sum(high, low)


@jit_inline
def divided(x, y):
    """x / y."""
    first = x[0] / y[0]
    rest = added(x, times((-first, 0.0), y))
    second = rest[0] / y[0]
    rest = added(rest, times((-second, 0.0), y))
    high, low = two_sum(first, second)
    return two_sum(high, low + rest[0] / y[0])


@jit_inline
def root(x):
    """The square root."""
    first = math.sqrt(x[0])
    rest = added(x, times((-first, 0.0), (first, 0.0)))
    return two_sum(first, rest[0] / (2.0 * first))


@jit_inline
def dot(x, x_low, y, y_low, place, stride, D):
    """The product of two vectors whose coordinates are ``stride`` apart."""
    total = ZERO
    for k in range(D):
        i = place + k * stride
        total = added(total, times((x[i], x_low[i]), (y[i], y_low[i])))
    return total


@jit_noalloc
def functions(beta, X):
    """G1, G2 and G3 at X."""
    halvings, size = 0, abs(beta[0] * X[0] * X[0])
    while size > SMALL:
        size, halvings = 0.25 * size, halvings + 1
    X = scaled(X, 0.5**halvings)
    square = times(X, X)
    z = negated(times(beta, square))
    fourth, fifth = ZERO, ZERO
    for k in range(TERMS - 1, -1, -1):
        fourth = added(times(fourth, z), (FOURTH[k, 0], FOURTH[k, 1]))
        fifth = added(times(fifth, z), (FIFTH[k, 0], FIFTH[k, 1]))
    cube = times(square, X)
    G4, G5 = times(times(square, square), fourth), times(times(square, cube), fifth)
    sixth = divided(cube, (6.0, 0.0))
    G3 = added(sixth, negated(times(beta, G5)))
    G2 = added(scaled(square, 0.5), negated(times(beta, G4)))
    G1 = added(X, negated(times(beta, G3)))
    for _ in range(halvings):
        G3 = scaled(added(G3, times(G1, G2)), 2.0)
        G0 = added((1.0, 0.0), negated(times(beta, G2)))
        G1, G2 = scaled(times(G0, G1), 2.0), scaled(times(G1, G1), 2.0)
    return G1, G2, G3


@jit_inline
def corrected(r, bend, gap):
    """The change of X that removes a gap of Kepler's equation, by Laguerre's method."""
    return -5.0 * gap / (r + math.sqrt(abs(16.0 * r * r - 20.0 * gap * bend)))


@jit_noalloc
def anomaly(mu, beta, r0, eta, zeta, t):
    """X after the time t, nearly, by corrections that stay inside an interval.

    On parabolas and hyperbolas |t| >= mu |X|^3 / 24, on ellipses nearly so.
    """
    start, end = 0.0, math.copysign((24.0 * abs(t) / mu) ** (1.0 / 3.0), t)
    for _ in range(MOST):
        _, (G2, _), (G3, _) = functions((beta, 0.0), (end, 0.0))
        if abs(r0 * end + (eta * G2 + zeta * G3)) >= abs(t):
            break
        start, end = end, 2.0 * end
    X = 0.5 * (start + end)
    for _ in range(MOST):
        (G1, _), (G2, _), (G3, _) = functions((beta, 0.0), (X, 0.0))
        gap = (r0 * X - t) + (eta * G2 + zeta * G3)
        if gap * t > 0.0:
            end = X
        else:
            start = X
        r = r0 + (eta * G1 + zeta * G2)
        new = X + corrected(r, eta - eta * beta * G2 + zeta * G1, gap)
        if not min(start, end) < new < max(start, end):
            new = 0.5 * (start + end)
        if abs(new - X) <= 2e-16 * abs(X):
            break
        X = new
    return X


@jit_inline
def scale_rows(state, place, stride, D, length, pace):
    """Places times a length and velocities times a pace, both of them powers of two."""
    for k in range(D):
        i = place + k * stride
        for row in range(2):
            state[4 + row, i] *= length
            state[6 + row, i] *= pace


@jit_noalloc
def follow_near_parabola(mu, t, state, place, stride, D):
    """Move an orbit by the time t: (q, its low part, v, its low part) in rows 4 to 7 of the state.

    place, stride  of its coordinates in a row

    NaN where its mean anomaly changes by more than FARTHEST, or where an orbit that is not bound
    moves as far. Computed with distance and mass near 1, so that powers do not overflow.
    """
    size = 0.0
    for k in range(D):
        size = max(size, abs(state[4, place + k * stride]))
    length = 2.0 ** -math.frexp(size)[1]
    pace = 2.0 ** (math.frexp(size / mu)[1] // 2)
    mu, t = mu * length * pace * pace, t / pace * length
    scale_rows(state, place, stride, D, length, pace)
    q, q_low, v, v_low = state[4], state[5], state[6], state[7]
    mass = (mu, 0.0)
    r0 = root(dot(q, q_low, q, q_low, place, stride, D))
    eta = dot(q, q_low, v, v_low, place, stride, D)
    fall = divided(mass, r0)
    beta = added(scaled(fall, 2.0), negated(dot(v, v_low, v, v_low, place, stride, D)))
    zeta = added(mass, negated(times(beta, r0)))
    turned = abs(t) * abs(beta[0]) ** 1.5 / mu
    X = (anomaly(mu, beta[0], r0[0], eta[0], zeta[0], t) if turned <= FARTHEST else math.nan, 0.0)
    if not math.isfinite(X[0]):
        for k in range(D):
            q[place + k * stride] = math.nan
        return
    for last in range(MOST_PAIRS):
        G1, G2, G3 = functions(beta, X)
        r = added(r0, added(times(eta, G1), times(zeta, G2)))
        if last == MOST_PAIRS - 1:
            break
        gap = added(times(r0, X), (-t, 0.0))
        gap = added(gap, added(times(eta, G2), times(zeta, G3)))
        bend = eta[0] * (1.0 - beta[0] * G2[0]) + zeta[0] * G1[0]
        X = added(X, (corrected(r[0], bend, gap[0]), 0.0))
    f, g = negated(times(fall, G2)), added(times(r0, G1), times(eta, G2))
    rate_f = negated(times(fall, divided(G1, r)))
    rate_g = negated(times(mass, divided(G2, r)))
    for k in range(D):
        i = place + k * stride
        x, y = (q[i], q_low[i]), (v[i], v_low[i])
        end = added(x, added(times(f, x), times(g, y)))
        speed = added(y, added(times(rate_f, x), times(rate_g, y)))
        q[i], q_low[i], v[i], v_low[i] = end[0], end[1], speed[0], speed[1]
    r = root(dot(q, q_low, q, q_low, place, stride, D))
    wanted = added(scaled(divided(mass, r), 2.0), negated(beta))
    for _ in range(2):
        square = dot(v, v_low, v, v_low, place, stride, D)
        share = scaled(divided(added(wanted, negated(square)), square), 0.5)
        for k in range(D):
            i = place + k * stride
            y = (v[i], v_low[i])
            v[i], v_low[i] = added(y, times(share, y))
    scale_rows(state, place, stride, D, 1.0 / length, 1.0 / pace)


@jit
def follow_each(mu, t, states):
    """Move orbits (k, 8, D) by the times t (k,)."""
    for k in range(mu.size):
        follow_near_parabola(mu[k], t[k], states[k], 0, 1, states.shape[2])
