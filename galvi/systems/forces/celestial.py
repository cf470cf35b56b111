"""Forces of celestial mechanics, as values of a `galvi.NBody` system.

Built-in forces that depend on positions alone are part of the Lagrangian, and of the energy of a
run; a `Force` and those that depend on velocities enter by the Lagrange-d'Alembert principle.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from galvi import input_checks
from galvi.arrays import Array
from galvi.input_checks import shown
from galvi.kernels.compile.jit import MATRIX, REAL
from galvi.kernels.forces import celestial_velocity
from galvi.systems.user_functions import compiles, returned_array

POLE_ROUNDING = 2.0**-50  # a pole whose length differs from 1 by less is not normalised
NEAR_LOGARITHM = 1e-6  # powers nearer to -1 lose digits of the energy by cancellation
FORMS = ("one source", "potential", "EIH")


class _Builtin:
    """A force without a user's function, as rows of constants for the kernels."""

    takes_velocity = False
    spatial: tuple[str, ...] = ()  # fields (3,) that are (0, 0, z) in the plane

    def poles(self, masses: Array, G: float) -> list[list[float]]:
        """Rows for `pole_pull` of galvi.kernels.forces.celestial."""
        return []

    def powers(self, masses: Array, G: float) -> list[list[float]]:
        """Rows for `power_pull` of galvi.kernels.forces.celestial."""
        return []

    def block(self, masses: Array, G: float) -> list[float]:
        """Kind, count and constants for galvi.kernels.forces.celestial_velocity; [] for a force of
        position."""
        return []

    def objection(self, masses: Array) -> str:
        """Why the force cannot act between bodies of these masses; "" where it can."""
        return ""


def _set(value: Any, **fields: Any) -> None:
    for name, entry in fields.items():
        object.__setattr__(value, name, entry)


def _source(name: str, body: int, masses: Array) -> str:
    """Why a body cannot be a source; "" where it can."""
    if body >= masses.size:
        return f"{name} must be one of {masses.size} bodies, by number; received {body}."
    if masses[body] == 0.0:
        return f"{name} must be a body with a mass; received {body}, which has none."
    return ""


def _for_each(name: str, numbers: Array, masses: Array) -> str:
    """Why numbers are not one for each body; "" where they are."""
    expected = f"{name} must have a number for each of {masses.size} bodies; received shape "
    return "" if numbers.shape == masses.shape else f"{expected}{numbers.shape}."


def _onto_others(source: int, masses: Array, numbers: Sequence[float]) -> list[list[float]]:
    """A row of constants for each other body: source, body, ratio of masses, mass, numbers."""
    return [
        [source, k, mass / masses[source], mass, *numbers]
        for k, mass in enumerate(masses.tolist())
        if k != source
    ]


@dataclass(frozen=True)
class Relativity(_Builtin):
    """General relativity to c^-2.

    Parameters
    ----------
    c
        speed of light in the problem's units, positive
    source
        index of the body whose field acts; not used by "EIH"
    form
        "one source": Schwarzschild's field of the source, which recoils; a force of velocity.
        "potential": V = -3 (G M)^2 m / (c r)^2 for every body, M the source's mass, which turns
        pericentres right and changes the mean motion by c^-2 (Nobili and Roxburgh, IAU Symp. 114
        (1986) 105). "EIH": the equations of Einstein, Infeld and Hoffmann of all bodies; a force of
        velocity, without further terms of c^-4

    Raises
    ------
    ValueError
        For a c that is not positive, a negative source or another form, and by `NBody` for a source
        that is no body or has no mass.

    Examples
    --------
    >>> star = galvi.Relativity(c=10065.32, form="EIH")  # au and years / 2 pi
    >>> galvi.NBody([1.0, 1e-3], forces=star).forces[0].form
    'EIH'
    """

    c: float
    source: int = 0
    form: str = "one source"

    def __post_init__(self) -> None:
        _set(self, c=input_checks.positive("c", self.c))
        _set(self, source=input_checks.whole("source", self.source, 0))
        if not isinstance(self.form, str) or self.form not in FORMS:
            raise ValueError(f"form must be one of {FORMS}; received {shown(self.form)}.")

    @property
    def takes_velocity(self) -> bool:  # type: ignore[override]
        """Whether the force depends on velocities."""
        return self.form != "potential"

    def poles(self, masses: Array, G: float) -> list[list[float]]:
        if self.takes_velocity:
            return []
        depth = -6.0 * (G * masses[self.source] / self.c) ** 2
        return _onto_others(self.source, masses, (0.0, 0.0, 1.0, depth, 0.0, 0.0))

    def block(self, masses: Array, G: float) -> list[float]:
        if self.form == "EIH":
            return [celestial_velocity.EIH, 1, self.c]
        return (
            [celestial_velocity.ONE_SOURCE, 2, self.c, self.source] if self.takes_velocity else []
        )

    def objection(self, masses: Array) -> str:
        return "" if self.form == "EIH" else _source("source", self.source, masses)


