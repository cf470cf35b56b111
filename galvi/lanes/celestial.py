"""The accelerations of galvi.kernels.forces.celestial, at all stages of a step."""

from __future__ import annotations

from llvmlite import ir

from galvi.kernels.compile.internals import cgutils
from galvi.kernels.compile.jit import jit_inline
from galvi.kernels.forces.celestial import (
    COLUMNS,
    FIRST_NUMBER,
    RECOIL,
    SOURCE,
    TARGET,
    WEIGHT,
    pole_pull,
    power_pull,
)
from galvi.lanes.stages import in_lanes
from galvi.lanes.values import Lane
from galvi.lanes.vectors import LANES, ZEROS

LANE_COUNT = (0,) * LANES


def _term_adder(law):
    """An intrinsic (form, places, pulls, terms, begin, end, *frame_terms) that adds to ``pulls``
    the accelerations by the terms ``begin`` to ``end``, which follow the force law ``law``.

    ``frame_terms`` is empty or (gaps, start, energy). Then ``places`` are relative to the start of
    the step, where ``gaps`` holds the vector between the bodies of each term, from index ``start``
    on; the energy of the terms is subtracted from row 0 of ``energy``.
    """

    @in_lanes
    def add(at, places, pulls, terms, begin, end, *frame_terms):
        builder, n = at.builder, len(at.axes)
        with cgutils.for_range(builder, end, start=begin, intp=end.type) as loop:
            first = builder.mul(loop.index, loop.index.type(COLUMNS))

            def row(k, first=first):
                value = at.number(terms.data, at.plus(first, k))
                return builder.mul(builder.fptosi(value, first.type), first.type(n))

            source, target = row(SOURCE), row(TARGET)
            gap = [places[target, x] - places[source, x] for x in at.axes]
            if frame_terms:
                gaps, start, energy = frame_terms
                start = builder.add(start, builder.mul(loop.index, start.type(n)))
                gap = [component + gaps.number(start, x) for x, component in enumerate(gap)]
            parameters = [terms.number(first, k) for k in range(FIRST_NUMBER, COLUMNS)]
            pull, back = law([*gap, at.none][:3], parameters), terms.number(first, RECOIL)
            if frame_terms:
                energy[0] = energy[0] - terms.number(first, WEIGHT) * pull[3]
            for x in at.axes:
                pulls[target, x] = pulls[target, x] + pull[x]
                pulls[source, x] = pulls[source, x] - back * pull[x]

    return add


add_poles, add_powers = _term_adder(pole_pull), _term_adder(power_pull)


@jit_inline
def add_terms(axes, terms, poles, s, Q, a):
    """Add to ``a`` the accelerations of the bodies at Q by the terms; Q and a are (d, P).

    The first ``poles`` terms are pole terms, the others power terms.
    """
    if terms.shape[0] > 0:
        form = (axes, LANE_COUNT, s, Q.shape[1])
        add_poles(form, Q, a, terms, 0, poles)
        add_powers(form, Q, a, terms, poles, terms.shape[0])


def add_in_frame(orbits, lanes, begin, end, gap, add):
    """Call ``add(body, acceleration)`` for the terms of the pairs ``begin`` to ``end`` of a frame.

    ``gap(source, target)`` returns the vector from the first to the second body. The terms number
    the bodies in the frame's order; their WEIGHT is 1 for `power_pull` and 0 for `pole_pull`.
    """
    builder, D = orbits.builder, orbits.D
    first, last = (orbits.integer(lanes, orbits.list_index(1, pair)) for pair in (begin, end))
    with cgutils.for_range(builder, last, start=first, intp=last.type) as loop:
        row = orbits.list_index(2, builder.mul(loop.index, last.type(COLUMNS)))
        source, target, is_power = (
            orbits.integer(lanes, lanes.plus(row, k)) for k in (SOURCE, TARGET, WEIGHT)
        )
        back, *parameters = (
            Lane(builder, lanes.spread(lanes.number(orbits.numbers, lanes.plus(row, k))))
            for k in (RECOIL, *range(FIRST_NUMBER, COLUMNS))
        )
        gap_in_space = [*gap(source, target), Lane(builder, ZEROS)][:3]
        pointers = [lanes.variable(ZEROS) for _ in range(D)]
        with builder.if_else(builder.trunc(is_power, ir.IntType(1))) as (power, pole):
            for branch, law in ((power, power_pull), (pole, pole_pull)):
                with branch:
                    for pointer, component in zip(
                        pointers, law(gap_in_space, parameters), strict=False
                    ):
                        builder.store(component.value, pointer)
        pull = [Lane(builder, builder.load(pointer)) for pointer in pointers]
        add(target, pull)
        add(source, [-back * component for component in pull])
