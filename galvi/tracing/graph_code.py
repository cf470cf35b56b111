"""Derivatives of nodes of a graph, and their code."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from galvi.tracing.graph import Node


def reachable(nodes: Sequence[Node]) -> list[Node]:
    """The nodes and all that they depend on, each after its arguments."""
    by_index, pending = {}, list(nodes)
    while pending:
        node = pending.pop()
        if node.index not in by_index:
            by_index[node.index] = node
            pending += [x for x in node.arguments if isinstance(x, Node)]
    return [by_index[k] for k in sorted(by_index)]


def gradient(node: Node, variables: Sequence[Node]) -> list[Node]:
    """The derivatives of a node by variables; the number 0 for one that it does not depend on."""
    zero = node.graph.number(0.0)
    adjoints = {node.index: node.graph.number(1.0)}
    for descendant in reversed(reachable([node])):
        adjoint = adjoints.get(descendant.index)
        if adjoint is None:
            continue
        for argument, partial in partials(descendant):
            so_far = adjoints.get(argument.index)
            term = adjoint * partial
            adjoints[argument.index] = term if so_far is None else so_far + term
    return [adjoints.get(x.index, zero) for x in variables]


def partials(node: Node) -> list[tuple[Node, Node]]:
    """Pairs (argument, derivative by it) for the arguments that are no numbers."""
    if node.kind in ("number", "variable"):
        return []
    x, *second = node.arguments
    unit = node.graph.number(1.0)
    if not second:
        return [(x, _derivative(node, x))]
    y = second[0]
    if node.kind == "+":
        pair = unit, unit
    elif node.kind == "-":
        pair = unit, -unit
    elif node.kind == "*":
        pair = y, x
    elif node.kind == "atan2":
        inverse = 1.0 / (x * x + y * y)
        pair = y * inverse, -(x * inverse)
    elif not isinstance(y, Node):
        return [(x, y * x ** (y - 1.0))]
    else:
        pair = y * node / x, node * x.log()
    return [(a, b) for a, b in zip((x, y), pair, strict=True) if a.kind != "number"]


def _derivative(node: Node, x: Node) -> Node:
    """The derivative of a function of one argument."""
    unit = node.graph.number(1.0)
    derivatives: dict[str, Callable[[], Node]] = {
        "inverse": lambda: -(node * node),
        "sin": x.cos,
        "cos": lambda: -x.sin(),
        "tan": lambda: unit + node * node,
        "exp": lambda: node,
        "sinh": x.cosh,
        "cosh": x.sinh,
        "tanh": lambda: unit - node * node,
        "log": lambda: unit / x,
        "sqrt": lambda: unit / (node + node),
    }
    return derivatives[node.kind]()


LITERAL_NUMBERS = (0.0, 1.0, -1.0)


class GraphCode:
    """Python code of nodes, in which numbers other than 0, 1 and -1 are entries of the array
    ``c``."""

    def __init__(self) -> None:
        self.constant_indices: dict[float, int] = {}

    @property
    def constants(self) -> tuple[float, ...]:
        """The numbers in ``c``, in the order of their first use."""
        return tuple(self.constant_indices)

    def written(self, outputs: Sequence[Node], power: str = "") -> tuple[list[str], list[str]]:
        """Lines that compute the nodes, and the code of each.

        Parameters
        ----------
        power
            name of a function for powers; "" for the operator **
        """
        nodes = reachable(outputs)
        divisors = _divisors(nodes, outputs)
        code: dict[int, str] = {}
        lines: list[str] = []
        for node in nodes:
            if node.kind == "variable":
                code[node.index] = node.arguments[0]
            elif node.kind == "number":
                code[node.index] = self._number(node.value)
            elif node.index not in divisors:
                code[node.index] = f"x{len(lines)}"
                lines.append(f"{code[node.index]} = {_formula(node, code, power)}")
        return lines, [code[x.index] for x in outputs]

    def _number(self, value: float) -> str:
        if value in LITERAL_NUMBERS:
            return repr(value)
        return f"c[{self.constant_indices.setdefault(value, len(self.constant_indices))}]"


def _divisors(nodes: Sequence[Node], outputs: Sequence[Node]) -> set[int]:
    """Indices of the inverses whose only use is as a factor: that product is printed as a
    quotient."""
    uses = dict.fromkeys((x.index for x in outputs), 2)
    for node in nodes:
        for x in node.arguments:
            if isinstance(x, Node):
                uses[x.index] = uses.get(x.index, 0) + 1
    divisors: set[int] = set()
    for node in nodes:
        inverses = [x for x in node.arguments if node.kind == "*" and x.kind == "inverse"]
        divisors.update(x.index for x in inverses[:1] if uses[x.index] == 1)
    return divisors


def _formula(node: Node, code: dict[int, str], power: str) -> str:
    """The code of an operation, from the code of its arguments."""
    arguments = [code.get(x.index, "") if isinstance(x, Node) else repr(x) for x in node.arguments]
    if node.kind == "*":
        for x, y in (node.arguments, node.arguments[::-1]):
            if x.index not in code:
                return f"{code[y.index]} / {code[x.arguments[0].index]}"
        return f"-{arguments[1]}" if arguments[0] == "-1.0" else f"{arguments[0]} * {arguments[1]}"
    if node.kind in ("+", "-"):
        return f"{arguments[0]} {node.kind} {arguments[1]}"
    if node.kind == "inverse":
        return f"1.0 / {arguments[0]}"
    if node.kind != "power":
        return f"{node.kind}({', '.join(arguments)})"
    return f"{power}({', '.join(arguments)})" if power else f"{arguments[0]} ** {arguments[1]}"