@dataclass(frozen=True)
class Oblateness(_Builtin):
    """The zonal harmonics J2 and J4 of one body's field, which acts on all others; it recoils.

    V = G M m [J2 (R / r)^2 P2(u) + J4 (R / r)^4 P4(u)] / r, u the sine of the latitude (Murray and
    Dermott, Solar System Dynamics (1999), 4.5).

    Parameters
    ----------
    body
        index of the oblate body, which needs a mass
    radius
        R, to which J2 and J4 belong, positive
    pole : array, shape (3,)
        direction of the body's axis, of any length, fixed in the axes of the problem; in a plane
        problem (0, 0, z)

    Raises
    ------
    ValueError
        For a negative body, a radius that is not positive, a pole of length 0 and numbers that are
        not finite.

    Examples
    --------
    >>> system = galvi.NBody([1.0, 1e-6], forces=galvi.Oblateness(0, J2=0.01, radius=0.5))
    >>> system.acceleration(np.array([[0.0, 0.0], [1.0, 0.0]]), 0.0)[1]
    array([-1.00375,  0.     ])
    """

    body: int
    J2: float
    radius: float
    J4: float = 0.0
    pole: Any = (0.0, 0.0, 1.0)
    spatial = ("pole",)

    def __post_init__(self) -> None:
        _set(self, body=input_checks.whole("body", self.body, 0))
        _set(self, J2=input_checks.real("J2", self.J2), J4=input_checks.real("J4", self.J4))
        _set(self, radius=input_checks.positive("radius", self.radius))
        pole = input_checks.array("pole", self.pole, (3,))
        with np.errstate(over="ignore"):
            length = float(np.linalg.norm(pole))
        if not 0.0 < length < np.inf:
            raise ValueError(
                f"pole must have a length above 0 that does not overflow; received "
                f"{shown(self.pole)}."
            )
        unit = pole if abs(length - 1.0) < POLE_ROUNDING else pole / length
        _set(self, pole=tuple(unit.tolist()))

    def poles(self, masses: Array, G: float) -> list[list[float]]:
        second = G * masses[self.body] * self.J2 * self.radius**2
        fourth = G * masses[self.body] * self.J4 * self.radius**4
        return _onto_others(self.body, masses, (*self.pole, 0.0, second, fourth))

    def objection(self, masses: Array) -> str:
        return _source("the body of an Oblateness", self.body, masses)


@dataclass(frozen=True)
class PowerLaw(_Builtin):
    """Every other body is accelerated by strength r^power away from the source, which recoils.

    V = -m strength r^(power + 1) / (power + 1) for a body of mass m; a logarithm for power -1.

    Raises
    ------
    ValueError
        For numbers that are not finite and a power within 1e-6 of -1 but not -1, and by `NBody` for
        a source without a mass.

    Examples
    --------
    >>> system = galvi.NBody([1.0, 0.5], forces=galvi.PowerLaw(source=0, strength=-2.0, power=1.0))
    >>> system.acceleration(np.array([[0.0, 0.0], [1.0, 0.0]]), 0.0)
    array([[ 1.5,  0. ],
           [-3. ,  0. ]])
    """

    source: int
    strength: float
    power: float

    def __post_init__(self) -> None:
        _set(self, source=input_checks.whole("source", self.source, 0))
        _set(self, strength=input_checks.real("strength", self.strength))
        _set(self, power=input_checks.real("power", self.power))
        if 0.0 < abs(self.power + 1.0) < NEAR_LOGARITHM:
            raise ValueError(
                f"power must be -1 or differ from it by at least {NEAR_LOGARITHM:g}, since the "
                f"energy is divided by the difference; received {self.power}."
            )

    def powers(self, masses: Array, G: float) -> list[list[float]]:
        A, n = self.strength, self.power
        energy = (0.0, -0.5 * A) if n == -1.0 else (-A / (n + 1.0), 0.0)
        return _onto_others(self.source, masses, (A, n, *energy, 0.0, 0.0))

    def objection(self, masses: Array) -> str:
        return _source("source", self.source, masses)


