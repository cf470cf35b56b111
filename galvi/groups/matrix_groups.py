"""The groups of rotations and rigid motions, of the plane and of space; and R^n."""

from __future__ import annotations

from dataclasses import dataclass
from types import ModuleType

import numpy as np

from galvi import input_checks
from galvi.arrays import Array
from galvi.groups.group import Layout, check_motion, check_rotation, inverse_motion, one_factor
from galvi.kernels.lie.groups import rn, se2, se3, so2, so3


@dataclass(frozen=True)
class Rn:
    """R^n; elements and velocities have shape (n,). ValueError unless n is at least 1."""

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
        """Zero."""
        return np.zeros(self.n)


class _Matrices:
    """Square matrices under multiplication: their rows, the dimension, and the number of leading
    components of a velocity that are rotations."""

    _sizes: tuple[int, int, int]
    _kernels: ModuleType

    @property
    def dimension(self) -> int:
        """Of the group."""
        return self._sizes[1]

    @property
    def shape(self) -> tuple[int, ...]:
        """Of an element."""
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
    """Rotation matrices (2, 2); velocities (1,), R' = R [[0, -v], [v, 0]]."""

    _sizes = (2, 1, 1)
    _kernels = so2

    def bracket(self, v: Array, w: Array) -> Array:
        """Zero: rotations of the plane commute."""
        return np.zeros(1)


@dataclass(frozen=True)
class SO3(_Rotations):
    """Rotation matrices (3, 3) from the body's frame to space.

    Velocities (3,) are the body's angular velocity: R' = R hat(v), hat(v) w = v x w.
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
    """

    _sizes = (4, 6, 3)
    _kernels = se3

    def bracket(self, v: Array, w: Array) -> Array:
        """(v_r x w_r, v_r x w_t - w_r x v_t) for v = (v_r, v_t)."""
        turning = np.cross(v[:3], w[:3])
        return np.concatenate([turning, np.cross(v[:3], w[3:]) - np.cross(w[:3], v[3:])])
