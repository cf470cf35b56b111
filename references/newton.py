"""Newton's second law of a problem: M v' = -dV/dq + f, with f the problem's external force.

Everything is evaluated by `references.forces` or by the user's own functions.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import lru_cache
from typing import Any

import numpy as np

from galvi import (
    Canonical,
    CentralForce,
    CosinePotential,
    FreeBody,
    LinearSpring,
    NBody,
    Problem,
    QuadraticDrag,
    RotorDrag,
    SchillerNaumann,
    SpringChain,
    UniformField,
)
from galvi.arrays import Array
from references.forces import celestial, formulas
from references.forces.force import (
    Force,
    agrees,
    by_formula,
    by_function,
    gradient,
    points_around,
    together,
)
from references.forces.of_problem import expressions_of, reproduces, symbols, time_symbol

# Type of a potential -> its formula, and the names of the fields with its constants.
FORMULAS: Mapping[type, tuple[Callable[..., Any], tuple[str, ...]]] = {
    LinearSpring: (formulas.spring, ("stiffness",)),
    CosinePotential: (formulas.pendulum, ("weight",)),
    CentralForce: (formulas.central, ("mu",)),
    UniformField: (formulas.uniform, ("force",)),
    SpringChain: (formulas.spring_chain, ("alpha", "beta")),
}
DRAG: Mapping[type, Callable[..., Any]] = {
    QuadraticDrag: formulas.rotor_drag,
    SchillerNaumann: formulas.rotor_drag_by_reynolds,
}


def is_forced(problem: Problem) -> bool:
    """Whether an external force acts, by the system's field ``force`` or ``forces``."""
    system: Any = problem.system
    return getattr(system, "force", None) is not None or bool(getattr(system, "forces", ()))


def is_thrown(problem: Problem) -> bool:
    """Whether the system is a FreeBody on which gravity alone acts."""
    system = problem.system
    return isinstance(system, FreeBody) and system.potential is None and not is_forced(problem)


def is_moved_by(problem: Problem, potential: type) -> bool:
    """Whether the system is a Canonical with a scalar or diagonal mass on which a potential of this
    type alone acts."""
    system = problem.system
    return (
        isinstance(system, Canonical)
        and isinstance(system.potential, potential)
        and not replaces_force(problem)
        and system.mass.ndim < 2
        and not is_forced(problem)
    )


def replaces_force(problem: Problem) -> bool:
    """Whether the gradient given to a Canonical differs from that of its known potential.

    False without a gradient, and for one that agrees to rounding at the start and around it.
    """
    system: Any = problem.system
    if system.gradient is None:
        return False
    formula = potential_formula(system.potential)
    return formula is None or not agrees(
        system.gradient, lambda q: -formula(q, np.zeros(q.shape), 0.0), points_around(problem.q0)
    )


def potential_formula(potential: Any) -> Force | None:
    """-dV/dq of a potential in FORMULAS; None for another potential."""
    if type(potential) not in FORMULAS:
        return None
    formula, names = FORMULAS[type(potential)]
    return by_formula(formula, *(getattr(potential, name) for name in names))


def is_differenced(problem: Problem) -> bool:
    """Whether `potential_force` differences the potential, since neither its gradient nor a formula
    to derive it from is known."""
    system: Any = problem.system
    if not isinstance(system, Canonical) or system.gradient is not None:
        return False
    own_gradient = getattr(system.potential, "gradient", None)
    if potential_formula(system.potential) is not None:
        return False
    return (own_gradient is None or system.explicit_time) and derived_gradient(problem) is None


@lru_cache(maxsize=32)
def derived_gradient(problem: Problem) -> Callable[..., Array] | None:
    """dV/dq of q, or of q and t, by the formula of the potential of a Canonical; None where it
    cannot be written out."""
    import sympy

    system: Any = problem.system
    names = "qt" if system.explicit_time else "q"
    potential = expressions_of(problem, system.potential, names)
    if potential is None or not reproduces(problem, potential, system.potential, names):
        return None
    q, _ = symbols(problem.q0.size)
    slopes = sympy.lambdify([q, time_symbol()], [potential[0].diff(x) for x in q], cse=True)
    return lambda q, t=0.0: np.array(slopes(q, t), dtype=np.float64)


