"""heyoka on any Lagrangian on R^d written in formulas: Taylor's method."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
import sympy

from galvi import Problem, Trajectory
from references.as_trajectory import as_trajectory
from references.contender import require
from references.heyoka import engine as heyoka_engine
from references.heyoka.elimination import solved
from references.heyoka.engine import DEFAULT
from references.setting import check_keys, described, sample_times
from references.textbook.lagrange_equations import TIME, LagrangeEquations

FUNCTIONS = {
    *(sympy.sin, sympy.cos, sympy.tan, sympy.asin, sympy.acos, sympy.atan, sympy.atan2),
    *(sympy.sinh, sympy.cosh, sympy.tanh, sympy.asinh, sympy.acosh, sympy.atanh),
    *(sympy.exp, sympy.log, sympy.erf),
}
OPERATIONS = (sympy.Add, sympy.Mul, sympy.Pow, sympy.Symbol, sympy.Rational)


@dataclass(frozen=True)
class HeyokaLagrangian:
    """A problem of `references.textbook.lagrange_equations`, in double or quadruple precision.

    precision  "double", or "real128": numbers, times and states are quadruple throughout

    Setting as `references.heyoka.taylor.HeyokaTaylor`.
    """

    name: str = "heyoka, Lagrangians"
    precision: str = "double"
    exact: bool = False

    @property
    def missing(self) -> str:
        """Why heyoka cannot be used here; empty when it can."""
        return heyoka_engine.missing(self.precision)

    def supports(self, problem: Problem) -> bool:
        """A Lagrangian from SymPy, or a Canonical with a known potential or a compiled gradient
        without branches, of functions that heyoka has, without external force.
        """
        equations = LagrangeEquations.of(problem)
        return equations is not None and all(
            kind in FUNCTIONS or issubclass(kind, OPERATIONS) for kind in equations.kinds
        )

    def run(self, problem: Problem, duration: float, setting: Mapping[str, Any]) -> Trajectory:
        """Adaptive steps; see `Contender`."""
        require(self, problem)
        check_keys(setting, ("samples", *DEFAULT))
        times = sample_times(problem.t0, duration, setting)
        options = heyoka_engine.options(setting, self.precision)
        number = heyoka_engine.kind(self.precision)
        equations = LagrangeEquations.of(problem)
        assert equations is not None
        began = problem.t0 if equations.timed else 0.0
        engine = _compiled(equations, began, self.precision, *heyoka_engine.switches(options))
        start = np.concatenate([problem.q0, problem.v0]).astype(number)
        states, steps, failure = heyoka_engine.propagated(
            engine, start, times - problem.t0, problem.t0, "the state is not finite."
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

    number = heyoka_engine.kind(precision)
    names = [*equations.q, *equations.v]
    known = {x: heyoka.expression(str(x)) for x in names}
    known[TIME] = heyoka.time + heyoka.expression(number(began))

    def translated(expression: Any) -> Any:
        numbers = {x: _number(x, number) for x in expression.atoms(sympy.Rational)}
        return heyoka.from_sympy(expression, {**known, **numbers})

    pull = [translated(x) for x in equations.pull]
    if equations.mass:
        pull = solved([[translated(x) for x in row] for row in equations.mass], pull)
    slopes = [*(known[x] for x in equations.v), *pull]
    return heyoka.taylor_adaptive(
        list(zip([known[x] for x in names], slopes, strict=True)),
        np.zeros(len(names)).astype(number),
        time=number(0.0),
        tol=number(tolerance),
        high_accuracy=accurate,
        compact_mode=compact,
        fp_type=number,
    )


def _number(x: Any, number: Any) -> Any:
    """A rational in the engine's precision; one that double precision holds is exact in any."""
    import heyoka

    if sympy.Rational(float(x)) == x:
        return heyoka.expression(float(x))
    return heyoka.expression(number(int(x.p)) / number(int(x.q)))


HEYOKA_LAGRANGIAN = HeyokaLagrangian()
HEYOKA_LAGRANGIAN_QUADRUPLE = HeyokaLagrangian(
    "heyoka, Lagrangians, quadruple precision", precision="real128", exact=True
)
