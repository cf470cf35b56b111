"""Lagrangians, potentials and forces from SymPy."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable
from functools import partial, reduce
from types import SimpleNamespace
from typing import Any

import numpy as np
import sympy

from galvi.systems.traces import Untraceable
from galvi.tracing import code as symbolic_code
from galvi.tracing import kinks
from galvi.tracing.code import POWER
from galvi.tracing.expression import Expressions, expressions
from galvi.tracing.graph import Graph, Node
from galvi.tracing.graph_code import GraphCode, gradient
from galvi.tracing.lane_law import function_lines
from galvi.tracing.symbolic_lagrangian import SymbolicForce, SymbolicLagrangian
from galvi.tracing.traced_lagrangian import lagrangian_source, law_code

# Names of functions that SymPy prints for numpy -> kinds of nodes.
KINDS = {
    "abs": "abs", "sign": "sign", "floor": "floor", "ceil": "ceil", "expm1": "expm1",
    "log1p": "log1p", "erf": "erf", "erfc": "erfc", "gamma": "gamma", "loggamma": "lgamma",
    "arcsinh": "arcsinh", "arccosh": "arccosh", "arctanh": "arctanh", "less": "<",
    "less_equal": "<=", "greater": ">", "greater_equal": ">=", "equal": "==", "not_equal": "!=",
    "logical_not": "not",
}  # fmt: skip


Write = Callable[..., Any]  # of given expressions, and of one or several in their symbols


def written(what: str, write: Write, given: Expressions, *expressions: Any) -> Any:
    """What ``write`` makes of the expressions; ValueError where it cannot, naming the smallest
    part of which it cannot make anything."""
    try:
        return write(given, *expressions)
    except (ArithmeticError, AttributeError, NameError, TypeError, Untraceable) as error:
        parts = set().union(*(x.atoms(sympy.Function, sympy.Pow) for x in expressions))
        for part in sympy.ordered(parts - {*expressions}):
            written(what, write, given, part)
        why = error if isinstance(error, Untraceable) else "it has no compiled form"
        raise ValueError(
            f"{what} must be made of functions that can be compiled; received "
            f"{given.text(expressions[0])}: {why}. Write it in other functions, or give "
            f"galvi.Lagrangian functions of Python."
        ) from error


def nodes_of(given: Expressions, *expressions: Any) -> list[Node]:
    """The expressions as nodes of one graph."""
    graph = Graph(literal=True)
    lifted: Callable[[Any], Any] = graph.lifted

    def function_of(kind: str) -> Callable[..., Node]:
        return lambda *of: graph.node(kind, *map(lifted, of))

    def select(conditions: list[Any], values: list[Any], default: float) -> Node:
        (condition, *others), (value, *more) = conditions, values
        other = [select(others, more, default)] if others else []
        return graph.choice(condition, lifted(value), *other)

    names: dict[str, Any] = {name: function_of(kind) for name, kind in KINDS.items()}
    for kind in ("and", "or"):
        names[f"logical_{kind}"] = SimpleNamespace(reduce=partial(reduce, function_of(kind)))
    branching = [sympy.Max, sympy.Min, sympy.Heaviside, sympy.KroneckerDelta]
    plain = [
        x.rewrite([sympy.Mod, sympy.frac], sympy.floor)
        .rewrite(sympy.sinc, sympy.sin)
        .rewrite(branching, sympy.Piecewise)
        for x in expressions
    ]
    symbols, places = zip(*given.places.items(), strict=True)
    function = sympy.lambdify(symbols, plain, [names | {"select": select}, "numpy"], cse=True)
    with np.errstate(all="ignore"):
        return [lifted(x) for x in function(*map(graph.variables, places))]


def lagrangian_code(given: Expressions, L: Any, *surfaces: Any) -> tuple[str, str]:
    """The source of a `SymbolicLagrangian`, with ``switches`` that are the surfaces' values, and
    the lines of its law."""
    nodes, d = nodes_of(given, L, *surfaces), len(given.q)
    q, v = (nodes[0].graph.variables(name, d) for name in "qv")
    by = gradient(nodes[0], [*v, *q])
    printed, law = law_code(by[d:], by[:d], v, math.inf)
    switches = {"switches": nodes[1:]} if surfaces else {}
    return lagrangian_source(printed, by, value=nodes[:1], **switches), law


def symbolic_force(given: Expressions) -> SymbolicForce:
    """The generalised forces of these expressions, compiled."""
    assert given.forces is not None
    nodes, printed = written("the force", nodes_of, given, *given.forces), GraphCode()
    lines, results = printed.written(nodes)
    text = symbolic_code.source(
        {"force": lines + [f"out[1, {k}] += {code}" for k, code in enumerate(results)]}
    )
    words = f"[{', '.join(map(given.text, given.forces))}]"
    law = function_lines("force(q, v, t, c)", *printed.written(nodes, POWER))
    return SymbolicForce(words, text, given.values, law, given.names)


NAME = "LagrangesMethod"


def is_lagranges_method(value: Any) -> bool:
    """Whether a value is a `sympy.physics.mechanics.LagrangesMethod`, without importing that."""
    return any(
        kind.__name__ == NAME and kind.__module__.startswith("sympy.") for kind in type(value).mro()
    )


def read_lagranges_method(method: Any) -> tuple[Any, list[Any], list[Any] | None]:
    """L, the coordinates, and the generalised forces of its loads, or None.

    A load on a point or a frame has the force F . dv/dq' with its velocity, or angular velocity, v.
    Raises ValueError for one with constraints.
    """
    if len(method.coneqs):
        raise ValueError(
            f"a LagrangesMethod with constraints cannot be used; received {len(method.coneqs)} of "
            f"them. Choose coordinates that fulfil them."
        )
    (lagrangian,) = method._L
    coordinates = list(method.q)
    if not method.forcelist:
        return lagrangian, coordinates, None
    time = coordinates[0].args[0]
    rates = [x.diff(time) for x in coordinates]
    forces: list[Any] = [0] * len(coordinates)
    for place, load in method.forcelist:
        velocity = getattr(place, "ang_vel_in" if hasattr(place, "ang_vel_in") else "vel")
        moving = velocity(method.inertial)
        for k, rate in enumerate(rates):
            along = moving.diff(rate, method.inertial, var_in_dcm=False)
            forces[k] += along.dot(load)
    return lagrangian, coordinates, forces


def symbolic(
    L: Any, q: Any, v: Any, t: Any, parameters: Any, force: Any
) -> tuple[SymbolicLagrangian, bool, SymbolicForce | None]:
    """The Lagrangian, whether it depends on the time, and the force or None.

    Raises TypeError or ValueError for unusable input; warns of a Lagrangian that is not twice
    differentiable somewhere.
    """
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
    what = "the Lagrangian and its derivatives"
    source, law = written(what, lagrangian_code, given, given.L, *surfaces)
    found = SymbolicLagrangian(
        given.text(given.L),
        source,
        given.values,
        len(given.q),
        tuple(map(given.text, surfaces)),
        law,
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
