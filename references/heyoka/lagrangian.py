"""Chains of rods and Lagrangians in coordinates, by heyoka."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache, lru_cache
from typing import Any, ClassVar

import numpy as np

from galvi import PlanarChain, Problem, Trajectory
from references.as_trajectory import as_trajectory
from references.contender import times_of_run
from references.heyoka import engine as heyoka_engine
from references.heyoka.engine import DOUBLE
from references.setting import described
from references.textbook.chain_equations import ChainEquations, is_chain
from references.textbook.lagrange_equations import (
    LagrangeEquations,
    is_constant,
    nodes,
    time_symbol,
)

DIGITS = 40  # of constants, more than quadruple precision has
TRANSLATABLE_NAMES = (  # of SymPy's types that heyoka can represent
    *("sin", "cos", "tan", "asin", "acos", "atan", "atan2", "exp", "log", "erf"),
    *("sinh", "cosh", "tanh", "asinh", "acosh", "atanh"),
    *("Add", "Mul", "Pow", "Symbol"),
)


def solved(M: list[list[Any]], b: list[Any]) -> list[Any]:
    """x with M x = b, by elimination without pivoting, as M is positive definite."""
    n = len(b)
    M, b = [list(row) for row in M], list(b)
    for k in range(n):
        for i in range(k + 1, n):
            ratio = M[i][k] / M[k][k]
            for j in range(k + 1, n):
                M[i][j] = M[i][j] - ratio * M[k][j]
            b[i] = b[i] - ratio * b[k]
    x: list[Any] = [None] * n
    for i in reversed(range(n)):
        upper_sum = sum((M[i][j] * x[j] for j in range(i + 1, n)), 0.0)
        x[i] = (b[i] - upper_sum) / M[i][i]
    return x


@dataclass(frozen=True)
class OnCoordinates:
    """Taylor's method on states (q, v), in double or quadruple precision.

    Attributes
    ----------
    precision
        "double", or "real128": numbers, times and states are quadruple throughout

    Notes
    -----
    Setting as `references.heyoka.taylor.HeyokaTaylor`.
    """

    fixed_step: ClassVar[bool] = False
    engine: ClassVar[str] = "heyoka"

    name: str
    precision: str = "double"
    exact: bool = False

    @property
    def missing(self) -> str:
        """Why heyoka cannot be used here; empty when it can."""
        return heyoka_engine.missing(self.precision)

    def supports(self, problem: Problem) -> bool:
        """Whether the equations of motion of a problem are known."""
        raise NotImplementedError

    def integrator(self, problem: Problem, tolerance: float, accurate: bool, compact: bool) -> Any:
        """heyoka's integrator for any start of the system."""
        raise NotImplementedError

    def run(self, problem: Problem, duration: float, setting: Mapping[str, Any]) -> Trajectory:
        """Adaptive steps; see `Contender`."""
        times = times_of_run(self, problem, duration, setting, *DOUBLE)
        options = heyoka_engine.options(setting, self.precision)
        engine = self.integrator(problem, *heyoka_engine.checked_options(options))
        start = np.concatenate([problem.q0, problem.v0])
        states, steps, failure = heyoka_engine.propagate(
            engine,
            start.astype(heyoka_engine.number_type(self.precision)),
            times - problem.t0,
            problem.t0,
            "the state is not finite.",
        )
        q, v = np.split(states.astype(np.float64), 2, axis=1)
        return as_trajectory(
            problem,
            described(self.name, {**setting, **options}, heyoka_engine.engine_name(self.precision)),
            times,
            q,
            v,
            counts={"steps": steps},
            failure=failure,
        )


def compiled(
    q: Sequence[Any],
    v: Sequence[Any],
    acceleration: Sequence[Any],
    precision: str,
    tolerance: float,
    accurate: bool,
    compact: bool,
) -> Any:
    """heyoka's integrator of q' = v, v' = acceleration, all lists of heyoka's expressions."""
    import heyoka

    number, state = heyoka_engine.number_type(precision), [*q, *v]
    return heyoka.taylor_adaptive(
        list(zip(state, [*v, *acceleration], strict=True)),
        np.zeros(len(state)).astype(number),
        time=number(0.0),
        tol=number(tolerance),
        high_accuracy=accurate,
        compact_mode=compact,
        fp_type=number,
    )


@dataclass(frozen=True)
class HeyokaChain(OnCoordinates):
    """A PlanarChain."""

    name: str = "heyoka, chains"

    def supports(self, problem: Problem) -> bool:
        """A Lagrangian that is a PlanarChain."""
        return is_chain(problem)

    def integrator(self, problem: Problem, tolerance: float, accurate: bool, compact: bool) -> Any:
        """As `OnCoordinates.integrator`."""
        return _compiled_chain(
            problem.system.function, self.precision, tolerance, accurate, compact
        )


