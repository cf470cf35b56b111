"""Stored truths for Lagrangians on R^d, written by `python -m references.stored.lagrangian`.

A file identifies its problem by its start, and by momenta, mass matrix and force at a state of
simple fractions, in 30 digits rounded to double. These do not depend on the form of the expression.
"""

from __future__ import annotations

import sys
from functools import lru_cache

from galvi import Problem, problems
from references.heyoka.lagrangian import HEYOKA_LAGRANGIAN_QUADRUPLE
from references.stored.states import Identity, StoredStates
from references.textbook.lagrange_equations import LagrangeEquations, time_symbol

DIGITS = 30


def _identity(problem: Problem) -> Identity:
    equations = LagrangeEquations.of(problem)
    assert equations is not None
    return {
        **_at_a_state(equations),
        "q0": problem.q0.tolist(),
        "v0": problem.v0.tolist(),
    }


@lru_cache(maxsize=32)
def _at_a_state(equations: LagrangeEquations) -> Identity:
    import sympy

    state = {x: sympy.Rational(k + 2, k + 3) for k, x in enumerate(equations.q)}
    state |= {x: sympy.Rational(2 * k + 1, k + 4) for k, x in enumerate(equations.v)}
    state[time_symbol()] = sympy.Rational(1, 2)
    rows = {"momenta": equations.momenta, "mass": sum(equations.mass, ()), "force": equations.pull}
    return {
        name: [float(x.evalf(DIGITS, subs=state)) for x in row] for name, row in rows.items() if row
    }


STORED_LAGRANGIAN = StoredStates(
    name="stored truth, Lagrangians",
    module="references.stored.lagrangian",
    makers={
        "elastic_pendulum": (problems.elastic_pendulum, 10.0),
        "henon_heiles": (problems.henon_heiles, 40.0),
        "fermi_pasta_ulam_tsingou": (problems.fermi_pasta_ulam_tsingou, 20.0),
    },
    engine=HEYOKA_LAGRANGIAN_QUADRUPLE,
    knows=lambda problem: LagrangeEquations.of(problem) is not None,
    identity=_identity,
    columns=lambda problem: [f"{x}{i}" for x in "qp" for i in range(problem.q0.size)],
)

if __name__ == "__main__":
    STORED_LAGRANGIAN.write(sys.argv[1:])
