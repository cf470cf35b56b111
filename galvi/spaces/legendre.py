"""Legendre polynomials and their integrals, for floats and decimals."""

from __future__ import annotations

from typing import Any

import numpy as np


def legendre(x: Any, degree: int) -> Any:
    """P_0 .. P_degree at x of shape (k,), as an array (k, degree + 1).

    (l + 1) P_{l+1} = (2 l + 1) x P_l - l P_{l-1}; stable for x in [-1, 1].
    """
    columns = [x * 0 + 1, x]
    for n in range(1, degree):
        columns.append(((2 * n + 1) * x * columns[n] - n * columns[n - 1]) / (n + 1))
    return np.stack(columns[: degree + 1], axis=-1)


def integrals(t: Any, count: int) -> Any:
    """The integrals of P_0(2 s - 1) .. P_{count - 1}(2 s - 1) over s in [0, t], (k, count).

    t of shape (k,); the integral of P_l is (P_{l+1} - P_{l-1})(2 t - 1) / (2 (2 l + 1)).
    """
    P = legendre(2 * t - 1, count)
    columns = [t]
    for n in range(1, count):
        columns.append((P[:, n + 1] - P[:, n - 1]) / (2 * (2 * n + 1)))
    return np.stack(columns[:count], axis=-1)
