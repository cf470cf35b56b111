"""Functions traced on symbols: their values, and their derivatives against complex steps."""

from __future__ import annotations

import functools
import math
from math import hypot, sin
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st
from numba import njit

from galvi.groups.group import Rn
from galvi.systems.traces import Untraceable
from galvi.tracing import graph_code, traced_lagrangian
from galvi.tracing.graph import Graph
from galvi.tracing.trace_check import values_and_bounds
from galvi.tracing.traced_lagrangian import traced_force, traced_gradient
from galvi.tracing.traced_lagrangian import traced_lagrangian as trace_lagrangian
from galvi.tracing.tracing import traced_nodes

Q, V, T = np.array([0.7, -0.4]), np.array([0.3, 0.9]), 0.6
SCALES = np.ones(2), np.ones(2)
STEP = 1e-30  # of complex differences, which have no cancellation


def law_and_trace(function: Any, slopes: Any = None, timed: bool = False, q: Any = Q) -> Any:
    """The law, as a function of (q, v, t), and the trace that it is from."""
    scales = np.ones(len(q))
    trace = trace_lagrangian(
        function, slopes, Rn(len(q)), q, np.resize(V, len(q)), T, timed, (scales, scales)
    )
    names: dict[str, Any] = {}
    exec(trace.law, names)
    return lambda q, v, t=0.0: names["law"](q, v, t, trace.constants), trace


def by_complex_steps(f: Any, x: Any) -> Any:
    """The derivatives of f by the entries of x, along the last axis."""
    return np.stack([np.imag(f(x + STEP * 1j * e)) / STEP for e in np.eye(x.size)], axis=-1)


def check(function: Any, q: Any = Q, v: Any = V) -> None:
    """Asserts that the law has the derivatives of the function, which must take complex numbers."""
    law, _ = law_and_trace(function, q=q)
    forces, momenta, rows = law(list(q), list(v))
    np.testing.assert_allclose(forces, by_complex_steps(lambda x: function(x, v), q), atol=1e-12)
    np.testing.assert_allclose(momenta, by_complex_steps(lambda x: function(q, x), v), atol=1e-12)
    mass = by_complex_steps(lambda x: np.array(law(list(q), list(x))[1]), v)
    lower = np.array([rows[max(i, j)][min(i, j)] for i in range(v.size) for j in range(v.size)])
    np.testing.assert_allclose(lower.reshape(mass.shape), mass, atol=1e-12)


LEAVES = st.sampled_from(["q[0]", "q[1]", "v[0]", "v[1]", "1.3", "-0.4", "2", "k", "0.0", "1.0"])
UNARY = st.sampled_from([
    "-{}", "np.sin({})", "np.cos({})", "np.exp(0.3 * {})", "np.sqrt(2.0 + ({}) ** 2)", "({}) ** 2",
    "({}) ** 3", "1.0 / (3.0 + np.sin({}))", "(2.1 + np.cos({})) ** 1.5", "np.arctan({})",
    "np.sinh(0.2 * {})", "np.cosh(0.2 * {})", "np.tanh({})",
    "np.log(1.5 + ({}) ** 2)", "(1.2 + ({}) ** 2) ** -0.7", "np.tan(0.2 * np.cos({}))",
    "np.sqrt(({}) ** 2 + 0.3) ** 2", "np.arcsin(0.6 * np.sin({}))", "1.3 ** np.cos({})",
    "(2.0 + np.sin({})) ** np.cos(q[1])", "np.power(1.5 + np.cos({}), 0.25)",
])  # fmt: skip
BINARY = st.sampled_from(["({} + {})", "({} - {})", "({} * {})", "({} / (3.0 + np.cos({})))"])
EXPRESSIONS = st.recursive(
    LEAVES,
    lambda inner: st.one_of(
        st.builds(lambda form, x: form.format(x), UNARY, inner),
        st.builds(lambda form, x, y: form.format(x, y), BINARY, inner, inner),
    ),
    max_leaves=12,
)


