"""heyoka on any Lagrangian on R^d written in formulas: Taylor's method."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache, lru_cache
from typing import Any

from galvi import Problem
from references.heyoka import engine as heyoka_engine
from references.heyoka.elimination import solved
from references.heyoka.on_coordinates import OnCoordinates, compiled
from references.textbook.lagrange_equations import LagrangeEquations, time_symbol

KNOWN = (
    *("sin", "cos", "tan", "asin", "acos", "atan", "atan2", "exp", "log", "erf"),
    *("sinh", "cosh", "tanh", "asinh", "acosh", "atanh"),
    *("Add", "Mul", "Pow", "Symbol", "Rational"),
)


@dataclass(frozen=True)
class HeyokaLagrangian(OnCoordinates):
    """A problem of `references.textbook.lagrange_equations`."""

    name: str = "heyoka, Lagrangians"

    def supports(self, problem: Problem) -> bool:
        """A Lagrangian from SymPy, or a Canonical with a known potential or a compiled gradient
        without branches, of functions that heyoka has, without external force.
        """
        equations = LagrangeEquations.of(problem)
        return equations is not None and all(issubclass(kind, _known()) for kind in equations.kinds)

    def integrator(self, problem: Problem, tolerance: float, accurate: bool, compact: bool) -> Any:
        """As `OnCoordinates.integrator`."""
        equations = LagrangeEquations.of(problem)
        assert equations is not None
        began = problem.t0 if equations.timed else 0.0
        return _compiled(equations, began, self.precision, tolerance, accurate, compact)


@cache
def _known() -> tuple[type, ...]:
    """SymPy's types of what heyoka has."""
    import sympy

    return tuple(getattr(sympy, name) for name in KNOWN)


@lru_cache(maxsize=16)
def _compiled(
    equations: LagrangeEquations,
    began: float,
    precision: str,
    tolerance: float,
    accurate: bool,
    compact: bool,
) -> Any:
    """heyoka's integrator of these equations, for any start at the time `began`."""
    import heyoka
    import sympy

    number = heyoka_engine.kind(precision)
    known = {x: heyoka.expression(str(x)) for x in (*equations.q, *equations.v)}
    known[time_symbol()] = heyoka.time + heyoka.expression(number(began))

    def translated(expression: Any) -> Any:
        numbers = {x: _number(x, number) for x in expression.atoms(sympy.Rational)}
        return heyoka.from_sympy(expression, {**known, **numbers})

    pull = [translated(x) for x in equations.pull]
    if equations.mass:
        pull = solved([[translated(x) for x in row] for row in equations.mass], pull)
    q, v = ([known[x] for x in names] for names in (equations.q, equations.v))
    return compiled(q, v, pull, precision, tolerance, accurate, compact)


def _number(x: Any, number: Any) -> Any:
    """A rational in the engine's precision; one that double precision holds is exact in any."""
    import heyoka
    import sympy

    if sympy.Rational(float(x)) == x:
        return heyoka.expression(float(x))
    return heyoka.expression(number(int(x.p)) / number(int(x.q)))


HEYOKA_LAGRANGIAN = HeyokaLagrangian()
HEYOKA_LAGRANGIAN_QUADRUPLE = HeyokaLagrangian(
    "heyoka, Lagrangians, quadruple precision", precision="real128", exact=True
)
