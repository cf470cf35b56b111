"""Runs a function of numbers on SymPy's symbols, which writes out the formula it computes."""

from __future__ import annotations

import operator
from collections.abc import Callable, Iterable
from typing import Any

import numpy as np
from numba.core.registry import CPUDispatcher

from galvi.arrays import Array


class Written:
    """A SymPy expression that takes part in arithmetic, where every number is the rational it is.

    numpy's elementary functions work on it by the methods of their names. It cannot be compared:
    code that branches on it raises TypeError.
    """

    __hash__ = None  # type: ignore[assignment]

    def __init__(self, expression: Any) -> None:
        self.expression = expression

    def __eq__(self, other: object) -> bool:
        raise TypeError("an expression has no value to compare.")

    def __bool__(self) -> bool:
        raise TypeError("an expression has no value to branch on.")

    def __neg__(self) -> Written:
        return Written(-self.expression)


def _exact(x: Any) -> Any:
    import sympy

    return x.expression if isinstance(x, Written) else sympy.Rational(float(x))


def _elementary(name: str) -> Any:
    import sympy

    return getattr(sympy, name)


def _add_operations() -> None:
    for name in ("add", "sub", "mul", "truediv", "pow"):
        of = getattr(operator, name)
        setattr(Written, f"__{name}__",
                lambda a, b, of=of: Written(of(a.expression, _exact(b))))  # fmt: skip
        setattr(Written, f"__r{name}__",
                lambda a, b, of=of: Written(of(_exact(b), a.expression)))  # fmt: skip
    for name in ("sin", "cos", "tan", "exp", "log", "sqrt"):
        setattr(Written, name, lambda a, name=name: Written(_elementary(name)(a.expression)))


_add_operations()


def written(expressions: Iterable[Any]) -> Array:
    """An array of them, for a function to compute with."""
    return np.array([Written(x) for x in expressions], dtype=object)


def formulas_of(function: Callable[..., Any], *arguments: Any) -> tuple[Any, ...] | None:
    """The expressions in the array that a function returns; None where it cannot be run on them."""
    plain = function.py_func if isinstance(function, CPUDispatcher) else function
    try:
        return tuple(_exact(x) for x in plain(*arguments))
    except Exception:  # a user's function may raise anything, as where it branches on a symbol
        return None
