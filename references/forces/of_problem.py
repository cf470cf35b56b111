"""SymPy expressions of a problem's functions of q, v and t on a vector space."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np

from galvi import Problem
from references.forces.force import points_around
from references.forces.on_symbols import SymbolicNumber, formulas_of, has_values, symbolic_array

# SymPy is imported where it is used: it takes a fifth of the import of the references.


@cache
def time_symbol() -> Any:
    """The symbol of the time."""
    import sympy

    return sympy.Symbol("t", real=True)


def symbols(d: int) -> tuple[tuple[Any, ...], tuple[Any, ...]]:
    """q0, q1, ... and v0, v1, ..., all real."""
    import sympy

    q, v = (tuple(sympy.Symbol(f"{x}{i}", real=True) for i in range(d)) for x in "qv")
    return q, v


def expressions_of(problem: Problem, function: Any, names: str) -> tuple[Any, ...] | None:
    """The expressions that a function returns on symbols; None if it fails on them.

    Parameters
    ----------
    names
        arguments of the function, such as "qt"
    """
    by_name = dict(zip("qv", symbols(problem.q0.size), strict=True))
    arguments = [
        SymbolicNumber(time_symbol()) if x == "t" else symbolic_array(by_name[x]) for x in names
    ]
    return formulas_of(function, *arguments)


def reproduces(problem: Problem, expressions: Any, function: Any, names: str) -> bool:
    """Whether the expressions reproduce the function's values at the start and around it."""
    by_name = {**dict(zip("qv", symbols(problem.q0.size), strict=True)), "t": time_symbol()}
    q, v = points_around(problem.q0), points_around(problem.v0)[::-1]
    t = problem.t0 + 0.37 * np.arange(len(q))
    points = zip(*({"q": q, "v": v, "t": t}[x] for x in names), strict=True)
    return has_values(expressions, [by_name[x] for x in names], function, points)
