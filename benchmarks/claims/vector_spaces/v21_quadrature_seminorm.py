"""V21: the rule's seminorm against the norm of u' (M (12), section 5)."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.polynomial.legendre import legvander
from scipy.linalg import eigvalsh

import galvi
from benchmarks.claims.kit import Array, MakeMethod, Report
from benchmarks.measures.independent_space import all_of_degree, gauss_points, slopes, values

DEGREES = range(2, 9)
RULES: dict[str, Callable[[int], galvi.Rule]] = {
    "Gauss N": galvi.gauss,
    "Gauss N + 1": lambda N: galvi.gauss(N + 1),
    "Lobatto N + 1": lambda N: galvi.lobatto(N + 1),
    "Lobatto N": galvi.lobatto,
}


def measure(make_method: MakeMethod, quick: bool, report: Report) -> dict[str, float]:
    """Extremes of the ratio over polynomials of degree N, for each rule."""
    ratios = {
        name: np.array([extremes(make_method(galvi.Polynomials(N), rule(N)), N) for N in DEGREES])
        for name, rule in RULES.items()
    }
    smallest, largest = ratios.pop("Lobatto N").T
    gauss, lobatto = (
        np.array(
            [
                means_of_legendre(make_method(galvi.Polynomials(1), rule(M)), degree(M))
                for M in DEGREES
            ]
        )
        for rule, degree in (
            (galvi.gauss, lambda M: 2 * M - 1),
            (galvi.lobatto, lambda M: 2 * M - 3),
        )
    )
    attained = np.sqrt(2.0 + 1.0 / (np.array(DEGREES) - 1.0))
    exact = "largest mean of a Legendre polynomial of degree 1 to"
    beyond = "least mean of the one of degree"
    return {
        f"{exact} 2 M - 1, Gauss M nodes": np.max(gauss[:, 0]),
        f"{exact} 2 M - 3, Lobatto M nodes": np.max(lobatto[:, 0]),
        f"{beyond} 2 M, Gauss M nodes": np.min(gauss[:, 1]),
        f"{beyond} 2 M - 2, Lobatto M nodes": np.min(lobatto[:, 1]),
        "departure of the largest ratio from sqrt(2 + 1 / (N - 1)), Lobatto N nodes": np.max(
            abs(largest - attained)
        ),
        "least ratio over all N, Lobatto N nodes": np.min(smallest),
        **{f"largest ratio, Lobatto N nodes, N = {N}": largest[N - 2] for N in (2, 3, 4)},
        **{
            f"largest departure of the ratio from 1, {name} nodes": np.max(abs(of_rule - 1.0))
            for name, of_rule in ratios.items()
        },
    }


def means_of_legendre(method: Any, degree: int) -> tuple[float, float]:
    """The largest |mean|, by the method's rule, of the Legendre polynomials of degrees 1 to
    `degree` on [0, 1], whose integrals are 0; and the |mean| of the next one."""
    means = abs(method.table.b @ legvander(2.0 * method.table.c - 1.0, degree + 1))
    return float(np.max(means[1:-1])), float(means[-1])


def extremes(method: Any, N: int) -> Array:
    """The smallest and the largest ratio of the rule's seminorm and the norm of slopes, (2,).

    They are square roots of eigenvalues of the table's Gram matrix of slopes relative to the exact
    one, which is computed by numpy from the polynomials with the values of the basis.
    """
    t, b = gauss_points(N)
    nodes, polynomials = np.linspace(0.0, 1.0, N + 1), all_of_degree(N)
    parts = np.linalg.solve(values(polynomials, nodes).T, method.space.basis(nodes))
    exact, slope = slopes(polynomials, t).T @ parts[:, 1:], method.table.slope
    gram = slope.T @ (method.table.b[:, None] * slope)
    return np.sqrt(eigvalsh(gram, exact.T @ (b[:, None] * exact))[[0, -1]])
