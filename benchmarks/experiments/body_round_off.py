"""Random walk or drift of the energy of bodies: `python -m benchmarks.experiments.body_round_off`.

An ensemble of runs whose starts differ by 1e-12, so that each rounds differently. Unbiased rounding
makes a random walk of the energy, whose RMS grows as the square root of the steps (Brouwer 1937);
a bias, however small, grows as the steps. Methods are so fine that truncation is below rounding.
"""

from __future__ import annotations

import sys

import numpy as np
import pandas as pd

import galvi
from benchmarks.statistics.drift import Growth, growth
from benchmarks.work_precision.galvi_methods import gauss_collocation
from galvi import Galerkin, Problem
from galvi.charts import CHARTS

RUNS, STEPS, SAMPLES = 16, 1_000_000, 500
SIZE, SEED = 1e-12, 1937
NEWTON_SHARE = 10  # as many times fewer steps with Newton's method, which takes so much longer
BODIES = (
    (galvi.problems.free_rigid_body, 12, 0.5),
    (galvi.problems.free_body_se3, 12, 0.25),
    (galvi.problems.heavy_top, 10, 0.05),
)  # problem, degree and step


def energy_growth(
    problem: Problem,
    method: Galerkin,
    step: float,
    steps: int = STEPS,
    runs: int = RUNS,
    solver: str = "auto",
) -> Growth:
    """The growth of the relative energy error with the number of steps."""
    generator, errors = np.random.default_rng(SEED), []
    for _ in range(runs):
        v0 = problem.v0 * (1.0 + SIZE * generator.standard_normal(problem.v0.shape))
        moved = Problem(problem.system, problem.q0, v0)
        every = max(1, steps // SAMPLES)
        run = galvi.integrate(moved, method, step, steps, save_every=every, solver=solver)
        if not run.success:
            raise RuntimeError(f"{problem.name}, {method}: {run.status}")
        energy = galvi.energy(run)
        errors.append(energy / energy[0] - 1.0)
    return growth(run.t[1:] / step, np.array(errors)[:, 1:])


def body_round_off_table(steps: int = STEPS, runs: int = RUNS) -> pd.DataFrame:
    """A row for each body, chart and solver; drifts are relative, of the energy, in each step."""
    rows = []
    for make, degree, step in BODIES:
        problem = make()
        for chart in CHARTS:
            method = gauss_collocation(degree, chart).method
            for solver, share in (("auto", 1), ("newton", NEWTON_SHARE)):
                found = energy_growth(problem, method, step, steps // share, runs, solver)
                rows.append(
                    {
                        "body": problem.name,
                        "degree": degree,
                        "step": step,
                        "chart": chart.name,
                        "solver": solver,
                        "steps": steps // share,
                        "drift": found.drift,
                        "its standard error": found.drift_uncertainty,
                        "RMS at the end": found.final,
                        "exponent": found.exponent,
                        "+-": found.uncertainty,
                    }
                )
    return pd.DataFrame(rows)


if __name__ == "__main__":
    asked = int(float(sys.argv[1])) if len(sys.argv) > 1 else STEPS
    print(body_round_off_table(asked).to_string(index=False, float_format="{:.2g}".format))
