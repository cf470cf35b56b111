"""Laws traced from a user's functions."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, cast

import numpy as np

from galvi.arrays import Array
from galvi.groups.group import Group, Rn
from galvi.systems.system import LagrangianKernel
from galvi.systems.traces import Untraceable
from galvi.tracing import code as symbolic_code
from galvi.tracing.code import POWER
from galvi.tracing.graph import Graph, Node
from galvi.tracing.graph_code import GraphCode
from galvi.tracing.graph_code import gradient as derivatives
from galvi.tracing.lane_law import (
    MAX_BUILT_IN_OPERATIONS,
    MAX_OPERATIONS,
    function_lines,
    function_of,
    law_lines,
)
from galvi.tracing.symbolic_lagrangian import SymbolicLagrangian
from galvi.tracing.trace_check import Sample, States, check_mass, check_slopes, check_values
from galvi.tracing.tracing import traced_nodes

Function = Callable[..., Any]


@dataclass(frozen=True, eq=False)
class TracedTerm:
    """A traced force or gradient: a function for lanes that returns a list of d values.

    Attributes
    ----------
    lines
        code that defines it
    constants
        constants c[0], c[1], ...
    sample
        the values of the traced function at some states
    """

    lines: str
    constants: tuple[float, ...]
    sample: Sample

    @property
    def holds(self) -> bool:
        return self.sample.holds

    def defined(self, q: Array, t: float) -> bool:
        """Whether the traced slopes(q, t, c) are finite at q and t."""
        with np.errstate(all="ignore"):
            slopes = function_of(self.lines, "slopes")(q, np.float64(t), np.array(self.constants))
        return bool(np.all(np.isfinite(np.array(slopes))))


def traced_force(
    force: Function,
    group: Group,
    q: Array,
    v: Array,
    t: float,
    timed: bool,
    scales: Sequence[Array],
) -> TracedTerm:
    """``force(q, v, t, c)`` from a user's force of (q, v), or of (q, v, t) if ``timed``.

    Parameters
    ----------
    q, v, t
        state near which the trace is checked
    scales : array, shape (d,)
        two arrays: lengths over which the force changes with q and with v

    Notes
    -----
    Raises `Untraceable`.
    """
    takes = "qvt" if timed else "qv"
    states = States.around(group, q, v, t, scales)
    sample = Sample.of(force, states, takes, v.size)
    nodes = traced_nodes(force, _symbols(q.shape, v.size, takes), (v.size,))
    return _term("force(q, v, t, c)", nodes, check_values(sample, nodes))


def traced_gradient(
    potential: Function, gradient: Function | None, q: Array, t: float, timed: bool, scale: Array
) -> TracedTerm:
    """``slopes(q, t, c)``, dV/dq, from a user's gradient, if given, else from the potential.

    The user's functions take (q), or (q, t) if ``timed``; scale (d,) and others as for
    `traced_force`. Raises `Untraceable`.
    """
    takes, scales = "qt" if timed else "q", (scale, np.zeros(q.size))
    states = States.around(Rn(q.size), q, np.zeros(q.size), t, scales)
    symbols = _symbols(q.shape, q.size, takes)
    if gradient is None:
        sample = Sample.of(potential, states, takes, 1)
        (V,) = traced_nodes(potential, symbols, ())
        check_values(sample, [V])
        nodes = derivatives(V, symbols[0])
        check_slopes(V, nodes, (), states, scales)
    else:
        sample = Sample.of(gradient, states, takes, q.size)
        nodes = traced_nodes(gradient, symbols, (q.size,))
        check_values(sample, nodes)
    return _term("slopes(q, t, c)", nodes, sample)


def _symbols(shape: tuple[int, ...], d: int, takes: str) -> list[Any]:
    graph, shapes = Graph(), {"q": shape, "v": (d,), "t": ()}
    return [graph.variables(name, *shapes[name]) for name in takes]


def _term(head: str, nodes: Sequence[Node], sample: Sample) -> TracedTerm:
    graph_code = GraphCode()
    lines, formulas = graph_code.written(nodes, POWER)
    if len(lines) > MAX_OPERATIONS:
        raise Untraceable(f"it takes more than {MAX_OPERATIONS} operations")
    return TracedTerm(function_lines(head, lines, formulas), graph_code.constants, sample)


@dataclass(frozen=True, eq=False)
class TracedLagrangian:
    """The law traced from a Lagrangian L(q, v) or L(q, v, t), or from its slopes.

    Attributes
    ----------
    law
        code that defines its law for lanes, see galvi.tracing.lane_law
    constants
        constants of the law
    lagrangian
        L with these derivatives; None if the user's slopes were traced instead of L
    samples
        the values of the traced functions at some states
    """

    law: str
    constants: tuple[float, ...]
    lagrangian: SymbolicLagrangian | None
    samples: tuple[Sample, ...]

    @property
    def holds(self) -> bool:
        return all(sample.holds for sample in self.samples)

    def defined(self, q: Array, v: Array, t: float) -> bool:
        """Whether the derivatives of the Lagrangian are finite at a state."""
        L = self.lagrangian
        return L is None or bool(np.all(np.isfinite(L.slopes(q, v, t))))


def traced_lagrangian(
    function: Function,
    slopes: Function | None,
    group: Group,
    q: Array,
    v: Array,
    t: float,
    timed: bool,
    scales: Sequence[Array],
) -> TracedLagrangian:
    """Trace the slopes, if given, else the Lagrangian, and check the law near a state.

    With slopes the Lagrangian is not called, since it is used for energies only.

    Parameters
    ----------
    slopes
        dL/dv and the Euclidean dL/dq in one vector, (d + entries of q,)
    timed
        whether the functions take (q, v, t) instead of (q, v)
    scales : array, shape (d,)
        two arrays: lengths over which L changes with q and with v

    Notes
    -----
    Raises `Untraceable`.
    """
    d, graph, takes = v.size, Graph(), "qvt" if timed else "qv"
    symbols = graph.variables("q", *q.shape), graph.variables("v", d), graph.variables("t")
    states, samples = States.around(group, q, v, t, scales), []
    entries = symbols[0].ravel()

    def trace(function: Function, shape: tuple[int, ...]) -> list[Node]:
        sample = Sample.of(function, states, takes, math.prod(shape))
        nodes = traced_nodes(function, symbols[: len(takes)], shape)
        samples.append(check_values(sample, nodes))
        return nodes

    L: Node | None = None
    if slopes is not None:
        euclidean = trace(slopes, (d + q.size,))
    else:
        (L,) = trace(function, ())
        euclidean = derivatives(L, [*symbols[1], *entries])
    momenta, left_derivative = euclidean[:d], states.chart.left_derivative(entries, euclidean[d:])
    slopes_of_L = [*momenta, *(x + graph.number(0.0) for x in left_derivative)]
    if L is not None:
        check_slopes(L, slopes_of_L[d:], slopes_of_L[:d], states, scales)
    graph_code, law = _law(slopes_of_L[d:], momenta, symbols[1])
    check_mass(law, graph_code.constants, slopes_of_L, states, scales)
    lagrangian = (
        None
        if L is None
        else _lagrangian(repr(function), graph_code, slopes_of_L, euclidean, L, law)
    )
    return TracedLagrangian(law, graph_code.constants, lagrangian, tuple(samples))


def traced_kernel(kernel: LagrangianKernel, d: int) -> tuple[str, Array]:
    """The law on R^d of a kernel with an external force, as code and constants.

    Raises `Untraceable`.
    """
    law, constants = kernel.function, kernel.constants
    force, force_constants = cast(Function, kernel.force), kernel.force_constants

    def slopes(q: Array, v: Array, t: float) -> Array:
        out = np.zeros((2, d))
        law(q, v, t, constants, out)
        force(q, v, t, force_constants, out)
        return out.ravel()

    symbols = _symbols((d,), d, "qvt")
    nodes = traced_nodes(slopes, symbols, (2 * d,))
    graph_code, lines = _law(nodes[d:], nodes[:d], symbols[1], MAX_BUILT_IN_OPERATIONS)
    return lines, np.array(graph_code.constants)


def _law(
    forces: Sequence[Node],
    momenta: Sequence[Node],
    v: Sequence[Node],
    max_operations: int = MAX_OPERATIONS,
) -> tuple[GraphCode, str]:
    """The `GraphCode` of a law, and the code that defines it; raises `Untraceable` above
    ``max_operations`` operations."""
    graph_code = GraphCode()
    lines, formulas = graph_code.written([*forces, *momenta, *mass(momenta, v)], POWER)
    if len(lines) > max_operations:
        raise Untraceable(f"its derivatives take more than {max_operations} operations")
    return graph_code, law_lines(lines, formulas, len(v))


def mass(momenta: Sequence[Node], v: Sequence[Node]) -> list[Node]:
    """The rows of d2L/dv2 up to the diagonal, one after the other."""
    rows = [derivatives(p, v[: i + 1]) for i, p in enumerate(momenta)]
    return [entry for row in rows for entry in row]


def _lagrangian(
    text: str,
    graph_code: GraphCode,
    slopes_of_L: Sequence[Node],
    euclidean: Sequence[Node],
    L: Node,
    law: str,
) -> SymbolicLagrangian:
    """L and its derivatives as a `SymbolicLagrangian` with the representation ``text``."""
    d, bodies = len(slopes_of_L) // 2, {}
    entries = [f"out[{k // d}, {k % d}]" for k in range(2 * d)]
    functions = [("law", slopes_of_L, entries), ("value", [L], ["out[0]"])]
    if [x.index for x in slopes_of_L] != [x.index for x in euclidean]:
        functions.append(("slopes", euclidean, [f"out[{k}]" for k in range(len(euclidean))]))
    for name, nodes, targets in functions:
        lines, formulas = graph_code.written(nodes)
        stores = [f"{target} = {code}" for target, code in zip(targets, formulas, strict=True)]
        bodies[name] = ("q, v, t, c, out", [*lines, *stores])
    return SymbolicLagrangian(text, symbolic_code.source(bodies), graph_code.constants, d, law=law)
