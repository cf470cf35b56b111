"""Built-in potentials: values with readable fields, which references and lanes recognise."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from galvi import input_checks
from galvi.arrays import Array
from galvi.kernels.forces import potentials as kernels


class Potential:
    """V(q) of configurations of shape (..., d), with its derivatives at one of them.

    Attributes
    ----------
    slopes, second
        functions of galvi.kernels.forces.potentials that fill dV/dq and d2V/dq2
    named
        names of the fields that are their constants
    """

    slopes: ClassVar[Callable[..., Any]]
    second: ClassVar[Callable[..., Any]]
    named: ClassVar[tuple[str, ...]]

    def __call__(self, q: Array) -> Any:
        """V(q), (...)."""
        raise NotImplementedError

    @property
    def constants(self) -> Array:
        """The constants (c,) of dV/dq."""
        return np.hstack([getattr(self, name) for name in self.named])

    def gradient(self, q: Array) -> Array:
        """dV/dq, (d,), at one configuration."""
        return self._filled(self.slopes, q, 1)

    def hessian(self, q: Array) -> Array:
        """d2V/dq2, (d, d), at one configuration."""
        return self._filled(self.second, q, 2)

    def _filled(self, function: Callable[..., Any], q: Any, axes: int) -> Array:
        q = np.asarray(q)
        out: Array = np.zeros(q.shape * axes, np.result_type(q, np.float64))
        with np.errstate(all="ignore"):
            function(q, self.constants, out)
        return out


@dataclass(frozen=True)
class CentralForce(Potential):
    """``V(q) = -mu / |q|``, q of shape (2,) or (3,), the centre at the origin.

    Parameters
    ----------
    mu
        strength, length^3 / time^2 times mass; ValueError unless finite and positive

    Examples
    --------
    >>> float(galvi.CentralForce(mu=4.0)(np.array([2.0, 0.0])))
    -2.0
    """

    slopes = staticmethod(kernels.central_force)
    second = staticmethod(kernels.central_force_hessian)
    named = ("mu",)
    mu: float = 1.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "mu", input_checks.positive("mu", self.mu))

    def __call__(self, q: Array) -> Array:
        return -self.mu / np.sqrt(np.sum(q * q, axis=-1))


@dataclass(frozen=True)
class CosinePotential(Potential):
    """V(q) = -weight sum cos(q_i), q of shape (d,): d pendulums, angles from hanging down.

    Parameters
    ----------
    weight
        m g l, an energy; ValueError unless finite and positive

    Examples
    --------
    >>> float(galvi.CosinePotential(weight=2.0)(np.array([0.0])))
    -2.0
    """

    slopes = staticmethod(kernels.pendulum)
    second = staticmethod(kernels.pendulum_hessian)
    named = ("weight",)
    weight: float = 1.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "weight", input_checks.positive("weight", self.weight))

    def __call__(self, q: Array) -> Array:
        return -self.weight * np.sum(np.cos(q), axis=-1)


@dataclass(frozen=True)
class LinearSpring(Potential):
    """``V(q) = stiffness |q|^2 / 2``, q of shape (d,).

    Parameters
    ----------
    stiffness
        force per length; ValueError unless finite and positive

    Examples
    --------
    >>> galvi.LinearSpring(stiffness=3.0).gradient(np.array([1.0, 2.0]))
    array([3., 6.])
    """

    slopes = staticmethod(kernels.linear_spring)
    second = staticmethod(kernels.linear_spring_hessian)
    named = ("stiffness",)
    stiffness: float = 1.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "stiffness", input_checks.positive("stiffness", self.stiffness))

    def __call__(self, q: Array) -> Array:
        return 0.5 * self.stiffness * np.sum(q * q, axis=-1)


@dataclass(frozen=True)
class SpringChain(Potential):
    """V(q) = sum over springs of r^2/2 + alpha r^3/3 + beta r^4/4, q of shape (d,) displacements.

    Parameters
    ----------
    alpha, beta
        quadratic and cubic stiffness; ValueError unless finite

    Notes
    -----
    Fermi, Pasta, Ulam and Tsingou, Los Alamos report LA-1940 (1955), eqs. 1 and 2.

    Examples
    --------
    >>> float(galvi.SpringChain()(np.array([0.0, 1.0, 0.0])))  # two springs stretched by 1
    1.0
    """

    slopes = staticmethod(kernels.spring_chain)
    second = staticmethod(kernels.spring_chain_hessian)
    named = ("alpha", "beta")
    alpha: float = 0.0
    beta: float = 0.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "alpha", input_checks.real("alpha", self.alpha))
        object.__setattr__(self, "beta", input_checks.real("beta", self.beta))

    def __call__(self, q: Array) -> Array:
        r = np.diff(q, prepend=0.0, append=0.0)
        return np.sum(r * r * (0.5 + r * (self.alpha / 3.0 + r * (self.beta / 4.0))), axis=-1)


@dataclass(frozen=True, eq=False)
class UniformField(Potential):
    """The potential of a constant force, e.g. of a weight, with force = mass g.

    ``V(q) = -force . q``.

    Parameters
    ----------
    force : array, shape (d,)
        as q; ValueError unless finite

    Examples
    --------
    >>> galvi.UniformField(force=(0.0, -9.81)).gradient(np.array([1.0, 2.0]))
    array([0.  , 9.81])
    """

    slopes = staticmethod(kernels.uniform_field)
    second = staticmethod(kernels.uniform_field_hessian)
    named = ("force",)
    force: Any

    def __post_init__(self) -> None:
        force = input_checks.array("force", self.force)
        if force.ndim != 1:
            raise ValueError(f"force must have shape (d,); received shape {force.shape}.")
        object.__setattr__(self, "force", force)

    def __call__(self, q: Array) -> Array:
        return -(q @ self.force)

    def _filled(self, function: Callable[..., Any], q: Any, axes: int) -> Array:
        if np.shape(q) != self.force.shape:
            raise ValueError(
                f"q must have the shape of the force, {self.force.shape}; received {np.shape(q)}."
            )
        return super()._filled(function, q, axes)


@dataclass(frozen=True, eq=False)
class UniformGravity:
    """The potential of the weight of a rotating body.

    ``V(R) = -mass g . R centre``, R of shape (3, 3).

    Parameters
    ----------
    mass
        of the body, positive
    centre : array, shape (3,)
        of mass, from the fixed point, in the body's frame
    g : array, shape (3,)
        acceleration of gravity in space; a number g stands for (0, 0, -g), downwards

    Raises
    ------
    ValueError
        For a mass that is not positive, a wrong shape or a number that is not finite.

    Examples
    --------
    >>> float(galvi.UniformGravity(mass=2.0, centre=(0.0, 0.0, -1.0), g=10.0)(np.eye(3)))
    -20.0
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
