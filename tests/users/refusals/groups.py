"""Refusals of bodies, Lagrangians and groups: errors and their messages."""

import numba
import numpy as np

import galvi
from tests.properties.group_bodies import (
    FOUR,
    MOMENTS,
    R0,
    SO3,
    SPIN,
    kinetic,
    nonlinear_gradient,
    nonlinear_potential,
    start,
)
from tests.properties.group_matrices import element
from tests.properties.lagrangians import METHOD, opaque, swinging

NOT_FINITE = "potential and gradient must be finite at the start"
REMEDY = r" Give three positive moments, each at most the sum of the others, or such a matrix\."
FACTORS = "factors must be groups such as"
PRODUCT = galvi.Product((galvi.SO3(), galvi.Rn(2)))


def one_step(problem):
    return galvi.integrate(problem, METHOD, 0.1, 1)


def moving(*factors):
    """The run of a step of free motion on these groups."""
    group = galvi.Product(factors) if len(factors) > 1 else factors[0]
    system = galvi.Lagrangian(lambda q, v: 0.5 * v @ v, group)
    state = element(group, np.zeros(group.dimension)), np.ones(group.dimension)
    return one_step(galvi.Problem(system, *state))


def line(L):
    """A call that runs a step of a Lagrangian of one coordinate."""
    return lambda: one_step(galvi.Problem(galvi.Lagrangian(L, galvi.Rn(1)), [0.6], [1.0]))


def tether(q):
    return 0.5 * np.sum(q[:3, 3] ** 2)


