"""A rigid body that rotates about a fixed point or about its centre of mass."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property, partial
from typing import Any, ClassVar

import numpy as np

from galvi import input_checks
from galvi.arrays import Array, read_only
from galvi.groups.group import SE3, SO3
from galvi.kernels.forces import lagrangian_derivatives
from galvi.systems.derivative_check import Curve, check_derivatives, direction
from galvi.systems.finite_differences import (
    CALLS,
    cayley_rotation,
    differenced_rotation_gradient,
    hat,
)
from galvi.systems.forces.external_force import check_force, check_force_at, with_force
from galvi.systems.lagrangian import Lagrangian
from galvi.systems.potentials.potentials import UniformGravity
from galvi.systems.system import LagrangianKernel
from galvi.systems.traces import reasons, share
from galvi.systems.user_functions import (
    Function,
    arguments,
    check_call_signatures,
    check_callables,
    compiles,
    returned_array,
    values_at,
)

SINGULAR_MOMENTS = 1e-14  # ratio of smallest to largest moment below which a matrix is singular
THIN_BODY_EXCESS = 1e-12  # relative rounding by which a moment may exceed the sum of the others


class Body:
    """Fields and checks that `RigidBody` and `FreeBody` share; a `Lagrangian` traces their
    functions."""

    group: ClassVar[SO3 | SE3]
    inertia: Any
    potential: Any
    gradient: Any
    force: Any
    explicit_time: Any
    timed_force: Any
    check: Any
    lagrangian: Any
    has_functions: Any  # whether there is a potential that is not built in, or a force
    potential_gradient: Any  # dV/dq at one configuration, 0 where it is not known
    _numbers: ClassVar[tuple[str, ...]]  # the fields before the potential

    def __reduce__(self) -> tuple[Any, ...]:
        cls: Any = type(self)
        make = partial(
            cls,
            explicit_time=self.explicit_time,
            timed_force=self.timed_force,
            check=self.check,
        )
        names = (*self._numbers, "potential", "gradient", "force")
        return make, tuple(getattr(self, name) for name in names)

    def velocity_shape(self, shape: tuple[int, ...]) -> tuple[int, ...]:
        """(d,): angular velocity, then velocity, in the body's frame."""
        return (self.group.dimension,)

    def check_state(self, q: Array, v: Array, t: float) -> None:
        """ValueError unless q is an element of the group."""
        self.group.check("q0", q)

    def check_functions(self, q: Array, v: Array, t: float) -> None:
        """ValueError unless potential, gradient and force are finite at a state and have the right
        shapes."""
        check_force_at(self, q, v, t)
        if self.potential is None:
            return
        value = input_checks.returned("potential", self.potential(*arguments(self, q, t)))
        slope = self.potential_gradient(q, t)
        if not (np.isfinite(value) and np.all(np.isfinite(slope))):
            raise ValueError(
                f"potential and gradient must be finite at the start; received {value} and "
                f"{slope.tolist()} at q0. Check them, or start elsewhere."
            )

    def trace(self, q: Array, v: Array, t: float, anew: bool = False) -> None:
        """As `galvi.Lagrangian.trace`, for the potential or its gradient, and the force."""
        if self.has_functions:
            self.lagrangian.trace(q, v, t, anew)
            share(self, self.lagrangian)

    @property
    def untraced(self) -> str:
        """As `Lagrangian.untraced`."""
        return reasons(self)

    @cached_property
    def inverse_inertia(self) -> Array:
        """J^-1, (3, 3)."""
        return inverse(self.inertia)

    def _potentials(self, q: Array, t: Array) -> Array:
        return values_at(lambda x, s: self.potential(*arguments(self, x, s)), q, t, 2)


