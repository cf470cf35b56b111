"""Vector functions compiled for whole arrays."""

from __future__ import annotations

from functools import cache
from typing import Any

import numba
import numpy as np
from numba import types
from numba.extending import intrinsic

from galvi.lanes.values import Lane
from galvi.lanes.vectors import LANES, Lanes


@cache
def compiled(function: Any, arity: int, returned: int, width: int = LANES) -> Any:
    """The function of ``width`` lanes, applied to ``arity`` arrays (P,).

    The function that is returned gives (P,), or (``returned``, P) for more than one value.
    """

    @intrinsic
    def apply_to_chunk(typingctx, arguments, returned_columns, padded, chunk):  # type: ignore[no-untyped-def]
        integer = types.intp
        signature = types.void(arguments, returned_columns, integer, integer)

        def generate(context, builder, signature, values):  # type: ignore[no-untyped-def]
            lanes = Lanes(context, builder, *values[2:], width)
            source, target = (lanes.pointer_to(signature.args[k], values[k]) for k in (0, 1))
            row = values[2].type
            loaded = [Lane(builder, lanes.load(source, row(k))) for k in range(arity)]
            value = function(*loaded)
            for k, lane in enumerate(value if isinstance(value, tuple) else (value,)):
                lanes.store(lane.value, target, row(k))
            return context.get_dummy_value()

        return signature, generate

    @numba.njit(error_model="numpy")
    def columns(arguments, returned_columns):  # type: ignore[no-untyped-def]
        padded = arguments.shape[1]
        for chunk in range(padded // width):
            apply_to_chunk(arguments, returned_columns, padded, chunk)

    def apply(*arguments: Any) -> Any:
        count = len(arguments[0])
        padded = -(-count // width) * width
        source = np.ones((arity, padded))
        for k, column in enumerate(arguments):
            source[k, :count] = column
        returned_columns = np.empty((returned, padded))
        columns(source, returned_columns)
        return returned_columns[0, :count] if returned == 1 else returned_columns[:, :count]

    return apply
