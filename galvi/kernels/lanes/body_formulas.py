"""A rigid body at eight stages at once, in a chart of rotations; see galvi.kernels.lanes.gravity.

xi, pi    coordinates and their momenta;  eta = xi'
velocity  of the body, T(xi) eta;  lambda = J velocity = T^-T pi

    T^-1 = k I + hat(xi) / 2 + d hat(xi)^2,   u = |xi|^2
    eta  = T^-1 J^-1 T^-T pi,   f = -d(lambda . J^-1 lambda / 2)/dxi + T^T tau

with k and d of the chart (galvi.kernels.lie.charts).

charts   a tuple of length 1 + the chart's number
weights  a tuple of length 1 for a free body, 2 for one with a weight
body     J^-1 by rows (9,), J by rows (9,), the centre of mass (3,), and mass g in the frame of the
         step's start (3,)
"""

from __future__ import annotations

from numba import types
from numba.extending import intrinsic

from galvi.kernels.lanes.values import Lane
from galvi.kernels.lanes.vectors import Lanes
from galvi.kernels.lie.arithmetic import cross, dot
from galvi.kernels.lie.chart_functions import inverse_radial, inverse_slopes
from galvi.kernels.lie.rotations import inverse_tangent, rotated, tangent


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


@intrinsic
def stage_rates(typingctx, charts, xi, velocity, eta, padded, chunk):
    """eta <- T(xi)^-1 velocity; rows of three, (3, P)."""
    whole = types.intp
    signature = types.void(charts, xi, velocity, eta, whole, whole)

    def generate(context, builder, signature, arguments):
        kinds = signature.args
        body = _Body(context, builder, signature, arguments, *arguments[4:])
        places, paces, rates = (body.lanes.data(kinds[k], arguments[k]) for k in (1, 2, 3))
        xi, chart = body.triple(places), kinds[0].count - 1
        body.keep(inverse_tangent(chart, 1.0, xi, body.triple(paces)), rates)
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
        xi, chart = body.triple(places), kinds[0].count - 1
        momentum = body.times(constants, 9, body.triple(paces))
        body.keep(tangent(chart, -1.0, xi, momentum), momenta)
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
        u, chart = dot(xi, xi), kinds[0].count - 1
        (_, d), (dk, dd) = inverse_radial(chart, u), inverse_slopes(chart, u)
        velocity = body.times(constants, 0, inverse_tangent(chart, -1.0, xi, pi))
        body.keep(velocity, results, 9)
        body.keep(inverse_tangent(chart, 1.0, xi, velocity), results, 0)
        work, by_pi, by_velocity = dot(pi, velocity), dot(xi, pi), dot(xi, velocity)
        gyration = cross(pi, velocity)
        along = work * (2.0 * dk) - work * d * 2.0
        if dd != 0.0:
            along = along + (by_pi * by_velocity - u * work) * dd * 2.0
        f = [
            gyration[i] * 0.5 - along * xi[i] - (pi[i] * by_velocity + velocity[i] * by_pi) * d
            for i in range(3)
        ]
        if kinds[1].count == 2:
            centre = [body.number(constants, 18 + i) for i in range(3)]
            weight = [body.number(constants, 21 + i) for i in range(3)]
            torque = cross(centre, rotated(chart, -1.0, xi, weight))
            pulled = tangent(chart, -1.0, xi, torque)
            f = [f[i] + pulled[i] for i in range(3)]
            body.keep(rotated(chart, 1.0, xi, torque), results, 6)
        body.keep(f, results, 3)
        return context.get_dummy_value()

    return signature, generate
