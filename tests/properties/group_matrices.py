"""Groups and algebras as matrices, written down independently of galvi's own formulas.

An element of R^n is [[I, x], [0, 1]], one of a product is block-diagonal. v (d,) is the velocity
of galvi's documentation, g' = g hat(v).
"""

import numpy as np
from hypothesis import strategies as st
from scipy.linalg import block_diag
from scipy.spatial.transform import Rotation

import galvi


def cross_matrix(w):
    return np.array([np.cross(w, e) for e in np.eye(3)]).T


def hat(group, v):
    """The matrix of v in the algebra."""
    v = np.asarray(v)
    if isinstance(group, galvi.Product):
        ends = np.cumsum([factor.dimension for factor in group.factors])[:-1]
        return block_diag(
            *(hat(f, part) for f, part in zip(group.factors, np.split(v, ends), strict=True))
        )
    if isinstance(group, galvi.SO2):
        return np.array([[0.0, -v[0]], [v[0], 0.0]])
    if isinstance(group, galvi.SO3):
        return cross_matrix(v)
    turning, moving = None, v
    if isinstance(group, galvi.SE2):
        turning, moving = np.array([[0.0, -v[0]], [v[0], 0.0]]), v[1:]
    if isinstance(group, galvi.SE3):
        turning, moving = cross_matrix(v[:3]), v[3:]
    n = moving.size
    matrix = np.zeros((n + 1, n + 1), dtype=v.dtype)
    if turning is not None:
        matrix[:n, :n] = turning
    matrix[:n, n] = moving
    return matrix


def as_matrix(group, g):
    """The matrix of an element."""
    if isinstance(group, galvi.Product):
        return block_diag(
            *(as_matrix(f, part) for f, part in zip(group.factors, group.parts(g), strict=True))
        )
    if isinstance(group, galvi.Rn):
        matrix = np.eye(group.n + 1)
        matrix[: group.n, group.n] = g
        return matrix
    return np.asarray(g)


def element(group, v):
    """An element for each v (d,), by scipy's rotations."""
    if isinstance(group, galvi.Product):
        ends = np.cumsum([factor.dimension for factor in group.factors])[:-1]
        pieces = zip(group.factors, np.split(np.asarray(v), ends), strict=True)
        return group.join(*(element(factor, part) for factor, part in pieces))
    if isinstance(group, galvi.Rn):
        return np.array(v, dtype=np.float64)
    if isinstance(group, galvi.SO2):
        return np.array([[np.cos(v[0]), -np.sin(v[0])], [np.sin(v[0]), np.cos(v[0])]])
    if isinstance(group, galvi.SE2):
        g = np.eye(3)
        g[:2, :2], g[:2, 2] = element(galvi.SO2(), v[:1]), v[1:]
        return g
    R = Rotation.from_rotvec(v[:3]).as_matrix()
    if isinstance(group, galvi.SO3):
        return R
    g = np.eye(4)
    g[:3, :3], g[:3, 3] = R, v[3:]
    return g


def vectors(group, largest=3.0):
    """A strategy for v (d,)."""
    component = st.floats(-largest, largest)
    return st.lists(component, min_size=group.dimension, max_size=group.dimension).map(np.array)


def title(value):
    """A name for a test's parameter."""
    return value.name if isinstance(value, galvi.Problem) else type(value).__name__
