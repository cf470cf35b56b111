"""The interface of groups; R^n, and the rotations and rigid motions of the plane and of space,
whose elements are matrices."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass
from types import ModuleType
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from galvi import input_checks
from galvi.arrays import Array
from galvi.kernels.lie.groups import rn, se2, se3, so2, so3
from galvi.kernels.lie.product import GROUPS

Layout = npt.NDArray[np.int64]
ROTATION_DEFECT = 1e-9  # largest entry of |R^T R - I| of a rotation
RANK_TOLERANCE = 1e-14  # singular values of at most this share of the largest count as 0


class Group(Hashable, Protocol):
    """A group; its elements are arrays of ``shape``, its algebra is R^dimension.

    Velocities and momenta are left-trivialised: g' = g hat(v), and mu is dual to v.
    """

    @property
    def dimension(self) -> int:
        """Dimension d of the group and of its algebra."""

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of one element."""

    @property
    def layout(self) -> Layout:
        """A row for each factor, (factors, 4): the number of its group in the kernels, dimension,
        number of entries, number of rotations; see galvi.kernels.lie.product."""

    def check(self, name: str, g: Array) -> None:
        """ValueError unless g is an element of the group; rotations are orthogonal to 1e-9."""

    def multiply(self, g: Array, k: Array) -> Array:
        """g k, for elements with any leading axes."""

    def inverse(self, g: Array) -> Array:
        """g^-1, for elements with any leading axes."""

    def bracket(self, v: Array, w: Array) -> Array:
        """[v, w] in the algebra, (d,): hat([v, w]) = hat(v) hat(w) - hat(w) hat(v)."""


def one_factor(kernel: Any, dimension: int, entries: int, rotations: int) -> Layout:
    """The layout of a group that is not a product.

    Parameters
    ----------
    kernel
        the module in galvi.kernels.lie.groups of the group
    entries
        number of entries of one element
    rotations
        number of leading components of a velocity that are rotations
    """
    return np.array([[GROUPS.index(kernel), dimension, entries, rotations]])


def is_group(value: Any) -> bool:
    """Whether the value is a group, not a class of groups."""
    return hasattr(value, "layout") and not isinstance(value, type)


def check_rotation(name: str, R: Array, n: int) -> None:
    """ValueError unless R is (n, n), orthogonal to 1e-9 and of determinant +1."""
    if R.shape != (n, n):
        raise ValueError(
            f"{name} must be a rotation matrix of shape ({n}, {n}); received shape {R.shape}."
            f"{_conversion(R, n)}"
        )
    with np.errstate(over="ignore", invalid="ignore"):
        defect = float(np.max(np.abs(R.T @ R - np.eye(n))))
        determinant = float(np.linalg.det(R))
    if not defect <= ROTATION_DEFECT or determinant < 0.0:
        violation = (
            f"|R^T R - I| = {defect:.1e}"
            if defect > ROTATION_DEFECT
            else f"determinant {determinant:.3g}"
        )
        nearest = _nearest(R)
        remedy = (
            "Give a matrix with orthonormal columns."
            if nearest is None
            else f"The nearest rotation is {nearest.round(6).tolist()}, from "
            f"galvi.nearest_rotation."
        )
        raise ValueError(
            f"{name} must be a rotation, R^T R = I with determinant 1, to {ROTATION_DEFECT:g}; "
            f"received {violation}. {remedy}"
        )


def check_motion(name: str, g: Array, n: int) -> None:
    """ValueError unless g is a rigid motion [[R, x], [0, 1]] of R^n, (n + 1, n + 1)."""
    side, last = n + 1, [0.0] * n + [1.0]
    if g.shape != (side, side) or g[n].tolist() != last:
        row = "0, " * n + "1"
        raise ValueError(
            f"{name} must be a rigid motion [[R, x], [{row}]] of shape ({side}, {side}); received "
            f"shape {g.shape}{'' if g.shape != (side, side) else f' with last row {g[n].tolist()}'}"
            f".{_conversion(g, n)}"
        )
    check_rotation(f"the rotation of {name}", g[:n, :n], n)


