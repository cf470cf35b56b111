"""Values of expressions with bounds on their rounding errors, by running error analysis.

N. Higham, Accuracy and Stability of Numerical Algorithms (2002), 3.3.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from galvi.arrays import Array
from galvi.symbolic.derivatives import reachable
from galvi.symbolic.graph import UNARY, Node

UNIT = 2.0**-52  # error of one operation, relative to its result


def evaluated(nodes: Sequence[Node], values: Mapping[str, Any]) -> tuple[Array, Array]:
    """The nodes (k, ...) and bounds of their rounding errors, from values (...) of the variables.

    values  name of a variable, such as "q[0]" -> its values

    Where an expression is undefined both are NaN or infinite.
    """
    x: dict[int, Any] = {}
    error: dict[int, Any] = {}
    with np.errstate(all="ignore"):
        for node in reachable(nodes):
            found: Any
            bound: Any
            if node.kind == "variable":
                found, bound = np.asarray(values[node.arguments[0]], dtype=np.float64), 0.0
            elif node.kind == "number":
                found, bound = np.float64(node.value), 0.0
            else:
                of = [y.index if isinstance(y, Node) else y for y in node.arguments]
                found, bound = _operation(
                    node.kind,
                    [x[k] if isinstance(k, int) else k for k in of],
                    [error[k] if isinstance(k, int) else 0.0 for k in of],
                )
            x[node.index], error[node.index] = found, bound + UNIT * np.abs(found)
    shape = np.broadcast_shapes(*(np.shape(each) for each in values.values()))
    rows = [x[node.index] for node in nodes], [error[node.index] for node in nodes]
    first, second = (np.array([np.broadcast_to(each, shape) for each in row]) for row in rows)
    return first, second


def _operation(kind: str, x: Sequence[Any], e: Sequence[Any]) -> tuple[Any, Any]:
    """The value, and what the errors of the arguments add to its error."""
    if kind in ("+", "-"):
        return (x[0] + x[1] if kind == "+" else x[0] - x[1]), e[0] + e[1]
    if kind == "*":
        return x[0] * x[1], np.abs(x[1]) * e[0] + np.abs(x[0]) * e[1]
    if kind == "atan2":
        square = x[0] * x[0] + x[1] * x[1]
        return np.arctan2(*x), (np.abs(x[1]) * e[0] + np.abs(x[0]) * e[1]) / square
    if kind == "power":
        found = x[0] ** x[1]
        by_log = np.where(e[1] > 0.0, np.abs(np.log(np.abs(x[0]))) * e[1], 0.0)
        return found, np.abs(found) * (np.abs(x[1] / x[0]) * e[0] + by_log)
    if kind == "inverse":
        found = 1.0 / x[0]
        return found, found * found * e[0]
    assert kind in UNARY
    found = getattr(np, kind)(x[0])
    slope = {
        "sin": 1.0, "cos": 1.0, "tan": 1.0 + found * found, "exp": found, "log": 1.0 / x[0],
        "sqrt": 0.5 / found, "sinh": np.cosh(x[0]), "cosh": np.sinh(x[0]), "tanh": 1.0,
    }[kind]  # fmt: skip
    return found, np.abs(slope) * e[0]
