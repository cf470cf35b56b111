"""A rigid body that rotates and translates, on SE(3)."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, ClassVar

import numpy as np

from galvi import input_checks
from galvi.arrays import Array
from galvi.groups.group import SE3
from galvi.kernels.forces import lagrangian_derivatives
from galvi.systems.forces.external_force import check_force, with_force
from galvi.systems.lagrangian import Lagrangian
from galvi.systems.rigid_body import Body, possible_inertia
from galvi.systems.system import LagrangianKernel
from galvi.systems.user_functions import (
    Function,
    arguments,
    check_call_signatures,
    check_callables,
    returned_array,
)


@dataclass(frozen=True, eq=False)
class FreeBody(Body):
    """A body that turns and moves, with the rigid motion q = [[R, x], [0, 1]].

    ``L = w . J w / 2 + mass |v|^2 / 2 + mass g . x - V``.

    Parameters
    ----------
    mass
        positive
    inertia
        J about the centre of mass x, in the body's frame: (3,) principal moments or (3, 3)
    g : array, shape (3,)
        acceleration of gravity in space
    potential
        V of one motion q (4, 4), besides gravity; None for none
    gradient
        the Euclidean dV/dq, (4, 4), whose last row is not used; differenced from V when missing
    force
        an external torque and force (6,) in the body's frame, of (q, v); see
        galvi.systems.forces.external_force
    explicit_time
        potential and gradient take (q, t) instead of (q)
    timed_force
        the force takes (q, v, t)
    check
        compare the gradient with differences of V when a `Problem` is made

    Raises
    ------
    ValueError
        For a mass or an inertia that no body can have, and for a gradient or ``explicit_time``
        without a potential.
    TypeError
        For a function that cannot be called with these arguments, and for flags that are no bools.

    Notes
    -----
    Configurations are (4, 4); velocities (6,) are (w, v), both in the body's frame, and momenta p =
    (J w, mass v). Functions are traced as those of a `galvi.Lagrangian`.

    Examples
    --------
    >>> body = galvi.FreeBody(mass=2.0, inertia=(1.0, 2.0, 2.5), g=(0.0, 0.0, -9.81))
    >>> problem = galvi.Problem(body, q0=np.eye(4), v0=(0.0, 0.1, 0.0, 1.0, 0.0, 0.0))
    >>> problem.p0
    array([0. , 0.2, 0. , 2. , 0. , 0. ])
    """

    group: ClassVar[SE3] = SE3()
    _numbers: ClassVar[tuple[str, ...]] = ("mass", "inertia", "g")

    mass: float
    inertia: Any
    g: Any = (0.0, 0.0, 0.0)
    potential: Function | None = None
    gradient: Function | None = None
    force: Function | None = None
    explicit_time: bool = field(default=False, kw_only=True)
    timed_force: bool = field(default=False, kw_only=True)
    check: bool = field(default=True, kw_only=True, compare=False)

    def __post_init__(self) -> None:
        check_force(self)
        check_callables(self, ("potential", "gradient"), "q")
        object.__setattr__(self, "mass", input_checks.positive("mass", self.mass))
        object.__setattr__(self, "inertia", possible_inertia(self.inertia))
        object.__setattr__(self, "g", input_checks.array("g", self.g, (3,)))
        if self.potential is None and (self.gradient is not None or self.explicit_time):
            raise ValueError(
                "a gradient and explicit_time are those of a potential; received none. Give one, "
                "or leave them out."
            )
        check_call_signatures(self, ("potential", "gradient"), "q", "explicit_time")

    def potential_gradient(self, q: Array, t: float) -> Array:
        """The user's dV/dq at one motion, (4, 4); 0 without a gradient."""
        if self.gradient is None:
            return np.zeros((4, 4))
        values = self.gradient(*arguments(self, q, t))
        return returned_array("gradient", values, (4, 4), "an array of shape (4, 4), dV/dq")

    def check_derivatives(self, q: Array, v: Array, t: float) -> None:
        """ValueError unless the gradient agrees with differences of V, at a state and near it."""
        if self.gradient is not None:
            self.lagrangian.check_derivatives(q, v, t)

    @property
    def has_functions(self) -> bool:
        """Whether there is a potential besides gravity, or a force."""
        return self.potential is not None or self.force is not None

    @cached_property
    def lagrangian(self) -> Lagrangian:
        """The same system as a `Lagrangian` with functions of (q, v)."""
        momentum, weight, V, gradient = (
            self.momentum,
            self.mass * self.g,
            self.potential,
            self.gradient,
        )

        def L(q: Any, v: Any, *t: Any) -> Any:
            without_potential = 0.5 * v @ momentum(v) + weight @ q[:3, 3]
            return without_potential if V is None else without_potential - V(q, *t)

        def slopes(q: Any, v: Any, *t: Any) -> Any:
            minus_dV_dq = np.zeros((4, 4)) if gradient is None else -np.asarray(gradient(q, *t))
            by_position = minus_dV_dq[:3, 3] + weight
            return np.concatenate(
                [
                    momentum(v),
                    minus_dV_dq[0, :3],
                    by_position[:1],
                    minus_dV_dq[1, :3],
                    by_position[1:2],
                    minus_dV_dq[2, :3],
                    by_position[2:],
                    minus_dV_dq[3],
                ]
            )

        return Lagrangian(
            L,
            self.group,
            slopes if V is None or gradient is not None else None,
            self.force,
            explicit_time=self.explicit_time,
            timed_force=self.timed_force,
            check=self.check,
        )

    def momentum(self, v: Array) -> Array:
        """p = (J w, mass v), v of shape (..., 6)."""
        return np.concatenate([v[..., :3] @ self.inertia, self.mass * v[..., 3:]], axis=-1)

    def velocity(self, p: Array) -> Array:
        """v = (J^-1 p_w, p_v / mass), p of shape (..., 6)."""
        return np.concatenate([p[..., :3] @ self.inverse_inertia, p[..., 3:] / self.mass], axis=-1)

    def potential_energy(self, q: Array, t: Array) -> Array:
        """V - mass g . x, (...), for q of shape (..., 4, 4) and times t (...)."""
        energies: Array = -self.mass * (q[..., :3, 3] @ self.g)
        if self.potential is None:
            return energies
        return energies + self._potentials(q, t)

    def lagrangian_kernel(self) -> LagrangianKernel:
        """Derivatives of L for the kernels; without a potential the constants are J by rows, mass,
        g."""
        if self.potential is not None:
            return self.lagrangian.lagrangian_kernel()
        constants = np.concatenate([self.inertia.ravel(), [self.mass], self.g])
        kernel = LagrangianKernel(
            lagrangian_derivatives.LAW, lagrangian_derivatives.free_body, constants=constants
        )
        return with_force(kernel, self, 4)

    @property
    def potential_calls_per_force(self) -> int:
        return 0 if self.potential is None else self.lagrangian.potential_calls_per_force