@dataclass(frozen=True, eq=False)
class Radiation(_Builtin):
    """Radiation pressure and Poynting-Robertson drag of one body's light; it does not recoil.

    Parameters
    ----------
    beta : array, shape (bodies,)
        ratio of radiation pressure to the source's attraction; 0 for no effect
    c
        speed of light in the problem's units, positive
    source
        index of the body that shines, which needs a mass

    Raises
    ------
    ValueError
        For a c that is not positive and numbers that are not finite, and by `NBody` for a beta of
        another shape or one that is not 0 for the source.

    Examples
    --------
    >>> galvi.Radiation(beta=[0.0, 0.01], c=10065.32).source
    0
    """

    beta: Any
    c: float
    source: int = 0
    takes_velocity = True

    def __post_init__(self) -> None:
        _set(self, beta=input_checks.array("beta", self.beta))
        _set(self, c=input_checks.positive("c", self.c))
        _set(self, source=input_checks.whole("source", self.source, 0))

    def block(self, masses: Array, G: float) -> list[float]:
        numbers = [self.c, self.source, *self.beta.tolist()]
        return [celestial_velocity.RADIATION, len(numbers), *numbers]

    def objection(self, masses: Array) -> str:
        objection = _source("source", self.source, masses) or _for_each("beta", self.beta, masses)
        if not objection and self.beta[self.source]:
            return f"beta of the source must be 0; received {self.beta[self.source]}."
        return objection


@dataclass(frozen=True, eq=False)
class Drag(_Builtin):
    """The acceleration ``-k |v|^(power - 1) v`` in a medium at rest; nothing recoils.

    Parameters
    ----------
    coefficients
        k of each body (bodies,), not negative
    power
        positive: 1 for Stokes' drag, 2 for quadratic drag

    Raises
    ------
    ValueError
        For a negative coefficient and a power that is not positive.

    Examples
    --------
    >>> drag = galvi.Drag([0.0, 0.1], power=2.0)
    >>> q, v = np.array([[0.0, 0.0], [1.0, 0.0]]), np.array([[0.0, 0.0], [0.0, 2.0]])
    >>> galvi.NBody([1.0, 1e-6], forces=drag).acceleration(q, 0.0, v)[1]
    array([-1. , -0.4])
    """

    coefficients: Any
    power: float = 1.0
    takes_velocity = True

    def __post_init__(self) -> None:
        numbers = input_checks.array("coefficients", self.coefficients)
        if np.any(numbers < 0.0):
            raise ValueError(f"coefficients must not be negative; received {numbers.tolist()}.")
        _set(self, coefficients=numbers, power=input_checks.positive("power", self.power))

    def block(self, masses: Array, G: float) -> list[float]:
        numbers = [self.power, *self.coefficients.tolist()]
        return [celestial_velocity.DRAG, len(numbers), *numbers]

    def objection(self, masses: Array) -> str:
        return _for_each("coefficients", self.coefficients, masses)


