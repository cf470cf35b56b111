"""The groups of rotations and rigid motions, of the plane and of space; and R^n."""

from __future__ import annotations

from dataclasses import dataclass

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


@dataclass(frozen=True)
class SO2:
    """Rotation matrices (2, 2); velocities (1,), R' = R [[0, -v], [v, 0]]."""

    @property
    def dimension(self) -> int:
        """1."""
        return 1

    @property
    def shape(self) -> tuple[int, ...]:
        """(2, 2)."""
        return (2, 2)

    @property
    def layout(self) -> Layout:
        """One factor."""
        return one_factor(so2, 1, 4, 1)

    def check(self, name: str, g: Array) -> None:
        """ValueError unless g is a rotation of the plane."""
        check_rotation(name, g, 2)

    def multiply(self, g: Array, k: Array) -> Array:
        """The matrix product."""
        return g @ k

    def inverse(self, g: Array) -> Array:
        """The transpose."""
        return np.swapaxes(g, -1, -2)

    def bracket(self, v: Array, w: Array) -> Array:
        """Zero: rotations of the plane commute."""
        return np.zeros(1)


@dataclass(frozen=True)
class SO3:
    """Rotation matrices (3, 3) from the body's frame to space.

    Velocities (3,) are the body's angular velocity: R' = R hat(v), hat(v) w = v x w.
    """

    @property
    def dimension(self) -> int:
        """3."""
        return 3

    @property
    def shape(self) -> tuple[int, ...]:
        """(3, 3)."""
        return (3, 3)

    @property
    def layout(self) -> Layout:
        """One factor."""
        return one_factor(so3, 3, 9, 3)

    def check(self, name: str, g: Array) -> None:
        """ValueError unless g is a rotation of space."""
        check_rotation(name, g, 3)

    def multiply(self, g: Array, k: Array) -> Array:
        """The matrix product."""
        return g @ k

    def inverse(self, g: Array) -> Array:
        """The transpose."""
        return np.swapaxes(g, -1, -2)

    def bracket(self, v: Array, w: Array) -> Array:
        """v x w."""
        return np.cross(v, w)


@dataclass(frozen=True)
class SE2:
    """Matrices [[R, x], [0, 1]] of shape (3, 3): a body with attitude R and origin at x.

    Velocities (3,) are the angular velocity and the linear velocity in the body's frame:
    g' = g [[0, -w, v_x], [w, 0, v_y], [0, 0, 0]].
    """

    @property
    def dimension(self) -> int:
        """3."""
        return 3

    @property
    def shape(self) -> tuple[int, ...]:
        """(3, 3)."""
        return (3, 3)

    @property
    def layout(self) -> Layout:
        """One factor."""
        return one_factor(se2, 3, 9, 1)

    def check(self, name: str, g: Array) -> None:
        """ValueError unless g is a rigid motion of the plane."""
        check_motion(name, g, 2)

    def multiply(self, g: Array, k: Array) -> Array:
        """The matrix product."""
        return g @ k

    def inverse(self, g: Array) -> Array:
        """[[R^T, -R^T x], [0, 1]]."""
        return inverse_motion(g)

    def bracket(self, v: Array, w: Array) -> Array:
        """(0, J (v_r w_t - w_r v_t)) for v = (v_r, v_t), J = [[0, -1], [1, 0]]."""
        x, y = v[0] * w[1:] - w[0] * v[1:]
        return np.array([0.0, -y, x])


@dataclass(frozen=True)
class SE3:
    """Matrices [[R, x], [0, 1]] of shape (4, 4): a body with attitude R and origin at x.

    Velocities (6,) are the angular and the linear velocity in the body's frame:
    g' = g [[hat(w), v], [0, 0]].
    """

    @property
    def dimension(self) -> int:
        """6."""
        return 6

    @property
    def shape(self) -> tuple[int, ...]:
        """(4, 4)."""
        return (4, 4)

    @property
    def layout(self) -> Layout:
        """One factor."""
        return one_factor(se3, 6, 16, 3)

    def check(self, name: str, g: Array) -> None:
        """ValueError unless g is a rigid motion."""
        check_motion(name, g, 3)

    def multiply(self, g: Array, k: Array) -> Array:
        """The matrix product."""
        return g @ k

    def inverse(self, g: Array) -> Array:
        """[[R^T, -R^T x], [0, 1]]."""
        return inverse_motion(g)

    def bracket(self, v: Array, w: Array) -> Array:
        """(v_r x w_r, v_r x w_t - w_r x v_t) for v = (v_r, v_t)."""
        turning = np.cross(v[:3], w[:3])
        return np.concatenate([turning, np.cross(v[:3], w[3:]) - np.cross(w[:3], v[3:])])
