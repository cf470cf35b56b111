"""Lagrange's equations in SymPy, derived from L itself, independent of galvi's derivatives.

M a = dL/dq - (d2L/dv dq) v - d2L/dv dt,   M = d2L/dv2
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property, lru_cache
from operator import mul, truediv
from typing import Any

import numpy as np

from galvi import Canonical, Lagrangian, Problem
from galvi.arrays import Array
from references.forces.of_problem import expressions_of, reproduces, symbols, time_symbol
from references.forces.on_symbols import formulas_of, symbolic_array
from references.newton import is_forced, potential_formula, replaces_force

# SymPy is imported where it is used: it takes a fifth of the import of the references.


@dataclass(frozen=True)
class LagrangeEquations:
    """The equations of motion of d coordinates.

    Attributes
    ----------
    q, v
        the symbols, (d,) each; the time is `time_symbol`
    momenta
        dL/dv, (d,)
    mass
        M by rows, (d, d); () where the equations are solved for a
    pull
        the right-hand side, (d,)

    Notes
    -----
    All numbers are rationals, equal to the problem's floats.
    """

    q: tuple[Any, ...]
    v: tuple[Any, ...]
    momenta: tuple[Any, ...]
    mass: tuple[tuple[Any, ...], ...]
    pull: tuple[Any, ...]

    @staticmethod
    def of(problem: Problem) -> LagrangeEquations | None:
        """The equations of a Lagrangian from SymPy without external force, or of a Canonical whose
        functions are formulas of the references or run on symbols; None for any other problem."""
        system: Any = problem.system
        if isinstance(system, Canonical):
            return _of_canonical(problem)
        if not isinstance(system, Lagrangian) or is_forced(problem):
            return None
        text = "" if system.slopes is not None else getattr(system.function, "expression", "")
        return _from_expression(text, system.function.constants) if text else None

    @cached_property
    def timed(self) -> bool:
        """Whether the equations depend on the time."""
        return any(time_symbol() in x.free_symbols for x in (*self.pull, *sum(self.mass, ())))

    @cached_property
    def kinds(self) -> set[type]:
        """The types of all nodes of the expressions, without those of constants."""
        expressions = (*self.pull, *sum(self.mass, ()))
        return {type(node) for x in expressions for node in nodes(x) if not is_constant(node)}


def nodes(expression: Any) -> Iterator[Any]:
    """The nodes of an expression, constants included, without those inside constants."""
    import sympy

    walk = sympy.preorder_traversal(expression)
    for node in walk:
        if is_constant(node):
            walk.skip()
        yield node


def is_constant(node: Any) -> bool:
    """Whether a node is a finite real number."""
    return bool(node.is_number and node.is_real)


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
    """The ratio, cancelled if it then takes fewer operations."""
    import sympy

    return min((ratio, sympy.cancel(ratio)), key=sympy.count_ops)


@lru_cache(maxsize=32)
def _of_canonical(problem: Problem) -> LagrangeEquations | None:
    import sympy

    d = problem.q0.size
    pull = _conservative(problem)
    if pull is not None and problem.system.force is not None:
        push = _external(problem)
        pull = push and tuple(x + y for x, y in zip(pull, push, strict=True))
    if pull is None:
        return None
    q, v = symbols(d)
    mass = problem.system.mass
    if mass.ndim == 2:
        rows = tuple(tuple(sympy.Rational(x) for x in row) for row in mass.tolist())
        momenta = tuple(sum(m * w for m, w in zip(row, v, strict=True)) for row in rows)
        return LagrangeEquations(q, v, momenta, rows, pull)
    weights = [sympy.Rational(m) for m in np.broadcast_to(mass, problem.q0.shape).tolist()]
    momenta, solved = (
        tuple(operation(x, m) for x, m in zip(entries, weights, strict=True))
        for operation, entries in ((mul, v), (truediv, pull))
    )
    return LagrangeEquations(q, v, momenta, (), solved)


def _conservative(problem: Problem) -> tuple[Any, ...] | None:
    """-dV/dq as expressions: by a formula of the references, from the user's gradient, or derived
    from the potential; None where no expressions reproduce the function's values."""
    system: Any = problem.system
    formula = None if replaces_force(problem) else potential_formula(system.potential)
    if formula is not None and formula.formula is not None:
        return _pull_of_formula(formula.formula, tuple(formula.numbers.tolist()), problem.q0.size)
    gradient, names = system.gradient, "qt" if system.explicit_time else "q"
    if gradient is None and not system.explicit_time:
        gradient = getattr(system.potential, "gradient", None)
    potential, slopes = None, None if gradient is None else expressions_of(problem, gradient, names)
    if slopes is None:
        potential = expressions_of(problem, system.potential, names)
        if potential is None:
            return None
        slopes = tuple(potential[0].diff(x) for x in symbols(problem.q0.size)[0])
    if gradient is None:
        verified = reproduces(problem, potential, system.potential, names)
    else:
        verified = reproduces(problem, slopes, gradient, names)
    return tuple(-slope for slope in slopes) if verified else None


def _external(problem: Problem) -> tuple[Any, ...] | None:
    """The external force as expressions; None where these do not reproduce its values."""
    system: Any = problem.system
    names = "qvt" if system.timed_force else "qv"
    force = expressions_of(problem, system.force, names)
    return force if force and reproduces(problem, force, system.force, names) else None


@lru_cache(maxsize=32)
def _pull_of_formula(formula: Any, numbers: tuple[float, ...], d: int) -> tuple[Any, ...] | None:
    """The force of a formula in `references.forces.formulas` as expressions; None where it cannot
    be run on symbols."""
    import sympy

    def force(q: Array, v: Array) -> Array:
        out = symbolic_array([sympy.Integer(0)] * d)
        formula(q, v, 0.0, numbers, out)
        return out

    return formulas_of(force, *map(symbolic_array, symbols(d)))
