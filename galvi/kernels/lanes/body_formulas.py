"""A rigid body at eight stages at once, in a chart of rotations; as galvi.kernels.lanes.gravity.

xi, pi    coordinates and their momenta;  eta = xi'
velocity  of the body, T(xi) eta;  lambda = J velocity = T^-T pi

    T^-1 = k I + hat(xi) / 2 + d hat(xi)^2,   u = |xi|^2
    eta  = T^-1 J^-1 T^-T pi,   f = -d(lambda . J^-1 lambda / 2)/dxi + T^T tau

Cayley: k = 1 + u / 4, d = 1 / 4. Exponential: k = 1, d = 1/12 + u e with
e = sum |B_{2k+4}| u^k / (2k+4)!, and dd/du = (d^2 - 3 e) / 2.

charts   a tuple whose length is 1 for Cayley, 2 for the exponential chart
weights  a tuple whose length is 1 for a free body, 2 for one with a weight
body     J^-1 by rows (9,), J by rows (9,), the centre of mass (3,), and mass g in the frame of the
         step's start (3,)
"""

from __future__ import annotations

import math
from fractions import Fraction
from typing import Any

from numba import types
from numba.extending import intrinsic

from galvi.kernels.lanes.values import Lane, cross, dot, polynomial
from galvi.kernels.lanes.vectors import Lanes

REACHES = (20.0, 2.0)  # |xi| of each chart: nearly half a turn; where its series are exact
TERMS = 16


def _bernoulli_terms():
    """|B_{2k+4}| / (2k+4)! for k = 0, 1, ..., TERMS - 1."""
    numbers: list[Any] = [Fraction(1)]
    for n in range(1, 2 * TERMS + 5):
        total = sum(math.comb(n + 1, k) * numbers[k] for k in range(n))
        numbers.append(-total / (n + 1))
    return [float(abs(numbers[2 * k + 4]) / math.factorial(2 * k + 4)) for k in range(TERMS)]


def _stumpff_terms(k):
    """(-1)^j / (2 j + k)! for j = 0, 1, ..., 12."""
    return [(-1.0) ** j / math.factorial(2 * j + k) for j in range(13)]


E_TERMS = _bernoulli_terms()


class _Body:
    """Loads, stores and the formulas above."""

    def __init__(self, context, builder, signature, arguments, padded, chunk):
        self.builder, self.lanes = builder, Lanes(context, builder, padded, chunk)
        self.zero = padded.type(0)

    def number(self, data, place):
        return Lane(self.builder, self.lanes.spread(self.lanes.number(data, self.zero.type(place))))

    def triple(self, data, first=0):
        return [
            Lane(self.builder, self.lanes.load(data, self.zero.type(first + i))) for i in range(3)
        ]

    def keep(self, triple, data, first=0):
        for i in range(3):
            self.lanes.store(triple[i].value, data, self.zero.type(first + i))

    def times(self, data, first, v):
        rows = [[self.number(data, first + 3 * i + j) for j in range(3)] for i in range(3)]
        return [dot(row, v) for row in rows]


def _inverse_terms(charts, u):
    """k, d, dk/du, dd/du; k and its derivative are numbers where they are constant."""
    if charts == 1:
        return 0.25 * u + 1.0, 0.25, 0.25, 0.0
    e = polynomial(E_TERMS, u)
    d = u * e + 1.0 / 12.0
    return 1.0, d, 0.0, 0.5 * (d * d - 3.0 * e)


def _tangent_terms(charts, u):
    """a, b, c of the tangent map; a and b are also the sine and cosine of the rotation."""
    if charts == 1:
        a = 1.0 / (0.25 * u + 1.0)
        return a, 0.5 * a, None
    b, c = polynomial(_stumpff_terms(2), u), polynomial(_stumpff_terms(3), u)
    return 1.0 - u * c, b, c


def _inverse(terms, sign, xi, v):
    """T^-1 v for sign = 1, T^-T v for sign = -1."""
    k, d, _, _ = terms
    turned = cross(xi, v)
    twice = cross(xi, turned)
    return [v[i] * k + turned[i] * (0.5 * sign) + twice[i] * d for i in range(3)]