@dataclass(frozen=True, eq=False)
class RigidBody(Body):
    """A body that turns about a fixed point, or about its centre of mass.

    L = v . J v / 2 - V(R), or V(R, t); R' = R hat(v).

    Parameters
    ----------
    inertia
        J about the fixed point or the centre of mass, in the body's frame: three principal moments,
        or a (3, 3) symmetric positive definite matrix
    potential
        V of one rotation matrix (3, 3); None for a free body
    gradient
        the Euclidean dV/dR, (3, 3); differenced from V when missing
    force
        an external torque in the body's frame, (3,), of (R, v); see
        galvi.systems.forces.external_force
    explicit_time
        potential and gradient take (R, t) instead of (R)
    timed_force
        the force takes (R, v, t)
    check
        compare the gradient with differences of V when a `Problem` is made

    Raises
    ------
    ValueError
        For an inertia that no body can have, and a gradient without a potential.
    TypeError
        For a function that cannot be called with these arguments, and for flags that are no bools.

    Notes
    -----
    Configurations are (3, 3), velocities and momenta p = J v (3,), in the body's frame. Functions
    that can be traced run in vector instructions (see `untraced`). Of the others, a gradient and a
    force compiled with ``numba.njit`` run inside the kernel; a potential without a gradient is
    differenced in Python, even if it is compiled.

    Examples
    --------
    >>> weight = galvi.UniformGravity(mass=2.0, centre=(0.0, 0.0, 0.3))
    >>> top = galvi.RigidBody(inertia=(0.5, 0.5, 0.2), potential=weight)
    >>> galvi.Problem(top, q0=np.eye(3), v0=(0.1, 0.0, 20.0)).p0
    array([0.05, 0.  , 4.  ])
    """

    group: ClassVar[SO3] = SO3()
    _numbers: ClassVar[tuple[str, ...]] = ("inertia",)

    inertia: Any
    potential: Function | None = None
    gradient: Function | None = None
    force: Function | None = None
    explicit_time: bool = field(default=False, kw_only=True)
    timed_force: bool = field(default=False, kw_only=True)
    check: bool = field(default=True, kw_only=True, compare=False)

    def __post_init__(self) -> None:
        check_force(self)
        check_callables(self, ("potential", "gradient"), "R")
        object.__setattr__(self, "inertia", possible_inertia(self.inertia))
        if self.gradient is not None and self.potential is None:
            raise ValueError("a gradient needs its potential; received none. Give both.")
        if self.explicit_time and isinstance(self.potential, UniformGravity):
            raise ValueError(
                f"explicit_time means functions of (R, t); {self.potential!r} takes R alone. "
                f"Leave explicit_time out, or give a potential(R, t)."
            )
        check_call_signatures(self, ("potential", "gradient"), "R", "explicit_time")

    def check_derivatives(self, q: Array, v: Array, t: float) -> None:
        """ValueError unless the gradient agrees with differences of V along a rotation, at an
        attitude and near it."""
        if not self.check or self.potential_calls_per_force or self.potential is None:
            return
        axis, potential = direction(3), self.potential

        def through(distance: float) -> Curve:
            R = q @ cayley_rotation(distance * direction(3, 1))
            then = t + distance * (abs(t) or 1.0) * self.explicit_time

            def energy(s: float) -> float:
                turned = R @ cayley_rotation(s * axis)
                return input_checks.returned("potential", potential(*arguments(self, turned, then)))

            def terms(s: float) -> Array:
                turned = R @ cayley_rotation(s * axis)
                return self.potential_gradient(turned, then) * (turned @ hat(axis))

            return Curve(energy, terms, axis, {"R": R}, "about")

        check_derivatives(self, {"gradient of the potential": through})

    @cached_property
    def lagrangian(self) -> Lagrangian:
        """The same system by functions of (q, v), which are traced."""
        momentum, V, gradient = self.momentum, self.potential, self.gradient

        def L(R: Any, v: Any, *t: Any) -> Any:
            kinetic = 0.5 * v @ momentum(v)
            return kinetic if V is None else kinetic - V(R, *t)

        def slopes(R: Any, v: Any, *t: Any) -> Any:
            assert gradient is not None
            return np.concatenate([momentum(v), -np.asarray(gradient(R, *t)).ravel()])

        return Lagrangian(
            L,
            self.group,
            None if gradient is None else slopes,
            self.force,
            explicit_time=self.explicit_time,
            timed_force=self.timed_force,
        )

    @property
    def has_functions(self) -> bool:
        return self.force is not None or not self.known_potential

    @property
    def known_potential(self) -> bool:
        return self.gradient is None and isinstance(self.potential, UniformGravity | None)

    def momentum(self, v: Array) -> Array:
        """p = J v in the body's frame, v of shape (..., 3)."""
        return v @ self.inertia

    def velocity(self, p: Array) -> Array:
        """v = J^-1 p, p of shape (..., 3)."""
        return p @ self.inverse_inertia

    def kinetic_energy(self, v: Array) -> Array:
        """v . J v / 2, (...)."""
        return 0.5 * np.sum(v * self.momentum(v), axis=-1)

    def potential_energy(self, q: Array, t: Array) -> Array:
        """V at each of the rotations q (..., 3, 3) and times t (...)."""
        if self.potential is None:
            return np.abs(0.0 * q[..., 0, 0])
        if isinstance(self.potential, UniformGravity):
            return np.asarray(self.potential(q))
        return self._potentials(q, t)

    def potential_gradient(self, q: Array, t: float) -> Array:
        """dV/dR at one rotation, (3, 3)."""
        if self.potential is None:
            return np.zeros((3, 3))
        return self._checked(*arguments(self, q, t))

    def _checked(self, *Rt: Any) -> Array:
        return returned_array(
            "gradient", self.slope()(*Rt), (3, 3), "an array of shape (3, 3), dV/dR"
        )

    def torque(self, q: Array, t: float) -> Array:
        """The potential's torque in the body's frame, (3,): torque . w = -dV(R)[R hat(w)]."""
        S = q.T @ self.potential_gradient(q, t)
        return np.array([S[1, 2] - S[2, 1], S[2, 0] - S[0, 2], S[0, 1] - S[1, 0]])

    def slope(self) -> Function:
        """The function dV/dR: the user's gradient, the potential's own, or differences."""
        if self.gradient is not None:
            return self.gradient
        if isinstance(self.potential, UniformGravity):
            return self.potential.gradient
        assert self.potential is not None
        return differenced_rotation_gradient(self.potential)

    def lagrangian_kernel(self) -> LagrangianKernel:
        """Derivatives of L for the kernels; the constants begin with J by rows."""
        numbers = self.inertia.ravel()
        if self.known_potential:
            potential = self.potential
            weight = potential.numbers if isinstance(potential, UniformGravity) else np.zeros(6)
            constants = np.concatenate([numbers, weight])
            kernel = LagrangianKernel(
                lagrangian_derivatives.LAW, lagrangian_derivatives.rigid_body, constants=constants
            )
            return with_force(kernel, self, 3)
        if self.gradient is None and self.lagrangian.builtin is not None:
            return self.lagrangian.lagrangian_kernel()
        slope = self.slope()
        signature = lagrangian_derivatives.signature(
            lagrangian_derivatives.BODY_GRADIENT, self.explicit_time, 3
        )
        compiled = compiles(slope, signature)
        field = LagrangianKernel(
            lagrangian_derivatives.BODY_GRADIENT,
            slope if compiled else self._checked,
            time_dependent=self.explicit_time,
            constants=numbers.copy(),
            compiled=compiled,
        )
        return with_force(field, self, 3)

    @property
    def potential_calls_per_force(self) -> int:
        """Smallest number of evaluations of V, for each component, to difference one gradient; 0
        where it is not differenced."""
        has_gradient = self.gradient is not None or self.known_potential
        return 0 if has_gradient or self.lagrangian.builtin is not None else CALLS


