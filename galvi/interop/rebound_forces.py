"""The forces that REBOUNDx adds to a simulation, as forces of a `galvi.NBody` system."""

from __future__ import annotations

import ctypes
import warnings
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any, cast

import numpy as np

from galvi.arrays import Array
from galvi.input_checks import shown
from galvi.interop.rebound_contents import OTHER_VERSION, Contents, copied
from galvi.problem import Problem
from galvi.systems.forces.celestial import (
    CelestialForce,
    Oblateness,
    PowerLaw,
    Radiation,
    Relativity,
    Tides,
)
from galvi.systems.nbody import NBody

FORCE_TOLERANCE = 1e-11  # of accelerations by a force, relative to the largest
# Largest difference of post-Newtonian forms, in units of v^2 / c^2; 1 to 6 was measured.
NEXT_ORDER_FACTOR = 20.0
# Largest difference of "gr", which uses Jacobi's coordinates, in units of the planets' masses over
# the star's.
MASS_RATIO_FACTOR = 20.0
POLE = (0.0, 0.0, 1.0)  # that of a body for which REBOUNDx has none
INTEGRATOR_WITHOUT_FORCES = "whfast512"  # of REBOUND, with which REBOUNDx does not work


@dataclass(frozen=True, eq=False)
class Forced:
    """A user's own `rebound.Simulation` with forces of REBOUNDx, which REBOUND does not copy.

    Attributes
    ----------
    simulation
        the simulation without these forces
    extras
        path of the file of the forces, as `reboundx.Extras.save` writes it
    """

    simulation: Any
    extras: str

    def copy(self) -> Any:
        """A copy of the simulation with the forces, which the copy owns.

        Raises
        ------
        ValueError
            For a file that REBOUNDx does not load in full, and for an integrator with which it does
            not work.
        """
        reboundx, copy = _engine(), copied(self.simulation)
        if copy.integrator.name.decode() == INTEGRATOR_WITHOUT_FORCES:
            raise ValueError(
                f"REBOUNDx has no forces for {INTEGRATOR_WITHOUT_FORCES}. Set another integrator "
                f"of the simulation: sim.integrator = 'whfast'."
            )
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            try:
                reboundx.Extras(copy, self.extras)
            except (RuntimeError, UnicodeEncodeError) as error:
                raise ValueError(
                    f"{self.extras} must be a file of REBOUNDx's, as rebx.save writes; it says: "
                    f"{error}"
                ) from None
        # REBOUNDx reports by warnings alone, which differ in their text only.
        problems = [
            str(warning.message) for warning in caught if OTHER_VERSION not in str(warning.message)
        ]
        if problems:
            raise ValueError(f"REBOUNDx does not load all of {self.extras}: {problems[0]}")
        return copy


def extras_of(sim: Any) -> Any:
    """The `reboundx.Extras` attached to a simulation in this process."""
    return sim._extras_ref


def forces_of(sim: Any, extras: Any, contents: Contents) -> list[CelestialForce]:
    """The forces of a simulation, each compared with REBOUNDx's accelerations at its state.

    Raises
    ------
    TypeError
        For extras of another type.
    ValueError
        For extras of another simulation, for an unknown force or an operator, with its name, and
        where accelerations differ, with both numbers.
    """
    reboundx = _engine()
    if not isinstance(extras, reboundx.Extras):
        raise TypeError(f"extras must be a reboundx.Extras; received {shown(extras)}.")
    if ctypes.addressof(extras._sim.contents) != ctypes.addressof(sim):
        raise ValueError("extras must be those of the simulation; received another one's.")
    operators = [
        _name(operator) for operator in _items(extras._allocated_operators, reboundx.Operator)
    ]
    added = _added(extras)
    unknown = [_name(force) for force in added if _name(force) not in READERS]
    if operators or unknown:
        raise ValueError(
            f"galvi knows REBOUNDx's {', '.join(sorted(READERS))}; received "
            f"{', '.join(sorted({*unknown, *operators}))}. Remove it first."
        )
    total: list[CelestialForce] = []
    for force in added:
        forces = READERS[_name(force)](force, sim, contents)
        _compare(
            _name(force),
            NBody(contents.masses, contents.G, forces),
            contents,
            _force_accelerations(sim, force, contents),
        )
        total += forces
    return total


