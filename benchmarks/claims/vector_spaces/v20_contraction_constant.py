"""V20: M's iteration contracts by eta C_N^2 at most (M theorems 1 and 2, proposition 1)."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from scipy.linalg import eigvalsh

import galvi
from benchmarks.claims.kit import Array, MakeMethod, Report
from benchmarks.claims.vector_spaces import contraction
from benchmarks.measures.independent_space import (
    all_of_degree,
    friedrichs,
    gauss_points,
    grams,
    inf_sup,
    kernels,
    lobatto_points,
    values,
    z0,
)
from benchmarks.test_problems import oscillators

DEGREES = (1, 2, 3, 4, 6, 8, 12, 16)
# Name -> (galvi's rule, the same by numpy, k, l) of rules with k N + l points.
RULES: dict[str, tuple[Any, Any, int, int]] = {
    "Gauss N": (galvi.gauss, gauss_points, 1, 0),
    "Gauss 2 N": (galvi.gauss, gauss_points, 2, 0),
    "Lobatto N + 1": (galvi.lobatto, lobatto_points, 1, 1),
    "Lobatto N": (galvi.lobatto, lobatto_points, 1, 0),
}
SHARES = (0.25, 0.5, 0.99)  # step over M's bound, for runs of the oscillator
SHARE = 0.9  # step over M's bound, for passes of nonlinear oscillators
FAULTS = contraction.FAULTS


def measure(make_method: MakeMethod, quick: bool, report: Report) -> dict[str, float]:
    """The extremes over all rules and degrees, and z0 by polynomials of degree 16."""
    numbers = []
    for name, (rule, points, factor, offset) in RULES.items():
        for degree in DEGREES[1 if name == "Lobatto N" else 0 :]:
            number = factor * degree + offset
            method = make_method(galvi.Polynomials(degree), rule(number))
            numbers.append(numbers_of(method, name, degree, *points(number)))
    exact = grams(all_of_degree(16), *gauss_points(40))
    measured = contraction.extremes(numbers)
    constant = measured["least inf-sup constant over all spaces and rules"]
    return measured | {
        "departure of that from 1 / sqrt(2)": abs(constant - math.sqrt(0.5)),
        "z0 from Friedrichs' inequality, polynomials of degree 16": eigvalsh(
            exact.values, exact.energy
        )[-1]
        ** -0.5,
    }


def numbers_of(method: Any, rule: str, degree: int, t: Array, b: Array) -> dict[str, float]:
    """The numbers of one rule and degree."""
    table, functions = method.table, all_of_degree(degree)
    gram, (starts, ends) = grams(functions, t, b), kernels(functions)
    constant = friedrichs(gram)
    square = 3.0 * constant**2 / z0() ** 2  # eta C_N^2 at h^2 K / m = 1
    root = np.linalg.cholesky(starts.T @ gram.energy @ starts).T
    left = ends.T @ gram.slope @ starts
    linear = np.linalg.solve(left, ends.T @ gram.values @ starts)  # M (5), u = starts x
    slopes = table.slope.T @ (table.b[:, None] * table.slope)
    of_table = np.linalg.cholesky(slopes + np.outer(table.end, table.end)).T
    contracted = size(of_table @ table.C @ table.psi, of_table)
    radius = np.max(abs(np.linalg.eigvals(table.A)))
    runs = [
        galvi.integrate(
            galvi.problems.harmonic_oscillator(),
            method,
            share / math.sqrt(square),
            2,
            solver="fixed_point",
        )
        for share in SHARES
    ]
    numbers = {
        "largest C_N over all spaces and rules": constant,
        "galvi.theory's C_N over numpy's, largest departure from 1": abs(
            method.theory().friedrichs / constant - 1.0
        ),
        f"largest contraction of a pass over eta C_N^2, {rule}": contracted / square,
        "contraction of galvi's pass less that of M's linear problem, over h^2 K / m, largest": abs(
            contracted - size(root @ linear, root)
        ),
        "least inf-sup constant over all spaces and rules": inf_sup(functions, gram),
        "least step where passes stop to converge, over M's bound": (square / radius) ** 0.5
        if radius > 0.0
        else math.inf,
        "runs by fixed-point iteration below the bound that fail": sum(
            not run.success for run in runs
        ),
    }
    back, phi = starts @ np.linalg.inv(root), values(functions, np.append(t, [0.0, 1.0]))
    onto = root @ np.linalg.solve(left, ends.T)
    passes = contraction.Iteration(
        (onto @ phi)[:, :-2] * b, (phi.T @ back)[:-2], onto @ phi[:, -2], phi[:, -1] @ back, 2
    )
    for oscillator in oscillators.NONLINEAR:
        bound = 1.0 / math.sqrt(square * oscillator.lipschitz)
        run = passes.run(oscillator, method, SHARE * bound, SHARE**2)
        name = oscillator.name
        numbers |= {
            f"largest ratio of successive passes over eta C_N^2, {name}": run["ratio"],
            f"least measured limit over M's bound, {name}": passes.limit(oscillator) / bound,
            f"largest galvi's step less the fixed point, {name}": run["apart"],
        }
        if math.isfinite(oscillator.radius):
            numbers |= {
                f"largest reach of the iterates over rho, {name}": run["reach"],
                f"largest |q| of the iterates over rho, {name}": run["spread"],
            }
    return numbers


def size(mapped: Any, root: Any) -> float:
    """The norm of a linear map where |x| = |root x|_2; `mapped` is root times its matrix."""
    return float(np.linalg.norm(mapped @ np.linalg.inv(root), 2))
