"""A potential on SO(3) that is not linear in R, and starts, for the tests of systems on groups."""

import numpy as np
from scipy.spatial.transform import Rotation

import galvi

FOUR = galvi.Galerkin(galvi.Polynomials(4), galvi.gauss(4))
SO3, MOMENTS, SPIN = galvi.SO3(), (1.0, 1.5, 2.0), np.array([0.3, -0.8, 0.5])
R0 = Rotation.from_rotvec([0.4, -0.9, 1.3]).as_matrix()
TWIST = np.array([[0.3, -1.0, 0.2], [0.7, 0.1, 0.4], [-0.5, 0.6, 0.9]])


def nonlinear_potential(R):
    """A potential that is not linear in R."""
    return np.sum(TWIST * R) ** 2 + 0.5 * np.sum(TWIST.T * R)


def nonlinear_gradient(R):
    return 2.0 * np.sum(TWIST * R) * TWIST + 0.5 * TWIST.T


def start(system, q0=R0, v0=SPIN):
    return galvi.Problem(system, q0, v0)


def kinetic(q, v):
    return 0.5 * v @ v
