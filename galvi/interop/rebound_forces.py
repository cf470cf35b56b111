"""The forces that REBOUNDx has added to a simulation, as those of point masses."""

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

FORCE_TOLERANCE = 1e-11  # of the largest acceleration by a force
# Post-Newtonian forms differ by terms of the next order, measured 1 to 6 times v^2 / c^2, and
# "gr" has Jacobi's coordinates, by which it differs by shares of the planets' masses.
NEXT_ORDER, OF_MASSES = 20.0, 20.0
POLE = (0.0, 0.0, 1.0)  # where REBOUNDx has none
WITHOUT_FORCES = "whfast512"  # an integrator of REBOUND's, for which REBOUNDx has no forces


@dataclass(frozen=True, eq=False)
class Forced:
    """A user's own `rebound.Simulation` with forces of REBOUNDx, which REBOUND does not copy.

    Attributes
    ----------
    simulation
        without them
    extras
        path of their file, as `reboundx.Extras.save` writes it
    """

    simulation: Any
    extras: str

    def copy(self) -> Any:
        """A copy of the simulation with the forces; they last as long as it.

        Raises
        ------
        ValueError
            For a file that REBOUNDx does not load in full, and for an integrator for which it has
            no forces.
        """
        reboundx, copy = _engine(), copied(self.simulation)
        if copy.integrator.name.decode() == WITHOUT_FORCES:
            raise ValueError(
                f"REBOUNDx has no forces for {WITHOUT_FORCES}. Set another integrator of the "
                f"simulation: sim.integrator = 'whfast'."
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
        # The text of the warnings is all that REBOUNDx gives.
        lost = [
            str(warning.message) for warning in caught if OTHER_VERSION not in str(warning.message)
        ]
        if lost:
            raise ValueError(f"REBOUNDx does not load all of {self.extras}: {lost[0]}")
        return copy


def extras_of(sim: Any) -> Any:
    """The `reboundx.Extras` of a simulation that was made in Python."""
    return sim._extras_ref


def forces_of(sim: Any, extras: Any, contents: Contents) -> list[CelestialForce]:
    """The forces, each compared with REBOUNDx's accelerations at the simulation's state.

    Raises
    ------
    TypeError
        For extras of another type.
    ValueError
        For extras of another simulation, for an unknown force or operator, by name, and where
        accelerations differ, with both numbers.
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
    """A sentence on how far the forces of the problem are from REBOUNDx's at its start; "" for
    round-off."""
    names, contents, expected = _extras_accelerations(forced, problem, problem.q0, problem.v0)
    off, allowed = _gaps(cast(NBody, problem.system), contents, expected)
    if np.max(off, initial=0.0) <= allowed:
        return ""
    share = np.max(off) / np.max(np.abs(expected))
    return (
        f"Accelerations by {names} as read by galvi differ from REBOUNDx's by {share:.1g} of the "
        f"largest"
    )


def _extras_accelerations(
    forced: Forced, problem: Problem, q: Array, v: Array
) -> tuple[str, Contents, Array]:
    """The names of all forces, the state, and their accelerations of a copy's particles (n, 3)."""
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
    """A parameter of a particle or force; the default where it is not set."""
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
    """Differences of the accelerations by forces, (n,), and the difference that rounding allows."""
    fall = NBody(contents.masses, contents.G).fall(contents.q)
    computed = system.acceleration(contents.q, 0.0, contents.v) - fall
    allowed = FORCE_TOLERANCE * np.max(np.abs(expected), initial=0.0) + 1e-15 * np.max(np.abs(fall))
    return np.max(np.abs(computed - expected), axis=1, initial=0.0), float(allowed)


def _compare(name: str, system: NBody, contents: Contents, expected: Array) -> None:
    off, allowed = _gaps(system, contents, expected)
    mu = contents.G * contents.masses
    for force in system.forces:
        if isinstance(force, Relativity) and force.takes_velocity:
            gap = np.linalg.norm(contents.q - contents.q[:, None], axis=2) + np.diag(
                [np.inf] * mu.size
            )
            speed = np.max(np.sum((contents.v - contents.v[0]) ** 2, axis=1))
            share = NEXT_ORDER * (np.max(np.sum(mu / gap, axis=1)) + speed) / force.c**2
            if force.form != "EIH":
                share += OF_MASSES * float(np.sum(mu[1:])) / mu[0]
            allowed += share * np.max(np.abs(expected))
    if np.max(off, initial=0.0) > allowed:
        k, plain = int(np.argmax(off)), NBody(contents.masses, contents.G)
        computed = system.acceleration(contents.q, 0.0, contents.v) - plain.fall(contents.q)
        raise ValueError(
            f"galvi misreads REBOUNDx's {name}: it accelerates {contents.parameters['bodies'][k]} "
            f"by {expected[k].tolist()}, galvi by {computed[k].tolist()}. Please report it."
        )


def _relativity(form: str) -> Callable[..., list[CelestialForce]]:
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
    both = [(_parameter(p, "Acentral"), _parameter(p, "gammacentral")) for p in sim.particles]
    return [PowerLaw(k, A, n) for k, (A, n) in enumerate(both) if A is not None and n is not None]


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
