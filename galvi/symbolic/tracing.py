"""Traces a function: calls it once on symbols, and finds the expressions that it returns."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from inspect import getattr_static
from types import FunctionType, MethodType
from typing import Any

import numpy as np
from numba.core.registry import CPUDispatcher

from galvi.symbolic.graph import Graph, Node, Untraceable
from galvi.symbolic.stand_ins import StandIns


def traced(
    function: Callable[..., Any], arguments: Sequence[Any], shape: tuple[int, ...]
) -> list[Node]:
    """The numbers that a function returns, as nodes: an array of this shape, () or (n,).

    arguments  nodes and arrays of nodes of one graph, which are not changed

    Numbers to which the function refers are those of now. Raises `Untraceable` for a function that
    needs a symbol's value, as a branch does, that calls what has no expression here, or that
    raises an exception of its own.
    """
    given = [x.copy() if isinstance(x, np.ndarray) else x for x in arguments]
    graph: Graph = next(x for a in given for x in np.ravel(a)).graph
    graph.refusal = ""
    try:
        with np.errstate(all="ignore"):
            result = np.asarray(_callable(function, StandIns(graph))(*given), dtype=object)
            found = [graph.lifted(x) for x in result.ravel()]
    except Untraceable:
        raise
    except Exception as error:  # whatever the function raises with symbols
        reason = graph.refusal or f"it raises {type(error).__name__} with symbols: {error}"
        raise Untraceable(reason) from error
    if graph.refusal:
        raise Untraceable(graph.refusal)
    nodes = [x for x in found if x is not None]
    if result.shape != shape or len(nodes) < result.size:
        raise Untraceable(f"it does not return real numbers of shape {shape}")
    return nodes


def _callable(function: Any, stand_ins: StandIns) -> Callable[..., Any]:
    call = getattr_static(function, "__call__", None)
    if not isinstance(function, CPUDispatcher) and isinstance(call, FunctionType):
        function = MethodType(call, function)
    found: Callable[..., Any] = stand_ins.replaced(function)
    return found