@dataclass(frozen=True)
class Tides(_Builtin):
    """The tides that other bodies raise on one, with a constant time lag; the forces are pairwise
    opposite (Hut, Astron. Astrophys. 99 (1981) 126).

    Parameters
    ----------
    body
        index of the body on which tides are raised; it needs a mass
    k2
        Love number of the body (twice the apsidal constant), not negative
    radius
        of the body, positive
    lag
        time by which the bulge is late, not negative
    spin : array, shape (3,)
        constant angular velocity of the body; in a plane problem (0, 0, z)
    raised_by
        index of the body that raises the tides; None: all others

    Raises
    ------
    ValueError
        For a negative body, k2, lag or raised_by, a radius that is not positive and numbers that
        are not finite, and by `NBody` for bodies that cannot act on each other so.

    Examples
    --------
    >>> galvi.Tides(body=1, k2=0.4, radius=5e-4, lag=1e-6, spin=(0, 0, 2.0), raised_by=0).spin
    (0.0, 0.0, 2.0)
    """

    body: int
    k2: float
    radius: float
    lag: float
    spin: Any = (0.0, 0.0, 0.0)
    raised_by: int | None = None
    spatial = ("spin",)
    takes_velocity = True

    def __post_init__(self) -> None:
        _set(self, body=input_checks.whole("body", self.body, 0))
        for name in ("k2", "lag"):
            number = input_checks.real(name, getattr(self, name))
            if number < 0.0:
                raise ValueError(f"{name} must not be negative; received {number}.")
            _set(self, **{name: number})
        _set(self, radius=input_checks.positive("radius", self.radius))
        _set(self, spin=tuple(input_checks.array("spin", self.spin, (3,)).tolist()))
        if self.raised_by is not None:
            _set(self, raised_by=input_checks.whole("raised_by", self.raised_by, 0))

    def block(self, masses: Array, G: float) -> list[float]:
        by = celestial_velocity.ALL_BODIES if self.raised_by is None else self.raised_by
        return [
            celestial_velocity.TIDES,
            7,
            self.body,
            self.k2 * self.radius**5,
            self.lag,
            by,
            *self.spin,
        ]

    def objection(self, masses: Array) -> str:
        objection = _source("the body of Tides", self.body, masses)
        if not objection and self.raised_by is not None:
            objection = _source("raised_by", self.raised_by, masses)
        if not objection and self.raised_by == self.body:
            return (
                f"raised_by must differ from body, on which tides are raised; received "
                f"{self.raised_by} for both."
            )
        return objection


@dataclass(frozen=True)
class Force:
    """A force given by a user's function.

    Parameters
    ----------
    function
        of q (bodies, D), then of v (bodies, D) and t, if it takes them; returns the forces (bodies,
        D), not divided by the masses
    takes_velocity
        whether the function takes v
    takes_time
        whether the function takes t

    Raises
    ------
    TypeError
        For a function of other arguments and flags that are no bools.

    Notes
    -----
    Its work is not counted: the energy of a run with a `Force` is not assessed.

    Examples
    --------
    >>> wind = galvi.Force(lambda q, v: -0.1 * v, takes_velocity=True)
    >>> wind.at(np.eye(2), np.ones((2, 2)), 0.0)
    array([[-0.1, -0.1],
           [-0.1, -0.1]])
    """

    function: Callable[..., Any]
    takes_velocity: bool = False
    takes_time: bool = False
    spatial = ()

    def __post_init__(self) -> None:
        for name in ("takes_velocity", "takes_time"):
            _set(self, **{name: input_checks.flag(name, getattr(self, name))})
        if not callable(self.function):
            raise TypeError(
                f"function must be a function of {self.arguments}; received {shown(self.function)}."
            )
        try:
            signature = inspect.signature(getattr(self.function, "py_func", self.function))
        except (TypeError, ValueError):  # of a function that is not written in Python
            return
        try:
            signature.bind(*[None] * (1 + self.takes_velocity + self.takes_time))
        except TypeError:
            raise TypeError(
                f"function must be a function of {self.arguments}; received a function of "
                f"{signature}. Set takes_velocity and takes_time as its arguments require."
            ) from None

    @property
    def arguments(self) -> str:
        """The arguments of the function as text, such as "(q, v)"."""
        return f"(q{', v' if self.takes_velocity else ''}{', t' if self.takes_time else ''})"

    @property
    def compiled(self) -> bool:
        """Whether the function is jitted and compiles to one that returns a matrix."""
        kinds = (MATRIX, *(MATRIX,) * self.takes_velocity, *(REAL,) * self.takes_time)
        return compiles(self.function, MATRIX(*kinds))

    def at(self, q: Array, v: Array, t: float) -> Array:
        """The force (bodies, D); ValueError for another shape."""
        arguments = (q.copy(), *(v.copy(),) * self.takes_velocity, *(float(t),) * self.takes_time)
        expected = f"an array of shape {q.shape}"
        return returned_array("a Force", self.function(*arguments), q.shape, expected)


CelestialForce = Relativity | Oblateness | PowerLaw | Radiation | Drag | Tides | Force
