import numpy as np

import galvi


def potential(q):
    return q[0] ** 4 / 4 + q[1] ** 2 / 2 + q[0] * q[1] ** 2 / 10


def gradient(q):
    return np.array([q[0] ** 3 + q[1] ** 2 / 10, q[1] + q[0] * q[1] / 5])


def spring():
    return galvi.Problem(galvi.Canonical(1.0, potential, gradient), [1.0, 0.3], [0.0, 0.2]), 20.0
