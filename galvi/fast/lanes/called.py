"""A law for lanes that calls compiled functions of a user's, one state after another.

For functions that cannot be written in the operations of lanes, as those that branch. What they
raise passes through the pass to the kernel's caller.

numbers  of a called law:
  NEAR            address of ``evaluate`` compiled
  FUNCTIONS       addresses (2,), as of galvi.kernels.forces.lagrangian_derivatives.Law, whose other
  KIND ...        fields follow: numbers, then the lengths of both arrays of constants
  FACTORS         f, then the layout (f, 4), the constants and those of the force, and the masses
                  d2L/dv2 at the first pass of the step, d (d + 1) / 2 for each lane

Addresses are stored as bits of an integer. d2L/dv2, where it is no constant, comes from differences
of dL/dv, in the first pass of a step only: an error of it costs passes, not accuracy.
"""

from __future__ import annotations

from functools import cache

import numpy as np
from llvmlite import ir
from numba import carray, types  # type: ignore[attr-defined]
from numba.core import cgutils

from galvi.fast.lanes.values import Lane
from galvi.fast.lanes.vectors import DOUBLE
from galvi.kernels.compile.function_pointers import addresses
from galvi.kernels.compile.jit import compiled_for, jit
from galvi.kernels.forces.lagrangian_derivatives import Law, slopes

NEAR, FUNCTIONS, KIND, TIMED, ROWS, CONSTANTS, FORCE_KIND, FORCE_CONSTANTS, FACTORS = (
    0, 1, 3, 4, 5, 6, 7, 8, 9,
)  # fmt: skip
LAYOUT = 10
STEP = 2.0**-12  # of a difference, over the largest velocity
POINTER, WHOLE = types.CPointer(types.float64), types.int64
EVALUATE = types.void(POINTER, POINTER, WHOLE, WHOLE, WHOLE, WHOLE, WHOLE, WHOLE)


def called_numbers(kernel, layout):
    """The numbers of the called law of a compiled galvi.systems.system, but for the
    masses."""
    whole = np.array([addresses((compiled_evaluate(), EVALUATE))[0], *kernel.functions])
    return np.concatenate([
        whole.astype(np.int64).view(np.float64),
        [kernel.kind, kernel.time_dependent, kernel.matrix_rows, kernel.constants.size,
         kernel.force_kind, kernel.force_constants.size, len(layout)],
        np.ravel(layout), kernel.constants, kernel.force_constants,
    ])  # fmt: skip


