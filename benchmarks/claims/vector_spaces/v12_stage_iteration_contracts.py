"""V12: H's iteration for the stages contracts (H theorem 2.3.1, lemmas 2.3.1 and 2.3.2).

With m = k = 1 a pass w -> A^-1 f(w) of nodal values is linear with the matrix h^2 D, D the same for
any h. Row 0 of A, H (2.6)-(2.8), is the initial value; rows 1 to n - 1 test with all basis
functions but the last.
"""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np

import galvi
from benchmarks.checks.claim import MakeMethod, Report
from benchmarks.claims.vector_spaces.contraction import passes
from benchmarks.measures.independent_space import (
    gauss_points,
    lagrange_at_chebyshev,
    slopes,
    values,
)
from benchmarks.test_problems.oscillators import NONLINEAR, NonlinearOscillator
from galvi.arrays import Array

NS = (3, 4, 6, 8, 12, 16, 20)
SHOWN = (4, 8, 16)  # n with rows of their own
SIZES = np.arange(0.05, 1.0, 0.05)  # steps below 1
SHARES = (0.5, 0.9)  # of H's bound, for passes of nonlinear oscillators
size = partial(np.linalg.norm, ord=np.inf)


def measure(make_method: MakeMethod, quick: bool, report: Report) -> dict[str, Any]:
    """Extremes over n, and limits over bounds for some n."""
    by_n = {n: numbers_of(make_method(galvi.Polynomials(n - 1), galvi.gauss(2 * n)), n) for n in NS}
    measured = {
        name: (min if name.startswith("least") else max)(numbers[name] for numbers in by_n.values())
        for name in by_n[NS[0]]
        if not name.startswith("measured")
    }
    for name in (name for name in by_n[NS[0]] if name.startswith("measured")):
        measured |= {f"{name}, n = {n}": by_n[n][name] for n in SHOWN}
    return measured


def numbers_of(method: Any, n: int) -> dict[str, float]:
    """The numbers of one n: those of extremes over n, and measured limits."""
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
        "measured limit / bound": limit,
        "measured limit in any norm / bound": np.max(abs(np.linalg.eigvals(D))) ** -0.5 / bound,
        "galvi's pass against H's, largest relative difference, all n": np.max(
            abs(pass_of(method) - D)
        )
        / np.max(abs(D)),
        "galvi.theory's bound over H's formula, largest departure from 1, all n": abs(
            own_bound / bound - 1.0
        ),
    }
    for oscillator in NONLINEAR:
        numbers |= of_nonlinear(oscillator, method, phi, b, inverse, factor * oscillator.lipschitz)
    return numbers


def pass_of(method: Any) -> Array:
    """The matrix of the method's own pass in nodal values, from its tableau, over -h^2 k / m.

    Q = psi x + q0 at the stages, a = -k Q / m, x = h^2 C a, and values at the nodes from x.
    """
    nodes, table = method.space.basis(method.space.nodes), method.table
    coefficients = np.linalg.inv(nodes)
    at_stages = coefficients[:1] + table.psi @ coefficients[1:]
    return -np.asarray((nodes[:, 1:] - nodes[:1, 1:]) @ table.C @ at_stages)


def of_nonlinear(
    oscillator: NonlinearOscillator,
    method: Any,
    phi: Array,
    b: Array,
    inverse: Array,
    factor: float,
) -> dict[str, float]:
    """H's passes A^-1 f(w) for an oscillator with a Lipschitz constant of its own; ``factor`` is
    H's factor of successive passes over h."""
    start: Any = oscillator.problem()
    (q0,), (v0,), n, name = start.q0, start.v0, len(phi), oscillator.name
    bound = min(1.0, 1.0 / factor)

    def stage_pass(w: Array, h: float) -> Array:
        """A^-1 = A_1^-1 diag(1, h, .. h)."""
        forces = h * (phi[:-1] * b) @ oscillator.slope(phi.T @ w) - v0 * np.eye(n - 1)[0]
        return inverse @ np.concatenate([[q0], h * forces])

    ran = {
        share: passes(
            partial(stage_pass, h=share * bound),
            np.full(n, q0),
            lambda w: float(np.max(abs(w))),
            lambda w: phi.T @ w,
        )
        for share in SHARES
    }
    slope = inverse @ np.vstack([np.zeros(2 * n), phi[:-1] * b])
    places = oscillator.places(2 * n)
    steepest = max(size((slope * bend) @ phi.T) for bend in oscillator.curvature(places))
    step = galvi.integrate(start, method, SHARES[-1] * bound, 1, solver="fixed_point")
    limit = steepest**-0.5 / bound
    numbers = {
        f"largest ratio of successive passes over H's factor, {name}, all n": max(
            run.ratio / (share * bound * factor) for share, run in ran.items()
        ),
        f"least of measured limit / bound, {name}, all n": limit,
        f"measured limit / bound, {name}": limit,
        f"galvi's step less the fixed point, {name}, largest over all n": abs(
            step.q[-1, 0] - ran[SHARES[-1]].limit[-1]
        ),
    }
    if np.isfinite(oscillator.radius):
        spread = np.max(np.sum(abs(phi), axis=0))
        reach = max(
            abs(q0) + spread * run.first / (1.0 - share * bound * factor)
            for share, run in ran.items()
        )
        numbers |= {
            f"largest reach of the iterates over rho, {name}, all n": reach / oscillator.radius,
            f"largest |q| of the iterates over rho, {name}, all n": max(
                run.spread for run in ran.values()
            )
            / oscillator.radius,
        }
    return numbers
