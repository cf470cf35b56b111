"""Refusals of point masses, Canonical systems, forces and problems: errors and messages."""

from functools import partial

import numba
import numpy as np
from scipy.spatial.transform import Rotation

import galvi
from galvi.problems import brownout
from tests.properties.forced_systems import FOUR, SPRING, START, lagrangian

KEPLER = galvi.problems.kepler(0.3)
WRONG_GRADIENT = r"^gradient must be the derivative of the potential: along .* at q = .*"


FUNCTIONS_OF_TIME = (  # without explicit_time=True; the arguments in the message, call
    (r"\(q\)", lambda: galvi.Canonical(1.0, lambda q, t: 0.0)),
    (r"\(q\)", lambda: galvi.Canonical(1.0, numba.njit(lambda q, t: 0.0))),
    (r"\(q\)", lambda: galvi.FreeBody(1.0, (1, 1, 1), potential=lambda q, t: 0.0)),
    (r"\(R\)", lambda: galvi.RigidBody((1, 1, 1), lambda R, t: 0.0)),
    (r"\(q, v\)", lambda: galvi.Lagrangian(lambda q, v, t: 0.5 * v @ v, galvi.Rn(1))),
)


def stepped(solver="auto", **fields):
    """A call that runs a step of a spring with another gradient, or a force."""
    problem = galvi.Problem(galvi.Canonical(1.0, SPRING, **fields), *START)
    return lambda: galvi.integrate(problem, FOUR, 0.1, 1, solver=solver)


def of_gradient(value):
    """A call that makes a problem of the potential 3 q whose gradient is `value`."""
    system = partial(galvi.Canonical, 1.0, lambda q: 3.0 * q[0], lambda q: np.full(1, value))
    return lambda: galvi.Problem(system(), [2.0], [0.0])


def balance(*run, **options):
    """A call for the balance of momentum of a run."""
    return lambda: galvi.momentum_balance(galvi.integrate(*run, **options))


