"""V13: stationary points are minima, and the action coercive, below a step (H 2.3.5, 2.3.8)."""

from __future__ import annotations

import math
from functools import partial
from typing import Any

import numpy as np
from scipy.linalg import eigh, eigvalsh, null_space
from scipy.optimize import brentq

import galvi
from benchmarks.claims.kit import Array, MakeMethod, Problem, Report
from benchmarks.measures.independent_space import all_of_degree, gauss_points, slopes, values

RATIOS = np.round(np.arange(0.1, 2.4001, 0.05), 10)  # step over the bound for minima
DIRECTIONS = 64  # random variations in addition to the eigenvectors
MIDPOINTS = 400  # midpoints for the integrals of |q| in W11


def measure(make_method: MakeMethod, quick: bool, report: Report) -> dict[str, float]:
    """Steps at which the least eigenvalue of the oscillator is 0, by two rules; then, for the
    oscillator and V = q^4 / 4, the least eigenvalues and second variations over their bounds."""
    method = make_method(galvi.Polynomials(7), galvi.gauss(8))
    few = make_method(galvi.Polynomials(2), galvi.lobatto(3))
    of_rule, of_few = (
        zero(table.psi, table.slope, table.b, table.end[None, :])
        for table in (method.table, few.table)
    )
    functions, (t, b), ends = all_of_degree(7), gauss_points(8), np.array([0.0, 1.0])
    exact = zero(values(functions, t).T, slopes(functions, t).T, b, values(functions, ends).T)
    numbers = {
        "that step over the one of exact integrals, less 1, oscillator": of_rule / exact - 1.0,
        "step where the least eigenvalue is 0, over the bound, a rule of degree 2 s - 1": of_few,
    }
    quartic = galvi.Canonical(
        1.0,
        lambda q: 0.25 * q[0] ** 4,
        lambda q: q**3,
        lambda q: np.array([[3.0 * q[0] ** 2]]),
    )
    cases: dict[str, tuple[Problem, Any, float]] = {
        "oscillator": (galvi.problems.harmonic_oscillator(), np.ones_like, 1.0),
        "quartic potential": (
            Problem(quartic, np.ones(1), np.zeros(1)),
            lambda q: 3.0 * q**2,
            3.0 * 1.05**2,
        ),
    }
    ratios = RATIOS[::2] if quick else RATIOS
    for name, case in cases.items():
        report(name)
        bound, along = math.pi / math.sqrt(case[-1]), partial(along_step, method, *case)
        eigenvalue, form, norm, farthest = np.array([along(h) for h in bound * ratios]).T
        lost, first = np.argmin(eigenvalue > 0.0), math.nan
        if eigenvalue[lost] < 0.0:
            first = brentq(lambda h, along=along: along(h)[0], 0.01, bound * ratios[lost]) / bound
        numbers |= {
            f"least eigenvalue over all steps below the bound, {name}": np.min(
                eigenvalue[ratios < 1.0]
            ),
            f"step where the least eigenvalue is 0, over the bound, {name}": first,
            f"second variation over H (2.22), least below the coercive bound, {name}": np.min(form),
            f"second variation over C_f |dq|^2 in W11, least below the coercive bound, {name}": (
                np.min(norm)
            ),
        }
    return numbers | {"largest |q| at the stages, all steps": np.max(farthest)}


def gram(functions: Array, b: Array) -> Array:
    """The Gram matrix of columns of values, with weights b."""
    return functions.T @ (b[:, None] * functions)


def zero(values: Array, slopes: Array, b: Array, ends: Array) -> float:
    """The h at which the oscillator's least eigenvalue is 0, over pi.

    The functions have `values` and `slopes` at a rule's nodes on [0, 1], and combinations whose
    values `ends` are 0 are varied.
    """
    free = null_space(ends)
    return float(np.sqrt(eigvalsh(gram(slopes @ free, b), gram(values @ free, b))[0]) / np.pi)


def along_step(method: Any, problem: Problem, second: Any, widest: float, h: float) -> list[float]:
    """Numbers of the discrete second variation with fixed ends along a step's curve.

    Returns its least eigenvalue; its least ratios to the form of H (2.22) and to the bound in
    W^{1,1}, infinity for steps on which these claim nothing; and the largest |q| at the stages. NaN
    for a failed run.
    """
    run = galvi.integrate(problem, method, h, 1)
    if not run.success:
        return [math.nan] * 4
    table, space, q = method.table, method.space, run(h * method.rule.nodes)[:, 0]
    free = null_space(table.end[None, :])
    values, slopes, b = table.psi @ free, table.slope @ free / h, h * table.b
    stiffness = gram(slopes, b)
    variation = stiffness - gram(values, b * second(q))
    eigenvalues, vectors = eigh(variation, stiffness)
    form = norm = math.inf
    level = 0.5 * (np.pi / h) ** 2 - widest
    if level > 0.0:
        form = eigvalsh(variation, 0.5 * stiffness + level * gram(values, b))[0]
        random = np.random.default_rng(13).normal(size=(len(variation), DIRECTIONS))
        directions = np.hstack([vectors, random])
        tau = (np.arange(MIDPOINTS) + 0.5) / MIDPOINTS
        fine = space.basis(tau) - space.basis(np.zeros(1)), space.derivative(tau) / h
        sizes = h * sum(np.mean(abs(u[:, 1:] @ free @ directions), axis=0) for u in fine)
        spent = np.sum(directions * (variation @ directions), axis=0)
        norm = np.min(spent / (min(0.25 / h, 0.5 / h * level) * sizes**2))
    return [eigenvalues[0], form, norm, np.max(abs(q))]
