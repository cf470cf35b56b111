"""Canonical Lagrangians: a constant mass and a potential."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from galvi import input_checks
from galvi.arrays import Array, read_only
from galvi.kernels.forces import force_kinds
from galvi.kernels.forces.potentials import over_stages
from galvi.systems.derivative_check import Curve, check_derivatives, direction
from galvi.systems.finite_differences import (
    CALLS,
    differenced_gradient,
    differenced_hessian,
    lengths_of,
    noise_of,
)
from galvi.systems.forces.external_force import check_force, check_force_at
from galvi.systems.potentials.potentials import Potential
from galvi.systems.system import ForceKernel
from galvi.systems.traces import reasons, refuse, trace, traces
from galvi.systems.user_functions import (
    Function,
    arguments,
    check_call_signatures,
    check_callables,
    compiles,
    returned_array,
    values_at,
)


@dataclass(frozen=True, eq=False)
class Canonical:
    """L = v.M v / 2 - V(q), or V(q, t) when ``explicit_time`` is set.

    Parameters
    ----------
    mass
        scalar, (d,) diagonal or (d, d) symmetric positive definite
    potential
        V of one configuration of shape (d,); a ``Potential`` has derivatives of its own
    gradient
        dV/dq, shape (d,); differenced from V when missing
    hessian
        d2V/dq2, shape (d, d); differenced from the gradient when missing
    force
        an external force (d,) of (q, v), such as drag; see galvi.systems.forces.external_force
    explicit_time
        potential and derivatives take (q, t) instead of (q)
    timed_force
        the force takes (q, v, t)
    check
        compare gradient and Hessian with differences of V when a `Problem` is made

    Raises
    ------
    ValueError
        For a mass that is not positive definite, and for ``explicit_time`` with a ``Potential``.
    TypeError
        For a function that cannot be called with these arguments, and for flags that are no bools.

    Notes
    -----
    The gradient, or else the potential, is traced and runs in vector instructions where it does not
    branch. Other functions run inside the kernel if compiled with ``numba.njit``, and else more
    slowly in Python. Exceptions that they raise reach the caller.

    Examples
    --------
    >>> def potential(q):
    ...     return (q @ q) / 2 + q[0] ** 2 * q[1]
    >>> system = galvi.Canonical(mass=1.0, potential=potential)
    >>> problem = galvi.Problem(system, q0=[0.1, 0.0], v0=[0.0, 0.2])
    >>> method = galvi.Galerkin(galvi.Polynomials(4), galvi.gauss(4))
    >>> galvi.integrate(problem, method, step=0.2, steps=50).status
    'Completed.'
    """

    mass: Any
    potential: Function
    gradient: Function | None = None
    hessian: Function | None = None
    force: Function | None = None
    explicit_time: bool = field(default=False, kw_only=True)
    timed_force: bool = field(default=False, kw_only=True)
    check: bool = field(default=True, kw_only=True, compare=False)

    def __post_init__(self) -> None:
        check_force(self)
        check_callables(self, ("potential", "gradient", "hessian"), "q", needed="potential")
        object.__setattr__(self, "mass", _positive_mass(self.mass))
        if self.explicit_time and self.builtin:
            raise ValueError(
                f"explicit_time means functions of (q, t); {self.potential!r} takes q alone. "
                f"Leave explicit_time out, or give a potential(q, t)."
            )
        check_call_signatures(self, ("potential", "gradient", "hessian"), "q", "explicit_time")

    def velocity_shape(self, shape: tuple[int, ...]) -> tuple[int, ...]:
        return shape

    def check_state(self, q: Array, v: Array, t: float) -> None:
        """ValueError unless q is (d,), d at least 1, and the mass has d rows or is a scalar."""
        if q.ndim != 1 or q.size == 0:
            raise ValueError(
                f"q0 must have shape (d,) for a Canonical system; received shape {q.shape}."
            )
        if self.mass.ndim and self.mass.shape[0] != q.size:
            raise ValueError(
                f"mass must be a scalar or have {q.size} rows like q0; received shape "
                f"{self.mass.shape}."
            )

    def check_functions(self, q: Array, v: Array, t: float) -> None:
        """ValueError unless potential, gradient, Hessian and force are finite at a state and have
        the right shapes."""
        check_force_at(self, q, v, t)
        value = input_checks.returned("potential", self.potential(*arguments(self, q, t)))
        if not np.isfinite(value):
            raise ValueError(
                f"the potential must be finite at the start; received {value} at q0. Check it, or "
                f"start elsewhere."
            )
        derivatives = [("gradient", self.potential_gradient(q, t))]
        if self.hessian is not None:
            derivatives.append(("hessian", self.potential_hessian(q, t)))
        for name, numbers in derivatives:
            if not np.all(np.isfinite(numbers)):
                raise ValueError(
                    f"the force must be finite at the start; received the {name} "
                    f"{numbers.tolist()} at q0. Check the {name}"
                    + ("." if self._known_gradient else ", which is differenced, or give one.")
                )

    def check_derivatives(self, q: Array, v: Array, t: float) -> None:
        """ValueError unless gradient and Hessian are derivatives, at a state and near it."""
        if not self.check:
            return
        scales, line, component = lengths_of(q), direction(q.size), direction(q.size, 1)

        def state(distance: float) -> tuple[Array, float]:
            point = q + distance * scales * direction(q.size, 2)
            return point, t + distance * (abs(t) or 1.0) * self.explicit_time

        def along(
            distance: float, function: Function, derivative: Callable[[Array, float], Array]
        ) -> Curve:
            point, then = state(distance)
            steps = lengths_of(point) * line
            return Curve(
                lambda s: function(point + s * steps, then),
                lambda s: derivative(point + s * steps, then) * steps,
                steps,
                {"q": point},
            )

        def energy(x: Array, s: float) -> float:
            return input_checks.returned("potential", self.potential(*arguments(self, x, s)))

        def force(x: Array, s: float) -> float:
            return float(component @ self.potential_gradient(x, s))

        curves: dict[str, Callable[[float], Curve]] = {}
        if self._known_gradient:
            curves["gradient of the potential"] = lambda distance: along(
                distance, energy, self.potential_gradient
            )
        if self.hessian is not None or (self.gradient is None and self._known_gradient):
            curves["hessian of the gradient"] = lambda distance: along(
                distance, force, lambda x, s: component @ self.potential_hessian(x, s)
            )
        check_derivatives(self, curves)

    def trace(self, q: Array, v: Array, t: float, anew: bool = False) -> None:
        """As `Lagrangian.trace`, for the force, and the gradient or the potential."""
        trace(self, q, v, t, anew)
        gradient_trace = None if anew else traces(self).traced.get("dV/dq")
        if (
            gradient_trace is not None
            and self.gradient is None
            and not gradient_trace.defined(q, t)
        ):
            refuse(self, "dV/dq", "it is not finite at a start")

    @property
    def untraced(self) -> str:
        return reasons(self)

    def momentum(self, v: Array) -> Array:
        """p = M v, v of shape (..., d)."""
        return v @ self.mass if self.mass.ndim == 2 else v * self.mass

    def velocity(self, p: Array) -> Array:
        """v = M^-1 p, p of shape (..., d)."""
        if self.mass.ndim < 2:
            return p / self.mass
        return np.linalg.solve(self.mass, p[..., None])[..., 0]

    def potential_energy(self, q: Array, t: Array) -> Array:
        """V at each of the configurations q (..., d) and times t (...)."""
        if self.builtin is not None:
            return self.builtin(q)
        return values_at(lambda x, s: self.potential(*arguments(self, x, s)), q, t, 1)

    def potential_gradient(self, q: Array, t: float) -> Array:
        """dV/dq at one configuration, (d,)."""
        return self._wrapped(self._gradient(), (q.size,), "gradient")(*arguments(self, q, t))

    def potential_hessian(self, q: Array, t: float) -> Array:
        """d2V/dq2 at one configuration, (d, d)."""
        return self._wrapped(self._hessian(), (q.size, q.size), "hessian")(*arguments(self, q, t))

    def acceleration(self, q: Array, t: float) -> Array:
        """-M^-1 dV/dq at one configuration, (d,)."""
        return -self.velocity(self.potential_gradient(q, t))

    def acceleration_jacobian(self, q: Array, t: float) -> Array:
        """-M^-1 d2V/dq2 at one configuration, (d, d)."""
        return -self.velocity(self.potential_hessian(q, t).T).T

    @cached_property
    def builtin(self) -> Potential | None:
        """The potential if it has derivatives of its own, else None."""
        return self.potential if isinstance(self.potential, Potential) else None

    @property
    def potential_calls_per_force(self) -> int:
        """Smallest number of evaluations of V, for each component, to difference one gradient; 0
        where it is not differenced."""
        return 0 if self._known_gradient else CALLS

    def noise_of_differences(self, q: Array, t: float) -> float:
        """The error of a differenced gradient, relative to its largest entry; 0 where it is not
        differenced, infinite where no two steps agree."""
        if self._known_gradient:
            return 0.0
        return noise_of(self.potential, *arguments(self, q, t))

    @property
    def _known_gradient(self) -> bool:
        return self.gradient is not None or self.builtin is not None

    def force_kernel(self, dimension: int) -> ForceKernel:
        """Force and derivative for the kernels; all d components share one block of Newton's
        matrix."""
        inverse_mass = self.inverse_mass(dimension)
        if self.builtin is not None and self.gradient is None and self.hessian is None:
            gradient, hessian = over_stages(self.builtin.slopes, self.builtin.second)
            return ForceKernel(
                gradient,
                hessian,
                force_kinds.BUILT_IN,
                inverse_mass,
                dimension,
                self.builtin.constants,
            )
        gradient = self._gradient()
        hessian = self._hessian(differenced=False)
        kind = force_kinds.TIMED_GRADIENT if self.explicit_time else force_kinds.GRADIENT
        force, slope = force_kinds.SIGNATURES[kind]
        compiled = compiles(gradient, force) and (hessian is None or compiles(hessian, slope))
        if not compiled:
            gradient = self._wrapped(gradient, (dimension,), "gradient")
            hessian = hessian and self._wrapped(hessian, (dimension, dimension), "hessian")
        return ForceKernel(gradient, hessian, kind, inverse_mass, dimension, compiled=compiled)

    def inverse_mass(self, dimension: int) -> Array:
        """M^-1, (d, d); of a diagonal mass its diagonal, (d, 1)."""
        if self.mass.ndim == 2:
            return np.ascontiguousarray(np.linalg.inv(self.mass))
        return np.broadcast_to(1.0 / self.mass, (dimension,))[:, None].copy()

    def _gradient(self) -> Function:
        if self.gradient is not None:
            return self.gradient
        if self.builtin is not None:
            return self.builtin.gradient
        return differenced_gradient(self.potential, self.explicit_time)

    def _hessian(self, differenced: bool = True) -> Any:
        if self.hessian is not None:
            return self.hessian
        if self.builtin is not None and self.gradient is None:
            return self.builtin.hessian
        return differenced_hessian(self._gradient()) if differenced else None

    @staticmethod
    def _wrapped(function: Function, shape: tuple[int, ...], name: str) -> Function:
        """The function with its value converted to float64; ValueError for another shape."""

        def checked(*arguments: Any) -> Array:
            return returned_array(name, function(*arguments), shape, f"an array of shape {shape}")

        return checked


def _positive_mass(mass: Any) -> Array:
    remedy = "Give a positive number, a vector of positive numbers or a positive definite matrix."
    mass = input_checks.array("mass", mass, remedy=remedy)
    if not mass.size:
        raise ValueError(f"mass must have entries; received shape {mass.shape}. {remedy}")
    if mass.ndim == 2 and mass.shape[0] == mass.shape[1]:
        if not np.allclose(mass, mass.T, rtol=1e-14, atol=0.0):
            raise ValueError(f"mass must be a symmetric matrix; received {mass.tolist()}. {remedy}")
        smallest = float(np.linalg.eigvalsh(mass)[0])
        if smallest <= 0.0:
            raise ValueError(
                f"mass must be positive definite; received smallest eigenvalue {smallest}. {remedy}"
            )
        return read_only(0.5 * (mass + mass.T))
    if mass.ndim > 1:
        raise ValueError(f"mass must be square; received shape {mass.shape}. {remedy}")
    if np.any(mass <= 0.0):
        raise ValueError(f"mass must be positive; received {mass.tolist()}. {remedy}")
    return mass
