"""Gaussian elimination of a mass matrix in heyoka's expressions."""

from __future__ import annotations

from typing import Any


def solved(M: list[list[Any]], b: list[Any]) -> list[Any]:
    """x with M x = b, by elimination without pivoting, as M is positive definite."""
    n = len(b)
    M, b = [list(row) for row in M], list(b)
    for k in range(n):
        for i in range(k + 1, n):
            ratio = M[i][k] / M[k][k]
            for j in range(k + 1, n):
                M[i][j] = M[i][j] - ratio * M[k][j]
            b[i] = b[i] - ratio * b[k]
    x: list[Any] = [None] * n
    for i in reversed(range(n)):
        known = sum((M[i][j] * x[j] for j in range(i + 1, n)), 0.0)
        x[i] = (b[i] - known) / M[i][i]
    return x
