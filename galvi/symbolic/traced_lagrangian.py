"""Derivatives of a user's Lagrangian, from expressions found by tracing its functions."""

from __future__ import annotations

import logging
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
LOG = logging.getLogger("galvi")
_FOUND: WeakKeyDictionary[Any, TracedLagrangian | str] = WeakKeyDictionary()  # or why there is none


@dataclass(frozen=True, eq=False)
class TracedLagrangian:
    """What was found by tracing a Lagrangian L(q, v) or L(q, v, t) on R^d, or its slopes.

    law         source of the law for lanes, see galvi.symbolic.lane_law
    constants   its constants
    lagrangian  L with these derivatives; None where only the slopes can be traced
    samples     what the traced functions returned at some states
    """

    law: str
    constants: tuple[float, ...]
    lagrangian: SymbolicLagrangian | None
    samples: tuple[Sample, ...]

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
        refuse(system, str(reason))


def refuse(system: Any, reason: str) -> None:
    """Forget what was traced of a system, and say why."""
    _FOUND[system] = reason
    LOG.info("The functions of %r are called one state at a time: %s.", system, reason)


def found(system: Any) -> TracedLagrangian | None:
    """What was traced of a system; None for nothing."""
    known = _FOUND.get(system)
    return None if isinstance(known, str) else known


def untraced(system: Any) -> str:
    """Why a system could not be traced; "" where it was, or was not tried."""
    known = _FOUND.get(system)
    return known if isinstance(known, str) else ""


def traced_lagrangian(
    function: Function, slopes: Function | None, q: Array, v: Array, t: float, timed: bool,
    scales: Sequence[Array],
) -> TracedLagrangian:  # fmt: skip
    """Traces slopes, if given, else the Lagrangian, and checks what it finds near a state.

    timed   whether the functions take (q, v, t) instead of (q, v)
    scales  (d,), (d,) lengths over which L changes with q and v

    Raises `Untraceable`.
    """
    d, graph = q.size, Graph()
    x, w, time = graph.variables("q", d), graph.variables("v", d), graph.variables("t")
    given, takes = ((x, w, time), "qvt") if timed else ((x, w), "qv")
    states = States.near(q, v, t, scales)
    L: Node | None = None
    samples: list[Sample] = []
    try:
        (L,) = traced(function, given, ())
        samples = [check_values(function, [L], states, takes)]
    except Untraceable:
        if slopes is None:
            raise
        L = None
    if slopes is not None:
        by = traced(slopes, given, (2 * d,))
        samples.append(check_values(slopes, by, states, takes))
    else:
        assert L is not None
        by = gradient(L, [*w, *x])
        check_slopes(L, by[d:], by[:d], states, scales)
    printed = GraphCode()
    lines, results = printed.written([*by[d:], *by[:d], *mass(by[:d], w)], POWER)
    law = law_lines(lines, results, d)
    check_mass(law, printed.constants, by, states, scales)
    law, source = law_source(law, d), _source(printed, by, L)
    found = None if L is None else SymbolicLagrangian(
        repr(function), source, printed.constants, d, law=law
    )  # fmt: skip
    return TracedLagrangian(law, printed.constants, found, tuple(samples))


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
