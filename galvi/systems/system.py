"""Interfaces of systems, and what they hand to the kernels."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from dataclasses import dataclass, field
from typing import Any, Protocol, runtime_checkable

from galvi.arrays import Array
from galvi.groups.group import Group
from galvi.kernels.compile.function_pointers import addresses
from galvi.kernels.forces import force_kinds, lagrangian_derivatives


@dataclass(frozen=True, eq=False)
class ForceKernel:
    """Functions and constants from which kernels compute the acceleration a(q, t) of a system.

    Attributes
    ----------
    force
        function with the signature of ``kind``, see galvi.kernels.forces.force_kinds
    slope
        derivative of ``force`` with respect to q, for Newton's method; None: differenced in the
        kernel
    kind
        force_kinds.BUILT_IN, GRADIENT or TIMED_GRADIENT
    constants : array, shape (c,)
        numbers for a built-in force
    inverse_mass : array, shape (d, 1)
        diagonal, or full of shape (d, d); applied to -force. Of shape (0, 0): ``force`` returns
        accelerations
    width
        number of components that a Newton block couples; d is a multiple of it
    compiled
        whether both functions can run inside a compiled kernel
    """

    force: Callable[..., Any]
    slope: Callable[..., Any] | None
    kind: int
    inverse_mass: Array
    width: int
    constants: Array = field(default_factory=force_kinds.no_constants)
    compiled: bool = True

    @property
    def functions(self) -> Any:
        """Addresses (2,) of the compiled functions, or the Python functions for the interpreter."""
        functions = (self.force, self.slope)
        if not self.compiled:
            return functions
        return addresses(*zip(functions, force_kinds.SIGNATURES[self.kind], strict=True))


@dataclass(frozen=True, eq=False)
class LagrangianKernel:
    """Derivatives of a Lagrangian, and a force, as galvi.kernels.forces.lagrangian_derivatives
    evaluates them.

    Attributes
    ----------
    kind
        LAW, EUCLIDEAN, LEFT, BODY_GRADIENT, CANONICAL or CANONICAL_GRADIENT of that module
    function
        function with the signature of ``kind``
    time_dependent
        whether a user's function takes the time
    matrix_rows
        rows of the matrix that a user's slopes and force take; 0 for a vector
    constants : array, shape (c,)
        constants of the Lagrangian
    force_kind
        NO_FORCE, FORCE, TIMED_FORCE or FORCE_LAW of that module
    force
        external force of that kind; None for NO_FORCE
    force_constants : array, shape (c,)
        constants of the force
    compiled
        whether both functions can run inside a compiled kernel
    """

    kind: int
    function: Callable[..., Any]
    time_dependent: bool = False
    matrix_rows: int = 0
    constants: Array = field(default_factory=force_kinds.no_constants)
    force_kind: int = lagrangian_derivatives.NO_FORCE
    force: Callable[..., Any] | None = None
    force_constants: Array = field(default_factory=force_kinds.no_constants)
    compiled: bool = True

    @property
    def functions(self) -> Any:
        """Addresses (2,) of the compiled functions, or the Python functions for the interpreter."""
        if not self.compiled:
            return self.function, self.force
        return addresses(
            (
                self.function,
                lagrangian_derivatives.signature(self.kind, self.time_dependent, self.matrix_rows),
            ),
            (self.force, lagrangian_derivatives.force_signature(self.force_kind, self.matrix_rows)),
        )


@runtime_checkable
class BuiltinLagrangian(Protocol):
    """A callable L(q, v) or L(q, v, t) with analytic derivatives, also compiled."""

    def __call__(self, q: Array, v: Array, *t: Any) -> float:
        """L(q, v) or L(q, v, t)."""

    def slopes(self, q: Array, v: Array, *t: Any) -> Array:
        """dL/dv and the Euclidean dL/dq in one vector, (d + entries of q,)."""

    def at_states(self, q: Array, v: Array, t: Array) -> tuple[Array, Array, Array]:
        """L(q, v) (n,), L(q, 0) (n,) and dL/dv (n, d) at n states: q (n, ...), v (n, d), t (n,)."""

    def compiled(self) -> tuple[Callable[..., Any], Array]:
        """Compiled function (q, v, t, constants, out (2, d)) that fills the rows dL/dv and the
        left-trivialised dL/dq, and its constants."""


@runtime_checkable
class KnownMass(BuiltinLagrangian, Protocol):
    """A `BuiltinLagrangian` v . M(q) v / 2 - V(q): its mass depends on the configuration alone."""

    def mass(self, q: Array) -> Array:
        """d2L/dv2 (d, d) at one configuration."""


class System(Hashable, Protocol):
    """A Lagrangian system; ``...`` are leading axes, ``shape`` the axes of one configuration."""

    def velocity_shape(self, shape: tuple[int, ...]) -> tuple[int, ...]:
        """Shape of velocities and momenta, from the shape of a configuration."""

    def check_state(self, q: Array, v: Array, t: float) -> None:
        """ValueError, with one sentence, where (q, v) at t cannot be a state of this system."""

    def momentum(self, v: Array) -> Array:
        """p = M v, for v of shape (..., *shape)."""

    def velocity(self, p: Array) -> Array:
        """v = M^-1 p, for p of shape (..., *shape)."""


class VectorSystem(System, Protocol):
    """A system on a vector space, with L = v.M v / 2 - V(q, t)."""

    def potential_energy(self, q: Array, t: Array) -> Array:
        """V(q, t) of shape (...), for q of shape (..., *shape) and t of shape (...)."""

    def acceleration(self, q: Array, t: float) -> Array:
        """M^-1 (-dV/dq) at one configuration, in its shape."""

    def acceleration_jacobian(self, q: Array, t: float) -> Array:
        """d(acceleration)/dq at one configuration, shape (d, d) with d = q.size."""

    def force_kernel(self, dimension: int) -> ForceKernel:
        """Force and derivative for the kernels; ``dimension`` is the length of the last axis of a
        configuration."""


class GroupSystem(System, Protocol):
    """A system on a Lie group: any regular Lagrangian, with an optional external force."""

    @property
    def group(self) -> Group:
        """The configuration space."""

    def lagrangian_kernel(self) -> LagrangianKernel:
        """Derivatives of the Lagrangian, and the external force, for the kernels."""


@runtime_checkable
class WithLimits(Protocol):
    """A system with forces that are NaN beyond a limit."""

    def beyond_limits(self, q: Array, v: Array, step: float) -> str:
        """A clause that names the force beyond its limits at a state or, approximately, within a
        step from it; "" where all are within."""