@settings(deadline=None, max_examples=80)
@given(EXPRESSIONS)
@example("np.arctan(q[0]) * 1.3 ** np.cos(v[1])")
def test_the_derivatives_of_an_expression_are_those_by_complex_steps(text: str) -> None:
    function: Any = eval(f"lambda q, v: {text} + 0.0 * q[0]", {"np": np, "k": 0.37})
    graph = Graph()
    q, v = graph.variables("q", 2), graph.variables("v", 2)
    (node,) = traced_nodes(function, (q, v), ())
    derivatives = graph_code.gradient(node, [*q, *v])
    values_of_symbols = {"q[0]": 0.7, "q[1]": -0.4, "v[0]": 0.3, "v[1]": 0.9}
    values, errors = values_and_bounds([node, *derivatives], values_of_symbols)
    assume(np.all(np.abs(values) < 1e6))
    x = np.array(list(values_of_symbols.values()))
    exact = by_complex_steps(lambda x: function(x[:2], x[2:]), x)
    limit = 1e3 * errors[1:] + 1e-12 * np.max(np.abs(exact))
    assert np.all(np.abs(values[1:] - exact) <= limit + 1e-15), (text, values[1:], exact)
    assert abs(values[0] - function(Q, V)) <= 16.0 * errors[0] + 1e-300
    printed = graph_code.GraphCode()
    lines, expressions = printed.written([node, *derivatives])
    names = {"q": Q, "v": V, "c": printed.constants, "atan2": np.arctan2, **vars(np)}
    exec("\n".join(lines), names)
    code = [eval(expression, names) for expression in expressions]
    np.testing.assert_allclose(code, values, rtol=0.0, atol=16.0 * np.max(errors) + 1e-300)


M = np.array([[2.0, 0.3], [0.3, 1.0]])


@njit
def sine_and_cube(x):
    return np.sin(x) + 0.1 * x**3


def arrays(q, v):
    products = np.zeros(2) + 0.0 * q * v
    products[0], products[1] = q[0] * v[1], np.sum(v)
    joined = np.concatenate([q, products])
    return 0.5 * v @ M @ v + np.dot(joined, joined) - np.sum(np.cos(q)) + np.outer(v, v).sum()


def scaled_and_inverse(q, v):
    inner = np.sqrt(3.0 * (q @ q)) / (q @ q) - 1.0 / (1.0 / (2.0 + q[1]))
    return inner * (v @ v) / 3.0 + v[0] / v[1] * (v[1] / 2.0) / v[0] + 0.0 * v[1]


@pytest.mark.parametrize("function", [arrays, scaled_and_inverse])
def test_the_law_of_a_function_has_its_derivatives(function: Any) -> None:
    check(function)


class Spring:
    def __init__(self, k):
        self.k = k

    def __call__(self, q, v, scale=1.0):
        return 0.5 * scale * v @ v - 0.5 * self.k * q @ q + math.cos(q[0])

    def method(self, q, v):
        return self(q, v)


def weighted(k, q, v, square=lambda x: x * x):
    return 0.5 * v @ v - 0.5 * k * square(q[0]) + sin(q[1]) + hypot(q[0], v[1])


def filled(q, v):
    copied, like, unit, mass = np.empty(2, float), np.zeros_like(q), np.ones_like(v), np.eye(2)
    sizes, first = np.full(2, 0.5, float), np.zeros(2, int)
    copied[:], like[0], unit[1], mass[0, 1], sizes[0] = q, q[1], v[0], q[0], v[1]
    return copied @ like + unit @ mass @ v + sizes @ q[first]


EQUAL_FUNCTIONS = {
    "new arrays": (
        filled,
        lambda q, v: (
            2 * q[0] * q[1]
            - q[0] * q[1]
            + v[0]
            + q[0] * v[1]
            + v[0] * v[1]
            + v[1] * q[0]
            + 0.5 * q[0]
        ),
    ),
    "an object": (Spring(3.0), Spring(3.0)),
    "a partial function": (functools.partial(weighted, 2.0), lambda q, v: weighted(2.0, q, v)),
    "a jitted function": (
        njit(lambda q, v: 0.5 * v @ v - sine_and_cube(q[0]) * q[1]),
        lambda q, v: 0.5 * v @ v - (math.sin(q[0]) + 0.1 * q[0] ** 3) * q[1],
    ),
    "functions of math": (
        lambda q, v: math.atan2(v[0], q[0]) + math.log(2 + math.exp(q[1]), 10) + math.pow(v[1], 2),
        lambda q, v: np.arctan2(v[0], q[0]) + np.log10(2 + np.exp(q[1])) + v[1] ** 2,
    ),
    "angles and roots": (
        lambda q, v: np.arccos(0.5 * q[0]) + abs(q[1]) * v[0] + np.linalg.norm(v) ** 2,
        lambda q, v: math.acos(0.5 * q[0]) + math.fabs(q[1]) * v[0] + v @ v,
    ),
    "a root over its square": (
        lambda q, v: v @ v * np.sqrt(1.0 + q[0] ** 2) / (1.0 + q[0] ** 2),
        lambda q, v: v @ v / math.sqrt(1.0 + q[0] ** 2),
    ),
    "degrees": (
        lambda q, v: np.sin(np.radians(40.0 * q))[0] + v @ np.diag([1.0, 2.0]) @ v,
        lambda q, v: math.sin(math.radians(40.0 * q[0])) + v[0] ** 2 + 2.0 * v[1] ** 2,
    ),
}


