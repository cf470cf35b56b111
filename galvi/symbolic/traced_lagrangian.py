"""Derivatives of a user's Lagrangian, from expressions found by tracing its functions."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np

from galvi.arrays import Array
from galvi.symbolic import code as symbolic_code
from galvi.symbolic.code import POWER
from galvi.symbolic.derivatives import gradient
from galvi.symbolic.graph import Graph, Node, Untraceable
from galvi.symbolic.graph_code import GraphCode
from galvi.symbolic.lane_law import law_lines, law_source
from galvi.symbolic.symbolic_lagrangian import SymbolicLagrangian
from galvi.symbolic.trace_check import Sample, States, check_mass, check_slopes, check_values
from galvi.symbolic.tracing import traced

Function = Callable[..., Any]
_FOUND: WeakKeyDictionary[Any, TracedLagrangian | str] = WeakKeyDictionary()  # or why there is none


@dataclass(frozen=True, eq=False)
class TracedLagrangian:
    """What was found by tracing a Lagrangian L(q, v) or L(q, v, t) on R^d, or its slopes.

    law         source of the law for lanes, see galvi.symbolic.lane_law, external force included;
                "" where that cannot be traced
    constants   its constants
    lagrangian  L with these derivatives; None where only the slopes can be traced
    samples     what the traced functions returned at some states
    refusal     why there is no law; "" where there is one
    """

    law: str
    constants: tuple[float, ...]
    lagrangian: SymbolicLagrangian | None
    samples: tuple[Sample, ...]
    refusal: str = ""

    def defined(self, q: Array, v: Array, t: float) -> bool:
        """Whether the derivatives of the Lagrangian are finite at a state."""
        L = self.lagrangian
        return L is None or bool(np.all(np.isfinite(L.slopes(q, v, t))))

    @property
    def holds(self) -> bool:
        """Whether the functions return at the last states what they did when they were traced."""
        return all(sample.holds for sample in self.samples)


def renew(system: Any, trace: Callable[[], TracedLagrangian]) -> None:
    """Trace a system, unless that failed before, or what was found still holds."""
    known = _FOUND.get(system)
    if isinstance(known, str) or (known is not None and known.holds):
        return
    try:
        _FOUND[system] = trace()
    except Untraceable as reason:
        _FOUND[system] = str(reason)


def refuse(system: Any, reason: str) -> None:
    """Forget what was traced of a system."""
    _FOUND[system] = reason


def found(system: Any) -> TracedLagrangian | None:
    """What was traced of a system; None for nothing."""
    known = _FOUND.get(system)
    return None if isinstance(known, str) else known


def refusal(system: Any) -> str:
    """Why a system has no traced law; "" where it has one, or none was sought."""
    known = _FOUND.get(system, "")
    return known if isinstance(known, str) else known.refusal


def traced_lagrangian(
    function: Function, slopes: Function | None, q: Array, v: Array, t: float, timed: bool,
    scales: Sequence[Array], force: Function | None = None, timed_force: bool = False,
) -> TracedLagrangian:  # fmt: skip
    """Traces slopes, if given, else the Lagrangian, and checks what it finds near a state.

    timed   whether the functions take (q, v, t) instead of (q, v)
    scales  (d,), (d,) lengths over which L changes with q and v
    force   external force; timed_force: whether it takes (q, v, t)

    Raises `Untraceable`.
    """
    d, graph = q.size, Graph()
    symbols = graph.variables("q", d), graph.variables("v", d), graph.variables("t")
    states, samples = States.near(q, v, t, scales), []

    def find(function: Function, timed: bool, shape: tuple[int, ...]) -> list[Node]:
        takes = "qvt" if timed else "qv"
        nodes = traced(function, symbols[: len(takes)], shape)
        samples.append(check_values(function, nodes, states, takes))
        return nodes

    L: Node | None = None
    try:
        (L,) = find(function, timed, ())
    except Untraceable:
        if slopes is None:
            raise
    if slopes is not None:
        by = find(slopes, timed, (2 * d,))
    else:
        assert L is not None
        by = gradient(L, [*symbols[1], *symbols[0]])
        check_slopes(L, by[d:], by[:d], states, scales)
    pushed, refusal = by[d:], ""
    if force is not None:
        try:
            own = find(force, timed_force, (d,))
            pushed = [x + y for x, y in zip(pushed, own, strict=True)]
        except Untraceable as reason:
            refusal = f"the force: {reason}"
    printed, momenta = GraphCode(), by[:d]
    lines, results = printed.written([*pushed, *momenta, *mass(momenta, symbols[1])], POWER)
    lines_of_law = law_lines(lines, results, d)
    check_mass(lines_of_law, printed.constants, [*momenta, *pushed], states, scales)
    law = "" if refusal else law_source(lines_of_law, d)
    source = _source(printed, by, L)
    found = None if L is None else SymbolicLagrangian(
        repr(function), source, printed.constants, d, law="" if force is not None else law
    )  # fmt: skip
    return TracedLagrangian(law, printed.constants, found, tuple(samples), refusal)


def mass(momenta: Sequence[Node], v: Sequence[Node]) -> list[Node]:
    """The rows of d2L/dv2 up to the diagonal, one after the other."""
    rows = [gradient(p, v[: i + 1]) for i, p in enumerate(momenta)]
    return [entry for row in rows for entry in row]


def _source(printed: GraphCode, by: Sequence[Node], L: Node | None) -> str:
    """As of galvi.symbolic.from_sympy: the functions law and value."""
    d = len(by) // 2
    results = {"law": (by, [f"out[{k // d}, {k % d}]" for k in range(2 * d)])}
    if L is not None:
        results["value"] = ([L], ["out[0]"])
    bodies = {}
    for name, (nodes, places) in results.items():
        lines, found = printed.written(nodes)
        stored = [f"{place} = {code}" for place, code in zip(places, found, strict=True)]
        bodies[name] = ("q, v, t, c, out", [*lines, *stored])
    return symbolic_code.source(bodies)
