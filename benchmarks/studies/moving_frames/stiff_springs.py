"""Stiff springs in steps beyond their period: errors and resonances, and energy exchange.

The chain of soft and stiff springs of `benchmarks.test_problems.stiff_springs`, in galvi's harmonic
frame and by two trigonometric methods.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import pandas as pd

import galvi
from benchmarks.statistics.drift import drift
from benchmarks.test_problems.stiff_springs import (
    SPRINGS,
    oscillatory_energies,
    stiff_springs,
    stiffness,
)
from benchmarks.work_precision.galvi_methods import gauss_collocation
from galvi import Problem
from galvi.arrays import Array
from references.scipy.ivp import DOP853, TIGHT
from references.textbook.trigonometric import exponential_integrator, mollified_impulse

COLUMNS = ("study", "contender", "x", "quantity", "value", "evaluations", "status")
RESONANCE, EXCHANGE, LONG = "steps", "exchange", "long"
ERROR, CHANGE, TOTAL = "error at the end", "change of the stiff energy", "change of the energy"
TREND, TREND_ERROR = "trend of the stiff energy", "standard error of that trend"
OMEGA = 50.0
SHORT, QUICK_TURNS, TURNS = 10.0, 20.0, 100.0  # times of errors, and of changes
PICTURE, TRUTH, LONGEST, QUICK_LONGEST = 200.0, 20.0, 10_000.0, 1_000.0
LARGEST, POINTS, QUICK_POINTS = 14.0, 40, 12  # of h omega
LEAST, SMALLEST, FINER, QUICK_FINER = 0.35, 0.02, 12, 4  # h omega of the peers' finer steps
LOOSER = 1e-13  # tolerance at which the truth is compared with itself
STAGES = (2, 4, 8)
FINE, EXCHANGED = 8, 4.0  # stages and h omega of the exchange
PARTS = 200
BOUND = "The error is below ten times that of the truth: take it as a bound."
EXPLANATION = (
    "Hairer, Lubich and Wanner's chain of soft (quartic) and stiff springs, ω = 50, from their "
    "start. Errors at t = 10, against DOP853, and the largest change of the stiff springs' "
    "energy in a longer run, over hω: the true energy changes by 0.06, and what a method adds "
    "is resonance. The harmonic frame turns the stiff springs exactly; what is left feels them, "
    "so that its error grows once they turn by more than about π for each stage, and 2 stages "
    "resonate near multiples of 2π. Mollified impulse and the exponential integrator take one "
    "force a step: their error is of order h^2, whatever ω is. They are measured down to hω = "
    "0.02 (errors only), and the table has the fewest evaluations at which each reaches an "
    "error. Errors under ten times the truth's, which is what DOP853 differs by from itself at "
    "a tolerance of 1e-13, are bounds, and marked. The energies of the three stiff springs are "
    "exchanged over times of order ω. Their sum oscillates, and its largest departures scatter "
    "from one tenth of a long run to the next, since the motion is chaotic; a drift is a trend "
    "of its mean beyond five standard errors. Evaluations are of the force, for a unit of time."
)
Report = Callable[[str], None]


def stiff_spring_study(quick: bool = False, report: Report = lambda sentence: None) -> pd.DataFrame:
    """Errors and changes for each method and step, and the energies of the exchange.

    x            h omega, or the time
    value        of the quantity; of the exchange each spring's energy
    evaluations  of the force in a unit of time
    """
    problem = stiff_springs(OMEGA)
    report("steps beyond the period of stiff springs")
    truth = DOP853.run(problem, TRUTH, {"samples": 2, **TIGHT})
    looser = DOP853.run(problem, TRUTH, {"samples": 2, "tolerance": LOOSER})
    middle, unsure = truth.q[1], _distance(looser.q[1], truth.q[1])
    found: list[dict[str, Any]] = []
    turning = QUICK_TURNS if quick else TURNS
    for step in np.linspace(LEAST, LARGEST, QUICK_POINTS if quick else POINTS):
        for label, contender in contenders().items():
            found += _steps(problem, label, contender, float(step), turning, middle, unsure)
    for step in np.geomspace(SMALLEST, LEAST, QUICK_FINER if quick else FINER, endpoint=False):
        for label, contender in peers().items():
            found += _steps(problem, label, contender, float(step), SHORT, middle, unsure)[:1]
    report("energy exchange of stiff springs")
    return pd.DataFrame(
        [*found, *_exchange(problem, truth), *_long(problem, quick)], columns=list(COLUMNS)
    )


def contenders() -> Mapping[str, Any]:
    """The harmonic frame with several stages, and two trigonometric methods."""
    frames = {
        f"galvi harmonic frame, Gauss {s}": gauss_collocation(s, galvi.HarmonicFrame())
        for s in STAGES
    }
    return frames | peers()


def peers() -> dict[str, Any]:
    """The two trigonometric methods."""
    springs = stiffness(OMEGA)
    return {one.name: one for one in (mollified_impulse(springs), exponential_integrator(springs))}


def _distance(q: Array, true: Array) -> float:
    """The largest difference, of stiff springs times omega."""
    scaled = np.concatenate([np.ones(SPRINGS), np.full(SPRINGS, OMEGA)])
    return float(np.max(np.abs(scaled * (q - true))))


def _steps(
    problem: Problem, label: str, contender: Any, wanted: float, turning: float, true: Array,
    unsure: float,
) -> list[dict[str, Any]]:  # fmt: skip
    """The rows of one method and step, the error first; steps end at SHORT.

    unsure  error of ``true``; an error below ten times this is a bound
    """
    count = max(1, round(SHORT * OMEGA / wanted))
    h = SHORT / count
    run = contender.run(problem, round(turning / SHORT) * SHORT, {"step": h})
    stiff = oscillatory_energies(run.q, run.p, OMEGA).sum(axis=1)
    spent = run.counts["force_evaluations"] / (run.t[-1] - run.t[0])
    known = {"study": RESONANCE, "contender": label, "x": h * OMEGA, "evaluations": spent}
    failed = "" if run.success else run.status
    error, change = _distance(run.q[count], true), float(np.max(np.abs(stiff - stiff[0])))
    return [
        {**known, "quantity": ERROR, "value": error,
         "status": failed or (BOUND if error < 10.0 * unsure else "")},
        {**known, "quantity": CHANGE, "value": change, "status": failed},
    ]  # fmt: skip


def _exchange(problem: Problem, truth: Any) -> list[dict[str, Any]]:
    """The energies of stiff springs up to PICTURE, and the error of one of them at TRUTH."""
    label, count = f"galvi harmonic frame, Gauss {FINE}", round(PICTURE * OMEGA / EXCHANGED)
    contender = contenders()[label]
    every = count // (5 * PARTS)
    run = contender.run(problem, PICTURE, {"step": PICTURE / count, "save_every": every})
    energies = oscillatory_energies(run.q, run.p, OMEGA)
    own = {"study": EXCHANGE, "contender": label, "evaluations": np.nan, "status": run.status}
    rows = [
        {**own, "x": float(t), "quantity": f"I_{k + 1}", "value": float(energies[row, k])}
        for k in range(SPRINGS)
        for row, t in enumerate(run.t)
    ]
    steps = round(TRUTH * OMEGA / EXCHANGED)
    near = contender.run(problem, TRUTH, {"step": TRUTH / steps, "save_every": steps})
    gap = oscillatory_energies(near.q[-1:], near.p[-1:], OMEGA) - oscillatory_energies(
        truth.q[-1:], truth.p[-1:], OMEGA
    )
    return [*rows, {**own, "x": TRUTH, "quantity": ERROR, "value": float(np.max(np.abs(gap)))}]


def _long(problem: Problem, quick: bool) -> list[dict[str, Any]]:
    """The trend of the stiff energy over a long run, and the largest changes in its tenths."""
    label, duration = f"galvi harmonic frame, Gauss {FINE}", QUICK_LONGEST if quick else LONGEST
    count = round(duration * OMEGA / EXCHANGED)
    setting = {"step": duration / count, "save_every": max(1, count // (10 * PARTS))}
    run = contenders()[label].run(problem, duration, setting)
    stiff = oscillatory_energies(run.q, run.p, OMEGA).sum(axis=1)
    total = np.asarray(galvi.energy(run))
    spent = run.counts["force_evaluations"] / duration
    own = {"study": LONG, "contender": label, "evaluations": spent, "status": run.status}
    sum_of = drift(run.t[:-1], (stiff - stiff[0])[:-1])  # the last step may be shorter
    trends = {TREND: sum_of.trend, TREND_ERROR: sum_of.trend_error}
    return [
        {**own, "x": float(run.t[-1]), "quantity": name, "value": sum_of.largest * value}
        for name, value in trends.items()
    ] + [
        {**own, "x": float(run.t[part[-1]]), "quantity": name,
         "value": float(np.max(np.abs(values[part] - values[0])))}
        for name, values in ((CHANGE, stiff), (TOTAL, total))
        for part in np.array_split(np.arange(1, len(run.t)), 10)
    ]  # fmt: skip