BODIES = (
    (ValueError,
     r"inertia must be positive definite; received principal moments \[-1\.0, 1\.0, 1\.0\]\."
     + REMEDY,
     galvi.RigidBody, (1.0, -1.0, 1.0)),
    (ValueError, "inertia must be symmetric; received",
     galvi.RigidBody, [[2, 0.5, 0], [0, 2, 0], [0, 0, 2]]),
    (ValueError, r"inertia must have shape \(3,\) or \(3, 3\); received shape \(2,\)",
     galvi.RigidBody, [1.0, 2.0]),
    (ValueError, "inertia must hold finite", galvi.RigidBody, (1.0, np.nan, 1.0)),
    (ValueError, "inertia must be an array of real numbers", galvi.RigidBody, "abc"),
    (ValueError,
     r"no body has the inertia \[1\.0, 1\.0, 2\.1\]: its largest moment exceeds .*\." + REMEDY,
     galvi.FreeBody, 1.0, (1.0, 1.0, 2.1)),
    (ValueError, "mass must be positive; received -1", galvi.FreeBody, -1.0, MOMENTS),
    (ValueError, r"g must have shape \(3,\)", galvi.FreeBody, 1.0, MOMENTS, 9.81),
    (TypeError, "potential must be a function of R", galvi.RigidBody, MOMENTS, 3),
    (ValueError, "a gradient needs its potential; received none",
     lambda: galvi.RigidBody(MOMENTS, gradient=nonlinear_gradient)),
    (ValueError, r"explicit_time means functions of \(R, t\)",
     lambda: galvi.RigidBody(MOMENTS, galvi.UniformGravity(1.0, SPIN), explicit_time=True)),
    (ValueError, "mass must be positive", galvi.UniformGravity, 0.0, SPIN),
    (ValueError, r"centre must have shape", galvi.UniformGravity, 1.0, (0.0, 1.0)),
    (ValueError, r"g must have shape", galvi.UniformGravity, 1.0, SPIN, np.ones(2)),
    (ValueError,
     r"q0 must be a rotation, .* received \|R\^T R - I\| = 2\.0e-03\. The nearest rotation is",
     galvi.Problem, galvi.RigidBody(MOMENTS), 1.001 * R0, SPIN),
    (ValueError, r"v0 must have shape \(3,\); received shape \(3, 3\)\. v0 is the body velocity\.",
     galvi.Problem, galvi.RigidBody(MOMENTS), R0, np.eye(3)),
    (ValueError, "q0 must be a rigid motion",
     galvi.Problem, galvi.FreeBody(1.0, MOMENTS), R0, np.ones(6)),
    (ValueError, r"v0 must have shape \(6,\)",
     galvi.Problem, galvi.FreeBody(1.0, MOMENTS), np.eye(4), SPIN),
    (TypeError, r"function must be a function of \(q, v\)", galvi.Lagrangian, 3, SO3),
    (TypeError, r"group must be a group such as galvi.SO3", galvi.Lagrangian,
     nonlinear_potential, 3),
    (TypeError, r"chart must be a chart such as galvi\.Cayley\(\); received <class",
     galvi.Galerkin, galvi.Polynomials(2), galvi.gauss(2), galvi.Exponential),
    *(  # singular, in turned axes
        (ValueError, "must be positive definite", galvi.RigidBody, np.eye(3) - np.outer(u, u))
        for u in ((0.36, 0.48, 0.8), (0.8, 0.0, 0.6), (2.0 / 3.0, 1.0 / 3.0, -2.0 / 3.0))
    ),
    (ValueError, "tilt must be between 0 and pi", lambda: galvi.problems.heavy_top(tilt=0.0)),
    (ValueError, "spin must be a finite real number",
     lambda: galvi.problems.heavy_top(spin=np.inf)),
    (ValueError, "angle must be between 0 and pi", galvi.problems.spherical_pendulum, 4.0),
    (ValueError, "amplitude must be between 0 and pi", galvi.problems.planar_pendulum, 0.0),
    (ValueError, "weight must be positive", galvi.problems.pendulum_3d, -1.0),
)  # fmt: skip
AT_START = (
    (ValueError, NOT_FINITE, galvi.RigidBody(MOMENTS, lambda R: np.nan)),
    (ValueError, NOT_FINITE, galvi.RigidBody(MOMENTS, nonlinear_potential, lambda R: np.inf * R)),
    (ValueError, r"potential must return a number; received an arr",
     galvi.RigidBody(MOMENTS, lambda R: R)),
    (ValueError, "potential must return a real number; received",
     galvi.RigidBody(MOMENTS, lambda R: None)),
    (ValueError, r"gradient must return an array of shape \(3, 3\), dV/dR; received shape \(3,\)",
     galvi.RigidBody(MOMENTS, nonlinear_potential, lambda R: R[0])),
    (ValueError, r"gradient must return an array of shape \(3, 3\), dV/dR; received shape \(2, 3\)",
     galvi.RigidBody(MOMENTS, nonlinear_potential, numba.njit(lambda R: R[:2] + 0.0))),
    (ValueError, "the Lagrangian must return a finite number",
     galvi.Lagrangian(lambda q, v: np.nan, SO3)),
    (ValueError, "the Lagrangian must return a number; received an",
     galvi.Lagrangian(lambda q, v: v, SO3)),
    (ValueError, "the Lagrangian must return a real number; rec",
     galvi.Lagrangian(lambda q, v: "a", SO3)),
    (ValueError,
     r"the Lagrangian is degenerate at the start: d2L/dv2 is singular, with eigenvalues",
     galvi.Lagrangian(lambda q, v: v[0] ** 2 + v[1] ** 2, SO3)),
    (ValueError,
     r"slopes must return dL/dv and dL/dq in an array of shape \(12,\); received shape \(3,\)",
     galvi.Lagrangian(kinetic, SO3, lambda q, v: v)),
    (ValueError, "the derivatives of the Lagrangian must be finite at the start",
     galvi.Lagrangian(kinetic, SO3, lambda q, v: np.full(12, np.nan))),
    (ValueError, r"gradient must return an array of shape \(3, 3\), dV/dR, of real numbers; rece",
     galvi.RigidBody(MOMENTS, lambda R: 1.0, lambda R: (1.0 + 1j) * R)),
)  # fmt: skip
GROUPS = (
    (ValueError, FACTORS, galvi.Product, ()),
    (ValueError, FACTORS, galvi.Product, (galvi.SO3(), 3)),
    (ValueError, FACTORS, galvi.Product, galvi.SO3()),
    (ValueError, "n must be a whole number", galvi.Rn, 0),
    (ValueError, r"matrix must be square; received an array of shape \(2, 3\)",
     galvi.nearest_rotation, np.ones((2, 3))),
    (ValueError, r"finite numbers only; received a non-finite entry at \[0, 0\]",
     galvi.nearest_rotation, np.full((3, 3), np.nan)),
    (ValueError, r"g must be a finite real number; received None\. Give a number, or a vector",
     galvi.UniformGravity, 1, (0, 0, 1), None),
    (ValueError, r"join needs one part for each of the 2 factors; received 1\.",
     PRODUCT.join, np.eye(3)),
    (ValueError,
     r"part 1 must have shape \(2,\), .* as an element of Rn\(n=2\); received shape \(3,\)",
     PRODUCT.join, np.eye(3), np.ones(3)),
    (ValueError, r"parts must have the same leading axes; received \[\(4,\), \(5,\)\]",
     PRODUCT.join, np.ones((4, 3, 3)), np.ones((5, 2))),
    (ValueError, r"shape \(0, 0\)", galvi.nearest_rotation, np.zeros((0, 0))),
    (ValueError, "matrix must be an array of real", galvi.nearest_rotation, [["a"]]),
    (ValueError, "no nearest rotation is", galvi.nearest_rotation, np.ones((3, 3))),
    (ValueError, r"q0 must be a rotation, .* Give a matrix with orthonormal columns\.",
     galvi.Problem, galvi.RigidBody(MOMENTS), np.zeros((3, 3)), MOMENTS),
    (TypeError, "run must be a galvi.Trajectory; received 'x'", galvi.rotations, "x"),
    (ValueError,
     "a Lagrangian does not say how rotations and translations of space act .* use a galvi",
     lambda: galvi.momentum_map(one_step(swinging(1.0)))),
    (ValueError, r"momenta of rotations and translations need .* on Rn\(n=1\) nothing says",
     lambda: galvi.momentum_map(moving(galvi.SO3(), galvi.Rn(1)))),
    (ValueError, "some factors are in the plane and some in space",
     lambda: galvi.linear_momentum(moving(galvi.SE2(), galvi.Rn(3)))),
    (ValueError, r"has rotations only, on which translations .* such as galvi\.SE3\(\)",
     lambda: galvi.linear_momentum(moving(galvi.SO3(), galvi.SO3()))),
    (ValueError, r"attitudes need a run on SO\(3\) or SE\(3\), .* Take a factor's matrices from",
     lambda: galvi.rotations(moving(galvi.SO2(), SO3))),
    (ValueError, r"attitudes need a run on SO\(3\) or SE\(3\), such as",
     lambda: galvi.rotations(one_step(galvi.problems.kepler(0.1)))),
    (ValueError, r"needs a run on SO\(2\), SE\(2\), SO\(3\), SE\(3\) or a galvi\.Product",
     lambda: galvi.orthogonality_defect(one_step(galvi.problems.kepler(0.1)))),
    (ValueError, "must be the derivative of the Lagrangian",
     lambda: galvi.Problem(galvi.FreeBody(1.0, MOMENTS, (0, 0, -1.0), tether, lambda q: 0.0 * q),
      np.eye(4), np.ones(6))),
    (ValueError, "are those of a potential; received none",
     lambda: galvi.FreeBody(1.0, MOMENTS, gradient=tether)),
    (TypeError, "potential must be a function of q; received 5",
     lambda: galvi.FreeBody(1.0, MOMENTS, (0, 0, -1.0), 5)),
    (ValueError, "solver fixed_point needs functions",
     lambda: galvi.integrate(start(galvi.Lagrangian(opaque(kinetic), SO3)), FOUR, 0.1, 3,
      solver="fixed_point")),
    (ValueError, "solver fixed_point needs functions",
     lambda: galvi.integrate_many(
         [start(galvi.RigidBody(MOMENTS, opaque(nonlinear_potential)))], FOUR, 0.1, 3,
      solver="fixed_point")),
    (ValueError, r"attitudes need .* np\.arctan2\(run\.q\[:, 1, 0\], run\.q\[:, 0, 0\]\)",
     lambda: galvi.rotations(moving(galvi.SO2()))),
    (ValueError, r"no linear momentum of its own; use galvi\.momentum_map",
     lambda: galvi.linear_momentum(one_step(galvi.problems.free_rigid_body()))),
    (ValueError, r"derivatives of the Lagrangian must be finite .* Give sl",
     line(lambda q, v: 0.5 * v @ v - abs(np.sin(1e40 * q[0] + q[0])))),
)  # fmt: skip


