"""Systems on Lie groups: bodies, trees of bodies, and Lagrangians on every group."""

from __future__ import annotations

import math
from functools import partial
from typing import Any

import numpy as np
from numba import njit

import galvi
from tests.agreement.row import Row
from tests.properties.ensemble_cases import in_plane
from tests.properties.group_bodies import MOMENTS, R0, SPIN, nonlinear_gradient, nonlinear_potential
from tests.properties.group_lagrangians import GROUPS, swelling
from tests.properties.group_matrices import element
from tests.properties.group_motions import COUPLED, FLYING, FREE, PENDULUM

ARM, STIFFNESS = np.array([0.1, 0.2, 0.3]), 3.0


def bulging(q: Any, v: Any) -> Any:
    """A Lagrangian on any group, not quadratic in v, whose mass depends on q."""
    entries = np.asarray(q).ravel()
    s = np.dot(np.linspace(0.3, -0.2, entries.size), entries)
    square = v @ v + 0.3 * v[0] * v[-1]
    return 0.5 * square * (1.0 + 0.2 * s * s) + 0.05 * square**2 - 0.5 * s * s - np.sin(s)


def tether(q: Any) -> Any:
    """Potential of a spring from the origin to a point of a body."""
    return 0.5 * STIFFNESS * np.sum((q[:3, 3] + q[:3, :3] @ ARM) ** 2)


def tether_gradient(q: Any) -> Any:
    pull = STIFFNESS * (q[:3, 3] + q[:3, :3] @ ARM)
    gradient = np.zeros((4, 4))
    gradient[:3, :3], gradient[:3, 3] = np.outer(pull, ARM), pull
    return gradient


def waving(R: Any, t: float) -> Any:
    return math.cos(3.0 * t) * R[0, 2] - R[2, 2]


def drag(q: Any, v: Any) -> Any:
    return -0.2 * v * math.sqrt(1.0 + v @ v)


BODY = 2.0, (1.0, 2.0, 2.5), (0.0, 0.0, -1.0)  # mass, principal moments, gravity
Q0 = np.block([[R0, np.array([[0.5], [-0.2], [0.8]])], [np.zeros((1, 3)), np.ones((1, 1))]])
V0 = np.array([0.3, 1.0, 0.2, 0.5, -0.4, 0.7])


def lagrangian_on(group: Any, **force: Any) -> tuple[Any, Any, Any]:
    """System, q0 and v0 of a Lagrangian on a group."""
    d = group.dimension
    start = element(group, np.linspace(0.5, -0.4, d))
    return galvi.Lagrangian(bulging, group, **force), start, np.linspace(0.6, 0.2, d)


BODIES_OF_FUNCTIONS: dict[str, tuple[Any, Any, Any]] = {  # system, q0, v0
    "a potential": (galvi.RigidBody(MOMENTS, nonlinear_potential), R0, SPIN),
    "a compiled gradient": (
        galvi.RigidBody(MOMENTS, njit(nonlinear_potential), njit(nonlinear_gradient)),
        R0,
        SPIN,
    ),
    "a driven top with drag": (
        galvi.RigidBody(MOMENTS, waving, force=drag, explicit_time=True),
        R0,
        SPIN,
    ),
    "a tether": (galvi.FreeBody(*BODY, tether, tether_gradient), Q0, V0),
    "drag": (galvi.FreeBody(*BODY, force=drag), Q0, V0),
    "L on SE(2)": lagrangian_on(galvi.SE2()),
    "a braked L": lagrangian_on(galvi.SE2(), force=drag),
}


def mass_of_entry(i: int, j: int) -> galvi.Problem:
    """A Lagrangian on SO(3) whose mass depends on entry (i, j) of the rotation."""
    inertia = np.diag([3.3, 2.5, 3.4])
    L = galvi.Lagrangian(lambda R, w: (0.5 + 0.05 * R[i, j]) * w @ (inertia @ w), galvi.SO3())
    return galvi.Problem(L, np.eye(3), [2.0, -1.9, 1.0])


def nearly_at_rest(body: galvi.Problem, rate: float) -> galvi.Problem:
    """The body with an angular velocity of `rate` about its first axis."""
    return body.with_initial_state(R0, [rate, 0.0, 0.0])


def swirl(q: Any, v: Any, t: float) -> Any:
    return -0.1 * v * v[0] + 0.3 * t


BALL = galvi.Link(galvi.Joint("ball"), 1.0, (0, 0, -0.5), (0.2, 0.3, 0.4))
HINGED = galvi.Link(
    [
        galvi.Joint("hinge", axis=(0, 1, 0), damping=0.1),
        galvi.Joint("slide", axis=(1, 0, 0), stiffness=3.0, armature=0.1),
    ],
    0.5,
    (0, 0, -0.3),
    (0.05,) * 3,
    parent=0,
    place=(0, 0, -1),
)
SPINNING = galvi.Problem(galvi.FreeBody(2.0, (1.0, 2.0, 2.5)), np.eye(4), V0)


def hanging(*links: galvi.Link, **force: Any) -> galvi.Problem:
    """A tree that hangs by a ball joint and whose two other joints start at 0.3 and 0.1."""
    system = galvi.Multibody(list(links), **force)
    q0 = system.group.join(R0, np.array([0.3, 0.1]))
    return galvi.Problem(system, q0, [0.3, -0.2, 0.1, 0.5, -0.4])


PLANAR_GROUPS = {"": galvi.SE2(), " beside a line": galvi.Product((galvi.SE2(), galvi.Rn(1)))}
ROWS: dict[str, Row] = {
    "free body": Row(lambda: FREE, 0.1),
    "spherical pendulum": Row(lambda: PENDULUM, 0.1),
    "top": Row(galvi.problems.heavy_top, 0.05),
    "box": Row(galvi.problems.free_box, 0.1),
    "thrown body": Row(lambda: FLYING, 0.05),
    "flying body": Row(lambda: SPINNING, 0.1),
    **{f"swelling on {name}": Row(partial(swelling, name, 2), 0.1) for name in GROUPS},
    **{
        f"body: {name}": Row(partial(galvi.Problem, *body), 0.05)
        for name, body in BODIES_OF_FUNCTIONS.items()
    },
    **{
        f"mass of entry {i}{j}": Row(partial(mass_of_entry, i, j), 0.05)
        for i, j in ((0, 0), (1, 2))
    },
    **{
        f"{name} from {rate:g}": Row(partial(nearly_at_rest, body, rate), 0.1)
        for rate in (0.0, 1e-30, 1e-12, -1e-3)
        for name, body in (("free", FREE), ("falling", PENDULUM))
    },
    **{
        f"body in the plane{name}": Row(partial(in_plane, group), 0.1)
        for name, group in PLANAR_GROUPS.items()
    },
    "pendulum and body": Row(lambda: COUPLED, 0.1),
    "ball, hinge and slide": Row(partial(hanging, BALL, HINGED), 0.05),
    "tree with a force": Row(partial(hanging, BALL, HINGED, force=swirl, timed_force=True), 0.05),
    "skew arm": Row(partial(galvi.problems.skew_arm, 0.1), 0.02),
    "floating arm": Row(partial(galvi.problems.skew_arm, floating=True), 0.02, gap_bound=64.0),
}