MAKERS = {
    "canonical": partial(galvi.Canonical, 1.0, SPRING),
    "lagrangian": partial(galvi.Lagrangian, lagrangian, galvi.Rn(2)),
    "body": partial(galvi.RigidBody, (1, 2, 2)),
    "tree": partial(galvi.Multibody, galvi.Link(galvi.Joint("hinge", damping=1.0), 1.0, (1, 0, 0))),
}
POINT_MASSES = (
    (ValueError, r"eccentricity must be in \[0, 1\)", galvi.problems.kepler, 1.0),
    (ValueError, r"eccentricity must be in \[0, 1\)", galvi.problems.kepler, -0.1),
    (ValueError, "eccentricity must be a finite real", galvi.problems.kepler, float("nan")),
    (ValueError, "energy must be in", galvi.problems.henon_heiles, 0.2),
    (ValueError, "one must be positive; received -1.0 for body 1",
     galvi.NBody, [1.0, -1.0]),
    (ValueError, "masses must hold finite numbers", galvi.NBody, [1.0, float("inf")]),
    (ValueError, r"masses must have shape \(bodies,\)", galvi.NBody, []),
    (ValueError, "mass must be positive", galvi.Canonical, -1.0, galvi.LinearSpring()),
    (ValueError, "positive definite",
     galvi.Canonical, np.diag([1.0, 0.0]), galvi.LinearSpring()),
    (ValueError, "symmetric matrix",
     galvi.Canonical, [[1.0, 2.0], [0.0, 1.0]], galvi.LinearSpring()),
    (ValueError, "mu must be positive", galvi.CentralForce, 0.0),
    (ValueError, "stiffness must be a finite real", galvi.LinearSpring, float("nan")),
    (ValueError, "bodies 0 and 1 at the same point",
     galvi.Problem, galvi.NBody([1.0, 2.0]), np.zeros((2, 3)), np.zeros((2, 3))),
    (ValueError, "one row for each of the 2 masses",
     galvi.Problem, galvi.NBody([1.0, 2.0]), np.eye(3), np.eye(3)),
    (ValueError, r"v0 must have shape \(2, 2\); received shape \(3, 3\)",
     galvi.Problem, galvi.NBody([1.0, 2.0]), np.eye(2), np.eye(3)),
    (ValueError, r"q0 must hold finite numbers only; received a non-finite entry at \[1\]",
     galvi.Problem, galvi.Canonical(1.0, galvi.LinearSpring()), [1.0, float("nan")], [0.0,
      0.0]),
    (ValueError, "mass must be a scalar or have 1 rows",
     galvi.Problem, galvi.Canonical([1.0, 2.0], galvi.LinearSpring()), [1.0], [0.0]),
    (ValueError, r"q0 must have shape \(d,\)",
     galvi.Problem, galvi.Canonical(1.0, galvi.LinearSpring()), 1.0, 0.0),
    (TypeError, "potential must be a function of q; received 3", galvi.Canonical, 1.0, 3),
    (ValueError, r"mu must be .*; received an array of shape \(1,\)\.",
     galvi.CentralForce, np.ones(1)),
    (ValueError, r"^q0 must have no masked entries; received 1 of them",
     galvi.Problem, KEPLER.system, np.ma.array([1.0, 0.0], mask=[False, True]), [0.0, 1.0]),
    (ValueError, "masses must", galvi.NBody, [0.0, 0.0]),
    (ValueError, "masses must be positive", galvi.PlanarChain, [1.0, -1.0], [1.0, 1.0]),
    (ValueError, r"lengths must have shape \(2,", galvi.PlanarChain, [1.0, 1.0], [1.0]),
    (ValueError, "gravity must be a finite", galvi.PlanarChain, [1.0], [1.0], np.inf),
    (TypeError, "rods must be True or False", galvi.PlanarChain, [1.0], [1.0], 9.81, 1),
    (ValueError, r"masses must have shape", galvi.problems.double_pendulum, (1, 2, 3)),
    (ValueError, "angles must", lambda: galvi.problems.double_pendulum(angles=(1, np.nan))),
    (ValueError, "links must be a whole number", galvi.problems.planar_chain, 0),
    (ValueError, "mass must be positive", lambda: galvi.problems.planar_chain(mass=0.0)),
)  # fmt: skip
FUNCTIONS = (
    (ValueError, r"gradient must return an array of shape \(2,\); received",
     stepped(gradient=lambda q: q[:1])),
    (ValueError, "force must be finite at the start", stepped(gradient=lambda q: q * np.nan)),
    (ValueError, "of real numbers; received an array of type complex128",
     stepped(gradient=lambda q: 1j * q)),
    (TypeError, "check must be True or False; received 1",
     lambda: galvi.Canonical(1.0, lambda q: 0.0, check=1)),
    (ValueError, WRONG_GRADIENT + r"expected 3, .* received -3, of the opposite sign\. ",
     of_gradient(-3.0)),
    (ValueError, WRONG_GRADIENT + r"expected 3, .* received 6, 2 times that\. ", of_gradient(6.0)),
    (ValueError, r"force must return an array of shape \(2,\); received",
     stepped(force=lambda q, v: np.zeros(3))),
    (ValueError, "force must be finite at the start", stepped(force=lambda q, v: v * np.nan)),
    (ValueError, "of real numbers", stepped(force=lambda q, v: v * 1j)),
    (ValueError, "external force",
     stepped(force=lambda q, v: np.maximum(v, 0.0), solver="fixed_point")),
    (ValueError, r"could be traced; .* branches on",
     lambda: galvi.integrate(
         galvi.Problem(galvi.Lagrangian(lambda q, v: abs(v @ v - max(q)), galvi.Rn(2)), *START),
         FOUR, 0.1, 1, solver="fixed_point")),
    *(
        (error, message, partial(make, force=force, timed_force=timed))
        for error, message, force, timed in (
            (TypeError, r"force must be a function of \(q, v\); received 3.0", 3.0, False),
            (TypeError, r"force must be a function of \(q, v, t\)", "x", True),
            (ValueError, r"timed_force means a force\(q, v, t\); received no force", None, True),
            (TypeError, r"of \(q, v\); received .* \(q, v, t\)\. .* give timed_force=True",
             lambda q, v, t: 0.0 * v, False),
            (TypeError,
             r"of \(q, v, t\), with .* received a function of 2, \(q, v\)\. Leave timed_force",
             lambda q, v: 0.0 * v, True),
        )
        for make in MAKERS.values()
    ),
    *(
        (TypeError, rf"must be a function of {args}; received .* give explicit_time=True", call)
        for args, call in FUNCTIONS_OF_TIME
    ),
    (TypeError,
     r"with explicit_time=True; received a function of 1, \(q\)\. Leave explicit_time out",
     lambda: galvi.Canonical(1.0, lambda q: 0.0, explicit_time=True)),
    (TypeError, r"gradient must be a function of \(q\); received <function .*> of \(\)",
     galvi.Canonical, 1.0, lambda q: 0.0, lambda: 0.0),
    (ValueError, "one body", balance(galvi.problems.free_body_se3(), FOUR, 0.1, 1)),
    (ValueError, "needs the Galerkin curves",
     balance(KEPLER, FOUR, 0.1, 4, save_every=2)),
    (ValueError, "every step",
     balance(KEPLER, FOUR, 0.1, 4, save_every=2, curves=True)),
)  # fmt: skip
BROWNOUT = (
    (ValueError, "diameter must be positive; received 0.0. Give it in metres",
     partial(brownout, diameter=0.0)),
    (ValueError, r"from 1e-06 to 0.01 m; received 100.0. .* 100 micrometres are",
     partial(brownout, diameter=100.0)),
    (ValueError, "from 1e-06 to 0.01 m; received 1e-07", partial(brownout, diameter=1e-7)),
    (ValueError, "diameter must be a finite real number",
     partial(brownout, diameter=float("nan"))),
    (ValueError, r"position must have shape \(3,\); received shape \(2,\)",
     partial(brownout, position=(1.0, 2.0))),
    (ValueError, "must not be below the ground, z >= 0; received z = -0.1. Raise it",
     partial(brownout, position=(1.0, 2.0, -0.1))),
    (ValueError, "velocity must hold finite numbers only",
     partial(brownout, velocity=(0.0, 0.0, float("inf")))),
    (ValueError, "drag_coefficient must be positive; received -0.4",
     partial(brownout, drag_coefficient=-0.4)),
    (ValueError, "Set timed_force",
     lambda: galvi.Canonical(1.0, galvi.UniformField((0, 0, -1)), force=galvi.RotorDrag(1.0))),
    (TypeError, r"drag_law must be galvi.QuadraticDrag.* received 3",
     galvi.RotorDrag, 1.0, 3),
)  # fmt: skip
ROTATION, QUATERNION = Rotation.from_rotvec([0.1, 0.2, 0.3]), r"Rotation\.from_quat"
BODY, FLYING = galvi.RigidBody((1.0, 2.0, 2.5)), galvi.FreeBody(1.0, (1.0, 2.0, 2.5))
COMMON_MISTAKES = (  # other forms of a rotation, and objects that are no system yet
    (TypeError, r"received <class .*\.Canonical.>\.$",
     galvi.Problem, galvi.Canonical, [1.0], [0.0]),
    (ValueError, r"Give q0\.as_matrix\(\)\.", lambda: galvi.Problem(BODY, ROTATION, np.zeros(3))),
    (ValueError, r"Rotation\.from_quat\(quaternion\)\.as_matrix\(\)",
     lambda: galvi.Problem(BODY, ROTATION.as_quat(), np.zeros(3))),
    (ValueError, QUATERNION, lambda: galvi.Problem(FLYING, ROTATION.as_quat(), np.zeros(6))),
    (ValueError, QUATERNION, lambda: galvi.Problem(FLYING, np.zeros(7), np.zeros(6))),
    (TypeError, r"galvi\.Lagrangian\(PlanarChain\(\.\.\.\), galvi\.Rn",
     lambda: galvi.Problem(galvi.PlanarChain([1.0], [1.0]), [1.0], [0.0])),
    (TypeError, r"galvi\.Canonical\(mass, CentralForce",
     lambda: galvi.Problem(galvi.CentralForce(1.0), [1.0], [0.0])),
    (TypeError, r"galvi\.RigidBody\(inertia, UniformGravity",
     lambda: galvi.Problem(galvi.UniformGravity(1.0, [0, 0, 1]), [1.0], [0.0])),
)  # fmt: skip


