"""A Lie group as one group of matrices, by the textbook: to check galvi's own formulas with.

Each factor of an element stands in a block of a block-diagonal matrix: rotations and rigid motions
as they are, x of R^n as [[1, x], [0, 1]]. Group, algebra and charts are then those of matrices.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.linalg import block_diag

from galvi import Cayley
from galvi.arrays import Array
from galvi.charts.chart import Chart
from galvi.groups.group import Group
from galvi.kernels.lie import charts as kinds

SIDES = {kinds.SO2: 2, kinds.SO3: 3, kinds.SE3: 4}
TERMS = 18  # 0.5^18 / 18! is 6e-22


@dataclass(frozen=True)
class MatrixGroup:
    """Of a galvi group; elements go in and out as arrays of ``group.shape``."""

    group: Group

    def matrix(self, g: Array) -> Array:
        """The element as a block-diagonal matrix, (N, N)."""
        blocks, flat = [], np.asarray(g).ravel()
        for kind, n in self.group.layout:
            if kind == kinds.RN:
                block = np.eye(n + 1, dtype=flat.dtype)
                block[:n, n], flat = flat[:n], flat[n:]
            else:
                side = SIDES[kind]
                block, flat = flat[: side**2].reshape(side, side), flat[side**2 :]
            blocks.append(block)
        result: Array = block_diag(*blocks)
        return result

    def element(self, matrix: Array) -> Array:
        """Back to an array of ``group.shape``."""
        parts, first = [], 0
        for kind, n in self.group.layout:
            side = n + 1 if kind == kinds.RN else SIDES[kind]
            block = matrix[first : first + side, first : first + side]
            parts.append(block[:n, n] if kind == kinds.RN else block.ravel())
            first += side
        return np.concatenate(parts).reshape(self.group.shape)

    @cached_property
    def basis(self) -> Array:
        """hat(e_a), (d, N, N)."""
        found, first = [], 0
        total = sum(n + 1 if k == kinds.RN else SIDES[k] for k, n in self.group.layout)
        for kind, n in self.group.layout:
            side = n + 1 if kind == kinds.RN else SIDES[kind]
            turns = {kinds.RN: 0, kinds.SO2: 1, kinds.SO3: 3, kinds.SE3: 3}[int(kind)]
            blocks = [_turn(side, a, turns) for a in range(turns)]
            if kind in (kinds.RN, kinds.SE3):
                for a in range(side - 1):
                    shift = np.zeros((side, side))
                    shift[a, side - 1] = 1.0
                    blocks.append(shift)
            for block in blocks:
                whole = np.zeros((total, total))
                whole[first : first + side, first : first + side] = block
                found.append(whole)
            first += side
        return np.array(found)

    def hat(self, v: Array) -> Array:
        """sum_a v_a hat(e_a), (N, N)."""
        result: Array = np.tensordot(v, self.basis, 1)
        return result

    def vee(self, matrix: Array) -> Array:
        """The v with hat(v) nearest to the matrix, (d,); the basis is orthogonal."""
        scale = np.sum(self.basis**2, axis=(1, 2))
        result: Array = np.tensordot(self.basis, matrix, 2) / scale
        return result

    def moved(self, g: Array, v: Array) -> Array:
        """g exp(hat(v))."""
        return self.element(self.matrix(g) @ exponential(self.hat(v)))

    def chart(self, chart: Chart, g: Array, xi: Array) -> Array:
        """g Phi(xi): the exponential, or (I - hat(xi)/2)^-1 (I + hat(xi)/2)."""
        X, unit = self.hat(xi), np.eye(len(self.basis[0]))
        Phi = np.linalg.solve(unit - X / 2, unit + X / 2) if chart == Cayley() else exponential(X)
        return self.element(self.matrix(g) @ Phi)


def exponential(X: Array) -> Array:
    """exp(X) of a small matrix: Taylor's series of X / 2^k, squared k times; no use of threads."""
    halvings = max(0, int(np.ceil(np.log2(max(np.linalg.norm(X), 1e-300)))) + 1)
    part = X / 2.0**halvings
    result = term = np.eye(len(X))
    for k in range(1, TERMS):
        term = term @ part / k
        result = result + term
    for _ in range(halvings):
        result = result @ result
    return result


def _turn(side: int, axis: int, turns: int) -> Array:
    i, j = (0, 1) if turns == 1 else ((axis + 1) % 3, (axis + 2) % 3)
    turn = np.zeros((side, side))
    turn[j, i], turn[i, j] = 1.0, -1.0
    return turn
