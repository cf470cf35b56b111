"""Every law, by every kind of method, by each engine: all agree with Newton's method.

A law is an entry of LAWS, a kind of method one of METHODS, an engine one of ENGINES.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import cache
from typing import Any

import numpy as np
import pytest

import galvi
from galvi.lanes import vectors
from tests.galvi.ensemble_cases import CASES, starts

CHAIN = galvi.PlanarChain(np.full(5, 1.0), np.full(5, 0.4))
LAWS: dict[str, tuple[galvi.Problem, float]] = {
    **{name: (problem, 0.5 * step) for name, (problem, step) in CASES.items()},
    "five_rods": (
        galvi.Problem(
            galvi.Lagrangian(CHAIN, galvi.Rn(5)), [0.3, 0.1, -0.2, 0.4, 0.2], [0.5, 0, 0, -0.3, 0.1]
        ),
        0.02,
    ),
}
METHODS = {  # name -> degree, points
    "as many points, one vector": (5, 5),
    "as many points, two vectors": (9, 9),
    "more points, one vector": (4, 6),
    "more points, two vectors": (7, 9),
}
STEPS, MEMBERS = 6, 11
State = tuple[Any, Any]


def method_of(name: str) -> galvi.Galerkin:
    degree, points = METHODS[name]
    return galvi.Galerkin(galvi.Polynomials(degree), galvi.gauss(points))


def last(run: galvi.Trajectory) -> State:
    assert run.success, run.status
    return run.q[-1], run.p[-1]


def by_lanes(problem: Any, method: Any, step: float, steps: int = STEPS) -> galvi.Trajectory:
    run = galvi.integrate(problem, method, step, steps)
    assert run.engine == "lanes"
    return run


def whole(problem: Any, method: Any, step: float) -> State:
    """All steps of one run."""
    return last(by_lanes(problem, method, step))


def resumed(problem: Any, method: Any, step: float) -> State:
    """Two runs, of which the second goes on where the first ended: the same bits."""
    found = last(galvi.resume(by_lanes(problem, method, step, 2), STEPS - 2))
    for one, other in zip(found, whole(problem, method, step), strict=True):
        np.testing.assert_array_equal(one, other)
    return found


def members(problem: Any, method: Any, step: float, chosen: Any) -> Any:
    q, v = (x[chosen] for x in starts(problem, MEMBERS, 0.05))
    q[0], v[0] = problem.q0, problem.v0
    found = galvi.integrate_ensemble(problem, q, v, method, step, STEPS)
    assert found.success.all(), found.status
    return [np.asarray(found[k]) for k in (0, 1)]


def alone(problem: Any, method: Any, step: float) -> State:
    """A member of its own."""
    q, p = members(problem, method, step, slice(0, 1))
    return q[0], p[0]


def in_company(problem: Any, method: Any, step: float) -> State:
    """The first of some members: the same bits as alone."""
    q, p = members(problem, method, step, slice(0, MEMBERS))
    for one, other in zip((q[0], p[0]), alone(problem, method, step), strict=True):
        np.testing.assert_array_equal(one, other)
    return q[0], p[0]


ENGINES: dict[str, Callable[[Any, Any, float], State]] = {
    "in lanes, resumed": resumed, "member alone, in company": in_company
}  # fmt: skip


@cache
def by_newton(law: str, method: str) -> State:
    problem, step = LAWS[law]
    return last(galvi.integrate(problem, method_of(method), step, STEPS, solver="newton"))


def distance(found: State, truth: State) -> float:
    """The largest difference of places and momenta, relative to 1 and their size."""
    pairs = zip(found, truth, strict=True)
    return max(float(np.abs(a - b).max() / (1.0 + np.abs(b).max())) for a, b in pairs)


ALL = ("henon_heiles", "free_body", "se2 x r1")  # laws of which `make test` has every case
SOME = (  # of others, since each compiles its own pass
    ("as many points, one vector", "in lanes, resumed"),
    ("more points, two vectors", "member alone, in company"),
)


def cases() -> Iterator[Any]:
    for law in LAWS:
        for method in METHODS:
            for engine in ENGINES:
                left_out = law not in ALL and (method, engine) not in SOME
                yield pytest.param(law, method, engine, marks=[pytest.mark.slow] * left_out)


@pytest.mark.parametrize(("law", "method", "engine"), list(cases()))
def test_all_engines_agree(law: str, method: str, engine: str) -> None:
    problem, step = LAWS[law]
    found = ENGINES[engine](problem, method_of(method), step)
    assert distance(found, by_newton(law, method)) < 2e-13


@pytest.mark.slow_cases(but=ALL)
@pytest.mark.parametrize("law", LAWS)
def test_vectors_of_four_agree(law: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(vectors, "AVX512", False)
    problem, step = LAWS[law]
    method = "more points, two vectors"
    assert distance(whole(problem, method_of(method), step), by_newton(law, method)) < 2e-13
