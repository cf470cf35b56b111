"""Compiles SymPy expressions of a Lagrangian and a force."""

from __future__ import annotations

import warnings
from typing import Any

from galvi.symbolic import code as symbolic_code
from galvi.symbolic import kinks, lane_law
from galvi.symbolic.force import SymbolicForce, symbolic_force
from galvi.symbolic.lagranges_method import is_lagranges_method, read_lagranges_method
from galvi.symbolic.parsing import Expressions, expressions
from galvi.symbolic.symbolic_lagrangian import SymbolicLagrangian


def symbolic(
    L: Any, q: Any, v: Any, t: Any, parameters: Any, force: Any
) -> tuple[SymbolicLagrangian, bool, SymbolicForce | None]:
    """The Lagrangian, whether it depends on the time, and the force or None.

    Raises ImportError without SymPy, TypeError or ValueError for unusable input; warns of a
    Lagrangian that is not twice differentiable somewhere.
    """
    sympy = sympy_module()
    if is_lagranges_method(L):
        if not (q is None and v is None and force is None):
            raise ValueError(
                "a LagrangesMethod brings its coordinates and forces; give only parameters, and t "
                "when it depends on the time."
            )
        L, q, force = read_lagranges_method(L)
    elif q is None:
        raise TypeError("q must hold the coordinates of the expression; received none.")
    given = expressions(L, q, v, t, parameters, force)
    surfaces = kinks.surfaces(given.L, {*given.q, *given.v, given.t})
    found = SymbolicLagrangian(
        given.text(given.L),
        _source(given, surfaces),
        given.values,
        len(given.q),
        tuple(map(given.text, surfaces)),
        ""
        if surfaces
        else lane_law.printed_law(
            given.q, given.v, given.t, given.L, given.places, kinks.differentiated
        ),
        sympy.srepr(given.L),
        given.names,
    )
    for k, words in enumerate(found.switching):
        where = kinks.find_kink(found, k)
        if where:
            warnings.warn(
                f"the Lagrangian is not twice differentiable where {words} changes its sign: its "
                f"{where} there. Steps across lose their order; smooth it, or end the run there.",
                stacklevel=3,
            )
    external = None if given.forces is None else symbolic_force(given)
    return found, given.t in given.L.free_symbols, external


def sympy_module() -> Any:
    """The module sympy; ImportError, saying what needs it, where it is not installed."""
    try:
        import sympy
    except ImportError as error:
        raise ImportError(
            f"galvi.Lagrangian.from_sympy needs SymPy: {error}. Install sympy."
        ) from error
    return sympy


def _source(given: Expressions, surfaces: tuple[Any, ...]) -> str:
    d, places = len(given.q), given.places
    by = [kinks.differentiated(given.L, x) for x in (*given.v, *given.q)]
    bodies = {
        "law": (by, lambda k, code: f"out[{k // d}, {k % d}] = {code}"),
        "value": ([given.L], lambda k, code: f"out[{k}] = {code}"),
        "switches": (surfaces, lambda k, code: f"out[{k}] = {code}"),
    }
    return symbolic_code.source(
        {
            name: ("q, v, t, c, out", symbolic_code.written(results, places, store))
            for name, (results, store) in bodies.items()
            if results
        }
    )
