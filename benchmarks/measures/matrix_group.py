"""A Lie group as a matrix group, by textbook formulas, to check galvi's own formulas.

Each factor of an element stands in a block of a block-diagonal matrix: rotations and rigid motions
as they are, x of R^n as [[1, x], [0, 1]]. Group, algebra and charts are then those of matrices.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from math import isqrt

import numpy as np
from scipy.linalg import block_diag

from galvi import Cayley, Exponential, ModifiedRodrigues
from galvi.arrays import Array
from galvi.charts.chart import Chart
from galvi.groups.group import Group

TAYLOR_TERMS = 18  # 0.5^18 / 18! is 6e-22


@dataclass(frozen=True)
class MatrixGroup:
    """The matrix group of a galvi group; elements are arrays of ``group.shape``."""

    group: Group

    def matrix(self, g: Array) -> Array:
        """The element as a block-diagonal matrix, (N, N)."""
        blocks, entries_left = [], np.asarray(g).ravel()
        for _, d, entries, rotations in self.group.layout:
            part, entries_left = entries_left[:entries], entries_left[entries:]
            if rotations:
                block = part.reshape(isqrt(entries), -1)
            else:
                block = np.eye(d + 1, dtype=entries_left.dtype)
                block[:d, d] = part
            blocks.append(block)
        return block_diag(*blocks)

    def element(self, matrix: Array) -> Array:
        """The element, an array of ``group.shape``, of a block-diagonal matrix."""
        parts, first = [], 0
        for _, d, entries, rotations in self.group.layout:
            side = isqrt(entries) if rotations else d + 1
            block = matrix[first : first + side, first : first + side]
            parts.append(block.ravel() if rotations else block[:d, d])
            first += side
        return np.concatenate(parts).reshape(self.group.shape)

    @cached_property
    def basis(self) -> Array:
        """hat(e_a), (d, N, N)."""
        generators, first = [], 0
        layout = self.group.layout
        total = sum(isqrt(r) if turns else d + 1 for _, d, r, turns in layout)
        for _, d, entries, turns in layout:
            side = isqrt(entries) if turns else d + 1
            blocks = [_rotation_generator(side, a, turns) for a in range(turns)]
            if d > turns:
                for a in range(side - 1):
                    shift = np.zeros((side, side))
                    shift[a, side - 1] = 1.0
                    blocks.append(shift)
            for block in blocks:
                generator = np.zeros((total, total))
                generator[first : first + side, first : first + side] = block
                generators.append(generator)
            first += side
        return np.array(generators)

    def hat(self, v: Array) -> Array:
        """sum_a v_a hat(e_a), (..., N, N) for v (..., d)."""
        return np.tensordot(v, self.basis, 1)

    def vee(self, matrix: Array) -> Array:
        """The v with hat(v) nearest to the matrix, (d,); the basis is orthogonal."""
        scale = np.sum(self.basis**2, axis=(1, 2))
        return np.tensordot(self.basis, matrix, 2) / scale

    def moved(self, g: Array, v: Array) -> Array:
        """g exp(hat(v))."""
        return self.element(self.matrix(g) @ exponential(self.hat(v)))

    def chart(self, chart: Chart, g: Array, xi: Array) -> Array:
        """g Phi(xi), with Phi from `MAPS`."""
        return self.element(self.matrix(g) @ MAPS[chart](self.hat(xi)))


def cayley(X: Array) -> Array:
    """(I - X/2)^-1 (I + X/2), for matrices (..., N, N)."""
    unit = np.eye(X.shape[-1])
    return np.linalg.solve(unit - X / 2, unit + X / 2)


def exponential(X: Array) -> Array:
    """exp(X) by the Taylor series of X / 2^k, squared k times."""
    halvings = max(0, int(np.ceil(np.log2(max(np.linalg.norm(X), 1e-300)))) + 1)
    part = X / 2.0**halvings
    matrix = term = np.eye(len(X))
    for k in range(1, TAYLOR_TERMS):
        term = term @ part / k
        matrix = matrix + term
    for _ in range(halvings):
        matrix = matrix @ matrix
    return matrix


MAPS: dict[Chart, Callable[[Array], Array]] = {
    Cayley(): cayley,
    Exponential(): exponential,
    ModifiedRodrigues(): lambda X: cayley(X / 2) @ cayley(X / 2),
}


def _rotation_generator(side: int, axis: int, rotations: int) -> Array:
    i, j = (0, 1) if rotations == 1 else ((axis + 1) % 3, (axis + 2) % 3)
    turn = np.zeros((side, side))
    turn[j, i], turn[i, j] = 1.0, -1.0
    return turn