@lru_cache(maxsize=16)
def _compiled_chain(
    chain: PlanarChain, precision: str, tolerance: float, accurate: bool, compact: bool
) -> Any:
    """heyoka's integrator of this chain, for any start."""
    import heyoka

    number = heyoka_engine.number_type(precision)
    equations = ChainEquations.of(chain, number)
    S, m = equations.levers, equations.masses
    n = len(m)
    q, v = (heyoka.make_vars(*(f"{name}{i}" for i in range(n))) for name in "qv")
    q, v = (x if n > 1 else [x] for x in (q, v))
    products = [
        [sum(m[k] * S[k, i] * S[k, j] for k in range(n)) for j in range(n)] for i in range(n)
    ]
    weight = [equations.gravity * sum(m[k] * S[k, i] for k in range(n)) for i in range(n)]
    M = [
        [heyoka.expression(products[i][j]) * heyoka.cos(q[i] - q[j]) for j in range(n)]
        for i in range(n)
    ]
    pull = []
    for i in range(n):
        M[i][i] = heyoka.expression(products[i][i] + equations.moments[i])
        across = [
            heyoka.expression(products[i][j]) * heyoka.sin(q[i] - q[j]) * v[j] * v[j]
            for j in range(n)
            if j != i
        ]
        pull.append(-sum(across, heyoka.expression(weight[i]) * heyoka.sin(q[i])))
    return compiled(q, v, solved(M, pull), precision, tolerance, accurate, compact)


HEYOKA_CHAIN = HeyokaChain()
HEYOKA_CHAIN_QUADRUPLE = HeyokaChain(
    "heyoka, chains, quadruple precision", precision="real128", exact=True
)


@dataclass(frozen=True)
class HeyokaLagrangian(OnCoordinates):
    """A problem of `references.textbook.lagrange_equations`."""

    name: str = "heyoka, Lagrangians"

    def supports(self, problem: Problem) -> bool:
        """A Lagrangian from SymPy without external force, or a Canonical whose functions can be
        written out, without branches, in functions that heyoka has."""
        equations = LagrangeEquations.of(problem)
        return equations is not None and all(
            issubclass(kind, _translatable()) for kind in equations.kinds
        )

    def integrator(self, problem: Problem, tolerance: float, accurate: bool, compact: bool) -> Any:
        """As `OnCoordinates.integrator`."""
        equations = LagrangeEquations.of(problem)
        assert equations is not None
        start_time = problem.t0 if equations.timed else 0.0
        return _compiled(equations, start_time, self.precision, tolerance, accurate, compact)


@cache
def _translatable() -> tuple[type, ...]:
    """The SymPy types that heyoka can represent."""
    import sympy

    return tuple(getattr(sympy, name) for name in TRANSLATABLE_NAMES)


@lru_cache(maxsize=16)
def _compiled(
    equations: LagrangeEquations,
    start_time: float,
    precision: str,
    tolerance: float,
    accurate: bool,
    compact: bool,
) -> Any:
    """heyoka's integrator of these equations, for any start at the time `start_time`."""
    import heyoka

    number = heyoka_engine.number_type(precision)
    translations = {x: heyoka.expression(str(x)) for x in (*equations.q, *equations.v)}
    translations[time_symbol()] = heyoka.time + heyoka.expression(number(start_time))

    def translated(expression: Any) -> Any:
        numbers = {x: _number(x, number) for x in nodes(expression) if is_constant(x)}
        return heyoka.from_sympy(expression, {**translations, **numbers})

    pull = [translated(x) for x in equations.pull]
    if equations.mass:
        pull = solved([[translated(x) for x in row] for row in equations.mass], pull)
    q, v = ([translations[x] for x in names] for names in (equations.q, equations.v))
    return compiled(q, v, pull, precision, tolerance, accurate, compact)


def _number(x: Any, number: Any) -> Any:
    """A constant in the engine's precision, exact if a double holds it."""
    import heyoka
    import sympy

    if x.is_Rational and sympy.Rational(float(x)) == x:
        return heyoka.expression(float(x))
    return heyoka.expression(number(str(sympy.N(x, DIGITS))))


HEYOKA_LAGRANGIAN = HeyokaLagrangian()
HEYOKA_LAGRANGIAN_QUADRUPLE = HeyokaLagrangian(
    "heyoka, Lagrangians, quadruple precision", precision="real128", exact=True
)