def check_forces(forced: Forced, problem: Problem, q: Array, v: Array) -> None:
    """ValueError, with both numbers, where the accelerations by REBOUNDx's forces and by those of
    the problem differ at this state."""
    names, contents, expected = _extras_accelerations(forced, problem, q, v)
    _compare(names, cast(NBody, problem.system), contents, expected)


def inexact(forced: Forced, problem: Problem) -> str:
    """A clause with the difference of the accelerations by the problem's forces from REBOUNDx's at
    the start; "" where it is round-off."""
    names, contents, expected = _extras_accelerations(forced, problem, problem.q0, problem.v0)
    differences, allowed = _gaps(cast(NBody, problem.system), contents, expected)
    if np.max(differences, initial=0.0) <= allowed:
        return ""
    share = np.max(differences) / np.max(np.abs(expected))
    return (
        f"Accelerations by {names} as read by galvi differ from REBOUNDx's by {share:.1g} of the "
        f"largest"
    )


def _extras_accelerations(
    forced: Forced, problem: Problem, q: Array, v: Array
) -> tuple[str, Contents, Array]:
    """The names of REBOUNDx's forces, the state (q, v) as `Contents`, and the accelerations (n, 3)
    by these forces at that state."""
    system, copy = cast(NBody, problem.system), forced.copy()
    bodies = problem.parameters.get("bodies", range(len(q)))
    contents = Contents((), system.masses, q, v, G=system.G, parameters={"bodies": bodies})
    added = _added(extras_of(copy))
    by_force = [np.zeros_like(q), *(_force_accelerations(copy, force, contents) for force in added)]
    return " and ".join(map(_name, added)), contents, np.sum(by_force, axis=0)


def _engine() -> Any:
    try:
        import reboundx
    except ModuleNotFoundError as error:
        raise ModuleNotFoundError(
            "REBOUNDx is not installed. Install it: pip install reboundx.", name="reboundx"
        ) from error
    return reboundx


def _added(extras: Any) -> list[Any]:
    return list(_items(extras._additional_forces, _engine().Force))


def _items(node: Any, kind: Any) -> Iterator[Any]:
    while node:
        yield ctypes.cast(node.contents.object, ctypes.POINTER(kind)).contents
        node = node.contents.next


def _name(effect: Any) -> str:
    return str(effect.name.decode())


def _parameter(owner: Any, name: str, default: Any = None) -> Any:
    """A parameter of REBOUNDx of a particle or force; ``default`` where it is not set."""
    try:
        return owner.params[name]
    except AttributeError:
        return default


def _force_accelerations(sim: Any, force: Any, contents: Contents) -> Array:
    """The accelerations of the particles by one of REBOUNDx's forces, (n, 3)."""
    kind = type(sim.particles[0])
    copies = (kind * len(contents.q))()
    for k, (q, v) in enumerate(zip(contents.q.tolist(), contents.v.tolist(), strict=True)):
        ctypes.memmove(
            ctypes.addressof(copies[k]), ctypes.addressof(sim.particles[k]), ctypes.sizeof(kind)
        )
        copies[k].x, copies[k].y, copies[k].z = q
        copies[k].vx, copies[k].vy, copies[k].vz = v
        copies[k].ax = copies[k].ay = copies[k].az = 0.0
    force._update_accelerations(ctypes.byref(sim), ctypes.byref(force), copies, len(contents.q))
    return np.array([(p.ax, p.ay, p.az) for p in copies])


def _gaps(system: NBody, contents: Contents, expected: Array) -> tuple[Array, float]:
    """Largest difference of each body's acceleration by forces from the expected one, (n,), and
    the difference that rounding allows."""
    fall = NBody(contents.masses, contents.G).fall(contents.q)
    computed = system.acceleration(contents.q, 0.0, contents.v) - fall
    allowed = FORCE_TOLERANCE * np.max(np.abs(expected), initial=0.0) + 1e-15 * np.max(np.abs(fall))
    return np.max(np.abs(computed - expected), axis=1, initial=0.0), float(allowed)


