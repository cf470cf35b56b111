"""The forces of an `NBody` system: checked, and as constants and functions for the kernels."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from typing import Any

import numba
import numpy as np

from galvi import input_checks
from galvi.arrays import Array, read_only
from galvi.input_checks import shown
from galvi.kernels.forces import celestial, celestial_velocity
from galvi.systems.forces.celestial import CelestialForce, Force


class Acting:
    """The forces on bodies of these masses (bodies,), and their constants for kernels.

    Attributes
    ----------
    terms : array, shape (rows, COLUMNS)
        rows of galvi.kernels.forces.celestial, those of its poles first
    poles
        number of rows of poles
    blocks : array, shape (c,)
        constants of galvi.kernels.forces.celestial_velocity, of the built-in forces of velocity
    functions
        the `Force` values, which call a user's function
    of_velocity
        whether a force depends on velocities
    conserve
        whether all forces are gradients of potentials that galvi knows

    Raises
    ------
    TypeError
        For a value that is no force.
    ValueError
        For a force that cannot act on these bodies, and for a force of velocity where a body has no
        mass.
    """

    def __init__(self, forces: Any, masses: Array, G: float) -> None:
        self.masses, self.G, self.forces = masses, G, input_checks.several(forces)
        for force in self.forces:
            if not isinstance(force, CelestialForce):
                raise TypeError(
                    f"forces must be values such as galvi.Oblateness(0, 1e-3, 0.1); received "
                    f"{shown(force)}."
                )
        self.functions = [force for force in self.forces if isinstance(force, Force)]
        builtin: Any = [force for force in self.forces if not isinstance(force, Force)]
        for force in builtin:
            if objection := force.objection(masses):
                raise ValueError(objection)
        poles = [row for force in builtin for row in force.poles(masses, G)]
        powers = [row for force in builtin for row in force.powers(masses, G)]
        self.poles = len(poles)
        self.terms = read_only(np.array(poles + powers).reshape(-1, celestial.COLUMNS))
        self.blocks = read_only(
            np.array([x for force in builtin for x in force.block(masses, G)], dtype=np.float64)
        )
        self.of_velocity = any(force.takes_velocity for force in self.forces)
        self.conserve = not self.functions and not self.blocks.size
        massless = np.flatnonzero(masses == 0.0)
        if self.of_velocity and massless.size:
            raise ValueError(
                f"with a force of velocity every body needs a mass; received {massless.size} "
                f"without, the first of them body {massless[0]}. Give each a small mass."
            )

    def check_state(self, q: Array, v: Array, t: float) -> None:
        """ValueError for an axis that is not normal to the plane of a plane problem, and for a
        `Force` that is not finite, not of q's shape, or acts on a massless body."""
        for force in self.forces if q.shape[1] == 2 else ():
            for name in force.spatial:
                axis = getattr(force, name)
                if axis[0] or axis[1]:
                    raise ValueError(
                        f"in the plane the {name} of {type(force).__name__} must be (0, 0, z); "
                        f"received {axis}."
                    )
        for function in self.functions:
            value = function.at(q, v, t)
            if not np.all(np.isfinite(value)):
                raise ValueError(
                    f"a Force must be finite at the start; received {value.tolist()}. Check its "
                    f"function, or start elsewhere."
                )
            pushed = np.flatnonzero((self.masses == 0.0) & np.any(value != 0.0, axis=1))
            if pushed.size:
                raise ValueError(
                    f"a Force must be 0 on a body without mass; received "
                    f"{value[pushed[0]].tolist()} on body {pushed[0]}. Give it a mass, or no force."
                )

    def constants(self, dimension: int) -> Array:
        """The constants of galvi.kernels.forces.celestial."""
        head = [float(dimension)], self.G * self.masses, [len(self.terms), float(self.poles)]
        return np.concatenate([*head, self.terms.ravel()])

    def velocity_constants(self, dimension: int) -> Array:
        """The constants of galvi.kernels.forces.celestial_velocity."""
        head = np.array([float(dimension), float(self.masses.size)])
        return np.concatenate([head, self.masses, self.G * self.masses, self.blocks])

    @cached_property
    def compiled(self) -> bool:
        """Whether all functions run inside a compiled kernel."""
        return all(function.compiled for function in self.functions)

    def extra_accelerations(self, q: Array, v: Array, t: float) -> Array:
        """The accelerations (bodies, D) by users' functions and built-in forces of velocity."""
        q, v = (np.array(x, dtype=np.float64) for x in (q, v))
        constants = self.velocity_constants(q.shape[1])
        a: Array = celestial_velocity.accelerations_of_blocks(q, v, float(t), constants)
        pushed = np.sum([np.zeros(q.shape), *(f.at(q, v, t) for f in self.functions)], axis=0)
        with np.errstate(divide="ignore"):  # infinite where a body without mass is pushed
            return a + np.divide(
                pushed, self.masses[:, None], out=np.zeros(q.shape), where=pushed != 0.0
            )

    def force(self, dimension: int) -> Callable[..., Array]:
        """A function (q, v, t) -> force, (d,), the sum of users' functions and of built-in forces
        of velocity; compiled where all users' functions are."""
        constants = self.velocity_constants(dimension)
        n, total = self.masses.size, _builtin(constants, self.masses.size, dimension)
        if not self.compiled:
            masses = np.repeat(self.masses, dimension)
            shape = n, dimension

            def in_python(q: Array, v: Array, t: float) -> Array:
                extra = self.extra_accelerations(q.reshape(shape), v.reshape(shape), t).ravel()
                with np.errstate(invalid="ignore"):  # NaN where a body without mass is pushed
                    return masses * extra

            return in_python
        for force in self.functions:
            total = _with(total, force, (n, dimension))
        return total

    def pushes(self, dimension: int) -> Callable[..., Any]:
        """A function as that of `force`, without built-in forces, not compiled."""
        total: Any = _no_force
        for force in self.functions:
            total = _with(total, force, (self.masses.size, dimension), lambda function: function)
        return total

    def accelerations(self, dimension: int) -> Callable[..., Array]:
        """A function (q, t) -> accelerations, (d,), by gravity and all forces; for forces that do
        not depend on velocities."""
        constants, force = self.constants(dimension), self.force(dimension)
        builtin, masses = celestial.accelerations, np.repeat(self.masses, dimension)

        def total_acceleration(q: Array, t: float) -> Array:
            times, a = np.empty(1), np.empty((q.size, 1))
            times[0] = t
            builtin(q.copy().reshape((q.size, 1)), times, constants, a)
            pushed = force(q, q, t)  # q also stands for v, which no force reads
            for k in range(q.size):
                if pushed[k] != 0.0:
                    a[k, 0] += pushed[k] / masses[k]  # infinite for a massless body
            return a[:, 0].copy()

        return (
            numba.njit(error_model="numpy")(total_acceleration)
            if self.compiled
            else total_acceleration
        )


