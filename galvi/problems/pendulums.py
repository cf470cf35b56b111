"""Oscillators and pendulums.

Oscillators: harmonic, driven, Hénon and Heiles's, the chain of Fermi, Pasta, Ulam and Tsingou.
Pendulums: on a circle, on a sphere, on a spring, of several rods, and on skew hinges.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import lru_cache
from typing import Any

import numpy as np

from galvi import input_checks
from galvi.groups.group import Rn
from galvi.groups.product import Product
from galvi.input_checks import shown
from galvi.kernels.compile.jit import jit
from galvi.problem import Problem
from galvi.systems.canonical import Canonical
from galvi.systems.lagrangian import Lagrangian
from galvi.systems.multibody import Multibody
from galvi.systems.planar_chain import PlanarChain
from galvi.systems.potentials.potentials import (
    CosinePotential,
    LinearSpring,
    SpringChain,
    UniformGravity,
)
from galvi.systems.rigid_body import RigidBody
from galvi.systems.trees.joint import Joint, Link
from galvi.systems.user_functions import sympy_module

DRIVE_FREQUENCY = 1.5  # angular frequency of the force that drives the oscillator
# Moment of the spherical pendulum about its rod, about which it does not rotate.
AXIAL_MOMENT = 0.5
HINGE_AXES = ((0.0, 0.0, 1.0), (1.0, 0.3, 0.0), (0.8, -0.6, 0.2))  # of the skew arm
HINGE_ANGLES = (0.2, -0.4, 0.6)  # radians
HINGE_RATES = (1.0, -0.8, 1.5)  # radians / s
BODY_VELOCITY = (0.1, 0.0, -0.2, 0.3, -0.2, 0.4)  # of the floating body: m / s, then radians / s


def harmonic_oscillator(velocity: float = 0.0) -> Problem:
    """L = (v^2 - q^2) / 2, from q = 1 with this velocity; at rest in H 2.4.1 and M 6.1. No units.

    Raises
    ------
    ValueError
        For a velocity that is not finite.

    Examples
    --------
    >>> galvi.problems.harmonic_oscillator().q0
    array([1.])
    """
    speed = input_checks.real("velocity", velocity)
    return Problem(
        system=Canonical(mass=1.0, potential=LinearSpring(1.0)),
        q0=np.array([1.0]),
        v0=np.array([speed]),
        name="harmonic oscillator",
        units="none (m = k = 1)",
    )


@jit  # type: ignore[untyped-decorator]
def _driven_potential(q: Any, t: float) -> Any:
    """V = q^2 / 2 + q^4 / 4 - q sin(DRIVE_FREQUENCY t)."""
    return 0.5 * q[0] ** 2 + 0.25 * q[0] ** 4 - q[0] * np.sin(DRIVE_FREQUENCY * t)


@jit  # type: ignore[untyped-decorator]
def _driven_gradient(q: Any, t: float) -> Any:
    """dV/dq, (1,)."""
    return np.array([q[0] + q[0] ** 3 - np.sin(DRIVE_FREQUENCY * t)])


@jit  # type: ignore[untyped-decorator]
def _driven_hessian(q: Any, t: float) -> Any:
    """d2V/dq2, (1, 1)."""
    return np.array([[1.0 + 3.0 * q[0] ** 2]])


def driven_oscillator() -> Problem:
    """Duffing's oscillator, q'' = -q - q^3 + sin(1.5 t), from q = 0.5, v = 0.8 at t = 0.4.

    No units. The motion is regular. The force depends on the time, so that no energy is conserved,
    and a method that counts the time from the start instead of t0 gives another motion.

    Examples
    --------
    >>> galvi.problems.driven_oscillator().t0
    0.4
    """
    return Problem(
        system=Canonical(
            1.0, _driven_potential, _driven_gradient, _driven_hessian, explicit_time=True
        ),
        q0=np.array([0.5]),
        v0=np.array([0.8]),
        t0=0.4,
        name="driven oscillator",
        units="none (m = k = 1)",
    )


@jit  # type: ignore[untyped-decorator]
def _star_potential(q: Any) -> Any:
    """V = (x^2 + y^2) / 2 + x^2 y - y^3 / 3."""
    return 0.5 * (q[0] ** 2 + q[1] ** 2) + q[0] ** 2 * q[1] - q[1] ** 3 / 3.0


@jit  # type: ignore[untyped-decorator]
def _star_gradient(q: Any) -> Any:
    """dV/dq, (2,)."""
    return np.array([q[0] + 2.0 * q[0] * q[1], q[1] + q[0] ** 2 - q[1] ** 2])


@jit  # type: ignore[untyped-decorator]
def _star_hessian(q: Any) -> Any:
    """d2V/dq2, (2, 2)."""
    return np.array([[1.0 + 2.0 * q[1], 2.0 * q[0]], [2.0 * q[0], 1.0 - 2.0 * q[1]]])


def henon_heiles(energy: float = 0.1) -> Problem:
    """A star in an axisymmetric galaxy, from q = (0, 0.1) with v = (v_x, 0.05) at this energy.

    The motion is bounded below the escape energy 1/6.

    Raises
    ------
    ValueError
        For an energy below that of the start with v_x = 0, and for one of at least 1/6.

    Examples
    --------
    >>> galvi.problems.henon_heiles(energy=0.1).q0
    array([0. , 0.1])
    """
    energy = input_checks.real("energy", energy)
    q0 = np.array([0.0, 0.1])
    resting = float(_star_potential(q0)) + 0.5 * 0.05**2
    if not resting <= energy < 1.0 / 6.0:
        raise ValueError(
            f"energy must be in [{resting:.6g}, 1/6), so that the start exists and the motion is "
            f"bounded; received {shown(energy)}."
        )
    return Problem(
        system=Canonical(1.0, _star_potential, _star_gradient, _star_hessian),
        q0=q0,
        v0=np.array([math.sqrt(2.0 * (energy - resting)), 0.05]),
        name="henon-heiles",
        parameters={"energy": energy},
        units="none",
    )


def fermi_pasta_ulam_tsingou(masses: int = 15, alpha: float = 0.25, beta: float = 0.0) -> Problem:
    """``masses`` unit masses between walls, released at rest in the lowest mode, amplitude 1.

    Fermi, Pasta and Ulam, Los Alamos report LA-1940 (1955).

    Raises
    ------
    ValueError
        For fewer than one mass.

    Examples
    --------
    >>> float(galvi.problems.fermi_pasta_ulam_tsingou(masses=7).q0[3])
    1.0
    """
    masses = input_checks.whole("masses", masses)
    position = np.arange(1, masses + 1) / (masses + 1)
    return Problem(
        system=Canonical(mass=1.0, potential=SpringChain(alpha, beta)),
        q0=np.sin(np.pi * position),
        v0=np.zeros(masses),
        name="fermi-pasta-ulam-tsingou",
        parameters={"masses": masses, "alpha": alpha, "beta": beta},
        units="none (masses and linear stiffness 1)",
    )


def planar_pendulum(amplitude: float = 2.0, rate: float = 0.0) -> Problem:
    """m = g = l = 1, released at ``amplitude`` radians from the downward vertical.

    Parameters
    ----------
    rate
        angular velocity at the start; at rest the period is 4 K(sin(amplitude / 2))

    Raises
    ------
    ValueError
        For an amplitude outside (0, pi) and a rate that is not finite.

    Examples
    --------
    >>> galvi.problems.planar_pendulum(amplitude=1.0).q0
    array([1.])
    """
    angle, turning = input_checks.real("amplitude", amplitude), input_checks.real("rate", rate)
    if not 0.0 < angle < math.pi:
        raise ValueError(
            f"amplitude must be between 0 and pi radians; received {shown(amplitude)}."
        )
    return Problem(
        system=Canonical(mass=1.0, potential=CosinePotential(1.0)),
        q0=np.array([angle]),
        v0=np.array([turning]),
        name=f"planar pendulum, amplitude {angle:g}" + (f", rate {turning:g}" if turning else ""),
        parameters={"amplitude": angle} | ({"rate": turning} if turning else {}),
        units="m = g = l = 1",
    )


def spherical_pendulum(angle: float = 1.0, rate: float = 0.5) -> Problem:
    """m = g = l = 1, at ``angle`` from the downward vertical, with azimuthal ``rate``.

    The rod is a symmetric rigid body that does not spin: R e3 points from the pivot to the mass.

    Raises
    ------
    ValueError
        Unless 0 < angle < pi and rate is finite.

    Examples
    --------
    >>> galvi.problems.spherical_pendulum(angle=0.5).q0.shape
    (3, 3)
    """
    theta, turning = input_checks.real("angle", angle), input_checks.real("rate", rate)
    if not 0.0 < theta < np.pi:
        raise ValueError(f"angle must be between 0 and pi radians; received {shown(angle)}.")
    from scipy.spatial.transform import Rotation  # would lengthen galvi's import by a fifth

    R = Rotation.from_euler("y", theta).as_matrix() @ np.diag([1.0, -1.0, -1.0])
    rod = R[:, 2]
    sideways = np.cross(rod, np.cross([0.0, 0.0, turning], rod))
    return Problem(
        system=RigidBody((1.0, 1.0, AXIAL_MOMENT), UniformGravity(1.0, (0.0, 0.0, 1.0), 1.0)),
        q0=R,
        v0=R.T @ sideways,
        name="spherical pendulum",
        parameters={"angle": theta, "rate": turning},
        units="m = g = l = 1",
    )


def elastic_pendulum(
    mass: float = 1.0,
    stiffness: float = 40.0,
    length: float = 1.0,
    gravity: float = 9.81,
    extended: float = 1.3,
    angle: float = 1.5,
) -> Problem:
    """A mass on a spring of this natural length, hung from a point, in a plane; needs SymPy.

    L = m (r'^2 + r^2 theta'^2) / 2 - k (r - l)^2 / 2 + m g r cos theta

    Parameters
    ----------
    extended, angle
        r and theta at the start, at rest; theta in radians from the downward vertical

    Raises
    ------
    ImportError
        Without SymPy.
    ValueError
        For a mass, stiffness, length or start r that is not positive.

    Examples
    --------
    >>> galvi.problems.elastic_pendulum().q0
    array([1.3, 1.5])
    """
    numbers = [
        input_checks.positive(name, value)
        for name, value in (("mass", mass), ("stiffness", stiffness), ("length", length))
    ]
    numbers.append(input_checks.real("gravity", gravity))
    start = [input_checks.positive("extended", extended), input_checks.real("angle", angle)]
    return Problem(
        system=_system(*numbers),
        q0=np.array(start),
        v0=np.zeros(2),
        name="elastic pendulum",
        parameters=dict(zip(("mass", "stiffness", "length", "gravity"), numbers, strict=True)),
        units="those of mass, stiffness, length and gravity; angles in radians",
    )


@lru_cache(maxsize=16)
def _system(mass: float, stiffness: float, length: float, gravity: float) -> Lagrangian:
    sympy = sympy_module()
    m, k, l, g, r, theta, speed, turning = sympy.symbols("m k l g r theta r' theta'", real=True)
    kinetic = m * (speed**2 + r**2 * turning**2) / 2
    return Lagrangian.from_sympy(
        kinetic - k * (r - l) ** 2 / 2 + m * g * r * sympy.cos(theta),
        [r, theta],
        [speed, turning],
        parameters={m: mass, k: stiffness, l: length, g: gravity},
    )


def double_pendulum(
    masses: Sequence[float] = (1.0, 1.0),
    lengths: Sequence[float] = (1.0, 1.0),
    gravity: float = 9.81,
    angles: Sequence[float] = (2.0, 2.5),
    rates: Sequence[float] = (0.0, 0.0),
) -> Problem:
    """Two point masses on weightless rods, the second hanging from the first.

    Parameters
    ----------
    masses, lengths
        (2,) starting at the fixed pivot
    angles, rates
        (2,) angles of the rods from the downward vertical, in radians, and their rates

    Raises
    ------
    ValueError
        Unless masses and lengths are two positive numbers each.

    Notes
    -----
    Chaotic for the default angles (tests/references/test_chains.py measures how fast).

    Examples
    --------
    >>> galvi.problems.double_pendulum(angles=(0.5, 0.0)).q0
    array([0.5, 0. ])
    """
    chain = PlanarChain(
        input_checks.array("masses", masses, (2,)),
        input_checks.array("lengths", lengths, (2,)),
        gravity,
    )
    return Problem(
        system=Lagrangian(chain, Rn(2)),
        q0=input_checks.array("angles", angles, (2,)),
        v0=input_checks.array("rates", rates, (2,)),
        name="double pendulum",
        parameters={"masses": chain.masses, "lengths": chain.lengths, "gravity": chain.gravity},
        units="those of masses, lengths and gravity; angles in radians",
    )


def planar_chain(
    links: int = 5,
    mass: float = 1.0,
    length: float = 1.0,
    gravity: float = 9.81,
    angle: float = 1.0,
) -> Problem:
    """Uniform rods hinged end to end, released in a straight line at rest.

    Parameters
    ----------
    links
        number of rods; the first is hinged to a fixed point
    mass, length
        of each rod
    angle
        initial angle of all rods from the downward vertical, in radians

    Raises
    ------
    ValueError
        For a number of links outside 1 to 1000, or a mass or length that is not positive.

    Notes
    -----
    q_i is the angle of rod i against the vertical.

    Examples
    --------
    >>> galvi.problems.planar_chain(links=3, angle=0.5).q0
    array([0.5, 0.5, 0.5])
    """
    n = input_checks.whole("links", links, at_most=1000)
    chain = PlanarChain(
        np.full(n, input_checks.positive("mass", mass)),
        np.full(n, input_checks.positive("length", length)),
        gravity,
        rods=True,
    )
    return Problem(
        system=Lagrangian(chain, Rn(n)),
        q0=np.full(n, input_checks.real("angle", angle)),
        v0=np.zeros(n),
        name=f"chain of {n} rods",
        parameters={
            "links": n,
            "mass": mass,
            "length": length,
            "gravity": chain.gravity,
            "angle": angle,
        },
        units="those of mass, length and gravity; angles in radians",
    )


def skew_arm(damping: float = 0.0, floating: bool = False) -> Problem:
    """Three rods of 1 kg and 0.5 m on skew hinges, the first of which is vertical.

    Parameters
    ----------
    damping
        of each hinge, N m s
    floating
        whether the arm is on a body of 5 kg that floats without gravity, on R^3 x SO(3) x R^3; else
        it is on the ground, with gravity along -z

    Raises
    ------
    ValueError
        For a negative damping.

    Notes
    -----
    Angles are 0 when the rods point along x. Without damping the energy is conserved, and for the
    floating arm the momenta too.

    Examples
    --------
    >>> galvi.problems.skew_arm(floating=True).system.group.dimension
    9
    """
    value = input_checks.real("damping", damping)
    base = [Link(Joint("free"), 5.0, (0.0, 0.02, -0.1), (0.15, 0.2, 0.1), name="body")]
    links = base if input_checks.flag("floating", floating) else []
    first = len(links)
    for k, axis in enumerate(HINGE_AXES):
        links.append(
            Link(
                Joint("hinge", axis=axis, armature=0.01, damping=value),
                mass=1.0,
                centre=(0.25, 0.0, 0.0),
                inertia=(0.002, 0.02, 0.02),
                parent=first + k - 1 if first + k else None,
                place=(0.5, 0.0, 0.0) if k else (0.3 * first, 0.0, 0.1 * first),
                name=f"link {k + 1}",
            )
        )
    system = Multibody(links, gravity=(0.0, 0.0, 0.0 if floating else -9.81))
    q0, v0 = np.array(HINGE_ANGLES), np.array(HINGE_RATES)
    if isinstance(system.group, Product):
        q0, v0 = (
            system.group.join(np.zeros(3), np.eye(3), q0),
            np.array([*BODY_VELOCITY, *HINGE_RATES]),
        )
    return Problem(
        system=system,
        q0=q0,
        v0=v0,
        name="floating arm" if floating else "skew arm",
        parameters={"damping": value, "floating": floating},
        units="kg, m, s; angles in radians",
    )