def _compare(name: str, system: NBody, contents: Contents, expected: Array) -> None:
    """ValueError where the accelerations by the system's forces differ from the expected ones
    (n, 3) by more than rounding and the order of the post-Newtonian forms allow."""
    differences, allowed = _gaps(system, contents, expected)
    mu = contents.G * contents.masses
    for force in system.forces:
        if isinstance(force, Relativity) and force.takes_velocity:
            gap = np.linalg.norm(contents.q - contents.q[:, None], axis=2) + np.diag(
                [np.inf] * mu.size
            )
            speed = np.max(np.sum((contents.v - contents.v[0]) ** 2, axis=1))
            share = NEXT_ORDER_FACTOR * (np.max(np.sum(mu / gap, axis=1)) + speed) / force.c**2
            if force.form != "EIH":
                share += MASS_RATIO_FACTOR * float(np.sum(mu[1:])) / mu[0]
            allowed += share * np.max(np.abs(expected))
    if np.max(differences, initial=0.0) > allowed:
        k, plain = int(np.argmax(differences)), NBody(contents.masses, contents.G)
        computed = system.acceleration(contents.q, 0.0, contents.v) - plain.fall(contents.q)
        raise ValueError(
            f"galvi misreads REBOUNDx's {name}: it accelerates {contents.parameters['bodies'][k]} "
            f"by {expected[k].tolist()}, galvi by {computed[k].tolist()}. Please report it."
        )


def _relativity(form: str) -> Callable[..., list[CelestialForce]]:
    """The reader of a force of general relativity of this form."""

    def read(force: Any, sim: Any, contents: Contents) -> list[CelestialForce]:
        c = _parameter(force, "c")
        if c is None:
            raise ValueError("a force of general relativity needs c; received none. Set it.")
        return [Relativity(c, 0, form)]

    return read


def _harmonics(force: Any, sim: Any, contents: Contents) -> list[CelestialForce]:
    forces: list[CelestialForce] = []
    for k, p in enumerate(sim.particles):
        J2, radius = _parameter(p, "J2", 0.0), _parameter(p, "R_eq")
        if J2 and radius:  # REBOUNDx has no J4 without J2
            axis = _parameter(p, "Omega")
            pole = POLE if axis is None else tuple(axis[i] for i in range(3))
            forces.append(Oblateness(k, J2, radius, _parameter(p, "J4", 0.0), pole))
    return forces


def _central(force: Any, sim: Any, contents: Contents) -> list[CelestialForce]:
    coefficients = [
        (_parameter(p, "Acentral"), _parameter(p, "gammacentral")) for p in sim.particles
    ]
    return [
        PowerLaw(k, A, n)
        for k, (A, n) in enumerate(coefficients)
        if A is not None and n is not None
    ]


def _radiation(force: Any, sim: Any, contents: Contents) -> list[CelestialForce]:
    beta, c = [_parameter(p, "beta", 0.0) for p in sim.particles], _parameter(force, "c")
    if c is None:
        raise ValueError("radiation_forces needs c; received none. Set it.")
    flags = [_parameter(p, "radiation_source") is not None for p in sim.particles]
    sources = [k for k, flag in enumerate(flags) if flag] or [0]
    return [Radiation([0.0 if k == i else b for k, b in enumerate(beta)], c, i) for i in sources]


def _tides(force: Any, sim: Any, contents: Contents) -> list[CelestialForce]:
    forces: list[CelestialForce] = []
    for k, p in enumerate(sim.particles):
        k2, lag = _parameter(p, "tctl_k2"), _parameter(p, "tctl_tau", 0.0)
        if k2 is not None and p.r and p.m:
            spin = (0.0, 0.0, _parameter(p, "OmegaMag", 0.0) if lag else 0.0)
            forces.append(Tides(k, k2, p.r, lag, spin, None if k == 0 else 0))
    return forces


READERS: dict[str, Callable[..., list[CelestialForce]]] = {
    "gr": _relativity("one source"),
    "gr_full": _relativity("EIH"),
    "gr_potential": _relativity("potential"),
    "gravitational_harmonics": _harmonics,
    "central_force": _central,
    "radiation_forces": _radiation,
    "tides_constant_time_lag": _tides,
}