def beside_gravity(forces, masses=(1.0, 1e-3, 0.0)):
    """A call that makes a problem of three bodies with forces, in the plane."""
    return lambda: galvi.Problem(galvi.NBody(masses, forces=forces), POSITIONS, 0.0 * POSITIONS)


def late_force(force):
    """A call that makes a problem of three bodies with a force of the time, from t = 1."""
    system = galvi.NBody([1.0, 1e-3, 2e-4], forces=galvi.Force(force, takes_time=True))
    return lambda: galvi.Problem(system, POSITIONS, 0.0 * POSITIONS, t0=1.0)


POSITIONS = np.array([[0.0, 0.0], [1.0, 0.1], [-0.3, 2.1]])
CELESTIAL = (
    (ValueError, "a body with a mass; received 2", beside_gravity(galvi.Oblateness(2, 1e-3, 0.1))),
    (ValueError, "one of 3 bodies, by number; received 3",
     beside_gravity(galvi.PowerLaw(3, 1.0, 1.0))),
    (ValueError, "every body needs a mass; received 1", beside_gravity(galvi.Drag([0, 0, 1e-3]))),
    (ValueError, "on a body without mass", beside_gravity(galvi.Force(lambda q: q))),
    (ValueError, r"shape \(3, 2\)", beside_gravity(galvi.Force(lambda q: q[0]))),
    (ValueError, r"pole of Oblateness must be \(0, 0, z\)",
     beside_gravity(galvi.Oblateness(0, 1e-3, 0.1, pole=(1, 0, 1)))),
    (ValueError, "a Force must be finite at the start",
     late_force(lambda q, t: q - (np.inf if t > 0.5 else 0.0))),
    (TypeError, "forces must be values", lambda: galvi.NBody([1.0], forces=(3.0,))),
    (ValueError, "a number for each of 2 bodies",
     lambda: galvi.NBody([1.0, 1.0], forces=galvi.Drag([1.0]))),
    *(
        (ValueError, f"{name} must be a whole number of at least 0; received -1",
         partial(force, *numbers, **{name: -1}))
        for force, numbers, name in (
            (galvi.Relativity, (1.0,), "source"), (galvi.Radiation, ([0.1], 1.0), "source"),
        )
    ),
    *(
        (ValueError, r"must be a whole number of at least 0; received -1", force, -1, *numbers)
        for force, numbers in (
            (galvi.PowerLaw, (1.0, 1.0)), (galvi.Oblateness, (1e-3, 0.1)),
            (galvi.Tides, (1.0, 1.0, 1.0)),
        )
    ),
    (ValueError, "form must be one of", lambda: galvi.Relativity(1.0, form="other")),
    (ValueError, "form must be one of", lambda: galvi.Relativity(1.0, form=np.zeros(0))),
    *(
        (ValueError, "pole must have a length", partial(galvi.Oblateness, 0, 1e-3, 0.1, pole=pole))
        for pole in ((0, 0, 0), (0, 0, 1e308))
    ),
    (ValueError, "must not be negative", lambda: galvi.Drag([-1.0])),
    (ValueError, "k2 must not be negative", lambda: galvi.Tides(0, -1.0, 1.0, 1.0)),
    (ValueError, "power must be -1 or differ from it by at least",
     lambda: galvi.PowerLaw(0, 1.0, -1.0 + 1e-9)),
    (TypeError, r"a function of \(q, v\); received 3.0",
     lambda: galvi.Force(3.0, takes_velocity=True)),
    (TypeError, "takes_velocity must be", lambda: galvi.Force(3.0, takes_velocity=np.zeros(0))),
    *(
        (TypeError, r"of \(q\); received a function of \(q, v\). Set takes",
         partial(galvi.Force, function))
        for function in (lambda q, v: -v, numba.njit(lambda q, v: -v))
    ),
    (ValueError, "cannot hold galvi's forces", lambda: galvi.integrate(
        beside_gravity(galvi.PowerLaw(0, 1e-3, 1.0))(), FOUR, 0.01, 1).to_rebound()),
    (ValueError, "forces of velocity", lambda: galvi.symplecticity_defect(
        beside_gravity(galvi.Drag([0.0, 0.1, 0.1]), (1.0, 0.1, 0.1))(), FOUR, 0.01)),
    (ValueError, "particles must be", lambda: galvi.problems.outer_solar_system(particles=-1)),
)  # fmt: skip
TABLE = {
    "tried first": COMMON_MISTAKES,
    "point masses": POINT_MASSES,
    "functions": FUNCTIONS,
    "brownout": BROWNOUT,
    "celestial forces": CELESTIAL,
}
