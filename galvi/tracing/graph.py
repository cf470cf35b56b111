"""Expressions as a graph in which equal expressions are one node, simplified when it is created.

Kinds of nodes, and their arguments:

number                      a value
variable                    its generated code, e.g. "q[0]"
"+", "-", "*"               two nodes; a number factor is the first argument
"inverse"                   a node x, for 1 / x
"atan2"                     two nodes
"power"                     two nodes, or a node and a number
sin, cos, ... of UNARY      a node

Nodes have the operators of numbers and the methods that numpy's functions call for an array of
objects, so that a function of numbers and arrays can be called on them. An operation that needs the
value of a node raises `Untraceable`.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Callable
from numbers import Real
from typing import Any, NoReturn

import numpy as np

from galvi.systems.traces import Untraceable

UNARY: dict[str, Callable[[float], float]] = {
    name: getattr(math, name)
    for name in ("sin", "cos", "tan", "exp", "log", "sqrt", "sinh", "cosh", "tanh")
}
ODD, EVEN = ("sin", "tan", "sinh", "tanh"), ("cos", "cosh")
MAX_NODES = 20_000  # largest number of nodes of a graph
MAX_FACTORS = 64  # largest integer power that is computed by products


class Graph:
    """The nodes of expressions, each after its arguments."""

    def __init__(self) -> None:
        self.nodes: dict[tuple[Any, ...], Node] = {}
        self.refusal = ""

    def node(self, kind: str, *arguments: Any) -> Node:
        """The node of this kind and arguments, new if there is none; it is not simplified."""
        key = (kind, *(x.index if isinstance(x, Node) else (x,) for x in arguments))
        node = self.nodes.get(key)
        if node is None:
            if len(self.nodes) == MAX_NODES:
                self.refuse(f"its derivatives have more than {MAX_NODES} terms")
            node = self.nodes[key] = Node(self, len(self.nodes), kind, arguments)
        return node

    def number(self, value: float) -> Node:
        """The node of a number; that of -0.0 is that of 0.0."""
        value = float(value)
        if not math.isfinite(value):
            self.refuse("it uses a number that is not finite")
        return self.node("number", value or 0.0)

    def variables(self, name: str, *shape: int) -> Any:
        """An array of variables name[0], name[1], ...; without a shape one variable ``name``."""
        if not shape:
            return self.node("variable", name)
        out = np.empty(math.prod(shape), dtype=object)
        out[:] = [self.node("variable", f"{name}[{i}]") for i in range(out.size)]
        return out.reshape(shape)

    def refuse(self, why: str) -> NoReturn:
        """Raise `Untraceable`, and store the reason, since the traced function may catch it."""
        self.refusal = self.refusal or why
        raise Untraceable(why)

    def as_node(self, x: Any) -> Node | None:
        """x as a node; None if it is neither a node nor a real number."""
        if isinstance(x, np.ndarray) and x.ndim == 0:
            x = x.item()
        if isinstance(x, Node):
            return x
        return self.number(float(x)) if isinstance(x, Real) else None

    def scaled(self, factor: float, x: Node | None) -> Node:
        """factor x, for a node without a number factor; None stands for 1."""
        if x is None or factor == 0.0:
            return self.number(factor)
        if factor == 1.0:
            return x
        if factor == -1.0 and x.kind == "-":
            return self.node("-", x.arguments[1], x.arguments[0])
        return self.node("*", self.number(factor), x)

    def sum(self, x: Node, y: Node) -> Node:
        """x + y; like terms are added."""
        (a, u), (b, w) = x.split, y.split
        if a == 0.0 or b == 0.0:
            return y if a == 0.0 else x
        if u is w:
            return self.scaled(a + b, u)
        if u is not None and w is not None and a == b == -1.0:
            return self.scaled(-1.0, self.sum(u, w))
        if w is not None and b == -1.0:
            return self.node("-", x, w)
        if u is not None and a == -1.0:
            return self.node("-", y, u)
        return self.node("+", *sorted((x, y), key=_index))

    def product(self, x: Node, y: Node) -> Node:
        """x y, with its number factor first."""
        (a, u), (b, w) = x.split, y.split
        factor = a * b
        if factor == 0.0 and a != 0.0 and b != 0.0:
            self.refuse("a product of its numbers underflows")
        if u is None or w is None:
            return self.scaled(factor, w if u is None else u)
        c, node = self._product(u, w).split
        return self.scaled(factor * c, node)

    def _product(self, u: Node, w: Node) -> Node:
        """u w; square roots and inverses of the same node cancel."""
        (base, halves), (base_w, halves_w) = _halves(u), _halves(w)
        halves += halves_w
        if base is not base_w or abs(halves) > 2:
            return self.node("*", *sorted((u, w), key=_index))
        power = (self.number(1.0), base.sqrt(), base)[abs(halves)]
        return self.inverse(power) if halves < 0 else power

    def inverse(self, x: Node) -> Node:
        """1 / x."""
        a, u = x.split
        if a == 0.0:
            self.refuse("it divides by 0")
        if u is None:
            return self.number(1.0 / a)
        return self.scaled(
            1.0 / a, u.arguments[0] if u.kind == "inverse" else self.node("inverse", u)
        )

    def unary(self, name: str, x: Node) -> Node:
        """The function ``name`` of `UNARY` at x; an odd or even one has a single node for x and
        -x."""
        a, u = x.split
        if u is None:
            try:
                return self.number(UNARY[name](a))
            except (ArithmeticError, ValueError):
                self.refuse(f"it takes {name} of {a}")
        if name in ODD + EVEN:
            has_swapped_arguments = u.kind == "-" and u.arguments[0].index < u.arguments[1].index
            if (a < 0.0) != has_swapped_arguments:
                node = self.node(name, -x)
                return -node if name in ODD else node
        return self.node(name, x)

    def power(self, x: Node, y: Node) -> Node:
        """x to the power y; by products if y is an integer up to MAX_FACTORS in size."""
        if y.kind != "number":
            return self.node("power", x, y)
        p = y.value
        if x.kind == "number":
            try:
                return self.number(math.pow(x.value, p))
            except (ArithmeticError, ValueError):
                self.refuse(f"it takes {x.value} to the power {p}")
        if p in (0.5, -0.5):
            return self.inverse(x.sqrt()) if p < 0.0 else x.sqrt()
        if p != int(p) or abs(p) > MAX_FACTORS:
            return self.node("power", x, p)
        product, square, exponent = self.number(1.0), x, abs(int(p))
        while exponent:
            product = product * square if exponent % 2 else product
            exponent //= 2
            square = square * square if exponent else square
        return self.inverse(product) if p < 0.0 else product


def _unary(name: str) -> Callable[[Any], Any]:
    def of_node(node: Node) -> Node:
        return node.graph.unary(name, node)

    return of_node


def _operator(operation: Callable[[Graph, Node, Node], Node]) -> Callable[[Node, Any], Any]:
    """A method of a node; NotImplemented for an operand that is neither a node nor a number."""

    def of_nodes(node: Node, operand: Any) -> Any:
        y = node.graph.as_node(operand)
        return NotImplemented if y is None else operation(node.graph, node, y)

    return of_nodes


def _comparison(compare: Callable[[Any, Any], bool]) -> Callable[[Node, Any], bool]:
    return lambda node, operand: compare(node.value, operand)


class Node:
    """An expression with the operators of numbers and the methods that numpy's functions call."""

    __slots__ = ("arguments", "graph", "index", "kind")
    __hash__ = None  # type: ignore[assignment]

    def __init__(self, graph: Graph, index: int, kind: str, arguments: tuple[Any, ...]) -> None:
        self.graph, self.index, self.kind, self.arguments = graph, index, kind, arguments

    @property
    def value(self) -> float:
        """The value of a number; `Untraceable` for any other node."""
        if self.kind != "number":
            self.graph.refuse("it branches on, or converts, an expression of the state")
        return float(self.arguments[0])

    @property
    def split(self) -> tuple[float, Node | None]:
        """The number factor, and the node that it multiplies; for a number, the node is None."""
        if self.kind == "number":
            return self.arguments[0], None
        if self.kind == "*" and self.arguments[0].kind == "number":
            return self.arguments[0].arguments[0], self.arguments[1]
        return 1.0, self

    __add__ = __radd__ = _operator(Graph.sum)
    __mul__ = __rmul__ = _operator(Graph.product)
    __sub__ = _operator(lambda graph, x, y: graph.sum(x, -y))
    __rsub__ = _operator(lambda graph, x, y: graph.sum(-x, y))
    __truediv__ = _operator(lambda graph, x, y: graph.product(x, graph.inverse(y)))
    __rtruediv__ = _operator(lambda graph, x, y: graph.product(graph.inverse(x), y))
    __pow__ = _operator(Graph.power)
    __rpow__ = _operator(lambda graph, x, y: graph.power(y, x))

    def __neg__(self) -> Node:
        a, u = self.split
        return self.graph.scaled(-a, u)

    def __pos__(self) -> Node:
        return self

    def __abs__(self) -> Node:
        return self.graph.unary("sqrt", self * self)  # exact, unless the square overflows

    def __float__(self) -> float:
        return self.value

    def __int__(self) -> int:
        return int(self.value)

    def __bool__(self) -> bool:
        return bool(self.value)

    __eq__, __lt__, __le__, __gt__, __ge__ = map(
        _comparison, (operator.eq, operator.lt, operator.le, operator.gt, operator.ge)
    )

    def __repr__(self) -> str:
        return f"<{self.kind} of the state>"

    sin, cos, tan, exp, log, sqrt, sinh, cosh, tanh = map(
        _unary, ("sin", "cos", "tan", "exp", "log", "sqrt", "sinh", "cosh", "tanh")
    )

    def arctan2(self, abscissa: Any) -> Node:
        """The angle of the point (abscissa, self)."""
        x = self.graph.as_node(abscissa)
        if x is None:
            self.graph.refuse("it takes an angle of what is no number")
        if self.kind == x.kind == "number":
            return self.graph.number(math.atan2(self.value, x.value))
        return self.graph.node("atan2", self, x)

    def arctan(self) -> Node:
        return self.arctan2(1.0)

    def arcsin(self) -> Node:
        return self.arctan2(((1.0 - self) * (1.0 + self)).sqrt())

    def arccos(self) -> Node:
        root: Node = ((1.0 - self) * (1.0 + self)).sqrt()
        return root.arctan2(self)

    def hypot(self, y: Any) -> Any:
        return (self * self + y * y) ** 0.5

    def log2(self) -> Any:
        return self.log() / math.log(2.0)

    def log10(self) -> Any:
        return self.log() / math.log(10.0)

    def radians(self) -> Any:
        return self * (math.pi / 180.0)

    def degrees(self) -> Any:
        return self * (180.0 / math.pi)

    def conjugate(self) -> Node:
        return self

    fabs, deg2rad, rad2deg = __abs__, radians, degrees


def _index(node: Node) -> int:
    return node.index


def _halves(x: Node) -> tuple[Node, int]:
    """(u, n) with x = u^(n / 2): n = 1 for sqrt(u), -2 for 1 / u, -1 for 1 / sqrt(u); else (x,
    2)."""
    inner, sign = (x.arguments[0], -1) if x.kind == "inverse" else (x, 1)
    return (inner.arguments[0], sign) if inner.kind == "sqrt" else (inner, 2 * sign)
