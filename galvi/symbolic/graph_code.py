"""Prints expressions as lines of Python."""

from __future__ import annotations

from collections.abc import Sequence

from galvi.symbolic.derivatives import reachable
from galvi.symbolic.graph import Node

LITERAL = (0.0, 1.0, -1.0)


class GraphCode:
    """Prints nodes; numbers other than 0, 1 and -1 become entries of the array ``c``.

    constants  these numbers, in the order in which they were first printed
    """

    def __init__(self) -> None:
        self.places: dict[float, int] = {}

    @property
    def constants(self) -> tuple[float, ...]:
        """The numbers in c."""
        return tuple(self.places)

    def written(self, results: Sequence[Node], power: str = "") -> tuple[list[str], list[str]]:
        """Lines that compute the results, and the code of each result.

        power  name of a function for powers; "" for the operator **
        """
        nodes = reachable(results)
        divisors = _divisors(nodes, results)
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
        return lines, [code[x.index] for x in results]

    def _number(self, value: float) -> str:
        if value in LITERAL:
            return repr(value)
        return f"c[{self.places.setdefault(value, len(self.places))}]"


def _divisors(nodes: Sequence[Node], results: Sequence[Node]) -> set[int]:
    """The inverses that are used once, as a factor, so that the product can be a quotient."""
    uses = dict.fromkeys((x.index for x in results), 2)
    for node in nodes:
        for x in node.arguments:
            if isinstance(x, Node):
                uses[x.index] = uses.get(x.index, 0) + 1
    found: set[int] = set()
    for node in nodes:
        once = [x for x in node.arguments if node.kind == "*" and x.kind == "inverse"]
        found.update(x.index for x in once[:1] if uses[x.index] == 1)
    return found


def _formula(node: Node, code: dict[int, str], power: str) -> str:
    """The code of one operation from that of its arguments."""
    of = [code.get(x.index, "") if isinstance(x, Node) else repr(x) for x in node.arguments]
    if node.kind == "*":
        for x, y in (node.arguments, node.arguments[::-1]):
            if x.index not in code:
                return f"{code[y.index]} / {code[x.arguments[0].index]}"
        return f"-{of[1]}" if of[0] == "-1.0" else f"{of[0]} * {of[1]}"
    if node.kind in ("+", "-"):
        return f"{of[0]} {node.kind} {of[1]}"
    if node.kind == "inverse":
        return f"1.0 / {of[0]}"
    if node.kind != "power":
        return f"{node.kind}({', '.join(of)})"
    return f"{power}({', '.join(of)})" if power else f"{of[0]} ** {of[1]}"
