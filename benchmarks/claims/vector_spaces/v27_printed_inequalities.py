"""V27: inequalities as printed: H's Poincare, M's inf-sup constants, and H's reason for nodes."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from functools import partial

import numpy as np
from scipy.linalg import eigvalsh, null_space

import galvi
from benchmarks.claims.kit import Array, Fault, MakeMethod, Problem, Report, always
from benchmarks.claims.vector_spaces.nodal_step import (
    chebyshev_points,
    condition,
    equispaced_points,
    exact_condition,
    lebesgue,
    oscillator_step,
)
from benchmarks.measures.independent_space import all_of_degree, gauss_points, slopes, values

DEGREE = 12  # of the discrete problems: sin(pi t / h) is approximated to 1e-10
LENGTHS = np.array([0.1, 0.5, 1.0, 2.0, 3.0, 3.2, 5.0, 20.0])  # h of Poincare's inequality
STEPS = np.array([0.1, 0.5, 1.0, 1.1, 1.5, 2.0, 2.1, 10.0])  # h of the inf-sup constants
NS, EXACTLY = (4, 5, 6, 8, 10, 12, 16, 20, 24), (4, 6, 8, 10)
FAULTS = {
    "nodes taken for each other": Fault(
        wrong={
            f"{__name__}.chebyshev_points": always(equispaced_points),
            f"{__name__}.equispaced_points": always(chebyshev_points),
        }
    )
}


def measure(make_method: MakeMethod, quick: bool, report: Report) -> dict[str, float]:
    """Numbers on the best constants of both inequalities, for each step and in three ways; then
    those of `of_nodes`."""
    functions, (t, b), ends = all_of_degree(DEGREE), gauss_points(DEGREE + 1), np.array([0.0, 1.0])
    legendre = values(functions, t), slopes(functions, t), b, values(functions, ends)
    table = make_method(galvi.Polynomials(DEGREE), galvi.gauss(DEGREE + 1)).table
    tabulated = (
        np.vstack([np.ones(len(table.b)), table.psi.T]),
        np.vstack([np.zeros(len(table.b)), table.slope.T]),
        table.b,
        np.column_stack([np.eye(DEGREE + 1, 1), np.append(1.0, table.end)]),
    )
    means = closed_form, partial(discrete, *legendre), partial(discrete, *tabulated)
    poincare = np.array([[mean(h)[0] for h in LENGTHS] for mean in means])
    beta = np.array([[mean(h)[1:] for h in STEPS] for mean in means]).transpose(2, 0, 1)
    at_own_end, at_other_end = beta / np.sqrt(STEPS)
    over, short = beta[0, 0] / STEPS, STEPS <= 1.0
    printed, below = poincare[0] * np.pi**2 / LENGTHS**2, np.pi > LENGTHS
    return {
        "least of best constant / (h^2 / pi^2), h < pi": np.min(printed[below]),
        "largest of best constant / (h^2 / pi^2), h > pi": np.max(printed[~below]),
        "largest departure of best constant / (h / pi) from 1, all h and means": np.max(
            abs(poincare / (LENGTHS / np.pi) - 1.0)
        ),
        "largest |v| / |v'| over h, all h and means": np.max(poincare / LENGTHS),
        "poincare": np.max(abs(poincare[1] / poincare[0] - 1.0)),
        "least of beta / h, at the norm's own end, h <= 1": np.min(over[short]),
        "largest of beta / h, at the norm's own end, h > 1": np.max(over[~short]),
        "largest |u(end)| / (sqrt(h) |u|_X), at the norm's own end, all h and means": np.max(
            at_own_end
        ),
        "least |u(end)| / (sqrt(h) |u|_X) of the best u, at the norm's own end, all h and means": (
            np.min(at_own_end)
        ),
        "largest departure of beta / sqrt(h) from 1, at the norm's own end, all h and means": (
            np.max(abs(at_own_end - 1.0))
        ),
        "largest departure of beta / sqrt(2 h) from 1, at the other end, all h and means": np.max(
            abs(at_other_end / np.sqrt(2.0) - 1.0)
        ),
        "inf_sup": np.max(abs(beta[:, 1] / beta[:, 0] - 1.0)),
        **of_nodes(make_method, EXACTLY[:-1] if quick else EXACTLY),
    }


def closed_form(h: float) -> tuple[float, float, float]:
    """|v| / |v'| for v = sin(pi t / h), |u(end)| / |u|_X for u = 1, and for u = h + t at the end h
    with the norm's end at 0."""
    s, b = gauss_points(40)
    square = b @ np.sin(np.pi * s) ** 2 / (b @ (np.pi / h * np.cos(np.pi * s)) ** 2)
    return np.sqrt(square), 1.0 / np.sqrt(1.0 / h), 2.0 * h / np.sqrt(h * np.sum(b) + h)


def discrete(u: Array, du: Array, b: Array, ends: Array, h: float) -> tuple[float, float, float]:
    """The largest |v| / |v'| for v = 0 at both ends, and |u(end)| / |u|_X at the norm's own end and
    at the other one, in the span of functions on [0, 1], for a step h.

    Parameters
    ----------
    u, du
        values and slopes at a rule's nodes, (functions, nodes)
    b
        weights of the rule
    ends
        values at 0 and 1, (functions, 2)
    """
    mass, stiffness, inside = (u * b) @ u.T, (du * b) @ du.T, null_space(ends.T)
    squares = eigvalsh(inside.T @ mass @ inside, inside.T @ stiffness @ inside)
    energy = (stiffness + np.outer(ends[:, 0], ends[:, 0])) / h
    constants = np.sqrt(np.sum(ends * np.linalg.solve(energy, ends), axis=0))
    return h * np.sqrt(squares[-1]), *constants


def of_nodes(make_method: MakeMethod, exactly: Sequence[int]) -> dict[str, float]:
    """Numbers on the conditioning on equispaced points over that on Chebyshev points; and on a step
    h = 1 of the oscillator, in rational arithmetic on both, and by galvi."""
    kinds = chebyshev_points, equispaced_points
    oscillator = galvi.Canonical(1.0, galvi.LinearSpring(1.0))
    conditions, lebesgues = (
        np.array([[of(points(n)) for n in NS] for points in kinds]) for of in (condition, lebesgue)
    )
    exact = np.array([[exact_condition(points(n)) for n in exactly] for points in kinds])
    compared = conditions[:, [NS.index(n) for n in exactly]] / exact
    different, distances = [], []
    for n in exactly:
        rational, again = (oscillator_step(points(n), Fraction(1)) for points in kinds)
        method = make_method(galvi.Polynomials(n - 1), galvi.gauss(n))
        runs = [
            galvi.integrate(Problem(oscillator, np.array([q0]), np.array([v0])), method, 1.0, 1)
            for q0, v0 in ((1.0, 0.0), (0.0, 1.0))
        ]
        by_galvi = np.array([[run.q[-1, 0], run.p[-1, 0]] for run in runs]).T
        different.append(np.sum(rational != again))
        distances.append(np.max(abs(by_galvi - rational.astype(float))))
    return {
        "least of condition of A on equispaced points over Chebyshev ones": np.min(
            conditions[1] / conditions[0]
        ),
        "least of the Lebesgue constant on equispaced points over Chebyshev ones": np.min(
            (lebesgues[1] / lebesgues[0])[1:]
        ),
        "largest relative distance of condition of A from its rational value": np.max(
            abs(compared - 1.0)
        ),
        "exact": np.max(abs(compared - 1.0)),
        "entries of the step's matrix that differ between the two nodes, all n": max(different),
        "distance of galvi's step from it, all n": np.max(distances),
    }
