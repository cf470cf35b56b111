"""Built-in potentials: values with readable fields, which references and lanes recognise."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, fields
from typing import Any, ClassVar, Protocol, runtime_checkable

import numpy as np

from galvi import input_checks
from galvi.arrays import Array
from galvi.kernels.constants import COMPLEX_STEP
from galvi.kernels.forces import potentials as kernels


@runtime_checkable
class Potential(Protocol):
    """V(q) of configurations of shape (..., d), with its derivatives at one of them."""

    def __call__(self, q: Array) -> Array:
        """V(q), (...)."""

    def gradient(self, q: Array) -> Array:
        """dV/dq, shape (d,)."""

    def hessian(self, q: Array) -> Array:
        """d2V/dq2, shape (d, d)."""

    @property
    def slopes(self) -> Callable[..., Any]:
        """dV/dq, of galvi.kernels.forces.potentials."""

    @property
    def constants(self) -> Array:
        """The constants (c,) of dV/dq."""


class Differentiated:
    """The derivatives of a potential by its ``slopes``, whose constants are its fields."""

    slopes: ClassVar[Callable[..., Any]]

    @property
    def constants(self) -> Array:
        """The constants (c,) of dV/dq."""
        values: Any = self
        return np.hstack([getattr(values, field.name) for field in fields(values)])

    def gradient(self, q: Array) -> Array:
        """dV/dq, (d,), at one configuration."""
        out = 0.0 * q
        with np.errstate(all="ignore"):
            self.slopes(q, self.constants, out)
        return out

    def hessian(self, q: Array) -> Array:
        """d2V/dq2, (d, d), at one configuration; NaN where the gradient is not finite."""
        out = np.empty((q.size, q.size), np.complex128)
        with np.errstate(all="ignore"):
            self.slopes(q[:, None] + 1j * COMPLEX_STEP * np.eye(q.size), self.constants, out)
        return out.imag / COMPLEX_STEP + 0.0 * self.gradient(q)[:, None]


@dataclass(frozen=True)
class CentralForce(Differentiated):
    """V(q) = -mu / |q|, q of shape (2,) or (3,), the centre at the origin.

    mu  strength, length^3 / time^2 times mass; ValueError unless finite and positive
    """

    slopes = staticmethod(kernels.central_force)
    mu: float = 1.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "mu", input_checks.positive("mu", self.mu))

    def __call__(self, q: Array) -> Array:
        return -self.mu / np.sqrt(np.sum(q * q, axis=-1))


@dataclass(frozen=True)
class CosinePotential(Differentiated):
    """V(q) = -weight sum cos(q_i), q of shape (d,): d pendulums, angles from hanging down.

    weight  m g l, an energy; ValueError unless finite and positive
    """

    slopes = staticmethod(kernels.pendulum)
    weight: float = 1.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "weight", input_checks.positive("weight", self.weight))

    def __call__(self, q: Array) -> Array:
        return -self.weight * np.sum(np.cos(q), axis=-1)


@dataclass(frozen=True)
class LinearSpring(Differentiated):
    """V(q) = stiffness |q|^2 / 2, q of shape (d,).

    stiffness  force per length; ValueError unless finite and positive
    """

    slopes = staticmethod(kernels.linear_spring)
    stiffness: float = 1.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "stiffness", input_checks.positive("stiffness", self.stiffness))

    def __call__(self, q: Array) -> Array:
        return 0.5 * self.stiffness * np.sum(q * q, axis=-1)


@dataclass(frozen=True)
class SpringChain(Differentiated):
    """V(q) = sum over springs of r^2/2 + alpha r^3/3 + beta r^4/4, q of shape (d,) displacements.

    alpha, beta  quadratic and cubic stiffness; ValueError unless finite

    Fermi, Pasta, Ulam and Tsingou, Los Alamos report LA-1940 (1955), eqs. 1 and 2.
    """

    slopes = staticmethod(kernels.spring_chain)
    alpha: float = 0.0
    beta: float = 0.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "alpha", input_checks.real("alpha", self.alpha))
        object.__setattr__(self, "beta", input_checks.real("beta", self.beta))

    def __call__(self, q: Array) -> Array:
        r = np.diff(q, prepend=0.0, append=0.0)
        return np.sum(r * r * (0.5 + r * (self.alpha / 3.0 + r * (self.beta / 4.0))), axis=-1)


@dataclass(frozen=True, eq=False)
class UniformField(Differentiated):
    """V(q) = -force . q, e.g. of a weight, with force = mass g.

    force  (d,) as q; ValueError unless finite
    """

    slopes = staticmethod(kernels.uniform_field)
    force: Any

    def __post_init__(self) -> None:
        force = input_checks.array("force", self.force)
        if force.ndim != 1:
            raise ValueError(f"force must have shape (d,); received shape {force.shape}.")
        object.__setattr__(self, "force", force)

    def __call__(self, q: Array) -> Array:
        return -(q @ self.force)


@dataclass(frozen=True, eq=False)
class UniformGravity:
    """V(R) = -mass g . R centre, R of shape (3, 3).

    mass    of the body, positive
    centre  (3,) of mass, from the fixed point, in the body's frame
    g       (3,) acceleration of gravity in space; a number g stands for (0, 0, -g), downwards

    Raises ValueError for a mass that is not positive, a wrong shape or a number that is not finite.
    """

    mass: float
    centre: Any
    g: Any = 9.81

    def __post_init__(self) -> None:
        object.__setattr__(self, "mass", input_checks.positive("mass", self.mass))
        object.__setattr__(self, "centre", input_checks.array("centre", self.centre, (3,)))
        g = self.g
        if not isinstance(g, Iterable) or isinstance(g, str):
            g = [0.0, 0.0, -input_checks.real("g", g, "Give a number, or a vector (3,) in space.")]
        object.__setattr__(self, "g", input_checks.array("g", g, (3,)))

    def __reduce__(self) -> tuple[Any, ...]:
        return UniformGravity, (self.mass, self.centre, self.g)

    def __call__(self, R: Array) -> Any:
        return -self.mass * ((self.g @ R) @ self.centre)

    def gradient(self, R: Array) -> Array:
        """dV/dR = -mass g centre^T, (3, 3)."""
        return -self.mass * np.outer(self.g, self.centre)

    @property
    def numbers(self) -> Array:
        """(6,): mass g, then the centre, the constants of the compiled form."""
        return np.concatenate([self.mass * self.g, self.centre])
