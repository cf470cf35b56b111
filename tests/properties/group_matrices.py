"""Elements of groups by scipy's rotations, and strategies for their coordinates (d,)."""

import numpy as np
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

import galvi


def cross_matrix(w):
    return np.array([np.cross(w, e) for e in np.eye(3)]).T


def element(group, v):
    """The element with the coordinates v, (d,): angles of rotation, by scipy, then translations."""
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
    """A strategy for vectors (d,) whose entries are at most ``largest`` in size."""
    component = st.floats(-largest, largest)
    return st.lists(component, min_size=group.dimension, max_size=group.dimension).map(np.array)


def title(value):
    """The id of a test's parameter: the problem's name, or the class."""
    return value.name if isinstance(value, galvi.Problem) else type(value).__name__