BODY_AND_CART = galvi.Product((SO3, galvi.Rn(1)))
STRETCHED = np.eye(3) + 1e-4 * np.diag([1.0, 0.0, 0.0])


def starting(group, q0):
    """A call that makes a problem on the group with this start."""
    system = galvi.Lagrangian(lambda q, v: 0.5 * v @ v, group)
    return lambda: galvi.Problem(system, q0, np.ones(group.dimension))


ELEMENTS = tuple(
    (ValueError, message, starting(group, q0))
    for group, q0, message in (
        (SO3, STRETCHED, r"q0 must be a rotation, R\^T R = I with determinant 1, to 1e-09; "
         r"received \|R\^T R - I\| = 2\.0e-04\. The nearest rotation is \[\[1\.0, 0\.0, 0\.0\], "
         r".*\], from galvi\.nearest_rotation\."),
        (SO3, np.diag([1.0, 1.0, -1.0]), r"received determinant -1\. The nearest rotation is"),
        (SO3, np.zeros((3, 3)), r"received \|R\^T R - I\| = 1\.0e\+00"),
        (SO3, np.eye(3).ravel(), r"of shape \(3, 3\); received shape \(9,\)"),
        (galvi.SO2(), np.diag([1.0, -1.0]), "received determinant -1"),
        (galvi.SO2(), np.eye(3), r"shape \(2, 2\); received shape \(3, 3\)"),
        (galvi.Rn(2), np.zeros(3), r"q0 must have shape \(2,\); received shape \(3,\)"),
        (galvi.SE3(), np.eye(3), r"q0 must be a rigid motion \[\[R, x\], \[0, 0, 0, 1\]\] of shape "
         r"\(4, 4\); received shape \(3, 3\)"),
        (galvi.SE3(), np.eye(4) + np.diag([1e-12], -3), r"with last row \[1e-12, 0\.0, 0\.0, 1\.0"),
        (galvi.SE3(), np.eye(4) + np.diag([0.5, 0.0], 2),
         "the rotation of q0 must be a rotation"),
        (BODY_AND_CART, np.zeros(9), r"q0 must have shape \(10,\), the entries of all factors; "
         r"received shape \(9,\)\. Make it with Product\.join"),
        (BODY_AND_CART, BODY_AND_CART.join(STRETCHED, np.zeros(1)),
         "part 0 of q0 must be a rotation"),
        (galvi.Product((BODY_AND_CART, galvi.SO2())), np.zeros(14),
         "part 0 of part 0 of q0 must be a rotation"),
    )
)  # fmt: skip


def started(system):
    return lambda: galvi.integrate(start(system), FOUR, 0.1, 3)


TABLE = {
    "bodies": BODIES,
    "functions on groups": tuple((*row[:2], started(row[2])) for row in AT_START),
    "groups": GROUPS,
    "elements": ELEMENTS,
}
