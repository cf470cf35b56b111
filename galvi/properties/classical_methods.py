"""Classical names of Nystrom tableaux, found by comparing numbers."""

from __future__ import annotations

import numpy as np

from galvi.arrays import Array
from galvi.spaces.legendre import legendre
from galvi.tableau import Tableau

MOST = 65  # largest number of stages for which collocation matrices are computed in float64
VERLET = ("Stormer-Verlet", "velocity Verlet", "leapfrog", "Newmark, beta = 0, gamma = 1/2")


def classical_name(table: Tableau) -> str:
    """The best known name of the method with this tableau, or ''."""
    return next(iter(classical_names(table)), "")


def classical_names(table: Tableau) -> tuple[str, ...]:
    """Names of known methods with this tableau, the best known first.

    These are partitioned Runge-Kutta pairs a, a^ for positions and velocities, A = a a^: a is
    collocation at the nodes c, a_kj the integral over [0, c_k] of the Lagrange basis on c, and
    a^_kj = b_j (1 - a_jk / b_k) makes the pair symplectic (Hairer, Lubich, Wanner, Geometric
    Numerical Integration, II.1.4, IV.2.1, VI.4.1). At Gauss's nodes a^ = a, at Lobatto's it is
    IIIB. At Radau's it is IA from the left, whose a is Radau I, and II from the right, whose a is
    IIA (Hairer and Wanner, Solving ODEs II, IV.5). One stage at an end is symplectic Euler.
    """
    whole = _names(table.c, table.b, table.A)
    return whole or _in_substeps(table)


def _names(c: Array, b: Array, A: Array) -> tuple[str, ...]:
    stages = c.size
    if stages > MOST:
        return ()
    integrals = _integrals(c)
    partner = b * (1.0 - integrals.T / b[:, None])
    values = legendre(2.0 * c - 1.0, stages)
    here, before = values[:, stages], values[:, stages - 1]
    collocation = _same(b, _interpolatory(values[:, :stages])) and _same(A, integrals @ partner)
    if not collocation:
        return ()
    count = f"{stages} stages" if stages > 1 else "1 stage"
    if _same(here, 0.0 * here):
        first = ("implicit midpoint",) if stages == 1 else ()
        return (*first, f"Gauss collocation, {count}")
    if c[0] == 0.0 and c[-1] == 1.0 and _same(b, _lobatto_weights(c)):
        return (*(VERLET if stages == 2 else ()), f"Lobatto IIIA-IIIB, {count}")
    if c[-1] == 1.0 and _same(here, before):
        first = ("symplectic Euler, position first",) if stages == 1 else ()
        return (*first, f"Radau IIA-II, {count}")
    if c[0] == 0.0 and _same(here, -before):
        first = ("symplectic Euler, velocity first",) if stages == 1 else ()
        return (*first, f"Radau I-IA, {count}")
    return ()


def _in_substeps(table: Tableau) -> tuple[str, ...]:
    """Names of a method that consists of several equal steps of a known one."""
    c, b, A = table.c, table.b, table.A
    for steps in range(2, c.size + 1):
        own = c.size // steps
        if c.size % steps == 0:
            one = steps * c[:own], steps * b[:own], steps**2 * A[:own, :own]
            names = _names(*one) if one[0][-1] <= 1.0 else ()
            if names and all(map(_same, (c, b, A), _repeated(*one, steps))):
                return tuple(f"{steps} steps of {name}" for name in names)
    return ()


def _repeated(c: Array, b: Array, A: Array, steps: int) -> tuple[Array, Array, Array]:
    """The tableau of ``steps`` equal steps of a method, with the total length as unit.

    The kick b_j of a step acts on stage c_k of the d-th step after it for d + c_k - c_j steps.
    """
    stages = c.size
    first = np.arange(steps)
    lag = (first[:, None] - first[None, :])[:, None, :, None]
    felt = (lag + c[:, None, None] - c) * b
    blocks = np.where(lag > 0, felt, np.where(lag == 0, A[None, :, None, :], 0.0))
    whole = blocks.reshape(steps * stages, steps * stages) / steps**2
    return (first[:, None] + c).ravel() / steps, np.tile(b, steps) / steps, whole


def _integrals(c: Array) -> Array:
    """Integrals over [0, c_k] of the Lagrange basis on c, (s, s)."""
    stages = c.size
    values = legendre(2.0 * c - 1.0, stages)
    integrals = np.column_stack(
        [c] + [(values[:, i + 1] - values[:, i - 1]) / (2 * (2 * i + 1)) for i in range(1, stages)]
    )
    result: Array = integrals @ np.linalg.inv(values[:, :stages])
    return result


def _interpolatory(values: Array) -> Array:
    """Interpolatory weights at nodes with these values (s, s) of the Legendre polynomials."""
    weights: Array = np.linalg.inv(values)[0]
    return weights


def _lobatto_weights(c: Array) -> Array:
    n = c.size - 1
    weights: Array = 1.0 / (n * (n + 1) * legendre(2.0 * c - 1.0, n)[:, n] ** 2)
    return weights


def _same(left: Array, right: Array) -> bool:
    return bool(np.allclose(left, right, rtol=0.0, atol=1e-12))
