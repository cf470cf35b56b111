"""Runs numerical functions on SymPy symbols, to obtain the formulas that they compute."""

from __future__ import annotations

import operator
from collections.abc import Callable, Iterable, Sequence
from typing import Any

import numpy as np
from numba.extending import is_jitted

from galvi.arrays import Array
from references.forces.force import ROUNDING

# Largest number of operations of a formula; an iteration run on symbols doubles it each time.
MAX_OPERATIONS = 4000
MIN_POINTS = 4  # smallest number of points at which a formula is compared with its function
# numpy's elementary functions, which call the method of their name, and SymPy's
ELEMENTARY = {
    **{name: name for name in ("sin", "cos", "tan", "exp", "log", "sqrt", "sinh", "cosh", "tanh")},
    **{f"arc{name}": f"a{name}" for name in ("sin", "cos", "tan", "sinh", "cosh", "tanh")},
    "arctan2": "atan2",
    "__abs__": "Abs",
}


class SymbolicNumber:
    """A SymPy expression that numerical code can use as a number; floats become exact rationals.

    Parameters
    ----------
    length
        number of operations; ValueError above MAX_OPERATIONS

    Notes
    -----
    numpy's elementary functions call its methods of the same names. Comparisons, as in code that
    branches, raise TypeError.
    """

    __hash__ = None  # type: ignore[assignment]

    def __init__(self, expression: Any, length: int = 1) -> None:
        if length > MAX_OPERATIONS:
            raise ValueError(
                f"a formula takes at most {MAX_OPERATIONS} operations; received {length}."
            )
        self.expression, self.length = expression, length

    def __eq__(self, other: object) -> bool:
        raise TypeError("an expression has no value to compare.")

    def __bool__(self) -> bool:
        raise TypeError("an expression has no value to branch on.")

    def __neg__(self) -> SymbolicNumber:
        return SymbolicNumber(-self.expression, self.length)

    def hypot(self, side: Any) -> Any:
        """The root of the sum of both squares."""
        return np.sqrt(self * self + side * side)


class SymbolicArray(np.ndarray[Any, Any]):
    """An array of `Written` values, of which numpy also computes the Euclidean norm."""

    def __array_function__(self, func: Any, types: Any, args: Any, kwargs: Any) -> Any:
        if func is np.linalg.norm and len(args) == 1 and not kwargs:
            return np.sqrt(np.sum(np.ravel(args[0]) ** 2))
        return super().__array_function__(func, types, args, kwargs)


def _exact(x: Any) -> Any:
    import sympy

    x = x.item() if isinstance(x, np.ndarray) else x  # as sums of a WrittenArray
    return x.expression if isinstance(x, SymbolicNumber) else sympy.Rational(float(x))


def _applied(name: str, *operands: Any) -> Any:
    """The value of Python's operator or SymPy's function of this name; NotImplemented for
    arrays."""
    import sympy

    if any(isinstance(x, np.ndarray) and x.ndim for x in operands):
        return NotImplemented
    operation = getattr(operator, name, None) or getattr(sympy, name)
    length = 1 + sum(x.length for x in operands if isinstance(x, SymbolicNumber))
    return SymbolicNumber(operation(*map(_exact, operands)), length)


def _add_operations() -> None:
    for name in ("add", "sub", "mul", "truediv", "pow"):
        setattr(SymbolicNumber, f"__{name}__", lambda a, b, name=name: _applied(name, a, b))
        setattr(SymbolicNumber, f"__r{name}__", lambda a, b, name=name: _applied(name, b, a))
    for method, name in ELEMENTARY.items():
        setattr(SymbolicNumber, method, lambda *operands, name=name: _applied(name, *operands))


_add_operations()


def symbolic_array(expressions: Iterable[Any]) -> Array:
    """The expressions as a `WrittenArray`."""
    return np.array([SymbolicNumber(x) for x in expressions], dtype=object).view(SymbolicArray)


def formulas_of(function: Callable[..., Any], *arguments: Any) -> tuple[Any, ...] | None:
    """The entries, as expressions, of the array or number that a function returns; None if it
    cannot be run on symbols."""
    plain = function.py_func if is_jitted(function) else function
    try:
        return tuple(_exact(x) for x in np.ravel(plain(*arguments)))
    except Exception:  # a user's function may raise anything, as where it branches on a symbol
        return None


def has_values(
    formulas: Sequence[Any],
    symbols: Sequence[Any],
    function: Callable[..., Any],
    points: Iterable[Sequence[Any]],
) -> bool:
    """Whether formulas reproduce the values of a function, to rounding.

    Parameters
    ----------
    symbols
        for each argument of the function a symbol, or for an array a tuple of symbols
    points
        arguments at which to compare; the function must be finite at MIN_POINTS of them or more

    Notes
    -----
    Rounding is relative to the largest sum of the magnitudes of a formula's terms.
    """
    import sympy

    terms = [sympy.Add.make_args(formula) for formula in formulas]
    numbers = sympy.lambdify(symbols, terms, "numpy")
    compared = 0
    for point in points:
        arguments = [np.array(x, dtype=np.float64) for x in point]
        with np.errstate(all="ignore"):
            try:
                values = np.ravel(np.asarray(function(*_copies(arguments)), dtype=np.float64))
            except Exception:  # a user's function may raise anything, as outside of its domain
                continue
            if not np.all(np.isfinite(values)):
                continue
            rows = [np.array(row, dtype=np.float64) for row in numbers(*_copies(arguments))]
            gaps = np.abs(values - [row.sum() for row in rows]) if values.size == len(rows) else 1
        size = max(np.abs(row).sum() for row in rows)
        if not np.max(gaps) <= ROUNDING * size:
            return False
        compared += 1
    return compared >= MIN_POINTS


def _copies(arguments: Sequence[Array]) -> list[Any]:
    """Copies of the arrays, and the numbers as floats."""
    return [x.copy() if x.ndim else float(x) for x in arguments]
