"""`warm`: compile in advance the kernels that single runs of galvi's problems call."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from functools import partial
from itertools import product
from typing import Any

import numpy as np
from joblib import cpu_count, delayed

import galvi
from galvi.charts import CHARTS
from reports.build.workers import parallel

SOLVERS = ("auto", "newton")
# Stages fill one SIMD vector or several, of four lanes or eight, and a force on a group is compiled
# separately for each of these cases that the processor uses.
POINT_COUNTS = (4, 8, 12, 16)  # quadrature points of the runs


def warm(report: Callable[[str], None] = print) -> None:
    """Compile the kernels of galvi's problems by runs of two steps, in parallel processes.

    Parameters
    ----------
    report
        called with a sentence on the time of each problem, and with one on the total
    """
    names, start = problem_makers(), time.perf_counter()
    processes = parallel(min(cpu_count(), len(names)), return_as="generator_unordered")
    timings = processes(delayed(warm_problem)(name) for name in names)
    for k, (name, seconds) in enumerate(timings, 1):
        report(f"{k} of {len(names)}: {name}, {seconds:.1f} s")
    report(f"All these kernels are compiled; it took {time.perf_counter() - start:.0f} s.")


def problem_makers() -> dict[str, Callable[[], galvi.Problem]]:
    """Name -> a function that makes the problem, for galvi's problems and two in plain Python."""
    makers = {name: getattr(galvi.problems, name) for name in galvi.problems.__all__}
    makers["functions in Python"] = pendulum_in_python
    makers["a force in Python"] = partial(pendulum_in_python, force=lambda q, v: -0.1 * v)
    return makers


def warm_problem(name: str) -> tuple[str, float]:
    """Run all variants of a problem; returns its name and the seconds that they took."""
    start = time.perf_counter()
    for variant in variants(problem_makers()[name]()):
        run_all(variant)
    return name, time.perf_counter() - start


def pendulum_in_python(**force: Any) -> galvi.Problem:
    """A pendulum in plain Python functions; only the rest of its kernel is compiled."""
    system = galvi.Canonical(1.0, lambda q: -np.cos(q[0]), lambda q: np.sin(q), **force)
    return galvi.Problem(system, [3.0], [0.0])


def variants(problem: galvi.Problem) -> Iterator[galvi.Problem]:
    """The problem, and for point masses also its planar version, which has its own kernel."""
    yield problem
    if isinstance(problem.system, galvi.NBody):
        yield galvi.Problem(problem.system, problem.q0[:, :2], problem.v0[:, :2])


def run_all(problem: galvi.Problem) -> None:
    """Run with every chart, solver and number of points, and evaluate the run's status and its
    energy at and between steps, so that their kernels are compiled, too."""
    step = 1e-2 / max(1.0, abs(problem.v0).max())
    for chart, solver, s in product(CHARTS, SOLVERS, POINT_COUNTS):
        method = galvi.Galerkin(galvi.Polynomials(s), galvi.gauss(s), chart)
        run = galvi.integrate(problem, method, step, 2, solver=solver)
        run.status, galvi.energy(run), galvi.energy(run, run.t[0] + 0.5 * step)
