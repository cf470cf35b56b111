"""The terms of galvi.kernels.forces.celestial, at all stages of a step."""

from __future__ import annotations

from numba.core import cgutils

from galvi.fast.lanes.stages import in_lanes
from galvi.fast.lanes.vectors import LANES
from galvi.kernels.compile.jit import jit_inline
from galvi.kernels.forces.celestial import (
    BACK,
    COLUMNS,
    NUMBERS,
    OTHER,
    SOURCE,
    pole_pull,
    power_pull,
)

EIGHT = (0,) * LANES


def _adding(law):
    """An intrinsic (form, places, pulls, terms, begin, end): pulls of some terms are added."""

    @in_lanes
    def add(at, places, pulls, terms, begin, end):
        builder, n = at.builder, len(at.axes)
        with cgutils.for_range(builder, end, start=begin, intp=end.type) as loop:
            first = builder.mul(loop.index, loop.index.type(COLUMNS))

            def row(k, first=first):
                number = at.number(terms.data, at.plus(first, k))
                return builder.mul(builder.fptosi(number, first.type), first.type(n))

            source, other = row(SOURCE), row(OTHER)
            gap = [places[other, x] - places[source, x] for x in at.axes] + [at.none]
            numbers = [terms.number(first, k) for k in range(NUMBERS, COLUMNS)]
            pull, back = law(gap[:3], numbers), terms.number(first, BACK)
            for x in at.axes:
                pulls[other, x] = pulls[other, x] + pull[x]
                pulls[source, x] = pulls[source, x] - back * pull[x]

    return add


add_poles, add_powers = _adding(pole_pull), _adding(power_pull)


@jit_inline
def add_terms(axes, terms, poles, s, Q, a):
    """a <- a + what the terms accelerate the bodies at Q by, (d, P) each."""
    if terms.shape[0] > 0:
        form = (axes, EIGHT, s, Q.shape[1])
        add_poles(form, Q, a, terms, 0, poles)
        add_powers(form, Q, a, terms, poles, terms.shape[0])
