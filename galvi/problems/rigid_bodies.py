"""Rigid bodies: free, on a pivot, and moving in space."""

from __future__ import annotations

from typing import Any

import numpy as np

from galvi import input_checks
from galvi.input_checks import shown
from galvi.problem import Problem
from galvi.systems.free_body import FreeBody
from galvi.systems.potentials.potentials import UniformGravity
from galvi.systems.rigid_body import RigidBody

INERTIA = (3.3, 2.5, 3.4)  # J = tr(J_d) I - J_d of H's J_d = diag(1.3, 2.1, 1.2)
ANGULAR_VELOCITY = (2.0, -1.9, 1.0)  # of H's free rigid body, in its frame
PENDULUM_INERTIA = (4.8, 3.0, 3.8)  # about the pivot, from H's J_d = diag(1, 2.8, 2)
PENDULUM_ANGULAR_VELOCITY = (0.5, -0.5, 0.4)  # in the pendulum's frame
HALF_LENGTHS = np.array([0.1, 0.2, 0.3])  # m, of the box, as in MuJoCo's `size`
BOX_DENSITY = 1000.0  # kg / m^3


def free_rigid_body(
    inertia: Any = INERTIA, velocity: Any = ANGULAR_VELOCITY, attitude: Any = None
) -> Problem:
    """A torque-free rigid body about its centre of mass.

    Parameters
    ----------
    inertia
        principal moments (3,) or a matrix (3, 3)
    velocity : array, shape (3,)
        angular velocity in the body's frame
    attitude : array, shape (3, 3)
        rotation matrix; None for the identity

    Raises
    ------
    ValueError
        As `galvi.RigidBody` and `galvi.Problem`.

    Notes
    -----
    The defaults are H's.

    Examples
    --------
    >>> galvi.problems.free_rigid_body(velocity=(0, 0, 1)).p0
    array([0. , 0. , 3.4])
    """
    return Problem(
        system=RigidBody(inertia),
        q0=np.eye(3) if attitude is None else attitude,
        v0=velocity,
        name="free rigid body",
        parameters={"inertia": np.asarray(inertia).tolist()},
        units="any: H gives none",
    )


def pendulum_3d(weight: float = 9.81, inverted: bool = False) -> Problem:
    """A rigid body as a pendulum in space (H 3.5.2).

    V = -weight e3 . R e3, where e3 points down.

    Parameters
    ----------
    weight
        m g times the distance 1 of the centre of mass; H gives no value
    inverted
        start upside down, R = diag(-1, 1, -1), where the motion is chaotic (H fig. 3.8)

    Raises
    ------
    ValueError
        Unless weight is finite and positive.

    Examples
    --------
    >>> galvi.problems.pendulum_3d(inverted=True).q0
    array([[-1.,  0.,  0.],
           [ 0.,  1.,  0.],
           [ 0.,  0., -1.]])
    """
    strength = input_checks.positive("weight", weight)
    return Problem(
        system=RigidBody(
            PENDULUM_INERTIA, UniformGravity(1.0, (0.0, 0.0, 1.0), (0.0, 0.0, strength))
        ),
        q0=np.diag([-1.0, 1.0, -1.0]) if input_checks.flag("inverted", inverted) else np.eye(3),
        v0=np.array(PENDULUM_ANGULAR_VELOCITY),
        name=f"3D pendulum{', inverted' if inverted else ''}, m g = {strength:g}",
        parameters={"weight": strength, "inverted": bool(inverted)},
        units="m = 1, centre of mass at distance 1, z down",
    )


def heavy_top(spin: float = 8.0, tilt: float = 0.5) -> Problem:
    """A top on a fixed tip, released at angle ``tilt`` from upright, spinning at rate ``spin``.

    The spin is about the axis of symmetry. The moments of inertia about the tip are (1.5, 1.5,
    0.5), m g l = 2, gravity points along -z. The energy and the angular momenta about the vertical
    and, by symmetry, about the axis are conserved. An upright top is stable (sleeping) where
    ``(0.5 spin)^2 > 4 * 1.5 m g l = 12``.

    Raises
    ------
    ValueError
        Unless 0 < tilt < pi.

    Examples
    --------
    >>> galvi.problems.heavy_top(spin=10.0).v0
    array([ 0.,  0., 10.])
    """
    rate, angle = input_checks.real("spin", spin), input_checks.real("tilt", tilt)
    if not 0.0 < angle < np.pi:
        raise ValueError(f"tilt must be between 0 and pi radians; received {shown(tilt)}.")
    from scipy.spatial.transform import Rotation  # would lengthen galvi's import by a fifth

    return Problem(
        system=RigidBody((1.5, 1.5, 0.5), UniformGravity(1.0, (0.0, 0.0, 1.0), 2.0)),
        q0=Rotation.from_euler("x", angle).as_matrix(),
        v0=np.array([0.0, 0.0, rate]),
        name="heavy top",
        parameters={"spin": rate, "tilt": angle},
        units="m = 1, l = 1, g = 2",
    )


def free_body_se3(mass: float = 2.0, g: Any = (0.0, 0.0, 0.0)) -> Problem:
    """H's free rigid body, thrown with velocity (0.3, 0.2, -0.1) of its centre of mass.

    Parameters
    ----------
    mass
        mass of the body
    g : array, shape (3,)
        acceleration of gravity; the attitude does not depend on it

    Raises
    ------
    ValueError
        As `galvi.FreeBody`.

    Examples
    --------
    >>> galvi.problems.free_body_se3(mass=2.0).p0[3:]
    array([ 0.6,  0.4, -0.2])
    """
    start = np.eye(4)
    return Problem(
        system=FreeBody(mass, INERTIA, g),
        q0=start,
        v0=np.array([*ANGULAR_VELOCITY, 0.3, 0.2, -0.1]),
        name="free body on SE(3)",
        parameters={"mass": float(mass), "g": np.asarray(g, dtype=np.float64).tolist()},
        units="any",
    )


def free_box() -> Problem:
    """A box of MuJoCo's size (.1 .2 .3) and density, spun with (1, 2, 3) rad/s; no gravity.

    Inertia m / 3 times the squared half lengths of the other two sides;
    ``m = 8 * 0.006 * 1000`` kg.

    Examples
    --------
    >>> galvi.problems.free_box().v0
    array([1., 2., 3.])
    """
    mass = float(8.0 * np.prod(HALF_LENGTHS) * BOX_DENSITY)
    inertia = mass / 3.0 * (np.sum(HALF_LENGTHS**2) - HALF_LENGTHS**2)
    return Problem(
        system=RigidBody(inertia),
        q0=np.eye(3),
        v0=np.array([1.0, 2.0, 3.0]),
        name="free box",
        parameters={"half lengths": HALF_LENGTHS.tolist(), "density": BOX_DENSITY},
        units="m, s, kg",
    )
