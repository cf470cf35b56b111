"""What a step costs: iterations, force evaluations, which solver, seconds."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import pandas as pd

import galvi
from benchmarks.statistics.timing import interleaved, warmed
from galvi import Problem, Trajectory

COLUMNS = (
    "problem",
    "method",
    "order",
    "step",
    "steps",
    "solver",
    "iterations_per_step",
    "forces_per_step",
    "force_evaluations",
    "hessian_evaluations",
    "linear_solves",
    "seconds_per_step",
    "status",
)
ROUNDS = 3


def cost_table(
    quick: bool = False, report: Callable[[str], None] = lambda sentence: None
) -> pd.DataFrame:
    """One row for each problem and method; a step is as long as the setting is meant to be used.

    Counts are exact for a build and machine. ``forces_per_step`` counts one configuration each, and
    ``solver`` says what solved the stage equations: the fixed point, Newton, or both. The seconds
    are those of a whole run over its steps.
    """
    cases, runs, calls, warm = _cases(quick), [], [], []
    for problem, method, step, steps in cases:
        report(f"{problem.name}: {method.name}")

        def call(problem: Problem = problem, method: Any = method, step: float = step,
                 steps: int = steps) -> Trajectory:  # fmt: skip
            return galvi.integrate(problem, method, step, steps, save_every=steps)

        run, seconds = warmed(call)
        runs.append(run)
        calls.append(call)
        warm.append(seconds)
    timings = interleaved(calls, ROUNDS, 0.01 if quick else 0.1, warm)
    return pd.DataFrame(
        [
            _row(*case, run, timing.seconds)
            for case, run, timing in zip(cases, runs, timings, strict=True)
        ],
        columns=list(COLUMNS),
    )


def _cases(quick: bool) -> list[tuple[Problem, galvi.Galerkin, float, int]]:
    """Gauss collocation at useful steps, and H's own methods at H's steps."""
    oscillator, kepler = galvi.problems.harmonic_oscillator(), galvi.problems.kepler(0.6)
    planets = galvi.problems.solar_system()
    steps = 1000 if quick else 10_000
    return [
        *((kepler, _gauss(s), math.tau / k, steps) for s, k in ((2, 256), (4, 64), (8, 24))),
        (kepler, _gauss(16), math.tau / 8, steps),
        *((planets, _gauss(s), h, steps) for s, h in ((4, 4.0), (8, 8.0), (16, 32.0))),
        (oscillator, _papers(16), 20.0, 1000),
        (oscillator, _papers(24), 20.0, 1000),
        (kepler, _papers(8), 2.0, 1000),
        (kepler, _papers(32), 2.0, 1000),
        (planets, _papers(25), 100.0, 100),
    ]


def _gauss(degree: int) -> galvi.Galerkin:
    return galvi.Galerkin(galvi.Polynomials(degree), galvi.gauss(degree))


def _papers(n: int) -> galvi.Galerkin:
    """H's choice: n basis functions, Gauss with 2 n points."""
    return galvi.Galerkin(galvi.Polynomials(n - 1), galvi.gauss(2 * n))


def _row(
    problem: Problem, method: galvi.Galerkin, step: float, steps: int, run: Trajectory,
    seconds: float,
) -> dict[str, Any]:  # fmt: skip
    counts, done = run.counts, max(1, run.counts["steps"])
    return {
        "problem": problem.name,
        "method": method.name,
        "order": method.order,
        "step": step,
        "steps": steps,
        "solver": _solver(counts, method.stages),
        "iterations_per_step": counts["iterations"] / done,
        "forces_per_step": counts["force_evaluations"] / done,
        "force_evaluations": counts["force_evaluations"],
        "hessian_evaluations": counts["hessian_evaluations"],
        "linear_solves": counts["linear_solves"],
        "seconds_per_step": seconds / done if run.success else float("nan"),
        "status": "" if run.success else run.status,
    }


def _solver(counts: Any, stages: int) -> str:
    """Newton's passes evaluate the Hessian at each stage; the others are fixed-point passes."""
    newton = counts["hessian_evaluations"] / stages
    if not newton:
        return "fixed point"
    return "Newton" if newton == counts["iterations"] else "Newton and fixed point"
