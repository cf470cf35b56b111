"""Classical names of Nystrom tableaux, found by comparing numbers."""

from __future__ import annotations

import numpy as np

from galvi.arrays import Array
from galvi.spaces.legendre import legendre
from galvi.table import Table


def classical_name(table: Table) -> str:
    """The name of a known method with this tableau, or ''.

    Collocation at Gauss nodes has A = B^2 with B_kj the integral over [0, c_k] of the Lagrange
    basis; the Lobatto pair has A = IIIA IIIB with IIIB_kj = b_j (1 - IIIA_jk / b_k) (Hairer,
    Lubich, Wanner, Geometric Numerical Integration, II.1.4, IV.2.1).
    """
    c, b, stages = table.c, table.b, table.c.size
    if stages > 40:
        return ""
    integrals = _integrals(c)
    ends = c[0] == 0.0 and c[-1] == 1.0
    if ends:
        partner = b * (1.0 - integrals.T / b[:, None])
        if _same(table.A, integrals @ partner) and _same(b, _lobatto_weights(c)):
            return "Stormer-Verlet" if stages == 2 else f"Lobatto IIIA-IIIB, {stages} stages"
        return ""
    zeros = legendre(2.0 * c - 1.0, stages)[:, stages]
    if _same(table.A, integrals @ integrals) and _same(zeros, np.zeros(stages)):
        return "implicit midpoint" if stages == 1 else f"Gauss collocation, {stages} stages"
    return ""


def _integrals(c: Array) -> Array:
    """Integrals over [0, c_k] of the Lagrange basis on c, (s, s)."""
    stages = c.size
    values = legendre(2.0 * c - 1.0, stages)
    integrals = np.column_stack(
        [c] + [(values[:, i + 1] - values[:, i - 1]) / (2 * (2 * i + 1)) for i in range(1, stages)]
    )
    result: Array = integrals @ np.linalg.inv(values[:, :stages])
    return result


def _lobatto_weights(c: Array) -> Array:
    n = c.size - 1
    weights: Array = 1.0 / (n * (n + 1) * legendre(2.0 * c - 1.0, n)[:, n] ** 2)
    return weights


def _same(left: Array, right: Array) -> bool:
    return bool(np.allclose(left, right, rtol=0.0, atol=1e-12))