def evaluate(lanes, numbers, width, r, d, count, chunk, anew):
    """Rows of numbers in all lanes: g (r,), v (d,), t; then dL/dg, dL/dv and the mass, which are
    filled.

    lanes  address of the rows; numbers as above
    width  how many lanes there are
    count  stages among them: the other lanes get what the first one has
    chunk  number of this vector among those of all stages
    anew   whether the mass is differenced, or that of the last time
    """
    head = carray(numbers, (LAYOUT,))
    factors, own, forced = int(head[FACTORS]), int(head[CONSTANTS]), int(head[FORCE_CONSTANTS])
    triangle = d * (d + 1) // 2
    first = LAYOUT + 4 * factors + own + forced
    whole = carray(numbers, (first + (chunk + 1) * width * triangle,))
    kept = whole[first + chunk * width * triangle :]
    layout = np.empty((factors, 4), np.int64)
    for k in range(4 * factors):
        layout[k // 4, k % 4] = int(whole[LAYOUT + k])
    begin = LAYOUT + 4 * factors
    law = Law(
        whole[FUNCTIONS:KIND].view(np.int64), int(head[KIND]), head[TIMED] != 0.0, int(head[ROWS]),
        whole[begin : begin + own], int(head[FORCE_KIND]),
        whole[begin + own : begin + own + forced],
    )  # fmt: skip
    rows = carray(lanes, (r + 1 + 3 * d + triangle, width))
    g, v, out, moved = np.empty(r), np.empty(d), np.empty((2, d)), np.empty((2, d))
    for j in range(count):
        for i in range(r):
            g[i] = rows[i, j]
        size = 0.0
        for i in range(d):
            v[i] = rows[r + i, j]
            size = max(size, abs(v[i]))
        t = rows[r + d, j]
        slopes(law, layout, g, v, t, out)
        for i in range(d):
            rows[r + d + 1 + i, j] = out[1, i]
            rows[r + 2 * d + 1 + i, j] = out[0, i]
        if anew != 0:
            far = STEP * (size if size > 0.0 else 1.0)
            for i in range(d):
                here = v[i]
                v[i] = here - far if here > 0.0 else here + far  # to where L is rather defined
                slopes(law, layout, g, v, t, moved)
                for k in range(i + 1):
                    slope = (moved[0, k] - out[0, k]) / (v[i] - here)
                    kept[width * (i * (i + 1) // 2 + k) + j] = slope
                v[i] = here
    for i in range(2 * d):
        for j in range(count, width):
            rows[r + d + 1 + i, j] = rows[r + d + 1 + i, 0]
    for i in range(triangle):
        for j in range(width):
            rows[r + 3 * d + 1 + i, j] = kept[width * i + (j if j < count else 0)]


@cache
def compiled_evaluate():
    """``evaluate`` compiled or cached, one function for all called laws."""
    return compiled_for(jit(evaluate), EVALUATE)


def called(r, d, mass=None):
    """The law of functions of elements with r entries and velocities (d,).

    mass  of d2L/dv2, where it is constant, the number among those above of the first entry, how
          many are in a row, 0 for the diagonal alone, and whether those beside it are not 0
    """

    def known(c):
        first, row, coupled = mass
        return [
            [c[first + row * i + j] if coupled or i == j else 0.0 for j in range(i + 1)]
            for i in range(d)
        ]

    def law(g, v, t, c):
        if not isinstance(v[0], Lane):
            forces, momenta, found = generic(g, v, t)
            return forces, momenta, known(c) if mass else found
        builder, lanes = c.builder, c.lanes
        width = lanes.width
        size = r + 1 + 3 * d + d * (d + 1) // 2
        rows = cgutils.alloca_once(builder, DOUBLE, width * size)

        def place(k):
            start = builder.gep(rows, [c.row(width * k)])
            return builder.bitcast(start, ir.PointerType(v[0].value.type))

        for k, value in enumerate([*g, *v, v[0].same(t)]):
            builder.store(v[0].same(value).value, place(k)).align = 8
        code = lanes.context.call_conv
        kind = code.get_function_type(EVALUATE.return_type, EVALUATE.args).as_pointer()
        near = builder.load(builder.bitcast(c.data, ir.IntType(64).as_pointer()))
        anew = c.row(0) if mass else builder.zext(c.of_pass.first_pass(), ir.IntType(64))
        left = builder.sub(c.of_pass.stages, lanes.offset)
        more = builder.icmp_unsigned(">", left, c.row(width))
        count = builder.select(more, c.row(width), left)
        chunk = builder.udiv(lanes.offset, c.row(width))
        given = [rows, c.data, c.row(width), c.row(r), c.row(d), count, chunk, anew]
        status, _ = code.call_function(
            builder, builder.inttoptr(near, kind), EVALUATE.return_type, EVALUATE.args, given
        )
        with builder.if_then(status.is_error, likely=False):
            code.return_status_propagate(builder, status)
        found = []
        for k in range(r + d + 1, size):
            value = builder.load(place(k))
            value.align = 8
            found.append(Lane(builder, value))
        whole = known(c) if mass else triangular(found[2 * d :], d)
        return found[:d], found[d : 2 * d], whole

    return law


def generic(g, v, t):
    """Values without special properties, where a law is looked at for these."""
    d = len(v)
    mass = [[np.cos(g[0] + v[j] + 0.3 * i * i + 0.7 * j) for j in range(i + 1)] for i in range(d)]
    return [x * t for x in v], [x * x for x in v], mass


def triangular(values, d):
    """Rows of a triangle from its entries."""
    return [values[i * (i + 1) // 2 : (i + 1) * (i + 2) // 2] for i in range(d)]
