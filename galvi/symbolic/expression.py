"""Checks that a user's SymPy expression is real and complete."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any


def in_words(expression: Any, words: Mapping[Any, str]) -> str:
    """The expression as text, its symbols replaced by these names."""
    import sympy

    return str(expression.xreplace({own: sympy.Symbol(name) for own, name in words.items()}))


def real_expression(what: str, expression: Any) -> Any:
    """The expression itself, numbers converted to SymPy.

    Raises TypeError for something that is no SymPy expression, ValueError for a complex or infinite
    one.
    """
    import sympy

    if isinstance(expression, int | float):
        expression = sympy.sympify(expression)
    if not isinstance(expression, sympy.Expr):
        shape = getattr(expression, "shape", None)
        received = repr(expression) if shape is None else f"a matrix of shape {shape}"
        remedy = " Take its entry, L[0]." if shape == (1, 1) else ""
        raise TypeError(f"{what} must be a SymPy expression; received {received}.{remedy}")
    infinite = (sympy.I, sympy.zoo, sympy.oo, -sympy.oo, sympy.nan)
    if expression.has(*infinite):
        raise ValueError(f"{what} must be real and finite; received {expression}.")
    return expression


def complete(
    what: str, found: Any, known: set[Any], words: Mapping[Any, str], names: set[str]
) -> Any:
    """The expression itself; ValueError for an unevaluated operation or an unknown symbol.

    known  all symbols that it may contain
    words  symbol -> its name in the user's notation
    names  names of the symbols given by the user; another symbol of such a name has different
           assumptions
    """
    import sympy
    from sympy.core.function import AppliedUndef

    left = found.atoms(
        sympy.Derivative, sympy.Integral, sympy.Sum, sympy.Product, sympy.Limit, sympy.Subs
    )
    if left:
        received = ", ".join(sorted(in_words(x, words) for x in left))
        raise ValueError(
            f"{what} must be an expression of q, v and t without derivatives, integrals or sums "
            f"left to do; received {received}. Call doit() on it, or replace velocities by those "
            f"in v.{unlike({*map(str, left)} & names)}"
        )
    unknown = {*map(str, found.free_symbols - known)}
    if unknown:
        raise ValueError(
            f"{what} must hold nothing but q, v, t and parameters; received "
            f"{', '.join(sorted(unknown))}.{_to_give(unknown - names)}{unlike(unknown & names)}"
        )
    undefined = found.atoms(AppliedUndef)
    if undefined:
        received = ", ".join(sorted(in_words(x, words) for x in undefined))
        raise ValueError(
            f"{what} must be made of known functions; received {received}. Put its formula in its "
            f"place.{unlike({*map(str, undefined)} & names)}"
        )
    if found.has(sympy.I, sympy.zoo, sympy.oo, -sympy.oo, sympy.nan):
        raise ValueError(
            f"{what} must be real and finite for real coordinates; received "
            f"{in_words(found, words)}."
        )
    return found


def _to_give(unknown: set[str]) -> str:
    """The remedy for symbols that were not given; '' for none."""
    if not unknown:
        return ""
    values = ", ".join(f"{name}: ..." for name in sorted(unknown))
    time = ", or t=t where it is the time" if "t" in unknown else ""
    return f" Give parameters={{{values}}}{time}."


def unlike(names: set[str]) -> str:
    """A sentence on symbols of the same name with different assumptions; '' for none."""
    if not names:
        return ""
    listed = ", ".join(sorted(names))
    return f" The given {listed} has other assumptions: use one symbol throughout."
