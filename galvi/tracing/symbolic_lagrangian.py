"""A Lagrangian from a SymPy expression, with compiled derivatives."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from galvi.arrays import Array
from galvi.tracing import code as symbolic_code
from galvi.tracing import kinks


@dataclass(frozen=True)
class SymbolicLagrangian:
    """L(q, v) or L(q, v, t) from `galvi.Lagrangian.from_sympy`; its repr is the expression.

    Attributes
    ----------
    text
        the expression in the user's notation
    source
        generated code with functions law, value and switches, and where q has other entries than v,
        slopes
    constants
        values of the parameters
    dimension
        d, the number of coordinates
    switching
        the expressions whose sign changes where L may not be C^2, in the user's notation
    law
        code that defines its law for lanes; "" if there is none
    expression
        L as text for sympy.sympify, exact, in the real symbols q0, ..., v0, ..., t, and c0, ... for
        the constants
    names
        the parameters in the user's notation, in the order of the constants
    """

    text: str
    source: str
    constants: tuple[float, ...]
    dimension: int
    switching: tuple[str, ...] = ()
    law: str = ""
    expression: str = ""
    names: tuple[str, ...] = ()

    def __repr__(self) -> str:
        return self.text

    def __call__(self, q: Array, v: Array, *t: Any) -> float:
        return float(self._in_python("value", q, v, *t)[0])

    def slopes(self, q: Array, v: Array, *t: Any) -> Array:
        """dL/dv and the Euclidean dL/dq, (d + entries of q,)."""
        return self._in_python("slopes" if "def slopes_" in self.source else "law", q, v, *t)

    def at_states(self, q: Array, v: Array, t: Array) -> tuple[Array, Array, Array]:
        """L (n,), L without velocities (n,) and dL/dv (n, d) at n states."""
        if " if " in self.source or "from math" in self.source:  # code for one state
            zeros = np.zeros(self.dimension)
            rows = [
                (self(*state), self(state[0], zeros, state[2]), self.slopes(*state))
                for state in zip(q, v, t, strict=True)
            ]
            value, at_rest, slopes = (np.array(column) for column in zip(*rows, strict=True))
            return value, at_rest, slopes[:, : self.dimension]
        functions = symbolic_code.functions(self.source)
        numbers, entries = np.array(self.constants), q.reshape(len(q), -1).T
        positions, velocities = entries[:, None], np.zeros((self.dimension, 2, len(q)))
        velocities[:, 0] = v.T
        values, derivatives = np.empty((1, 2, len(q))), np.empty((2, self.dimension, len(q)))
        with np.errstate(all="ignore"):
            functions["value"].py_func(
                positions, velocities, t, numbers, values
            )  # with v, and without
            functions["law"].py_func(entries, v.T, t, numbers, derivatives)
        return values[0, 0], values[0, 1], derivatives[0].T

    def check_start(self, q: Array, v: Array, t: float) -> None:
        """Raise ValueError if L is not C^2 at a state, see `galvi.tracing.kinks`."""
        kinks.check_start(self, q, v, t)

    def switches(self, q: Array, v: Array, *t: Any) -> Array:
        """The values of the expressions in ``switching``."""
        return self._in_python("switches", q, v, *t)

    def compiled(self) -> tuple[Callable[..., Any], Array]:
        """Compiled function (q, v, t, constants, out (2, d)) that fills the rows dL/dv and dL/dq,
        and its constants."""
        return symbolic_code.functions(self.source)["law"], np.array(self.constants)

    def _in_python(self, name: str, q: Array, v: Array, t: float = 0.0) -> Array:
        function = symbolic_code.functions(self.source)[name].py_func
        d, entries = self.dimension, np.ravel(q)
        sizes = {"slopes": d + entries.size, "value": 1, "switches": len(self.switching)}
        out = np.full((2, d) if name == "law" else sizes[name], np.nan)
        with np.errstate(all="ignore"):
            try:
                function(entries, np.asarray(v), np.float64(t), np.array(self.constants), out)
            except (ArithmeticError, ValueError):  # math's functions raise where numpy's are NaN
                out[...] = np.nan
        return out.ravel()
