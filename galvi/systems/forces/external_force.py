"""External forces: a user's function, checked once, and built-in ones."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any, Protocol, runtime_checkable

import numpy as np

from galvi.arrays import Array
from galvi.input_checks import flag, shown
from galvi.kernels.forces import lagrangian_derivatives
from galvi.systems.system import LagrangianKernel
from galvi.systems.user_functions import check_call_signatures, compiles, returned_array


@runtime_checkable
class BuiltinForce(Protocol):
    """A callable f(q, v, t) of one configuration and velocity that has a compiled form."""

    def __call__(self, q: Array, v: Array, t: float) -> Array:
        """f(q, v, t), shape of v."""

    def compiled(self) -> tuple[Callable[..., Any], Array]:
        """Compiled function (q (r,), v (d,), t, constants, out (2, d)) that adds the force to the
        second row of out, and its constants."""


class Forced(Protocol):
    """A system with an optional external force.

    Attributes
    ----------
    force
        f(q, v), or f(q, v, t), of one configuration and velocity (d,) -> (d,); on a group
        left-trivialised, as velocities are: a torque in the body's frame. None: no force
    timed_force
        whether it takes (q, v, t)
    """

    @property
    def force(self) -> Callable[..., Any] | None:
        """f(q, v) or f(q, v, t); None without a force."""

    @property
    def timed_force(self) -> bool:
        """Whether the force takes the time."""


def check_force(system: Forced) -> None:
    """TypeError for a force that is not a function of these arguments and for flags that are no
    bools; ValueError for timed_force without a force and for a built-in force without timed_force.
    """
    for name in ("explicit_time", "timed_force"):
        flag(name, getattr(system, name))
    arguments = "(q, v, t)" if system.timed_force else "(q, v)"
    if system.force is None and system.timed_force:
        raise ValueError(
            "timed_force means a force(q, v, t); received no force. Give one, or leave "
            "timed_force out."
        )
    if system.force is not None and not callable(system.force):
        raise TypeError(f"force must be a function of {arguments}; received {shown(system.force)}.")
    if isinstance(system.force, BuiltinForce) and not system.timed_force:
        raise ValueError(
            f"{system.force!r} takes (q, v, t); received timed_force=False. Set timed_force."
        )
    check_call_signatures(system, ("force",), "q, v", "timed_force")


def force_at(system: Forced, q: Array, v: Array, t: float) -> Array:
    """The external force at one state, (d,); 0 for a system without. ValueError for a wrong shape.

    Its virtual work enters the discrete Lagrange-d'Alembert principle (Marsden and West, Acta
    Numerica 10 (2001), 3.2).
    """
    if system.force is None:
        return np.zeros(v.shape)
    q, v = np.array(q, dtype=np.float64), np.array(v, dtype=np.float64)
    values = system.force(q, v, float(t)) if system.timed_force else system.force(q, v)
    return returned_array("force", values, v.shape, f"an array of shape {v.shape}")


def check_force_at(system: Forced, q: Array, v: Array, t: float) -> None:
    """ValueError unless the force is finite at a state, and of the velocity's shape."""
    force = force_at(system, q, v, t)
    if not np.all(np.isfinite(force)):
        raise ValueError(
            f"the force must be finite at the start; received {force.tolist()}. Check the function "
            f"force, or start elsewhere."
        )


def with_force(field: LagrangianKernel, system: Forced, matrix_rows: int) -> LagrangianKernel:
    """The kernel description with the system's external force added.

    Parameters
    ----------
    matrix_rows
        rows of the matrix that the user's force takes as q; 0 for a vector
    """
    if system.force is None:
        return field
    if isinstance(system.force, BuiltinForce):
        add, constants = system.force.compiled()
        return replace(
            field,
            force_kind=lagrangian_derivatives.FORCE_LAW,
            force=add,
            force_constants=constants,
        )
    time_dependent = system.timed_force
    kind = lagrangian_derivatives.TIMED_FORCE if time_dependent else lagrangian_derivatives.FORCE
    compiled = compiles(system.force, lagrangian_derivatives.force_signature(kind, matrix_rows))

    def checked(q: Array, v: Array, t: float = 0.0) -> Array:
        return force_at(system, q, v, t)

    return replace(
        field,
        force_kind=kind,
        matrix_rows=matrix_rows,
        force=system.force if compiled else checked,
        compiled=field.compiled and compiled,
    )