def inverse(inertia: Array) -> Array:
    """The inverse of an inertia, made exactly symmetric."""
    matrix = np.linalg.inv(inertia)
    return read_only(0.5 * (matrix + matrix.T))


def possible_inertia(inertia: Any) -> Array:
    """(3, 3) from principal moments or a matrix; ValueError for one that no body can have."""
    remedy = "Give three positive moments, each at most the sum of the others, or such a matrix."
    J = input_checks.array("inertia", inertia, remedy=remedy)
    if J.shape not in ((3,), (3, 3)):
        raise ValueError(
            f"inertia must have shape (3,) or (3, 3); received shape {J.shape}. {remedy}"
        )
    J = np.diag(J) if J.ndim == 1 else J
    if not np.allclose(J, J.T, rtol=1e-14, atol=1e-14 * float(np.max(np.abs(J)))):
        raise ValueError(f"inertia must be symmetric; received {J.tolist()}. {remedy}")
    moments = np.linalg.eigvalsh(J)
    if moments[0] <= SINGULAR_MOMENTS * moments[2]:
        raise ValueError(
            f"inertia must be positive definite; received principal moments {moments.tolist()}. "
            f"{remedy}"
        )
    check_moments(moments, remedy)
    return read_only(0.5 * (J + J.T))


def check_moments(moments: Any, remedy: str) -> None:
    """ValueError for principal moments (3,), in ascending order, that no body can have."""
    if moments[2] > (moments[0] + moments[1]) * (1.0 + THIN_BODY_EXCESS):
        raise ValueError(
            f"no body has the inertia {moments.tolist()}: its largest moment exceeds the sum of "
            f"the others. {remedy}"
        )