def potential_force(problem: Problem) -> Force:
    """-dV/dq of a Canonical, by gradient, formula or differences; of NBody the accelerations.

    Formulas are those of `references.forces.formulas`, or derived from the user's own potential.
    """
    system: Any = problem.system
    if isinstance(system, NBody):
        return by_formula(formulas.gravity, problem.q0.shape[-1], system.G * system.masses)
    arguments = "qt" if system.explicit_time else "q"
    if system.gradient is not None:
        return by_function(system.gradient, arguments, -1.0)
    formula = potential_formula(system.potential)
    if formula is not None:
        return formula
    potential = system.potential
    if not system.explicit_time and getattr(potential, "gradient", None) is not None:
        return by_function(potential.gradient, "q", -1.0)
    derived = derived_gradient(problem)
    if derived is not None:
        return by_function(derived, arguments, -1.0)

    def slope(q: Array, *t: float) -> Array:
        return gradient(lambda x: potential(x.copy(), *t), q)

    return by_function(slope, arguments, -1.0)


def external_force(problem: Problem) -> Force:
    """The external force f(q, v, t) of a system on a vector space; of NBody the accelerations by
    its forces."""
    system: Any = problem.system
    if isinstance(system, NBody):
        dimension = problem.q0.shape[-1]

        def accelerated(q: Array, v: Array, t: float) -> Array:
            return celestial.accelerations(system, q, v, t)[:, :dimension].ravel()

        return by_function(accelerated, "qvt", 1.0)
    if type(system.force) is RotorDrag and type(system.force.drag_law) in DRAG:
        law = system.force.drag_law
        return by_formula(DRAG[type(law)], system.force.factor, *law.numbers)
    return by_function(system.force, "qvt" if system.timed_force else "qv", 1.0)


def total_force(problem: Problem) -> Force:
    """The sum of `potential_force` and, if the problem has one, `external_force`."""
    force = potential_force(problem)
    return together(force, external_force(problem)) if is_forced(problem) else force


def inverse_mass(problem: Problem) -> Array:
    """The inverse mass, (d,) or (d, d), that turns `total_force` into accelerations; ones for
    NBody."""
    system: Any = problem.system
    if isinstance(system, NBody):
        return np.ones(problem.q0.size)
    if system.mass.ndim == 2:
        return np.linalg.inv(system.mass)
    return np.broadcast_to(1.0 / system.mass, problem.q0.shape).copy()


def acceleration(problem: Problem) -> Callable[[Array, Array, float], Array]:
    """A function (q, v, t) -> acceleration on a vector space, in the shape of q."""
    force, inverse = total_force(problem), inverse_mass(problem)
    weigh: Any = np.dot if inverse.ndim == 2 else np.multiply

    def accelerated(q: Array, v: Array, t: float) -> Array:
        return weigh(inverse, force(q, v, t).ravel()).reshape(q.shape)

    return accelerated


def acceleration_jacobian(problem: Problem) -> Callable[[Array, float], Array]:
    """A function (q, t) -> da/dq (d, d), without external force, by the Hessian, the formula or
    differences."""
    force, inverse = potential_force(problem), inverse_mass(problem)
    inverse = inverse if inverse.ndim == 2 else np.diag(inverse)
    hessian = getattr(problem.system, "hessian", None)

    def slope(q: Array, t: float) -> Array:
        if hessian is not None:
            arguments = (q.copy(), t) if problem.system.explicit_time else (q.copy(),)
            return -inverse @ np.asarray(hessian(*arguments), dtype=np.float64)
        if force.formula is not None:
            return inverse @ force.jacobian(q, t)
        zero_velocity = np.zeros(q.shape)
        rows = [gradient(lambda x, i=i: force(x, zero_velocity, t)[i], q) for i in range(q.size)]
        return inverse @ np.array(rows)

    return slope
