"""Two bodies from apocentre to apocentre, at eccentricities that fixed steps hardly resolve."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd

import galvi
from benchmarks.applications.external.integrator import ExternalIntegrator
from benchmarks.work_precision.galvi_methods import gauss_collocation, in_clock
from benchmarks.work_precision.participants import label_beside, offered_settings
from benchmarks.work_precision.problems.encounters import clock_label
from galvi import Problem
from galvi.trajectory import COMPLETED
from references.closed_forms.kepler import KEPLER
from references.contender import Contender
from references.rebound import ias15
from references.scipy.ivp import DOP853, TIGHT

COLUMNS = (
    "eccentricity",
    "contender",
    "settings",
    "error",
    "energy_error",
    "evaluations",
    "status",
)
ECCENTRICITIES = (0.9, 0.99, 0.999, 0.999999)
STEPS = (101, 1001, 10_001, 100_001)  # odd, so that the pericentre is in the middle of a step
DEGREES = (4, 8, 16)
TAU = (0.8, 0.4)  # steps in the clock
EXPLANATION = (
    "GM = a = 1, one period from apocentre to apocentre, error against the closed form. Equal "
    "steps must resolve the passage through the pericentre, which lasts about (1 - e)^(3/2) of a "
    "period: at e = 0.999999 a billionth, which no affordable number of equal steps resolves. A "
    "run then stops with a status, or completes with an error of order one or more and a status "
    "that reports the energy error. Such orbits need steps that follow the motion: equal ones in a "
    "clock, here dt = r^(3/2) dtau, or adaptive ones, as two other integrators take."
)


def through_pericentre(eccentricity: float) -> Problem:
    """The Kepler problem with GM = a = 1 from its apocentre, counterclockwise."""
    kepler = galvi.problems.kepler(eccentricity)
    speed = math.sqrt((1.0 - eccentricity) / (1.0 + eccentricity))
    q0, v0 = [-(1.0 + eccentricity), 0.0], [0.0, -speed]
    return Problem(kepler.system, q0, v0, name=kepler.name, parameters=kepler.parameters)


def high_eccentricity_table(
    quick: bool = False,
    report: Callable[[str], None] = lambda sentence: None,
    externals: Sequence[ExternalIntegrator] = (),
) -> pd.DataFrame:
    """One row for each eccentricity, contender and setting; external integrators take part where
    they can.

    error         distance from the closed form at the end, in semi-major axes
    energy_error  at the end, relative
    evaluations   number of force evaluations; NaN where the engine does not count
    status        empty, or the reason for a missing or wrong number
    """
    rows, participants = [], _participants(quick)
    for eccentricity in ECCENTRICITIES:
        problem = through_pericentre(eccentricity)
        report(problem.name)
        end = KEPLER.run(problem, math.tau, {"samples": 1}).q[-1]
        others = [
            (label_beside(external, [label for label, _, _ in participants]), external, setting)
            for external in externals
            for setting in offered_settings(external, problem, math.tau, STEPS[0])
        ]
        for label, contender, setting in (*participants, *others):
            row = {"eccentricity": eccentricity, "contender": label, "settings": _said(setting)}
            rows.append({**row, **_measured(problem, contender, setting, end)})
    return pd.DataFrame(rows, columns=list(COLUMNS))


def _participants(quick: bool) -> list[tuple[str, Contender, Mapping[str, Any]]]:
    steps = STEPS[:-1] if quick else STEPS
    ours = [
        (f"galvi degree {s}, Gauss {s}", gauss_collocation(s),
         {"step": math.tau / n, "save_every": n})
        for s in DEGREES for n in steps
    ]  # fmt: skip
    return [
        *ours,
        *((clock_label(8), in_clock(8, galvi.Sundman()), {"step": h}) for h in TAU),
        ("REBOUND IAS15", ias15.IAS15, {"samples": 1, **ias15.DEFAULT}),
        ("SciPy DOP853", DOP853, {"samples": 1, **TIGHT}),
    ]


def _measured(
    problem: Problem, contender: Contender, setting: Mapping[str, Any], end: Any
) -> dict[str, Any]:
    nan = float("nan")
    blank = {"error": nan, "energy_error": nan, "evaluations": nan}
    if contender.missing:
        return {**blank, "status": contender.missing}
    run = contender.run(problem, math.tau, setting)
    evaluations = float(run.counts.get("force_evaluations", nan))
    if not run.success:
        return {**blank, "evaluations": evaluations, "status": run.status}
    energy = galvi.energy(run)
    return {
        "error": float(np.linalg.norm(run.q[-1] - end)),
        "energy_error": float(abs(energy[-1] / energy[0] - 1.0)),
        "evaluations": evaluations,
        "status": "" if run.status == COMPLETED else run.status,
    }


def _said(setting: Mapping[str, Any]) -> str:
    if "save_every" in setting:
        return f"{setting['save_every']} steps"
    return " ".join(f"{key}={value}" for key, value in setting.items() if key != "samples")
