"""Interface of groups, their elements as matrices, and the checks of these."""

from __future__ import annotations

from collections.abc import Hashable
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from galvi import input_checks
from galvi.arrays import Array
from galvi.kernels.lie.product import GROUPS

Layout = npt.NDArray[np.int64]


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
        """(factors, 4): number of each factor's group in the kernels, its dimension, entries and
        rotations; see galvi.kernels.lie.product."""

    def check(self, name: str, g: Array) -> None:
        """Raise ValueError unless g is an element of the group to within 1e-9."""

    def multiply(self, g: Array, k: Array) -> Array:
        """g k, for elements with any leading axes."""

    def inverse(self, g: Array) -> Array:
        """g^-1, for elements with any leading axes."""

    def bracket(self, v: Array, w: Array) -> Array:
        """[v, w] in the algebra, (d,): hat([v, w]) = hat(v) hat(w) - hat(w) hat(v)."""


def one_factor(kernel: Any, dimension: int, entries: int, rotations: int) -> Layout:
    """The layout of a group that is not a product.

    kernel     its module of galvi.kernels.lie.groups
    entries    number of entries of one element
    rotations  number of leading components of a velocity that are rotations
    """
    return np.array([[GROUPS.index(kernel), dimension, entries, rotations]])


def is_group(value: Any) -> bool:
    """Whether the value is a group, not a class of groups."""
    return hasattr(value, "layout") and not isinstance(value, type)


CLOSE = 1e-9
RANK = 1e-14  # singular values below this share of the largest count as 0


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
    if not defect <= CLOSE or determinant < 0.0:
        what = f"|R^T R - I| = {defect:.1e}" if defect > CLOSE else f"determinant {determinant:.3g}"
        nearest = _nearest(R)
        remedy = (
            "Give a matrix with orthonormal columns."
            if nearest is None
            else f"The nearest rotation is {nearest.round(6).tolist()}, from "
            f"galvi.nearest_rotation."
        )
        raise ValueError(
            f"{name} must be a rotation, R^T R = I with determinant 1, to {CLOSE:g}; received "
            f"{what}. {remedy}"
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


def _conversion(given: Array, n: int) -> str:
    """How four or seven numbers, perhaps a quaternion, become a matrix of space; else empty."""
    if n != 3 or given.shape not in ((4,), (7,)):
        return ""
    return (
        " A quaternion with the scalar last becomes a rotation matrix by "
        "scipy.spatial.transform.Rotation.from_quat(quaternion).as_matrix()."
    )


def inverse_motion(g: Array) -> Array:
    """[[R^T, -R^T x], [0, 1]] for rigid motions with any leading axes."""
    n, result = g.shape[-1] - 1, np.zeros_like(g)
    transpose = np.swapaxes(g[..., :n, :n], -1, -2)
    result[..., :n, :n] = transpose
    result[..., :n, n] = -(transpose @ g[..., :n, n:])[..., 0]
    result[..., n, n] = 1.0
    return result


def nearest_rotation(matrix: Array) -> Array:
    """The rotation R that is closest to ``matrix`` (n, n) in the Frobenius norm.

    R = U diag(1, ..., 1, det(U V^T)) V^T from the singular value decomposition U S V^T (Kabsch,
    Acta Cryst. A32 (1976) 922). Raises ValueError for a matrix that is not square, not finite, or
    of rank below n - 1, for which the nearest rotation is not unique.
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
    U, sizes, Vt = np.linalg.svd(matrix)
    if not sizes[max(len(sizes) - 2, 0)] > RANK * sizes[0]:
        return None
    U[:, -1] *= np.sign(np.linalg.det(U @ Vt))
    return U @ Vt
