"""Problems whose laws have vector code, and starts for the members of their ensembles."""

import numpy as np
import sympy
from scipy.spatial.transform import Rotation

import galvi
from tests.properties.group_matrices import element


def swinging(stiffness=40.0, damping=0.1):
    """An elastic pendulum from SymPy with a drag force, whose L depends on the time."""
    r, a, vr, va, m, k, c, t = sympy.symbols("r a vr va m k c t", real=True)
    L = m * (vr**2 + (r * va) ** 2) / 2 + m * 9.81 * r * sympy.cos(a) - k * (r - 1) ** 2 / 2
    L = L * (1 + sympy.sin(t) / 10)
    values = {m: 1.3, k: stiffness, c: damping}
    system = galvi.Lagrangian.from_sympy(
        L, [r, a], [vr, va], t=t, parameters=values, force=[-c * vr, -c * r**2 * va]
    )
    return galvi.Problem(system, [1.2, 0.4], [0.1, 0.2], t0=0.3)


def three_bodies():
    """A star and two planets, one of them massless, in the plane."""
    system = galvi.NBody(np.array([1.0, 1e-3, 0.0]))
    return galvi.Problem(
        system, [[0.0, 0.0], [1.0, 0.0], [0.0, 1.7]], [[0.0, 0.0], [0.0, 1.0], [-0.75, 0.0]]
    )


def in_plane(group, well=1.0):
    """A body on ``group`` under a constant force, in a quadratic well of strength ``well``."""
    d, r = group.dimension, int(np.prod(group.shape))
    masses, direction = 1.0 + 0.3 * np.arange(d), 0.4 * np.cos(np.arange(r))

    def lagrangian(g, v):
        height = direction @ g.reshape(r)
        return 0.5 * (masses @ (v * v)) - height - 0.5 * well * height**2

    system = galvi.Lagrangian(lagrangian, group)
    return galvi.Problem(system, element(group, np.full(d, 0.3)), 0.5 - 0.2 * np.arange(d))


# Name -> problem, and a step at which the iterations converge.
CASES = {
    "kepler": (galvi.problems.kepler(0.3), 0.2),
    "henon_heiles": (galvi.problems.henon_heiles(), 0.2),
    "double_pendulum": (galvi.problems.double_pendulum(), 0.03),
    "brownout": (galvi.problems.brownout(400e-6), 0.01),
    "sympy": (swinging(), 0.05),
    "three_bodies": (three_bodies(), 0.1),
    "polar": (galvi.problems.kepler_polar(), 0.1),
    "free_body": (galvi.problems.free_rigid_body(), 0.1),
    "pendulum_3d": (galvi.problems.pendulum_3d(), 0.1),
    "free_body_se3": (galvi.problems.free_body_se3(), 0.05),
    "se2": (in_plane(galvi.SE2()), 0.1),
    "se2 without a well": (in_plane(galvi.SE2(), 0.0), 0.1),
}


def starts(problem, members, size=1e-2, seed=7):
    """Configurations and velocities of members near the problem's start.

    On groups other than R^n, SO(3) and SE(3) the configurations are near the unit instead.
    """
    random = np.random.default_rng(seed)
    q, v = problem.q0, problem.v0
    velocities = v + size * random.standard_normal((members, *v.shape))
    if isinstance(getattr(problem.system, "group", galvi.Rn(1)), galvi.Rn):
        return q + size * random.standard_normal((members, *q.shape)), velocities
    configurations = np.stack([q] * members)
    group = problem.system.group
    if not isinstance(group, galvi.SO3 | galvi.SE3):
        coordinates_of_members = size * random.standard_normal((members, group.dimension))
        return np.stack(
            [element(group, coordinates) for coordinates in coordinates_of_members]
        ), velocities
    rotations = Rotation.from_rotvec(size * random.standard_normal((members, 3))).as_matrix()
    configurations[:, :3, :3] = q[:3, :3] @ rotations
    return configurations, velocities