def _conversion(array: Array, n: int) -> str:
    """A remedy for arrays of 4 or 7 numbers, perhaps a quaternion, where a matrix of space is
    expected; else ""."""
    if n != 3 or array.shape not in ((4,), (7,)):
        return ""
    return (
        " A quaternion with the scalar last becomes a rotation matrix by "
        "scipy.spatial.transform.Rotation.from_quat(quaternion).as_matrix()."
    )


def inverse_motion(g: Array) -> Array:
    """[[R^T, -R^T x], [0, 1]] for rigid motions with any leading axes."""
    n, inverse = g.shape[-1] - 1, np.zeros_like(g)
    transpose = np.swapaxes(g[..., :n, :n], -1, -2)
    inverse[..., :n, :n] = transpose
    inverse[..., :n, n] = -(transpose @ g[..., :n, n:])[..., 0]
    inverse[..., n, n] = 1.0
    return inverse


def nearest_rotation(matrix: Array) -> Array:
    """The rotation R that is closest to a matrix in the Frobenius norm.

    R = U diag(1, ..., 1, det(U V^T)) V^T from the singular value decomposition U S V^T (Kabsch,
    Acta Cryst. A32 (1976) 922).

    Parameters
    ----------
    matrix : array, shape (n, n)
        of rank at least n - 1

    Returns
    -------
    array, shape (n, n)
        the rotation

    Raises
    ------
    ValueError
        For a matrix that is not square, not finite, or of rank below n - 1, for which the nearest
        rotation is not unique.

    Examples
    --------
    >>> galvi.nearest_rotation(np.array([[0.0, -1.0], [1.01, 0.0]])).round(12) + 0.0
    array([[ 0., -1.],
           [ 1.,  0.]])
    """
    matrix = input_checks.array("matrix", matrix)
    if matrix.ndim != 2 or matrix.shape[0] != matrix.shape[1] or not matrix.size:
        raise ValueError(f"matrix must be square; received an array of shape {matrix.shape}.")
    nearest = _nearest(matrix)
    if nearest is None:
        n = len(matrix)
        raise ValueError(
            f"no nearest rotation is defined for a matrix of rank below {n - 1}, from which many "
            f"are equally far; received {matrix.tolist()}."
        )
    return nearest


def _nearest(matrix: Array) -> Array | None:
    """The rotation nearest to a matrix (n, n); None for a rank below n - 1."""
    U, sizes, Vt = np.linalg.svd(matrix)
    if not sizes[max(len(sizes) - 2, 0)] > RANK_TOLERANCE * sizes[0]:
        return None
    U[:, -1] *= np.sign(np.linalg.det(U @ Vt))
    return U @ Vt


@dataclass(frozen=True)
class Rn:
    """R^n; elements and velocities have shape (n,). ValueError unless n is at least 1.

    Examples
    --------
    >>> galvi.Rn(2).multiply(np.array([1.0, 2.0]), np.array([0.5, 0.0]))
    array([1.5, 2. ])
    """

    n: int

    def __post_init__(self) -> None:
        object.__setattr__(self, "n", input_checks.whole("n", self.n))

    @property
    def dimension(self) -> int:
        """n."""
        return self.n

    @property
    def shape(self) -> tuple[int, ...]:
        """(n,)."""
        return (self.n,)

    @property
    def layout(self) -> Layout:
        """One factor."""
        return one_factor(rn, self.n, self.n, 0)

    def check(self, name: str, g: Array) -> None:
        """ValueError unless g is (n,)."""
        if g.shape != self.shape:
            raise ValueError(f"{name} must have shape {self.shape}; received shape {g.shape}.")

    def multiply(self, g: Array, k: Array) -> Array:
        """g + k."""
        return g + k

    def inverse(self, g: Array) -> Array:
        """-g."""
        return -g

    def bracket(self, v: Array, w: Array) -> Array:
        """Zero: translations commute."""
        return np.zeros(self.n)


