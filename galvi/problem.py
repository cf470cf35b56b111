"""An initial value problem: a mechanical system with its initial state and units."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from types import MappingProxyType
from typing import Any
from weakref import WeakSet

import numpy as np

from galvi import input_checks
from galvi.arrays import Array, read_only
from galvi.input_checks import shown
from galvi.systems.canonical import Canonical
from galvi.systems.free_body import FreeBody
from galvi.systems.lagrangian import Lagrangian
from galvi.systems.nbody import NBody
from galvi.systems.potentials.potentials import Potential, UniformGravity
from galvi.systems.rigid_body import RigidBody
from galvi.systems.system import BuiltinLagrangian, System

_REGULAR: WeakSet[Lagrangian] = WeakSet()  # systems that are not degenerate
WithFunctions = Canonical | Lagrangian | RigidBody | FreeBody  # systems of a user's functions


@dataclass(frozen=True, eq=False)
class Problem:
    """Everything an integrator or a reference receives.

    Parameters
    ----------
    system
        the mechanical system, e.g. ``Canonical(...)``, ``NBody(...)``, ``RigidBody(...)``
    q0
        configuration at t0, in the system's shape: (d,), (bodies, 2 or 3), or an element of a Lie
        group, e.g. a rotation matrix (3, 3)
    v0
        velocity at t0: of q0's shape, or on a Lie group the body velocity, e.g. (3,)
    t0
        initial time
    name
        for titles and tables; it has no effect on any computation
    parameters
        the numbers from which the problem was built, for records
    units
        one line: the units of length, time and mass

    Raises
    ------
    ValueError
        When a shape does not match, a number is not finite, a derivative is not that of its
        function or d2L/dv2 is singular.
    TypeError
        When system is no system or parameters is no mapping.

    Notes
    -----
    Given gradients, Hessians and slopes are compared with differences of the functions to which
    they belong, at the start and at a state near it, unless the system has ``check=False``
    (``galvi.systems.derivative_check``).

    Examples
    --------
    >>> system = galvi.Canonical(mass=2.0, potential=galvi.LinearSpring(8.0))
    >>> problem = galvi.Problem(system, q0=[1.0], v0=[0.0], name="spring", units="m, s, kg")
    >>> problem.p0, problem.with_initial_state([0.5], [1.0]).p0
    (array([0.]), array([2.]))
    """

    system: System
    q0: Array
    v0: Array
    t0: float = 0.0
    name: str = ""
    parameters: Mapping[str, Any] = field(default_factory=dict)
    units: str = ""

    def __post_init__(self) -> None:
        if isinstance(self.system, type) or not hasattr(self.system, "velocity_shape"):
            raise TypeError(
                f"system must be a system such as galvi.NBody(masses); "
                f"received {shown(self.system)}."
                f"{_remedy(self.system)}"
            )
        if hasattr(self.q0, "as_matrix"):
            raise ValueError(
                f"q0 must be an array, a rotation as its matrix; received {shown(self.q0)}. "
                f"Give q0.as_matrix()."
            )
        q0 = input_checks.array("q0", self.q0)
        shape = self.system.velocity_shape(q0.shape)
        remedy = "v0 has the shape of q0." if shape == q0.shape else "v0 is the body velocity."
        if q0.ndim < 2 and shape != q0.shape:
            remedy = f"So must q0; received shape {q0.shape}."
        v0 = input_checks.array("v0", self.v0, shape, remedy)
        object.__setattr__(self, "t0", input_checks.real("t0", self.t0))
        self.system.check_state(q0, v0, self.t0)
        object.__setattr__(self, "q0", q0)
        object.__setattr__(self, "v0", v0)
        if not isinstance(self.parameters, Mapping):
            raise TypeError(
                f"parameters must be a dict of names; received {shown(self.parameters)}."
            )
        object.__setattr__(self, "parameters", MappingProxyType(dict(self.parameters)))
        if isinstance(self.system, WithFunctions):
            self.system.check_derivatives(self.q0, self.v0, self.t0)
        if isinstance(self.system, WithFunctions | NBody):
            self.system.trace(self.q0, self.v0, self.t0)
        if isinstance(self.system, Lagrangian) and self.system not in _REGULAR:
            self.system.check_degenerate(self.q0, self.v0, self.t0)
            _REGULAR.add(self.system)

    def __reduce__(self) -> tuple[Any, ...]:
        content = (self.system, self.q0, self.v0, self.t0, self.name, dict(self.parameters))
        return Problem, (*content, self.units)

    def body_names(self) -> list[Any]:
        """The names of the point masses in parameters["bodies"], or their numbers."""
        names: Any = self.parameters.get("bodies")
        count = len(self.q0)
        bodies = list(names) if input_checks.has_items(names) and not isinstance(names, str) else []
        return bodies if len(bodies) == count else list(range(count))

    def with_initial_state(self, q0: Any, v0: Any) -> Problem:
        """The same problem from another configuration and velocity, for `galvi.integrate_many`."""
        return replace(self, q0=q0, v0=v0)

    def moved(self, q: Array, v: Array, t: float, system: System | None = None) -> Problem:
        """The same problem from another state of its motion, without checks; ``system``, of the
        same type, may replace its system."""
        problem = object.__new__(Problem)
        attributes = {key: value for key, value in vars(self).items() if key != "p0"}
        vars(problem).update(attributes, q0=read_only(q), v0=read_only(v), t0=t)
        if system is not None:
            vars(problem).update(system=system)
        return problem

    @cached_property
    def p0(self) -> Array:
        """Conjugate momentum at t0, dL/dv(q0, v0), shape of v0."""
        with np.errstate(over="ignore"):  # a run from this state reports it
            if isinstance(self.system, Lagrangian):
                return read_only(self.system.momentum(self.v0, self.q0, self.t0))
            return read_only(self.system.momentum(self.v0))

    def __repr__(self) -> str:
        return f"Problem({self.name or type(self.system).__name__!r}, q0 of shape {self.q0.shape})"


def _remedy(value: Any) -> str:
    """How a Lagrangian or a potential becomes a system; empty for anything else."""
    name = type(value).__name__
    if isinstance(value, type):
        return ""
    if isinstance(value, BuiltinLagrangian):
        return f" Give galvi.Lagrangian({name}(...), galvi.Rn(d)), with d coordinates."
    if isinstance(value, Potential):
        return f" Give galvi.Canonical(mass, {name}(...))."
    if isinstance(value, UniformGravity):
        return f" Give galvi.RigidBody(inertia, {name}(...))."
    return ""
