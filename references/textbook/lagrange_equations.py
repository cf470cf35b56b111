"""Lagrange's equations in SymPy, derived from L itself, apart from galvi's derivatives.

M a = dL/dq - (d2L/dv dq) v - d2L/dv dt,   M = d2L/dv2
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache, cached_property, lru_cache
from operator import mul, truediv
from typing import Any

import numpy as np
from numba.core.registry import CPUDispatcher

from galvi import Canonical, Lagrangian, Problem
from galvi.arrays import Array
from references.forces.force import agrees, points_around
from references.forces.on_symbols import formulas_of, written
from references.newton import is_forced, potential_formula, replaces_force

# SymPy, where it is used, is imported: it takes a fifth of the import of the references.


@cache
def time_symbol() -> Any:
    """The symbol of the time."""
    import sympy

    return sympy.Symbol("t", real=True)


@dataclass(frozen=True)
class LagrangeEquations:
    """The equations of motion of d coordinates, without external force.

    q, v     the symbols, (d,) each; the time is `time_symbol`
    momenta  dL/dv, (d,)
    mass     M by rows, (d, d); () where the equations are solved for a
    pull     the right-hand side, (d,)

    All numbers are rationals, equal to those given.
    """

    q: tuple[Any, ...]
    v: tuple[Any, ...]
    momenta: tuple[Any, ...]
    mass: tuple[tuple[Any, ...], ...]
    pull: tuple[Any, ...]

    @staticmethod
    def of(problem: Problem) -> LagrangeEquations | None:
        """Of a Lagrangian from SymPy, or of a Canonical whose gradient is a formula of the
        references or a compiled function without branches; None of anything else.
        """
        system: Any = problem.system
        if is_forced(problem):
            return None
        if isinstance(system, Lagrangian):
            text = "" if system.slopes is not None else getattr(system.function, "expression", "")
            return _from_expression(text, system.function.constants) if text else None
        if isinstance(system, Canonical) and not system.explicit_time:
            return _from_potential(problem)
        return None

    @cached_property
    def timed(self) -> bool:
        """Whether they depend on the time."""
        return any(time_symbol() in x.free_symbols for x in (*self.pull, *sum(self.mass, ())))

    @cached_property
    def kinds(self) -> set[type]:
        """The types of all nodes of their expressions."""
        import sympy

        return {
            type(node)
            for one in (*self.pull, *sum(self.mass, ()))
            for node in sympy.preorder_traversal(one)
        }


def symbols(d: int) -> tuple[tuple[Any, ...], tuple[Any, ...]]:
    """q0, q1, ... and v0, v1, ..., all real."""
    import sympy

    q, v = (tuple(sympy.Symbol(f"{x}{i}", real=True) for i in range(d)) for x in "qv")
    return q, v


@lru_cache(maxsize=32)
def _from_expression(text: str, constants: tuple[float, ...]) -> LagrangeEquations:
    import sympy

    L = sympy.sympify(text)
    L = L.xreplace({x: sympy.Rational(x) for x in L.atoms(sympy.Float)})
    velocities = [x for x in L.free_symbols if x.name[0] == "v"]
    q, v = symbols(1 + max(int(x.name[1:]) for x in velocities))
    momenta = [L.diff(x) for x in v]
    mass = [[p.diff(x) for x in v] for p in momenta]
    pull = [
        L.diff(q[i]) - sum(p.diff(x) * w for x, w in zip(q, v, strict=True)) - p.diff(time_symbol())
        for i, p in enumerate(momenta)
    ]
    d = len(q)
    if all(mass[i][j] == 0 for i in range(d) for j in range(d) if i != j):
        pull, mass = [_shortest(pull[i] / mass[i][i]) for i in range(d)], []
    numbers = {sympy.Symbol(f"c{k}", real=True): sympy.Rational(x) for k, x in enumerate(constants)}
    p, a, *rows = (tuple(x.xreplace(numbers) for x in row) for row in (momenta, pull, *mass))
    return LagrangeEquations(q, v, p, tuple(rows), a)


def _shortest(ratio: Any) -> Any:
    """The ratio as it is or cancelled, whichever takes fewer operations."""
    import sympy

    return min((ratio, sympy.cancel(ratio)), key=sympy.count_ops)


def _from_potential(problem: Problem) -> LagrangeEquations | None:
    import sympy

    system: Any = problem.system
    if problem.q0.ndim != 1:
        return None
    if system.gradient is None or not replaces_force(problem):
        force = potential_formula(system.potential)
        if force is None or force.formula is None:
            return None
        pull = _pull_of_formula(force.formula, tuple(force.numbers.tolist()), problem.q0.size)
    else:
        if not isinstance(system.gradient, CPUDispatcher):
            return None
        pull = _pull_of_gradient(system.gradient, problem.q0.size)
    if pull is None:
        return None
    q, v = symbols(problem.q0.size)
    mass = system.mass
    if mass.ndim == 2:
        rows = tuple(tuple(sympy.Rational(x) for x in row) for row in mass.tolist())
        momenta = tuple(sum(m * w for m, w in zip(row, v, strict=True)) for row in rows)
        return LagrangeEquations(q, v, momenta, rows, pull)
    weights = [sympy.Rational(m) for m in np.broadcast_to(mass, problem.q0.shape).tolist()]
    momenta, solved = (
        tuple(of(x, m) for x, m in zip(some, weights, strict=True))
        for of, some in ((mul, v), (truediv, pull))
    )
    return LagrangeEquations(q, v, momenta, (), solved)


@lru_cache(maxsize=32)
def _pull_of_formula(formula: Any, numbers: tuple[float, ...], d: int) -> tuple[Any, ...] | None:
    """The force of one of `references.forces.formulas`."""
    import sympy

    def force(q: Array, v: Array) -> Array:
        out = written([sympy.Integer(0)] * d)
        formula(q, v, 0.0, numbers, out)
        return out

    return formulas_of(force, *map(written, symbols(d)))


@lru_cache(maxsize=32)
def _pull_of_gradient(gradient: Any, d: int) -> tuple[Any, ...] | None:
    """Minus a gradient that runs on symbols, and whose formula gives the same at a few places."""
    import sympy

    q, _ = symbols(d)
    slopes = formulas_of(gradient, written(q))
    if slopes is None or len(slopes) != d:
        return None
    found = sympy.lambdify([q], slopes, "math")
    same = agrees(gradient, lambda x: np.array(found(x.tolist())), points_around(np.ones(d)))
    return tuple(-x for x in slopes) if same else None
