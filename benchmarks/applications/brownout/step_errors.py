"""The errors of the step and of sampling in a cloud's statistics, by degree and number of steps."""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd

from benchmarks.applications.brownout.cloud import DIAMETERS, END_TIME, Cloud
from benchmarks.applications.brownout.cost_at import cost_at
from benchmarks.applications.brownout.statistics import (
    DEPTH,
    HEIGHT,
    ParticleShares,
    particle_shares,
    total,
)
from benchmarks.checks.claim import MakeMethod, Report
from benchmarks.measures.refinement import collocation
from benchmarks.statistics.estimate import Estimate
from benchmarks.store.tables import number, row, series
from benchmarks.store.tables import rows as rows_of

COMPARED_STEPS = {  # degree: numbers of steps
    1: (96, 128, 160, 192, 224, 256, 320, 384),
    2: (48, 56, 64, 80, 96, 128, 192),
    3: (24, 32, 48, 64),
    4: (24, 32, 48, 96),
}
TOO_FEW_STEPS = {1: 48, 2: 24, 3: 16}  # steps that leave grains unsolved
FINEST = (4, 768)
QUICK_FINEST = (4, 384)
WORK = "evaluations of the wind a grain"
UNSOLVED = "grains whose steps were not solved"
SAMPLING, STEP_ERROR, GRAINS = "standard error", "error of the step", "super-particles"


def step_errors(
    make_method: MakeMethod, quick: bool, grains: int, report: Report
) -> list[dict[str, Any]]:
    """Rows of the study of step errors.

    DEPTH and HEIGHT of the finest run with their SAMPLING errors and numbers of GRAINS; for each
    other run the STEP_ERROR of both with its standard error; WORK and UNSOLVED. The statistic is
    named in `study`.
    """
    clouds = {diameter: Cloud(diameter, grains=np.arange(grains)) for diameter in DIAMETERS}
    s, steps = QUICK_FINEST if quick else FINEST
    report(f"statistics, degree {s} in {steps} steps")
    finest, rows = particle_shares(clouds, collocation(make_method, s), steps), []
    for quantity in (DEPTH, HEIGHT):
        statistic = total(finest.shares_in(quantity))
        values = {
            quantity: statistic.value,
            SAMPLING: statistic.uncertainty or 0.0,
            GRAINS: finest.grains,
        }
        rows += rows_of(values, study=quantity)
    for s, steps in (*compared(), *TOO_FEW_STEPS.items()):
        report(f"statistics, degree {s} in {steps} steps")
        run = particle_shares(clouds, collocation(make_method, s), steps)
        columns = {"n": s + 1, "steps": steps, "step": END_TIME / steps}
        rows.append(row(study=UNSOLVED, quantity=UNSOLVED, value=run.unsolved, **columns))
        if TOO_FEW_STEPS.get(s) == steps:
            continue
        columns["status"] = f"{run.unsolved} grains failed" if run.unsolved else ""
        for quantity in (DEPTH, HEIGHT):
            rows += _error_of_step(quantity, run, finest, columns)
        work = run.work / (grains * len(DIAMETERS))
        rows.append(row(study=WORK, quantity=WORK, value=work, **columns))
    return rows


def compared() -> list[tuple[int, int]]:
    """Degree and number of steps of each run."""
    return [(s, steps) for s, step_counts in COMPARED_STEPS.items() for steps in step_counts]


def _error_of_step(
    quantity: str, run: ParticleShares, best: ParticleShares, where: dict[str, Any]
) -> list[dict[str, Any]]:
    """The rows of the error of the step and of its standard error."""
    difference = total(run.shares_in(quantity) - best.shares_in(quantity))
    values = {STEP_ERROR: difference.value, f"{SAMPLING} of it": difference.uncertainty or 0.0}
    return rows_of(values, study=quantity, **where)


def sampling_error(table: pd.DataFrame, quantity: str, grains: float | None = None) -> float:
    """The standard error of a statistic with a number of grains; None: the number of the study."""
    n = number(table, study=quantity, quantity=GRAINS)
    error = number(table, study=quantity, quantity=SAMPLING)
    return error * float(np.sqrt(n / (grains or n)))


def cost_of(table: pd.DataFrame, quantity: str, s: int, level: float) -> Estimate:
    """Evaluations of the wind for each grain at which the error of the step is at the level."""
    steps_and_errors = [
        series(table, "steps", study=study, quantity=name, n=s + 1)[1][::-1]
        for study, name in (
            (WORK, WORK),
            (quantity, STEP_ERROR),
            (quantity, f"{SAMPLING} of it"),
        )
    ]
    return cost_at(level, *steps_and_errors)