def _builtin(constants: Array, n: int, D: int) -> Any:
    add = celestial_velocity.add_forces

    @numba.njit
    def builtin(q: Any, v: Any, t: Any) -> Any:
        out = np.zeros((2, n * D))
        add(q, v, t, constants, out)
        return out[1].copy()

    return builtin


def _no_force(q: Any, v: Any, t: Any) -> Any:
    return np.zeros(q.size)


def _with(inner: Any, force: Force, shape: tuple[int, int], jit: Any = numba.njit) -> Any:
    """A function (q, v, t) -> inner(q, v, t) plus a user's force; NaN where that has a wrong
    shape."""
    f: Any = force.function
    takes = force.takes_velocity, force.takes_time
    calls: Any = {
        (False, False): lambda q, v, t: f(q),
        (True, False): lambda q, v, t: f(q, v),
        (False, True): lambda q, v, t: f(q, t),
        (True, True): lambda q, v, t: f(q, v, t),
    }
    call = jit(calls[takes])

    def both(q: Any, v: Any, t: Any) -> Any:
        values = call(q.copy().reshape(shape), v.copy().reshape(shape), t)
        total = inner(q, v, t)
        for k in range(total.size):
            has_shape = values.shape[0] == shape[0] and values.shape[1] == shape[1]
            total[k] += values[k // shape[1], k % shape[1]] if has_shape else np.nan
        return total

    return jit(both)