@pytest.mark.parametrize("name", EQUAL_FUNCTIONS)
def test_a_function_is_traced_however_it_is_written(name: str) -> None:
    first, second = EQUAL_FUNCTIONS[name]
    _, trace = law_and_trace(first)
    for q, v in np.random.default_rng(4).uniform(0.2, 0.9, (5, 2, 2)):
        assert trace.lagrangian(q, v) == pytest.approx(second(q, v), rel=1e-14)


FUNCTIONS = (
    *("sin", "cos", "tan", "exp", "log", "sqrt", "sinh", "cosh", "tanh", "arctan", "arcsin"),
    *("arccos", "log2", "log10", "radians", "degrees", "fabs", "deg2rad", "rad2deg"),
)


@pytest.mark.parametrize("name", FUNCTIONS)
def test_a_function_of_numpy_is_traced_as_itself(name: str) -> None:
    def lagrangian(q: Any, v: Any) -> Any:
        return v @ v + getattr(np, name)(0.5 * q[0] + 0.1 * v[1])

    _, trace = law_and_trace(lagrangian)
    assert trace.lagrangian(Q, V) == pytest.approx(lagrangian(Q, V), rel=1e-14)


def test_slopes_rule_over_the_lagrangian_and_their_mass_is_derived() -> None:
    def slopes(q: Any, v: Any) -> Any:
        out = np.empty(4)
        out[:2] = M @ v * (1.0 + 0.5 * v @ M @ v)
        out[2:] = -np.asarray(q, dtype=np.float64)
        return out

    law, trace = law_and_trace(lambda q, v: float(q[0]), slopes)
    assert trace.lagrangian is None
    forces, momenta, rows = law(list(Q), list(V))
    np.testing.assert_allclose([*momenta, *forces], slopes(Q, V), rtol=1e-15)
    mass = M * (1.0 + 0.5 * V @ M @ V) + np.outer(M @ V, M @ V)
    assert np.allclose([rows[0][0], *rows[1]], mass[np.tril_indices(2)], rtol=1e-14)


def test_numbers_are_constants_so_that_one_law_serves_all_values() -> None:
    def pendulum(k: float, l: float) -> Any:
        return lambda q, v: 0.5 * l * v @ v + k * np.cos(q[0]) - (q[1] - l) ** 2

    (_, first), (_, second) = (
        law_and_trace(pendulum(*numbers)) for numbers in ((3.7, 1.2), (5.1, 2.3))
    )
    assert first.law == second.law and first.constants != second.constants


def test_derivatives_that_are_always_0_cost_nothing() -> None:
    law, trace = law_and_trace(lambda q, v: 0.5 * v @ v + 0.0 * np.sin(q[1]) - q[0])
    assert law(list(Q), list(V)) == [[-1.0, 0.0], list(V), [[1.0], [0.0, 1.0]]]
    assert "sin" not in trace.law


def test_a_root_that_only_occurs_squared_has_derivatives_at_0() -> None:
    law, _ = law_and_trace(lambda q, v: 0.5 * np.linalg.norm(v) ** 2 - np.linalg.norm(q) ** 3)
    forces, momenta, _ = law([0.0, 0.0], [0.0, 0.0])
    assert forces == [0.0, 0.0] and momenta == [0.0, 0.0]


calls = []


def counting(q: Any, v: Any) -> Any:
    calls.append(0)
    return 0.5 * v @ v + len(calls) * q[0]


def catching(q: Any, v: Any) -> Any:
    try:
        return v @ v * float(q[0])
    except Exception:
        return v @ v


