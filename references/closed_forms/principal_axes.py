"""Principal moments and axes of a body in 80-digit arithmetic."""

from __future__ import annotations

from itertools import combinations
from typing import Any

import numpy as np

from galvi.extended_precision import decimals
from references.closed_forms.decimal_trigonometry import SMALLEST

SWEEPS = 20


def principal_axes(inertia: Any) -> tuple[Any, Any]:
    """Moments (3,), ascending, and axes as columns of an orthogonal (3, 3), by Jacobi's method.

    inertia  (3, 3) symmetric, of decimals; call inside ``localcontext(DIGITS)``

    Those of a diagonal matrix are its own, exactly.
    """
    J, axes = inertia.copy(), decimals(np.eye(3))
    size = max(abs(J.ravel()))
    for _ in range(SWEEPS):
        if max(abs(J[i, j]) for i, j in combinations(range(3), 2)) < SMALLEST * size:
            break
        for i, j in combinations(range(3), 2):
            if J[i, j]:
                turn = _rotation(J, i, j)
                J, axes = turn.T @ J @ turn, axes @ turn
    order = sorted(range(3), key=lambda k: J[k, k])
    return J.diagonal()[order], axes[:, order]


def _rotation(J: Any, i: int, j: int) -> Any:
    """The plane rotation, by at most an eighth of a turn, that makes J_ij zero."""
    half = (J[j, j] - J[i, i]) / (2 * J[i, j])
    tangent = 1 / (abs(half) + (half * half + 1).sqrt()) * (1 if half >= 0 else -1)
    cosine = 1 / (tangent * tangent + 1).sqrt()
    turn = decimals(np.eye(3))
    turn[i, i] = turn[j, j] = cosine
    turn[i, j], turn[j, i] = tangent * cosine, -tangent * cosine
    return turn
