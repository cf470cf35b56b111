"""The Lagrangian of a chain of hinged links that swings in a plane."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from galvi import input_checks
from galvi.arrays import Array, read_only
from galvi.kernels.forces.planar_chain import compiled_planar_chain_states, planar_chain


@dataclass(frozen=True, eq=False)
class PlanarChain:
    """L(q, v) of n links, q (n,) their angles from hanging down, as on ``galvi.Rn(n)``.

    Parameters
    ----------
    masses : array, shape (n,)
        of the links, starting at the fixed pivot
    lengths : array, shape (n,)
        of the links, in the same order
    gravity
        downward acceleration; zero for none
    rods
        False: each mass is a point at the lower end of its weightless link, as in the double
        pendulum of the textbooks; True: each link is a uniform thin rod

    Raises
    ------
    ValueError
        For a mass or length that is not positive.

    Notes
    -----
    With M_i the mass below link i, L = sum_ij A_ij cos(q_i - q_j) v_i v_j / 2 + sum_i B_i cos(q_i).
    Points: A_ij = l_i l_j (m_k + M_k), where k is the larger of i and j; B_i = g l_i (m_i + M_i).
    Rods: A_ii = l_i^2 (m_i / 3 + M_i), else A_ij = l_i l_j (m_k / 2 + M_k); B_i = g l_i (m_i / 2 +
    M_i).

    Examples
    --------
    >>> rods = galvi.PlanarChain(masses=(1.0, 1.0), lengths=(1.0, 0.5), rods=True)
    >>> system = galvi.Lagrangian(rods, galvi.Rn(2))
    >>> galvi.Problem(system, q0=[1.0, 1.5], v0=[0.0, 0.0]).p0
    array([0., 0.])
    """

    masses: Any
    lengths: Any
    gravity: float = 9.81
    rods: bool = False

    def __post_init__(self) -> None:
        masses = _positive("masses", self.masses)
        object.__setattr__(self, "masses", masses)
        object.__setattr__(self, "lengths", _positive("lengths", self.lengths, masses.shape))
        object.__setattr__(self, "gravity", input_checks.real("gravity", self.gravity))
        input_checks.flag("rods", self.rods)
        object.__setattr__(self, "rods", bool(self.rods))

    @cached_property
    def numbers(self) -> Array:
        """The coefficients A by rows, then B, (n n + n,)."""
        m, l, n = self.masses, self.lengths, self.masses.size
        below = np.append(np.cumsum(m[::-1])[::-1][1:], 0.0)
        lever_share, inertia_share = (0.5, 1.0 / 3.0) if self.rods else (1.0, 1.0)
        lever = lever_share * m + below
        farther = np.maximum.outer(np.arange(n), np.arange(n))
        A = np.outer(l, l) * lever[farther]
        A[np.diag_indices(n)] = l**2 * (inertia_share * m + below)
        return read_only(np.concatenate([A.ravel(), self.gravity * l * lever]))

    def __call__(self, q: Array, v: Array, *t: Any) -> float:
        n = self.masses.size
        A, B = self.numbers[: n * n].reshape(n, n), self.numbers[n * n :]
        return float(0.5 * v @ (A * np.cos(np.subtract.outer(q, q))) @ v + B @ np.cos(q))

    def slopes(self, q: Array, v: Array, *t: Any) -> Array:
        """dL/dv, then dL/dq, (2 n,)."""
        out = np.empty((2, self.masses.size))
        planar_chain.py_func(
            np.asarray(q), np.asarray(v), 0.0, self.numbers, out
        )  # compiling it takes a second
        return out.ravel()

    def at_states(self, q: Array, v: Array, t: Array) -> tuple[Array, Array, Array]:
        out = np.empty(len(v)), np.empty(len(v)), np.empty(v.shape)
        compiled_planar_chain_states()(q, v, self.numbers, *out)
        return out

    def compiled(self) -> tuple[Callable[..., Any], Array]:
        """As `BuiltinLagrangian.compiled`, with `numbers` for constants."""
        return planar_chain, np.array(self.numbers)


def _positive(name: str, value: Any, shape: tuple[int, ...] | None = None) -> Array:
    numbers = input_checks.array(name, value, shape, "Give one for each link.")
    if numbers.ndim != 1 or numbers.size == 0 or np.any(numbers <= 0.0):
        raise ValueError(
            f"{name} must be positive numbers, one for each link; received {numbers.tolist()}."
        )
    return numbers
