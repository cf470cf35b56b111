"""Errors of the stages' first guess, by body: `python -m benchmarks.experiments.solver_ideas`.

Shows why `galvi.fast.lanes.nbody` first iterates one planet with its star, and why the
extrapolation uses one earlier step and not two.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

import galvi
from benchmarks.measures.orbit_shape import period
from galvi import Problem
from galvi.arrays import Array
from galvi.spaces.polynomials import legendre

STEPS, STAGES, PER_ORBIT = 60, 8, 8.3


def start_errors(problem: Problem) -> tuple[Array, Array]:
    """Errors of the first stages relative to the distance from the origin, (bodies,) each.

    Extrapolated from the accelerations of one and of two earlier steps; geometric mean over the
    steps, each step and body with the optimal number of Legendre terms.
    """
    method = galvi.Galerkin(galvi.Polynomials(STAGES), galvi.gauss(STAGES))
    step = period(problem, 1) / PER_ORBIT
    run = galvi.integrate(problem, method, step, STEPS, progress=False)
    c, A = method.table.c, step**2 * method.table.A
    field: Any = problem.system
    a = np.stack([[field.acceleration(q, 0.0) for q in run((k + c) * step)] for k in range(STEPS)])
    found = []
    for k in range(2, STEPS):
        size = np.linalg.norm(run.q[k], axis=-1)

        def error(guess: Array, k: int = k, size: Array = size) -> Array:
            moved = np.einsum("ij,jbx->ibx", A, guess - a[k])
            worst: Array = np.abs(moved).max(axis=(0, 2)) / size
            return worst

        one = _best(error, 2.0 * c - 1.0, 2.0 * c + 1.0, a[k - 1])
        two = _best(error, np.concatenate([c - 1.0, c]), c + 1.0, np.concatenate(a[k - 2 : k]))
        found.append((one, two))
    means = np.exp(np.mean(np.log(found), axis=0))
    return means[0], means[1]


def _best(error: Callable[[Array], Array], nodes: Array, ahead: Array, a: Array) -> Array:
    """The smallest error of polynomials of every degree, fitted at the nodes."""
    errors = []
    for terms in range(1, len(nodes) + 1):
        fit = legendre(ahead, terms - 1) @ np.linalg.pinv(legendre(nodes, terms - 1))
        errors.append(error(np.einsum("ij,jbx->ibx", fit, a)))
    smallest: Array = np.min(errors, axis=0)
    return smallest


if __name__ == "__main__":
    for problem in (
        galvi.problems.outer_solar_system(),
        galvi.problems.solar_system(pluto=False),
    ):
        print(problem.name, f"- {STAGES} stages, {PER_ORBIT} steps in the first planet's period")
        names: Any = problem.parameters["bodies"]
        for name, one, two in zip(names, *start_errors(problem), strict=False):
            print(f"  {name:24s} from one step {one:.0e}, from two {two:.0e}")
