"""Robots' arms with skew hinges, and a grain of sand in a rotor's wind."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import galvi
from benchmarks.work_precision.entries import Entry, compared, galvi_entries, general_kernel
from benchmarks.work_precision.participants import readable_setting
from benchmarks.work_precision.problem import (
    COORDINATES,
    MOTION,
    Truth,
    WorkPrecisionProblem,
    adaptive,
    largest_difference,
)
from galvi import Problem
from references.mujoco.accelerations_ivp import MUJOCO_ACCELERATIONS
from references.mujoco.steps import (
    DEFAULT_STEP,
    MUJOCO_DISCRETE,
    MUJOCO_EULER,
    MUJOCO_IMPLICIT,
    MUJOCO_IMPLICITFAST,
    MUJOCO_RK4,
)
from references.scipy.ivp import DOP853, ODE45
from references.scipy.ivp import TIGHT as TIGHTEST

TIGHT, SECOND_TOLERANCE = 1e-13, 1e-12  # of the truth, and of the run that gives its error
RK4_STEPS, FIRST_ORDER_STEPS = (200, 800, 3200, 12_800), (2000, 16_000)
FIRST_ORDER = (MUJOCO_EULER, MUJOCO_IMPLICIT, MUJOCO_IMPLICITFAST, MUJOCO_DISCRETE)


def skew_arm(quick: bool) -> WorkPrecisionProblem:
    """Three links on skew hinges that swing in gravity for some two turns."""
    steps = {4: (100, 200, 400), 6: (80, 100, 140), 8: (50, 70, 100)}
    return _arm(galvi.problems.skew_arm(), 2.0, quick, steps, COORDINATES)


def floating_arm(quick: bool) -> WorkPrecisionProblem:
    """The same arm on a body that floats without weight."""
    steps = {4: (50, 100, 200, 400), 6: (50, 70, 100), 8: (40, 50, 70)}
    return _arm(galvi.problems.skew_arm(floating=True), 10.0, quick, steps, MOTION)


def _arm(
    problem: Problem,
    duration: float,
    quick: bool,
    counts: Mapping[int, Sequence[int]],
    quantity: str,
) -> WorkPrecisionProblem:
    """galvi, MuJoCo's integrators, and DOP853 on MuJoCo's accelerations, which is the truth."""

    def truth() -> Truth:
        end, coarser = (
            MUJOCO_ACCELERATIONS.run(problem, duration, {"samples": 1, "tolerance": tolerance}).q[
                -1
            ]
            for tolerance in (TIGHT, SECOND_TOLERANCE)
        )
        name = MUJOCO_ACCELERATIONS.name
        description = f"{name}, tolerance {TIGHT:g}; by its difference from {SECOND_TOLERANCE:g}"
        (run,) = adaptive("tolerance", (TIGHT,))
        source = (name, readable_setting(run))
        return Truth(end, largest_difference(end, coarser), description, source)

    entries = [
        *galvi_entries(counts, stops_early_too=True),
        Entry(MUJOCO_RK4, (*RK4_STEPS, round(duration / DEFAULT_STEP))),
        *(Entry(contender, FIRST_ORDER_STEPS) for contender in FIRST_ORDER),
        Entry(MUJOCO_ACCELERATIONS, (1e-6, 1e-9, 1e-11, TIGHT)),
    ]
    return compared(problem, duration, quick, entries, truth, quantity=quantity, net_time=True)


GRAIN_DURATION = 2.0  # half of the grain's
GRAIN_STEPS = {2: (50, 100, 200), 4: (50, 100, 200), 6: (50, 100)}
GRAIN_TRUTH_ERROR = 2e-14  # m; from truths with tolerances 3, 10 and 30 times looser


def brownout(quick: bool) -> WorkPrecisionProblem:
    """A grain of 100 micrometres."""
    problem = galvi.problems.brownout()

    def truth() -> Truth:
        run = DOP853.run(problem, GRAIN_DURATION, {"samples": 1, **TIGHTEST})
        return Truth(run.q[-1], GRAIN_TRUTH_ERROR, f"{DOP853.name} at rtol={TIGHTEST['rtol']:g}")

    entries = [
        *galvi_entries(GRAIN_STEPS),
        general_kernel(4, GRAIN_STEPS[4]),
        *(Entry(contender, (1e-6, 1e-9), quick_values=slice(1)) for contender in (DOP853, ODE45)),
    ]
    return compared(
        problem, GRAIN_DURATION, quick, entries, truth, quantity=COORDINATES, net_time=True
    )
