"""The largest rate of pairs that this machine's divide and square-root units allow.

A pair of bodies needs 1 / (x sqrt(x)) of its squared distance x. This kernel computes nothing else,
on numbers in the L1 cache, with the same vector instructions as galvi's own.
"""

from __future__ import annotations

import numpy as np
from llvmlite import ir
from numba import types
from numba.extending import intrinsic

from galvi.fast.lanes.vectors import DOUBLE, LANES, VECTOR
from galvi.kernels.compile.jit import jit

PAIRS = 1024  # squared distances, 16 KiB with the results
PASSES = 500


@intrinsic
def pull(typingctx, squares, pulls, chunk):
    """pulls <- 1 / (squares sqrt(squares)) in eight lanes from 8 chunk on."""
    signature = types.void(squares, pulls, types.intp)

    def generate(context, builder, signature, arguments):
        offset = builder.mul(arguments[2], ir.Constant(arguments[2].type, LANES))
        places = []
        for kind, argument in zip(signature.args[:2], arguments[:2], strict=True):
            data = context.make_array(kind)(context, builder, argument).data
            place = builder.gep(data, [offset])
            places.append(builder.bitcast(place, VECTOR.as_pointer()))
        x = builder.load(places[0])
        x.align = 8
        name = f"llvm.sqrt.v{LANES}f64"
        module = builder.module
        root = module.globals.get(name) or ir.Function(
            module, ir.FunctionType(VECTOR, [VECTOR]), name
        )
        cube = builder.fmul(x, builder.call(root, [x]))
        one = ir.Constant(VECTOR, [ir.Constant(DOUBLE, 1.0)] * LANES)
        builder.store(builder.fdiv(one, cube), places[1]).align = 8
        return context.get_dummy_value()

    return signature, generate


@jit
def pull_pairs(squares, pulls, passes):
    """Apply `pull` to all squares, `passes` times."""
    for _ in range(passes):
        for chunk in range(squares.size // LANES):
            pull(squares, pulls, chunk)


def call_and_pairs():
    """A function without arguments, and the number of pairs that one call evaluates."""
    squares, pulls = np.linspace(1.0, 900.0, PAIRS), np.zeros(PAIRS)
    return lambda: pull_pairs(squares, pulls, PASSES), PAIRS * PASSES
