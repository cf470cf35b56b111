"""Accelerations -M^-1 dV/dq at the stages as vector instructions, for one potential.

A potential is given by its slopes, a function as in galvi.fast.lanes.laws.

Q, a       (d, P)  places at the stages, and the accelerations there
t          (P,)    times
constants  (c,)    M^-1, (d,) diagonal or (d d,) by rows, then those of the potential
"""

from __future__ import annotations

from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

from galvi.fast.lanes.law_pass import Constants
from galvi.fast.lanes.laws import From, times_inverse_mass
from galvi.fast.lanes.values import Lane
from galvi.fast.lanes.vectors import LANES, Lanes


def accelerations(slopes, d, coupled, q, t, c):
    """-M^-1 dV/dq, d values; M^-1 is diagonal unless ``coupled``."""
    found = slopes(q, t, From(c, d * d if coupled else d))
    return [-a for a in times_inverse_mass(found, d, coupled, c)]


def force_pass(slopes, d, coupled):
    """An intrinsic (Q, t, constants, a) that fills a, for a potential on R^d."""

    @intrinsic
    def whole_pass(typingctx, Q, t, constants, a):
        signature = types.void(Q, t, constants, a)

        def generate(context, builder, signature, values):
            places, times, numbers, results = (
                context.make_array(signature.args[k])(context, builder, values[k]) for k in range(4)
            )
            padded = builder.extract_value(places.shape, 1)
            row = padded.type
            chunks = builder.udiv(padded, row(LANES))
            with cgutils.for_range(builder, chunks, intp=row) as loop:
                lanes = Lanes(context, builder, padded, loop.index)
                given = Constants(builder, lanes, numbers.data, row)
                q = [Lane(builder, lanes.load(places.data, row(i))) for i in range(d)]
                time = Lane(builder, lanes.load(times.data, row(0)))
                for i, lane in enumerate(accelerations(slopes, d, coupled, q, time, given)):
                    lanes.store(q[0].same(lane).value, results.data, row(i))
            return context.get_dummy_value()

        return signature, generate

    return whole_pass
