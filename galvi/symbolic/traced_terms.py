"""Terms of a law for lanes from a user's functions, by tracing: a force, and dV/dq."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from galvi.arrays import Array
from galvi.groups.group import Group
from galvi.groups.matrix_groups import Rn
from galvi.symbolic.code import POWER
from galvi.symbolic.derivatives import gradient as derivatives
from galvi.symbolic.graph import Graph, Node, Untraceable
from galvi.symbolic.graph_code import GraphCode
from galvi.symbolic.lane_law import LONGEST, function_lines
from galvi.symbolic.trace_check import Sample, States, check_slopes, check_values
from galvi.symbolic.tracing import traced

Function = Callable[..., Any]


@dataclass(frozen=True, eq=False)
class TracedTerm:
    """A function of galvi.kernels.lanes.elementary that returns a list of d values.

    lines      that define it
    constants  its own, c[0], c[1], ...
    sample     what the traced function returned at some states
    """

    lines: str
    constants: tuple[float, ...]
    sample: Sample

    @property
    def holds(self) -> bool:
        """As of galvi.symbolic.traces."""
        return self.sample.holds

    def defined(self, q: Array, t: float) -> bool:
        """Whether slopes(q, t, c) are finite there."""
        made: dict[str, Any] = {}
        exec(compile(self.lines, "<slopes>", "exec"), made)
        with np.errstate(all="ignore"):
            found = made["slopes"](q, np.float64(t), np.array(self.constants))
        return bool(np.all(np.isfinite(np.array(found))))


def traced_force(
    force: Function, group: Group, q: Array, v: Array, t: float, timed: bool,
    scales: Sequence[Array],
) -> TracedTerm:  # fmt: skip
    """``force(q, v, t, c)`` from a user's force of (q, v), or of (q, v, t) if ``timed``.

    q, v, t  state near which it is checked
    scales   (d,), (d,) lengths over which it changes with q and v

    Raises `Untraceable`.
    """
    takes = "qvt" if timed else "qv"
    states = States.near(group, q, v, t, scales)
    sample = Sample.of(force, states, takes, v.size)
    nodes = traced(force, _symbols(q.shape, v.size, takes), (v.size,))
    return _term("force(q, v, t, c)", nodes, check_values(sample, nodes))


def traced_gradient(
    potential: Function, gradient: Function | None, q: Array, t: float, timed: bool, scale: Array
) -> TracedTerm:
    """``slopes(q, t, c)``, dV/dq, from a user's gradient, if given, else from the potential.

    The user's functions take (q), or (q, t) if ``timed``; scale (d,) and others as for
    `traced_force`. Raises `Untraceable`.
    """
    takes, scales = "qt" if timed else "q", (scale, np.zeros(q.size))
    states = States.near(Rn(q.size), q, np.zeros(q.size), t, scales)
    symbols = _symbols(q.shape, q.size, takes)
    if gradient is None:
        sample = Sample.of(potential, states, takes, 1)
        (V,) = traced(potential, symbols, ())
        check_values(sample, [V])
        nodes = derivatives(V, symbols[0])
        check_slopes(V, nodes, (), states, scales)
    else:
        sample = Sample.of(gradient, states, takes, q.size)
        nodes = traced(gradient, symbols, (q.size,))
        check_values(sample, nodes)
    return _term("slopes(q, t, c)", nodes, sample)


def _symbols(shape: tuple[int, ...], d: int, takes: str) -> list[Any]:
    graph, shapes = Graph(), {"q": shape, "v": (d,), "t": ()}
    return [graph.variables(name, *shapes[name]) for name in takes]


def _term(head: str, nodes: Sequence[Node], sample: Sample) -> TracedTerm:
    printed = GraphCode()
    lines, results = printed.written(nodes, POWER)
    if len(lines) > LONGEST:
        raise Untraceable(f"it takes more than {LONGEST} operations")
    return TracedTerm(function_lines(head, lines, results), printed.constants, sample)
