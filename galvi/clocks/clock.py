"""Clocks of a system: dt = g(q) dtau with g > 0, so that constant steps in tau follow the motion.

Sundman's transformation, in Poincare's form: with E the energy at the start,

    L_tau(q, q') = g(q) (L(q, q'/g(q)) + E),    t' = g(q)

is a Lagrangian like any other, whose motions of energy 0 are those of L with energy E. A method's
step of constant length in tau is therefore as symplectic, symmetric and momentum-preserving as it
is for L with a constant step in time.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol, runtime_checkable

import numpy as np

from galvi import input_checks
from galvi.arrays import Array
from galvi.input_checks import shown
from galvi.problem import Problem
from galvi.systems.finite_differences import differenced_gradient
from galvi.systems.nbody import NBody
from galvi.systems.user_functions import returned_array

Rate = Callable[[Any], Any]  # g of one configuration
# Largest difference of a user's gradient from finite differences, relative to the largest entry.
GRADIENT_TOLERANCE = 1e-4


@runtime_checkable
class AnyClock(Protocol):
    """The interface of clocks."""

    @property
    def vectorized(self) -> bool:
        """Whether g also takes n flat configurations at once, as an array (entries, n)."""

    def rate(self, problem: Problem) -> Rate:
        """g of one flat configuration of the problem; ValueError where the clock does not apply."""

    def slope(self, problem: Problem) -> Callable[[Array], Array]:
        """dg/dq of one flat configuration."""


@dataclass(frozen=True)
class DynamicalTime:
    """The clock of point masses, g = (sum over pairs of G (m_i + m_j) / r_ij^3)^(-1/2).

    For two bodies on a circle g is the time in which they turn by one radian, so that a revolution
    takes 2 pi in tau; with more bodies g is at most that of the closest pair. A step of 0.3 to 0.6
    suits degree 8. Pairs of massless bodies do not count. Only for `galvi.NBody` systems of at
    least two bodies.

    Examples
    --------
    >>> bodies = galvi.NBody([3.0, 4.0, 5.0])
    >>> burrau = galvi.Problem(bodies, [[1, 3], [-2, -1], [1, -1]], np.zeros((3, 2)))
    >>> clock = galvi.DynamicalTime()
    >>> method = galvi.Galerkin(galvi.Polynomials(8), galvi.gauss(8), clock=clock)
    >>> run = galvi.integrate(burrau, method, step=0.3, duration=63.0)
    >>> run.success, float(run.t[-1]), bool(np.diff(run.t).min() < 1e-5)
    (True, 63.0, True)
    """

    vectorized = True
    longest = 3.0  # largest step in tau, where a revolution takes 2 pi

    def rate(self, problem: Problem) -> Rate:
        """g of a flat configuration (entries,), or of n of them (entries, n)."""
        system = problem.system
        if not isinstance(system, NBody) or system.masses.size < 2:
            received = (
                "one body" if isinstance(system, NBody) else f"a {type(system).__name__} system"
            )
            raise ValueError(
                f"galvi.DynamicalTime needs a galvi.NBody system of at least two bodies; received "
                f"{received}. Use galvi.Clock(function), or for one centre galvi.Sundman()."
            )
        masses, size = system.G * system.masses, problem.q0.shape[1]
        pairs = [
            (i, j, float(masses[i] + masses[j]))
            for i in range(masses.size)
            for j in range(i + 1, masses.size)
            if masses[i] + masses[j] > 0.0
        ]

        def rate(q: Any) -> Any:
            total: Any = 0.0
            for i, j, mass in pairs:
                square: Any = 0.0
                for k in range(size):
                    gap = q[i * size + k] - q[j * size + k]
                    square = square + gap * gap
                total = total + mass / (square * np.sqrt(square))
            return 1.0 / np.sqrt(total)

        return rate

    def slope(self, problem: Problem) -> Callable[[Array], Array]:
        """dg/dq of a flat configuration."""
        masses, rate = problem.system.G * problem.system.masses, self.rate(problem)  # type: ignore[attr-defined]
        sums = masses[:, None] + masses

        def slope(flat: Array) -> Array:
            q = flat.reshape(problem.q0.shape)
            gaps = q[:, None] - q
            square = np.sum(gaps**2, axis=-1) + np.eye(len(q))
            pull: Array = np.sum((sums * (1.0 - np.eye(len(q))) / square**2.5)[..., None] * gaps, 1)
            return (1.5 * rate(flat) ** 3 * pull).ravel()

        return slope


@dataclass(frozen=True)
class Sundman:
    """The clock of one particle about a centre at the origin, ``g = |q|^power / sqrt(gm)``.

    Parameters
    ----------
    power
        3/2: steps are equal shares of the local dynamical time; 1: equal differences of the
        eccentric anomaly; 2: of the true anomaly
    gm
        G M of the centre, in the units of the problem. With power 3/2 the step has no unit, and a
        revolution on a circle takes 2 pi; with other powers its unit is that of a length to the
        power 3/2 - power

    Examples
    --------
    >>> clock = galvi.Sundman(power=1.5)
    >>> method = galvi.Galerkin(galvi.Polynomials(8), galvi.gauss(8), clock=clock)
    >>> run = galvi.integrate(galvi.problems.kepler(0.999), method, step=0.3, duration=6.2)
    >>> run.status, bool(np.ptp(galvi.energy(run)) < 1e-8)
    ('Completed.', True)
    """

    power: float = 1.5
    gm: float = 1.0
    vectorized = True

    def __post_init__(self) -> None:
        for name in ("power", "gm"):
            object.__setattr__(self, name, input_checks.positive(name, getattr(self, name)))

    def rate(self, problem: Problem) -> Rate:
        """g of a configuration (d,)."""
        if isinstance(problem.system, NBody) or problem.q0.ndim != 1:
            raise ValueError(
                f"galvi.Sundman needs one particle on a vector space, with its centre at the "
                f"origin; received {shown(problem)}. For point masses use galvi.DynamicalTime()."
            )
        if not np.any(problem.q0):
            raise ValueError(
                "galvi.Sundman needs a particle away from its centre; received q0 = 0."
            )
        half, share = 0.5 * self.power, 1.0 / math.sqrt(self.gm)

        def rate(q: Any) -> Any:
            square: Any = 0.0
            for k in range(problem.q0.size):
                square = square + q[k] * q[k]
            return square**half * share if share != 1.0 else square**half

        return rate

    def slope(self, problem: Problem) -> Callable[[Array], Array]:
        """dg/dq of a configuration (d,)."""
        rate = self.rate(problem)
        return lambda q: self.power * rate(q) / (q @ q) * q

    def __repr__(self) -> str:
        gm = "" if self.gm == 1.0 else f", gm={self.gm!r}"
        return f"Sundman(power={self.power!r}{gm})"


@dataclass(frozen=True)
class Clock:
    """The clock of a function g of one configuration q, dt = g(q) dtau.

    Parameters
    ----------
    function
        q -> positive number, smooth, about the time in which q changes by its size; on a group q is
        a matrix. It is traced where it does not branch, else called
    gradient
        q -> dg/dq of q's shape; None: by finite differences where the function cannot be traced

    Examples
    --------
    >>> def pace(q):
    ...     return 1.0 / (2.0 + np.cos(q[1]))
    >>> method = galvi.Galerkin(galvi.Polynomials(6), galvi.gauss(6), clock=galvi.Clock(pace))
    >>> run = galvi.integrate(galvi.problems.elastic_pendulum(), method, step=0.2, duration=2.0)
    >>> run.status, float(run.t[-1])
    ('Completed.', 2.0)
    """

    function: Callable[..., Any]
    gradient: Callable[..., Any] | None = None
    vectorized = False

    def __post_init__(self) -> None:
        for name in ("function", "gradient"):
            value = getattr(self, name)
            if not callable(value) and (name == "function" or value is not None):
                raise TypeError(f"{name} must be a function of q; received {shown(value)}.")

    def rate(self, problem: Problem) -> Rate:
        """g of a flat configuration."""
        shape = problem.q0.shape
        value = input_checks.returned("the clock", self.function(problem.q0.copy()))
        if not (np.isfinite(value) and value > 0.0):
            raise ValueError(
                f"a clock must return a positive, finite number; received {value} at q0. Check it, "
                f"or start elsewhere."
            )
        if len(shape) == 1:
            return self.function
        return lambda flat: self.function(flat.reshape(shape))

    def slope(self, problem: Problem) -> Callable[[Array], Array]:
        """dg/dq of a flat configuration."""
        gradient, shape, q0 = self.gradient, problem.q0.shape, problem.q0.ravel()
        differenced: Callable[[Array], Array] = differenced_gradient(self.rate(problem), False)
        if gradient is None:
            return differenced

        def slope(flat: Array) -> Array:
            values = gradient(flat.reshape(shape))
            return returned_array("gradient", values, shape, f"an array of shape {shape}").ravel()

        received, expected = slope(q0.copy()), differenced(q0.copy())
        if not np.max(np.abs(received - expected)) <= GRADIENT_TOLERANCE * np.max(np.abs(expected)):
            raise ValueError(
                f"gradient must be dg/dq of the clock's function; received {received.tolist()} at "
                f"q0, where differences give {expected.tolist()}. Leave it out, or correct it."
            )
        return slope

    def __str__(self) -> str:
        return f"Clock({getattr(self.function, '__name__', 'function')})"


def check_step(problem: Problem, clock: AnyClock, step: float) -> None:
    """ValueError for a clock whose g is not positive and finite at the start, and for a step that
    does not change the time or is too long for the clock."""
    g = float(clock.rate(problem)(problem.q0.ravel()))
    if not (math.isfinite(g) and g > 0.0):
        raise ValueError(
            f"a clock must be positive and finite; received {g} at the start. Start elsewhere."
        )
    if problem.t0 + step * g == problem.t0:
        raise ValueError(
            f"step must change the time; received {step!r} at t0 = {problem.t0!r}, where times are "
            f"{math.ulp(problem.t0):.1e} apart. Shift t0 towards 0, or use a larger step."
        )
    longest = getattr(clock, "longest", math.inf)
    if abs(step) > longest:
        raise ValueError(
            f"step must be at most {longest:g}: {units_of_steps(problem, clock)}, so that a "
            f"revolution is 2 pi; received {step!r}. Use 0.3 to 0.6 for degree 8."
        )


def units_of_steps(problem: Problem, clock: AnyClock) -> str:
    """A clause on the unit of a clock's steps."""
    g = float(clock.rate(problem)(problem.q0.ravel()))
    return f"steps are in units of the clock {clock}, {g:.3g} of time at the start"
