"""A method, and a pendulum as a Lagrangian that is differenced, for the tests of Lagrangians."""

import numpy as np

import galvi

METHOD = galvi.Galerkin(galvi.Polynomials(4), galvi.gauss(4))
MOMENTS = np.array([1.0, 1.5, 2.0])


def opaque(function):
    """The function of q, v and perhaps t behind a call of `float`, which cannot be traced."""

    def untraceable(*qvt):
        float(np.ravel(qvt[0])[0])
        return function(*qvt)

    return untraceable


def swinging(l):
    """A pendulum whose coordinate is l times its angle, from an angle of 1."""
    L = opaque(lambda q, v: 0.5 * v @ v / l**2 + np.cos(q[0] / l))
    system = galvi.Lagrangian(L, galvi.Rn(1))
    return galvi.Problem(system, [l], [0.3 * l])
