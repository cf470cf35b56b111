"""Derivatives of expressions, by accumulation from the result backwards."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from galvi.symbolic.graph import Node


def reachable(nodes: Sequence[Node]) -> list[Node]:
    """The nodes and all those that they are made of, each after its arguments."""
    found, left = {}, list(nodes)
    while left:
        node = left.pop()
        if node.index not in found:
            found[node.index] = node
            left += [x for x in node.arguments if isinstance(x, Node)]
    return [found[k] for k in sorted(found)]


def gradient(node: Node, variables: Sequence[Node]) -> list[Node]:
    """The derivatives of a node by variables; the number 0 where it does not depend on one."""
    zero = node.graph.number(0.0)
    by = {node.index: node.graph.number(1.0)}
    for each in reversed(reachable([node])):
        adjoint = by.get(each.index)
        if adjoint is None:
            continue
        for argument, partial in partials(each):
            so_far = by.get(argument.index)
            term = adjoint * partial
            by[argument.index] = term if so_far is None else so_far + term
    return [by.get(x.index, zero) for x in variables]


def partials(node: Node) -> list[tuple[Node, Node]]:
    """The arguments that are no numbers, each with the derivative by it."""
    if node.kind in ("number", "variable"):
        return []
    x, *others = node.arguments
    one = node.graph.number(1.0)
    if not others:
        return [(x, _derivative(node, x))]
    y = others[0]
    if node.kind == "+":
        pair = one, one
    elif node.kind == "-":
        pair = one, -one
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
    one = node.graph.number(1.0)
    found: dict[str, Callable[[], Node]] = {
        "inverse": lambda: -(node * node),
        "sin": x.cos,
        "cos": lambda: -x.sin(),
        "tan": lambda: one + node * node,
        "exp": lambda: node,
        "sinh": x.cosh,
        "cosh": x.sinh,
        "tanh": lambda: one - node * node,
        "log": lambda: one / x,
        "sqrt": lambda: one / (node + node),
    }
    return found[node.kind]()