REFUSED = {
    "a branch": (lambda q, v: v @ v if q[0] > 0.0 else 2.0 * v @ v, "branches"),
    "the larger of two": (lambda q, v: v @ v + max(q[0], q[1]), "branches"),
    "numpy's larger of two": (lambda q, v: v @ v + np.maximum(q[0], q[1]), "branches"),
    "a conversion": (lambda q, v: 0.5 * v @ v + float(q[0]), "branches on, or converts"),
    "a linear system": (lambda q, v: v @ np.linalg.solve(M + np.diag(q), v), "LinAlg|UFunc|Type"),
    "random numbers": (lambda q, v: v @ v + np.random.default_rng().uniform() * q[0], "something"),
    "a counter": (counting, "something else"),
    "what catches exceptions": (catching, "converts"),
    "an error of its own": (lambda q, v: 1 // 0, "ZeroDivisionError"),
    "no number": (lambda q, v: "high", "real numbers"),
    "several numbers": (lambda q, v: v * v, r"shape \(\)"),
    "an unknown function": (lambda q, v: v @ v + math.erf(q[0]), "converts"),
    "a number that is not finite": (lambda q, v: v @ v + math.inf * q[0], "not finite"),
    "a division by 0": (lambda q, v: v @ v / 0.0, "divides by 0"),
    "a kink at the start": (lambda q, v: v @ v + abs(q[0] - 0.7), "not finite at the start"),
    "no value at the start": (lambda q, v: v @ v + np.sqrt(q[0] - 2.0), "not finite at"),
    "long code": (lambda q, v: v @ v + sum(np.sin(k * q[0]) for k in range(1500)), "than 4000"),
    "endless code": (lambda q, v: sum(np.sin(k * q[0]) for k in range(9000)), "20000 terms"),
}


@pytest.mark.slow_cases("long code")
@pytest.mark.parametrize("name", REFUSED)
def test_a_function_that_is_no_expression_is_refused_with_the_reason(name: str) -> None:
    function, reason = REFUSED[name]
    with pytest.raises(Untraceable, match=reason):
        law_and_trace(function)


def test_an_interrupt_passes_through() -> None:
    def interrupted(q: Any, v: Any) -> Any:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        law_and_trace(interrupted)


def without_second_partial(node: Any) -> Any:
    pairs = PARTIALS(node)
    return pairs[:1] if node.kind == "*" else pairs


def with_plus_for_minus(node: Any, code: Any, power: str) -> str:
    return FORMULA(node, code, power).replace(" - ", " + ")


def without_mass_coupling(momenta: Any, v: Any) -> Any:
    entries = MASS(momenta, v)
    entries[1] = 0.0 * entries[1]
    return entries


PARTIALS, FORMULA, MASS = graph_code.partials, graph_code._formula, traced_lagrangian.mass


@pytest.mark.parametrize(
    ("module", "name", "fault", "reason"),
    [
        (
            graph_code,
            "partials",
            without_second_partial,
            "its derivatives are not those of the function",
        ),
        (graph_code, "_formula", with_plus_for_minus, "its generated code is wrong"),
        (traced_lagrangian, "mass", without_mass_coupling, "its derivatives are not those"),
    ],
)
def test_planted_faults_of_the_tracer_are_caught(
    module: Any, name: str, fault: Any, reason: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(module, name, fault)
    with pytest.raises(Untraceable, match=reason):
        law_and_trace(lambda q, v: 0.5 * v @ M @ v - q[0] * np.sin(q[1]) + (q[0] - q[1]))


def test_a_force_and_a_gradient_are_traced_alike() -> None:
    def force(q: Any, v: Any, t: float) -> Any:
        return -0.3 * v * np.sqrt(v @ v) + np.array([math.sin(2.0 * t), 0.0])

    def potential(q: Any) -> Any:
        return 1.5 * q @ q + np.cos(q[0] * q[1])

    names: dict[str, Any] = {}
    traced_push = traced_force(force, Rn(2), Q, V, T, True, SCALES)
    exec(traced_push.lines, names)
    values = names["force"](list(Q), list(V), T, traced_push.constants)
    np.testing.assert_allclose(values, force(Q, V, T), rtol=1e-14)
    exact = by_complex_steps(potential, Q)
    for gradient in (None, lambda q: by_hand(q)):
        traced_potential = traced_gradient(potential, gradient, Q, T, False, SCALES[0])
        exec(traced_potential.lines, names)
        np.testing.assert_allclose(
            names["slopes"](Q, T, traced_potential.constants), exact, rtol=1e-14
        )
        assert traced_potential.holds
    with pytest.raises(Untraceable, match="branches"):
        traced_gradient(potential, lambda q: q if q[0] > 0.0 else -q, Q, T, False, SCALES[0])


def by_hand(q: Any) -> Any:
    return 3.0 * q - np.sin(q[0] * q[1]) * q[::-1]
