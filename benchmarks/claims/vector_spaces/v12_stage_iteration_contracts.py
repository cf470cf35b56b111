"""V12: H's iteration for the stages contracts (H theorem 2.3.1, lemmas 2.3.1 and 2.3.2).

With m = k = 1 a pass w -> A^-1 f(w) of nodal values is linear with the matrix h^2 D, D the same for
any h. Row 0 of A, H (2.6)-(2.8), is the initial value; rows 1 to n - 1 test with all basis
functions but the last.
"""

from __future__ import annotations

import math
from functools import partial
from typing import Any

import numpy as np

import galvi
from benchmarks.claims.kit import Array, MakeMethod, Report
from benchmarks.claims.vector_spaces import contraction
from benchmarks.measures.independent_space import (
    gauss_points,
    lagrange_at_chebyshev,
    slopes,
    values,
)
from benchmarks.test_problems import oscillators

NS = (3, 4, 6, 8, 12, 16, 20)
SHOWN_NS = (4, 8, 16)  # n that have rows of their own
SIZES = np.arange(0.05, 1.0, 0.05)  # step sizes below 1
SHARES = (0.5, 0.9)  # step over H's bound, for passes of nonlinear oscillators
FAULTS = contraction.FAULTS
size = partial(np.linalg.norm, ord=np.inf)


def measure(make_method: MakeMethod, quick: bool, report: Report) -> dict[str, Any]:
    """The extremes over all n of the numbers of each n."""
    return contraction.extremes(
        [numbers_of(make_method(galvi.Polynomials(n - 1), galvi.gauss(2 * n)), n) for n in NS]
    )


def numbers_of(method: Any, n: int) -> dict[str, Any]:
    """The numbers of one n, of which `measure` takes extremes; for n in SHOWN_NS also its
    limits."""
    basis, (t, b) = lagrange_at_chebyshev(n - 1), gauss_points(2 * n)
    phi, dphi = values(basis, t), slopes(basis, t)
    mass, stiffness = (phi * b) @ phi.T, (dphi * b) @ dphi.T
    inverses = [np.linalg.inv(np.vstack([np.eye(1, n), stiffness[:-1] / h])) for h in (1.0, *SIZES)]
    inverse = inverses[0]
    D = inverse @ np.vstack([np.zeros(n), mass[:-1]])
    factor = size(inverse) * np.max(np.sum(abs(phi), axis=0) * np.max(abs(phi[:-1]), axis=0))
    bound = min(1.0, 1.0 / factor)
    own_bound = method.theory(galvi.problems.harmonic_oscillator(), lipschitz=1.0).stage_step
    limit = size(D) ** -0.5 / bound
    numbers = {
        "least singular value of A_1 over all n": 1.0 / np.linalg.norm(inverse, 2),
        "largest |A^-1| at h < 1 over |A_1^-1|, all n": max(map(size, inverses[1:]))
        / size(inverse),
        "least of measured limit / bound, all n": limit,
        "galvi's pass against H's, largest relative difference, all n": np.max(
            abs(pass_of(method) - D)
        )
        / np.max(abs(D)),
        "galvi.theory's bound over H's formula, largest departure from 1, all n": abs(
            own_bound / bound - 1.0
        ),
    }
    if n in SHOWN_NS:
        spectral = np.max(abs(np.linalg.eigvals(D))) ** -0.5 / bound
        numbers[f"measured limit / bound, n = {n}"] = limit
        numbers[f"measured limit in any norm / bound, n = {n}"] = spectral
    pull = inverse @ np.vstack([np.zeros(2 * n), phi[:-1] * b])
    passes = contraction.Iteration(pull, phi.T, inverse[:, 1], np.eye(n)[-1], np.inf)
    for oscillator in oscillators.NONLINEAR:
        slower = factor * oscillator.lipschitz
        bound, name = min(1.0, 1.0 / slower), oscillator.name
        limit = passes.limit(oscillator) / bound
        runs = [passes.run(oscillator, method, h, h * slower) for h in bound * np.array(SHARES)]
        largest = contraction.extremes(runs)
        numbers |= {
            f"largest ratio of successive passes over H's factor, {name}, all n": largest["ratio"],
            f"least of measured limit / bound, {name}, all n": limit,
            f"galvi's step less the fixed point, {name}, largest over all n": runs[-1]["apart"],
        }
        if n in SHOWN_NS:
            numbers[f"measured limit / bound, {name}, n = {n}"] = limit
        if math.isfinite(oscillator.radius):
            reach, spread = largest["reach"], largest["spread"]
            numbers[f"largest reach of the iterates over rho, {name}, all n"] = reach
            numbers[f"largest |q| of the iterates over rho, {name}, all n"] = spread
    return numbers


def pass_of(method: Any) -> Array:
    """The matrix of the method's own pass in nodal values, from its tableau, over -h^2 k / m.

    Q = psi x + q0 at the stages, a = -k Q / m, x = h^2 C a, and values at the nodes from x.
    """
    nodes, table = method.space.basis(method.space.nodes), method.table
    coefficients = np.linalg.inv(nodes)
    at_stages = coefficients[:1] + table.psi @ coefficients[1:]
    return -np.asarray((nodes[:, 1:] - nodes[:1, 1:]) @ table.C @ at_stages)
