"""A spring, a start and forces, for the tests of external forces."""

import functools

import numba
import numpy as np

import galvi

FOUR = galvi.Galerkin(galvi.Polynomials(4), galvi.gauss(4))
MASS = np.array([[1.0, 0.3], [0.3, 2.0]])
SPRING = galvi.LinearSpring(1.5)
START = np.array([1.0, 0.5]), np.array([0.1, 0.4])
WIND = np.array([0.4, -0.2])


def drag(q, v):
    """Quadratic drag in still air."""
    return -0.2 * np.sqrt(np.sum(v * v)) * v


def windy_drag(q, v, t):
    """Quadratic drag in a wind along one line, in proportion to cos t."""
    relative = v - WIND * np.cos(t)
    return -0.2 * np.sqrt(np.sum(relative * relative)) * relative


def spring_gradient(q):
    return 1.5 * q


def timed_gradient(q, t):
    return (1.5 + 0.5 * np.sin(t)) * q


def timed_potential(q, t):
    return 0.5 * (1.5 + 0.5 * np.sin(t)) * (q @ q)


def lagrangian(q, v):
    return 0.5 * v @ MASS @ v - 0.75 * q @ q


def lagrangian_slopes(q, v):
    return np.concatenate((MASS @ v, -1.5 * q))


compiled = functools.cache(numba.njit)
# Name -> system, and whether its potential and its force depend on the time.
SYSTEMS = {
    "a potential known to galvi": (galvi.Canonical(MASS, SPRING, force=compiled(drag)), 0, 0),
    "a compiled gradient": (
        galvi.Canonical(
            MASS, lambda q: 0.75 * q @ q, compiled(spring_gradient), force=compiled(windy_drag),
            timed_force=True,
        ), 0, 1,
    ),
    "a timed potential": (
        galvi.Canonical(
            MASS, timed_potential, compiled(timed_gradient), force=compiled(drag),
            explicit_time=True,
        ), 1, 0,
    ),
    "functions of Python": (
        galvi.Canonical(
            MASS, timed_potential, timed_gradient, force=windy_drag, explicit_time=True,
            timed_force=True,
        ), 1, 1,
    ),
    "a compiled force and a potential of Python": (
        galvi.Canonical(MASS, lambda q: 0.75 * q @ q, force=compiled(drag)), 0, 0,
    ),
    "a Lagrangian": (
        galvi.Lagrangian(
            lagrangian, galvi.Rn(2), compiled(lagrangian_slopes), compiled(windy_drag),
            timed_force=True,
        ), 0, 1,
    ),
}  # fmt: skip


def zero_gradient(q):
    return 0.0 * q
