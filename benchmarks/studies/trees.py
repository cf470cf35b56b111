"""Orders of convergence and times of a step on trees: galvi beside MuJoCo's integrators.

The truth is DOP853 on the accelerations that MuJoCo computes, which no integrator here shares.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import pandas as pd

import galvi
from benchmarks.checks.claim import Report
from benchmarks.statistics.repeated_run import net_time
from benchmarks.statistics.timing import interleaved
from benchmarks.store.tables import failure
from benchmarks.work_precision.galvi_methods import gauss_collocation
from benchmarks.work_precision.problem import fixed, galvi_label, largest_difference
from galvi.arrays import Array
from references import Contender
from references.mujoco.accelerations_ivp import MUJOCO_ACCELERATIONS
from references.mujoco.steps import MUJOCO_EULER, MUJOCO_IMPLICITFAST, MUJOCO_RK4

COLUMNS = (
    "problem",
    "contender",
    "order",
    "steps",
    "step",
    "error",
    "unsure",
    "seconds_per_step",
    "status",
)
TIGHT, SECOND_TOLERANCE = 1e-13, 1e-12  # of the truth, and of the run that gives its error
SAMPLES = 5  # times of the errors
TIMING, QUICK_TIMING = (3, 0.02), (1, 0.002)  # rounds of the times, and seconds of each in a round
RK4_STEPS, FIRST_ORDER_STEPS = (100, 200, 400, 800), (1000, 2000, 4000, 8000)
EXPLANATION = (
    "Two conservative motions: an arm of three skew hinges that swings for 0.5 s, and the same arm "
    "on a body that floats for 5 s. The error is the largest of a coordinate at five times, "
    "against DOP853 on the accelerations that MuJoCo computes; its order is fitted, and stands "
    "beside that of theory, which must match the theoretical order. Times of a step are from one "
    "interleaved run of the finest steps, less what a call costs besides; the last column follows "
    "from both, beyond what was run where the error asked for is below the smallest."
)


class Tree(NamedTuple):
    """A conservative tree; counts are galvi's numbers of steps by degree, multiples of SAMPLES."""

    problem: galvi.Problem
    duration: float
    counts: dict[int, tuple[int, ...]]


def trees() -> tuple[Tree, ...]:
    """An arm in gravity, and one on a floating body."""
    arm = {1: (50, 100, 200, 400), 2: (40, 80, 160, 320), 3: (30, 40, 60, 80, 110)}
    floating = {1: (100, 200, 400, 800), 2: (50, 100, 200, 400), 3: (40, 60, 80, 120, 160)}
    return (
        Tree(galvi.problems.skew_arm(), 0.5, arm),
        Tree(galvi.problems.skew_arm(floating=True), 5.0, floating),
    )


def participants(tree: Tree) -> list[tuple[str, Contender, int, tuple[int, ...]]]:
    """Label, contender, order and numbers of steps of each participant."""
    galvi_entries = [
        (galvi_label(degree), gauss_collocation(degree), 2 * degree, counts)
        for degree, counts in tree.counts.items()
    ]
    mujoco = (
        (MUJOCO_EULER, FIRST_ORDER_STEPS),
        (MUJOCO_IMPLICITFAST, FIRST_ORDER_STEPS),
        (MUJOCO_RK4, RK4_STEPS),
    )
    return galvi_entries + [
        (contender.name, contender, contender.order, counts) for contender, counts in mujoco
    ]


def tree_study(quick: bool = False, report: Report = lambda sentence: None) -> pd.DataFrame:
    """A row for each tree, integrator and number of steps; one with the reason without MuJoCo.

    order             theoretical order
    error             largest difference of an entry of the configurations
    unsure            difference of the truth from itself at a looser tolerance
    seconds_per_step  seconds for a step in the run with the most steps; NaN for others
    """
    if MUJOCO_ACCELERATIONS.missing:
        return pd.DataFrame([{"status": MUJOCO_ACCELERATIONS.missing}], columns=list(COLUMNS))
    timed = QUICK_TIMING if quick else TIMING
    rows = [row for tree in trees() for row in _rows(tree, timed, report)]
    return pd.DataFrame(rows, columns=list(COLUMNS))


def truth(tree: Tree) -> tuple[Array, float]:
    """Configurations at the samples, and their largest difference from a looser tolerance."""
    positions, looser = (
        MUJOCO_ACCELERATIONS.run(
            tree.problem, tree.duration, {"samples": SAMPLES, "tolerance": tolerance}
        ).q
        for tolerance in (TIGHT, SECOND_TOLERANCE)
    )
    return positions, largest_difference(positions, looser)


def row(
    tree: Tree, label: str, contender: Contender, order: int, steps: int, true: Array, unsure: float
) -> dict[str, Any]:
    """The row of a run, without its time."""
    step = tree.duration / steps
    setting = {"step": step, "save_every": steps // SAMPLES}
    run = contender.run(tree.problem, tree.duration, setting)
    return {
        "problem": tree.problem.name,
        "contender": label,
        "order": order,
        "steps": steps,
        "step": step,
        "unsure": unsure,
        "seconds_per_step": math.nan,
        "status": failure(run),
        "error": largest_difference(run.q, true) if run.success else math.nan,
    }


def _rows(tree: Tree, timed: tuple[int, float], report: Report) -> list[dict[str, Any]]:
    report(tree.problem.name)
    reference, rows, calls = truth(tree), [], []
    for label, contender, order, counts in participants(tree):
        rows += [row(tree, label, contender, order, steps, *reference) for steps in counts]
        setting = fixed(tree.duration, counts[-1])
        calls.append(net_time(contender, tree.problem, tree.duration, setting, counts[-1]))
    timings = iter(interleaved(calls, *timed))
    for line, following in zip(rows, [*rows[1:], {}], strict=True):
        if following.get("contender") != line["contender"]:  # the finest of its contender
            line["seconds_per_step"] = next(timings).seconds / line["steps"]
    return rows