class _Matrices:
    """A group of square matrices under multiplication.

    Attributes
    ----------
    _sizes
        rows of a matrix, dimension of the group, number of leading components of a velocity that
        are rotations
    _kernels
        the module in galvi.kernels.lie.groups of the group
    """

    _sizes: tuple[int, int, int]
    _kernels: ModuleType

    @property
    def dimension(self) -> int:
        """Dimension of the group."""
        return self._sizes[1]

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of one element."""
        return self._sizes[0], self._sizes[0]

    @property
    def layout(self) -> Layout:
        """One factor."""
        rows, dimension, rotations = self._sizes
        return one_factor(self._kernels, dimension, rows * rows, rotations)

    def multiply(self, g: Array, k: Array) -> Array:
        """The matrix product."""
        return g @ k


class _Rotations(_Matrices):
    def check(self, name: str, g: Array) -> None:
        """ValueError unless g is a rotation."""
        check_rotation(name, g, self._sizes[0])

    def inverse(self, g: Array) -> Array:
        """The transpose."""
        return np.swapaxes(g, -1, -2)


class _Motions(_Matrices):
    def check(self, name: str, g: Array) -> None:
        """ValueError unless g is a rigid motion."""
        check_motion(name, g, self._sizes[0] - 1)

    def inverse(self, g: Array) -> Array:
        """[[R^T, -R^T x], [0, 1]]."""
        return inverse_motion(g)


@dataclass(frozen=True)
class SO2(_Rotations):
    """Rotation matrices (2, 2); velocities (1,), R' = R [[0, -v], [v, 0]].

    Examples
    --------
    >>> galvi.SO2().dimension, galvi.SO2().shape
    (1, (2, 2))
    """

    _sizes = (2, 1, 1)
    _kernels = so2

    def bracket(self, v: Array, w: Array) -> Array:
        """Zero: rotations of the plane commute."""
        return np.zeros(1)


@dataclass(frozen=True)
class SO3(_Rotations):
    """Rotation matrices (3, 3) from the body's frame to space.

    Velocities (3,) are the body's angular velocity: R' = R hat(v), hat(v) w = v x w.

    Examples
    --------
    >>> galvi.SO3().bracket(np.array([1.0, 0.0, 0.0]), np.array([0.0, 1.0, 0.0]))
    array([0., 0., 1.])
    """

    _sizes = (3, 3, 3)
    _kernels = so3

    def bracket(self, v: Array, w: Array) -> Array:
        """v x w."""
        return np.cross(v, w)


@dataclass(frozen=True)
class SE2(_Motions):
    """Matrices [[R, x], [0, 1]] of shape (3, 3): a body with attitude R and origin at x.

    Velocities (3,) are the angular velocity and the linear velocity in the body's frame:
    g' = g [[0, -w, v_x], [w, 0, v_y], [0, 0, 0]].

    Examples
    --------
    >>> galvi.SE2().dimension, galvi.SE2().shape
    (3, (3, 3))
    """

    _sizes = (3, 3, 1)
    _kernels = se2

    def bracket(self, v: Array, w: Array) -> Array:
        """(0, J (v_r w_t - w_r v_t)) for v = (v_r, v_t), J = [[0, -1], [1, 0]]."""
        x, y = v[0] * w[1:] - w[0] * v[1:]
        return np.array([0.0, -y, x])


@dataclass(frozen=True)
class SE3(_Motions):
    """Matrices [[R, x], [0, 1]] of shape (4, 4): a body with attitude R and origin at x.

    Velocities (6,) are the angular and the linear velocity in the body's frame:
    g' = g [[hat(w), v], [0, 0]].

    Examples
    --------
    >>> galvi.SE3().dimension, galvi.SE3().shape
    (6, (4, 4))
    """

    _sizes = (4, 6, 3)
    _kernels = se3

    def bracket(self, v: Array, w: Array) -> Array:
        """(v_r x w_r, v_r x w_t - w_r x v_t) for v = (v_r, v_t)."""
        turning = np.cross(v[:3], w[:3])
        return np.concatenate([turning, np.cross(v[:3], w[3:]) - np.cross(w[:3], v[3:])])
