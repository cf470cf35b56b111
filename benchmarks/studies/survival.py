"""Who survives close encounters: planets 50 times as heavy, and Burrau's problem."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd

import galvi
from benchmarks.applications.external.integrator import ExternalIntegrator
from benchmarks.statistics.timing import once
from benchmarks.work_precision.galvi_methods import gauss_collocation, in_clock
from benchmarks.work_precision.participants import label_beside, offered_settings
from benchmarks.work_precision.problem import galvi_label
from benchmarks.work_precision.problems.encounters import clock_label
from galvi import Problem
from galvi.trajectory import COMPLETED
from references.contender import Contender
from references.rebound import ias15, whfast
from references.rebound.mercurius import MERCURIUS
from references.rebound.trace import TRACE
from references.scipy.ivp import DOP853, TIGHT
from references.stored.encounters import YEAR, burrau, heavy_planets

COLUMNS = ("problem", "contender", "settings", "energy_error", "seconds", "success", "status")
YEARS, QUICK_YEARS = 600.0, 60.0
BURRAU = 70.0  # after the lightest body has left, near t = 60
STATES = 500
EXPLANATION = (
    "The outer planets with 50 times their masses over 600 years, in which they meet again and "
    "again; and Burrau's problem, three bodies at rest at the corners of a triangle with sides "
    "3, 4 and 5, in which two of them pass each other at 1e-2 to 1e-4 of their first distance. "
    "Equal steps do not resolve encounters, and WHFast gives no warning. MERCURIUS and TRACE "
    "change to another integrator for them. galvi without a clock takes equal steps too; a run "
    "that cannot be trusted stops and names the bodies and a step that would do, or completes with "
    "a warning in its status. With a clock its steps follow the motion. In both problems "
    "codes disagree on positions, so the energy is compared: at 500 times, and in the clock after "
    "each step, the closest passages included."
)


def survival_table(
    quick: bool = False,
    report: Callable[[str], None] = lambda sentence: None,
    externals: Sequence[ExternalIntegrator] = (),
) -> pd.DataFrame:
    """One row for each problem, contender and setting; external integrators take part.

    energy_error  largest, relative, over ``STATES`` states; in the clock over those of all steps
    seconds       of one run
    success       as the run says
    status        empty, or what the run says beyond that it was completed
    """
    years = QUICK_YEARS if quick else YEARS
    rows = []
    for problem, duration, steps in (
        (heavy_planets(), years * YEAR, (5.0, 20.0)),
        (burrau(), BURRAU, (1e-2, 1e-3)),
    ):
        report(problem.name)
        counts = [-(-round(duration / step) // STATES) * STATES for step in steps]
        known = _participants(problem, duration, counts)
        others = [
            (label_beside(external, [label for label, _, _ in known]), external, setting)
            for external in externals
            for setting in offered_settings(external, problem, duration, counts[0])
        ]
        for label, contender, setting in (*known, *others):
            row = {"problem": problem.name, "contender": label, "settings": _said(setting)}
            rows.append({**row, **_measured(problem, duration, contender, setting)})
    return pd.DataFrame(rows, columns=list(COLUMNS))


def _participants(
    problem: Problem, duration: float, counts: Sequence[int]
) -> list[tuple[str, Contender, Mapping[str, Any]]]:
    fixed: list[tuple[str, Contender, Mapping[str, Any]]] = [
        ("REBOUND MERCURIUS", MERCURIUS, {}),
        ("REBOUND TRACE", TRACE, {}),
        *((galvi_label(s), gauss_collocation(s), {}) for s in (8, 16)),
    ]
    if problem.system.masses.max() > 0.5 * problem.system.masses.sum():  # type: ignore[attr-defined]
        fixed.insert(0, ("REBOUND WHFast, best", whfast.WHFAST, whfast.BEST))
    return [
        *(
            (label, contender,
             {"step": duration / count, "save_every": count // STATES, **options})
            for label, contender, options in fixed
            for count in counts
        ),
        *(
            (clock_label(8), in_clock(8, galvi.DynamicalTime()), {"step": h, "save_every": 1})
            for h in (0.6, 0.3)
        ),
        ("REBOUND IAS15", ias15.IAS15, {"samples": STATES, **ias15.DEFAULT}),
        ("SciPy DOP853", DOP853, {"samples": STATES, **TIGHT}),
    ]  # fmt: skip


def _measured(
    problem: Problem, duration: float, contender: Contender, setting: Mapping[str, Any]
) -> dict[str, Any]:
    nan = float("nan")
    if contender.missing or not contender.supports(problem):
        why = contender.missing or "It does not take this problem."
        return {"energy_error": nan, "seconds": nan, "success": False, "status": why}
    run, seconds = once(lambda: contender.run(problem, duration, setting))
    energy = galvi.energy(run)
    change = np.abs(energy / energy[0] - 1.0)
    return {
        "energy_error": float(np.nanmax(change)),
        "seconds": seconds,
        "success": run.success,
        "status": "" if run.status == COMPLETED else run.status,
    }


def _said(setting: Mapping[str, Any]) -> str:
    if "step" in setting:
        return f"step {setting['step']:.3g}"
    return " ".join(f"{key}={value}" for key, value in setting.items() if key != "samples")
