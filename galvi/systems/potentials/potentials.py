"""Built-in potentials: values with readable fields, which references and lanes recognise."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any, Protocol, runtime_checkable

import numpy as np

from galvi import input_checks
from galvi.arrays import Array
from galvi.kernels.forces import potentials as kernels


@dataclass(frozen=True, eq=False)
class Law:
    """Derivatives of a potential as compiled functions of all s stages at once.

    gradient   (Q (d, s), t (s,), constants, out (d, s)) fills out with dV/dq
    hessian    (Q (d, s), t (s,), constants, out (d, d, s)) fills out with d2V/dq2
    constants  (c,) constants of both functions
    """

    gradient: Callable[..., Any]
    hessian: Callable[..., Any]
    constants: Array


@runtime_checkable
class Potential(Protocol):
    """V(q) of configurations of shape (..., d), with its derivatives at one of them."""

    def __call__(self, q: Array) -> Array:
        """V(q), (...)."""

    def gradient(self, q: Array) -> Array:
        """dV/dq, shape (d,)."""

    def hessian(self, q: Array) -> Array:
        """d2V/dq2, shape (d, d)."""

    def law(self) -> Law:
        """Compiled derivatives and their constants."""


@dataclass(frozen=True)
class CentralForce:
    """V(q) = -mu / |q|, q of shape (2,) or (3,), the centre at the origin.

    mu  strength, length^3 / time^2 times mass; ValueError unless finite and positive
    """

    mu: float = 1.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "mu", input_checks.positive("mu", self.mu))

    def __call__(self, q: Array) -> Array:
        return -self.mu / np.sqrt(np.sum(q * q, axis=-1))

    def gradient(self, q: Array) -> Array:
        """mu q / |q|^3."""
        return self.mu * q / np.linalg.norm(q) ** 3

    def hessian(self, q: Array) -> Array:
        """mu (I - 3 q q^T / |q|^2) / |q|^3."""
        square = float(q @ q)
        return self.mu * (np.eye(q.size) - 3.0 * np.outer(q, q) / square) / square**1.5

    def law(self) -> Law:
        return Law(kernels.central_gradient, kernels.central_hessian, np.array([self.mu]))


@dataclass(frozen=True)
class CosinePotential:
    """V(q) = -weight sum cos(q_i), q of shape (d,): d pendulums, angles from hanging down.

    weight  m g l, an energy; ValueError unless finite and positive
    """

    weight: float = 1.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "weight", input_checks.positive("weight", self.weight))

    def __call__(self, q: Array) -> Array:
        return -self.weight * np.sum(np.cos(q), axis=-1)

    def gradient(self, q: Array) -> Array:
        """weight sin(q_i)."""
        return self.weight * np.sin(q)

    def hessian(self, q: Array) -> Array:
        """weight cos(q_i) on the diagonal."""
        return np.diag(self.weight * np.cos(q))

    def law(self) -> Law:
        return Law(kernels.cosine_gradient, kernels.cosine_hessian, np.array([self.weight]))


@dataclass(frozen=True)
class LinearSpring:
    """V(q) = stiffness |q|^2 / 2, q of shape (d,).

    stiffness  force per length; ValueError unless finite and positive
    """

    stiffness: float = 1.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "stiffness", input_checks.positive("stiffness", self.stiffness))

    def __call__(self, q: Array) -> Array:
        return 0.5 * self.stiffness * np.sum(q * q, axis=-1)

    def gradient(self, q: Array) -> Array:
        """stiffness q."""
        return self.stiffness * q

    def hessian(self, q: Array) -> Array:
        """stiffness I."""
        return self.stiffness * np.eye(q.size)

    def law(self) -> Law:
        return Law(kernels.spring_gradient, kernels.spring_hessian, np.array([self.stiffness]))


@dataclass(frozen=True)
class SpringChain:
    """V(q) = sum over springs of r^2/2 + alpha r^3/3 + beta r^4/4, q of shape (d,) displacements.

    alpha, beta  quadratic and cubic stiffness; ValueError unless finite

    Fermi, Pasta, Ulam and Tsingou, Los Alamos report LA-1940 (1955), eqs. 1 and 2.
    """

    alpha: float = 0.0
    beta: float = 0.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "alpha", input_checks.real("alpha", self.alpha))
        object.__setattr__(self, "beta", input_checks.real("beta", self.beta))

    def __call__(self, q: Array) -> Array:
        r = np.diff(q, prepend=0.0, append=0.0)
        return np.sum(r * r * (0.5 + r * (self.alpha / 3.0 + r * (self.beta / 4.0))), axis=-1)

    def gradient(self, q: Array) -> Array:
        """dV/dq, (d,)."""
        out = np.empty((q.size, 1))
        law = self.law()
        law.gradient(np.ascontiguousarray(q)[:, None], np.zeros(1), law.constants, out)
        return out[:, 0]

    def hessian(self, q: Array) -> Array:
        """d2V/dq2, (d, d)."""
        out = np.empty((q.size, q.size, 1))
        law = self.law()
        law.hessian(np.ascontiguousarray(q)[:, None], np.zeros(1), law.constants, out)
        return out[:, :, 0]

    def law(self) -> Law:
        return Law(kernels.chain_gradient, kernels.chain_hessian, np.array([self.alpha, self.beta]))


@dataclass(frozen=True, eq=False)
class UniformField:
    """V(q) = -force . q, e.g. of a weight, with force = mass g.

    force  (d,) as q; ValueError unless finite
    """

    force: Any

    def __post_init__(self) -> None:
        force = input_checks.array("force", self.force)
        if force.ndim != 1:
            raise ValueError(f"force must have shape (d,); received shape {force.shape}.")
        object.__setattr__(self, "force", force)

    def __call__(self, q: Array) -> Array:
        return -(q @ self.force)

    def gradient(self, q: Array) -> Array:
        """-force."""
        return -self.force + 0.0 * q

    def hessian(self, q: Array) -> Array:
        """0."""
        return np.zeros((q.size, q.size))

    def law(self) -> Law:
        return Law(kernels.uniform_gradient, kernels.uniform_hessian, np.array(self.force))


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
