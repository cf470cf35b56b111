"""The external force of a SymPy Lagrangian, compiled."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from galvi.arrays import Array
from galvi.symbolic import code as symbolic_code
from galvi.symbolic.lane_law import printed_force
from galvi.symbolic.parsing import Expressions


@dataclass(frozen=True)
class SymbolicForce:
    """f(q, v, t), (d,), from `galvi.Lagrangian.from_sympy`; its repr is the expressions.

    text       the expressions in the user's notation
    source     generated code with a function force
    constants  values of the parameters
    law        the lines that define it for lanes, see `BuiltinForce`; "" for none
    names      the parameters in the user's notation, in the order of the constants
    """

    text: str
    source: str
    constants: tuple[float, ...]
    law: str = ""
    names: tuple[str, ...] = ()

    def __repr__(self) -> str:
        return self.text

    def __call__(self, q: Array, v: Array, t: float) -> Array:
        out = np.zeros((2, len(v)))
        numbers = np.array(self.constants)
        try:
            with np.errstate(all="ignore"):
                symbolic_code.functions(self.source)["force"].py_func(
                    q, v, np.float64(t), numbers, out
                )
        except (ArithmeticError, ValueError):  # math's functions raise where numpy's are NaN
            out[...] = np.nan
        result: Array = out[1]
        return result

    def compiled(self) -> tuple[Callable[..., Any], Array]:
        """Compiled function (q, v, t, constants, out (2, d)) that adds the force to the second row
        of out, and its constants."""
        return symbolic_code.functions(self.source)["force"], np.array(self.constants)


def symbolic_force(given: Expressions) -> SymbolicForce:
    """The generalised forces of these expressions, compiled."""
    assert given.forces is not None
    lines = symbolic_code.written(
        given.forces, given.places, lambda k, code: f"out[1, {k}] += {code}"
    )
    text = symbolic_code.source({"force": ("q, v, t, c, out", lines)})
    words = f"[{', '.join(map(given.text, given.forces))}]"
    law = printed_force(given.forces, given.places)
    return SymbolicForce(words, text, given.values, law, given.names)