def _tangent(terms, sign, xi, v):
    """T v for sign = 1, T^T v for sign = -1."""
    a, b, c = terms
    turned = cross(xi, v)
    result = [v[i] * a - turned[i] * b * float(sign) for i in range(3)]
    if c is None:
        return result
    along = dot(xi, v) * c
    return [result[i] + along * xi[i] for i in range(3)]


def _rotate(terms, sign, xi, v):
    """Phi v for sign = 1, Phi^T v for sign = -1."""
    sine, cosine, _ = terms
    turned = cross(xi, v)
    twice = cross(xi, turned)
    return [v[i] + turned[i] * sine * float(sign) + twice[i] * cosine for i in range(3)]


@intrinsic
def stage_rates(typingctx, charts, xi, velocity, eta, padded, chunk):
    """eta <- T(xi)^-1 velocity; rows of three, (3, P)."""
    whole = types.intp
    signature = types.void(charts, xi, velocity, eta, whole, whole)

    def generate(context, builder, signature, arguments):
        kinds = signature.args
        body = _Body(context, builder, signature, arguments, *arguments[4:])
        places, paces, rates = (body.lanes.data(kinds[k], arguments[k]) for k in (1, 2, 3))
        xi = body.triple(places)
        terms = _inverse_terms(kinds[0].count, dot(xi, xi))
        body.keep(_inverse(terms, 1, xi, body.triple(paces)), rates)
        return context.get_dummy_value()

    return signature, generate


@intrinsic
def stage_momenta(typingctx, charts, numbers, xi, velocity, pi, padded, chunk):
    """pi <- T(xi)^T J velocity."""
    whole = types.intp
    signature = types.void(charts, numbers, xi, velocity, pi, whole, whole)

    def generate(context, builder, signature, arguments):
        kinds = signature.args
        body = _Body(context, builder, signature, arguments, *arguments[5:])
        constants, places, paces, momenta = (
            body.lanes.data(kinds[k], arguments[k]) for k in (1, 2, 3, 4)
        )
        xi = body.triple(places)
        terms = _tangent_terms(kinds[0].count, dot(xi, xi))
        momentum = body.times(constants, 9, body.triple(paces))
        body.keep(_tangent(terms, -1, xi, momentum), momenta)
        return context.get_dummy_value()

    return signature, generate


@intrinsic
def stage_forces(typingctx, charts, weights, numbers, xi, pi, out, padded, chunk):
    """out (12, P) <- eta, f, n and the body velocity, three rows each, from xi and pi."""
    whole = types.intp
    signature = types.void(charts, weights, numbers, xi, pi, out, whole, whole)

    def generate(context, builder, signature, arguments):
        kinds = signature.args
        body = _Body(context, builder, signature, arguments, *arguments[6:])
        constants, places, momenta, results = (
            body.lanes.data(kinds[k], arguments[k]) for k in (2, 3, 4, 5)
        )
        xi, pi = body.triple(places), body.triple(momenta)
        u = dot(xi, xi)
        terms = _inverse_terms(kinds[0].count, u)
        k, d, dk, dd = terms
        velocity = body.times(constants, 0, _inverse(terms, -1, xi, pi))
        body.keep(velocity, results, 9)
        body.keep(_inverse(terms, 1, xi, velocity), results, 0)
        work, by_pi, by_velocity = dot(pi, velocity), dot(xi, pi), dot(xi, velocity)
        turned = cross(pi, velocity)
        along = work * (2.0 * dk) - work * d * 2.0
        if kinds[0].count == 2:
            along = along + (by_pi * by_velocity - u * work) * dd * 2.0
        f = [
            turned[i] * 0.5 - along * xi[i] - (pi[i] * by_velocity + velocity[i] * by_pi) * d
            for i in range(3)
        ]
        if kinds[1].count == 2:
            centre = [body.number(constants, 18 + i) for i in range(3)]
            weight = [body.number(constants, 21 + i) for i in range(3)]
            radial = _tangent_terms(kinds[0].count, u)
            torque = cross(centre, _rotate(radial, -1, xi, weight))
            pulled = _tangent(radial, -1, xi, torque)
            f = [f[i] + pulled[i] for i in range(3)]
            body.keep(_rotate(radial, 1, xi, torque), results, 6)
        body.keep(f, results, 3)
        return context.get_dummy_value()

    return signature, generate
