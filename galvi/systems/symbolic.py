"""A Lagrangian written in SymPy, its derivatives formed there and compiled."""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from typing import Any

import numpy as np

from galvi.arrays import Array
from galvi.kernels import slopes
from galvi.systems import kinks, symbolic_code
from galvi.systems.group_field import GroupField
from galvi.systems.symbolic_force import SymbolicForce, symbolic_force
from galvi.systems.symbolic_input import Expressions, expressions


@dataclass(frozen=True)
class SymbolicLagrangian:
    """L(q, v) or L(q, v, t) from `galvi.Lagrangian.from_sympy`; its repr is the expression.

    text       the expression, in the user's words
    source     the code made of it, with functions law, value and switches
    constants  the values of its parameters
    dimension  d
    switching  in words, what changes sign where L may not be twice differentiable
    """

    text: str
    source: str
    constants: tuple[float, ...]
    dimension: int
    switching: tuple[str, ...] = ()

    def __repr__(self) -> str:
        return self.text

    def __call__(self, q: Array, v: Array, *t: Any) -> float:
        return float(self._in_python("value", q, v, *t)[0])

    def slopes(self, q: Array, v: Array, *t: Any) -> Array:
        """dL/dv and dL/dq, (2 d,)."""
        return self._in_python("law", q, v, *t)

    def switches(self, q: Array, v: Array, *t: Any) -> Array:
        """The values of what ``switching`` names."""
        return self._in_python("switches", q, v, *t)

    def check_start(self, q: Array, v: Array, t: float) -> None:
        """ValueError where the motion starts on a kink, where L has no second derivatives."""
        for k, words in enumerate(self.switching):
            if kinks.at(self, k, q, v, t):
                raise ValueError(
                    f"the Lagrangian is not twice differentiable at the start, where {words} "
                    f"changes its sign. Start elsewhere, or smooth it."
                )

    def group_field(self) -> GroupField:
        """The same for the kernels."""
        law = symbolic_code.functions(self.source)["law"]
        return GroupField(slopes.LAW, law, constants=np.array(self.constants))

    def _in_python(self, name: str, q: Array, v: Array, t: float = 0.0) -> Array:
        function = symbolic_code.functions(self.source)[name].py_func
        sizes = {"law": 2 * self.dimension, "value": 1, "switches": len(self.switching)}
        out = np.full((2, self.dimension) if name == "law" else sizes[name], np.nan)
        with np.errstate(all="ignore"):
            try:
                function(np.asarray(q), np.asarray(v), np.float64(t), np.array(self.constants), out)
            except (ArithmeticError, ValueError):  # math's functions raise where numpy's are NaN
                out[...] = np.nan
        return out.ravel()


def symbolic(
    L: Any, q: Any, v: Any, t: Any, parameters: Any, force: Any
) -> tuple[SymbolicLagrangian, bool, SymbolicForce | None]:
    """L as a value, whether it takes the time, and the force or None.

    Raises ImportError without SymPy, TypeError or ValueError for what cannot be used; warns of a
    Lagrangian that is not twice differentiable somewhere.
    """
    try:
        import sympy  # noqa: F401
    except ImportError as error:
        raise ImportError(
            f"galvi.Lagrangian.from_sympy needs SymPy: {error}. Install sympy."
        ) from error
    given = expressions(L, q, v, t, parameters, force)
    surfaces = kinks.surfaces(given.L, {*given.q, *given.v, given.t})
    found = SymbolicLagrangian(
        given.text(given.L), _source(given, surfaces), given.values, len(given.q),
        tuple(map(given.text, surfaces)),
    )  # fmt: skip
    for k, words in enumerate(found.switching):
        where = kinks.somewhere(found, k)
        if where:
            warnings.warn(
                f"the Lagrangian is not twice differentiable where {words} changes its sign: its "
                f"{where} there. Steps across lose their order; smooth it, or end the run there.",
                stacklevel=3,
            )
    pushing = None if given.forces is None else symbolic_force(given)
    return found, given.t in given.L.free_symbols, pushing


def _source(given: Expressions, surfaces: tuple[Any, ...]) -> str:
    d, places = len(given.q), given.places
    by = [kinks.differentiated(given.L, x) for x in (*given.v, *given.q)]
    bodies = {
        "law": (by, lambda k, code: f"out[{k // d}, {k % d}] = {code}"),
        "value": ([given.L], lambda k, code: f"out[{k}] = {code}"),
        "switches": (surfaces, lambda k, code: f"out[{k}] = {code}"),
    }
    return symbolic_code.source({
        name: ("q, v, t, c, out", symbolic_code.written(results, places, store))
        for name, (results, store) in bodies.items() if results
    })  # fmt: skip
