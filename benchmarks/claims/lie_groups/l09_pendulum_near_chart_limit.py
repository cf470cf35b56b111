"""L9: the 3D pendulum from upside down, in steps that near the chart's limit (H 3.8 and 3.9)."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np

import galvi
from benchmarks.claims.kit import (
    CAYLEY,
    ORACLES,
    DataFrame,
    Fault,
    MakeMethod,
    Measurement,
    Problem,
    Report,
    failure,
    fewer,
    history,
    method_on_group,
    number,
    readings,
    row,
    table_of,
    times,
    with_arguments,
)
from benchmarks.claims.lie_groups.pendulum_motion import TRUTH, oracles
from benchmarks.claims.lie_groups.steps_near_the_limit import (
    LOOSE_OPTIONS,
    NEAR_ANGLE,
    STEP,
    STEPS_PER_RUN,
    TURN,
    WIDER_CHARTS,
    N,
    read_steps,
    single_steps,
)
from benchmarks.measures.errors import PER_STEP, curve_times, energy_errors
from benchmarks.measures.rigid_invariants import turns
from galvi.charts import CHARTS

STEPS = 200  # H gives no number
HELD, LIGHT, HEAVY = (21.0, 22.0, 23.0), 9.81, 29.43
DRAWN = 22.0  # m g of the run in the figures
WEIGHTS = (5.0, 8.0, LIGHT, 12.0, 15.0, 18.0, 20.0, *HELD, *range(24, 31))
QUICK_WEIGHTS = (LIGHT, 20.0, *HELD, 24, 26, 30)
ENERGY, DONE = "energy error", "steps done"
CURVE, ENDS = "centre of mass on the curve", "centre of mass at step ends"
SHOWN = 50  # steps whose curve is in the table
GROWTH, UPSIDE_DOWN, HANGING = "growth of the distance of two starts", "upside down", "hanging"
SYMMETRIC, MOMENTS = f"{UPSIDE_DOWN}, symmetric body", (4.8, 4.8, 3.8)
LARGEST, FARTHEST = f"largest {ENERGY}", f"largest {TURN} [rad]"
SHARE = f"share of the energy's jumps in steps beyond {NEAR_ANGLE:.3g} rad"


def named(weight: float, chart: str) -> str:
    """The study of a run."""
    return f"m g = {weight:g}, {chart} chart"


JUDGED = {
    **{named(weight, CAYLEY.name): (DONE, FARTHEST, LARGEST, SHARE) for weight in HELD},
    named(LIGHT, CAYLEY.name): (FARTHEST, LARGEST),
    named(HEAVY, CAYLEY.name): (DONE,),
    **{named(HEAVY, chart): (DONE, LARGEST) for chart in WIDER_CHARTS},
}


def pendulum(weight: float, inverted: bool) -> Problem:
    """The body from H's second start, upside down, or from H's first one, hanging."""
    return galvi.problems.pendulum_3d(weight, inverted=inverted)


def symmetric(weight: float) -> Problem:
    """The start of `pendulum` for a body with two equal moments, whose motion is integrable."""
    gravity = galvi.UniformGravity(1.0, (0.0, 0.0, 1.0), (0.0, 0.0, weight))
    return replace(pendulum(weight, True), system=galvi.RigidBody(MOMENTS, gravity))


def hanging(weight: float, inverted: bool) -> tuple[float, bool]:
    """The arguments of `pendulum` for a planted fault: always hanging."""
    return weight, False


def by_exponential(space: Any, rule: Any, chart: Any) -> galvi.Galerkin:
    """The methods in the exponential chart, in which the energy does not jump."""
    return galvi.Galerkin(space, rule, galvi.Exponential())


FAULTS = {
    "a body that hangs": Fault(wrong={f"{__name__}.pendulum": with_arguments(hanging)}),
    "a body without symmetry": Fault(wrong=fewer(__name__, MOMENTS=(4.8, 3.0, 3.8))),
    "a run that ends early": Fault(table=times(0.9, quantity=DONE)),
    "steps that turn by less": Fault(table=times(0.9, quantity=TURN)),
    "steps in another chart": Fault(make=by_exponential, wrong=fewer(__name__, QUICK_WEIGHTS=HELD)),
}


def study(make_method: MakeMethod, quick: bool, report: Report) -> DataFrame:
    """Series of the `named` runs, each up to its end:

    'energy error'    relative, over time
    'turn in a step'  rotation angle between the ends of a step, rad, over time
    'steps done'      with the status
    'centre of mass on the curve', '... at step ends'  positions over time, in the first 50 steps

    Also the `growth` of the distance of two starts, for three kinds of starts, and the single steps
    of `steps_near_the_limit`.
    """
    start = galvi.problems.pendulum_3d(DRAWN, inverted=True)
    observed = [
        *single_steps(make_method, quick),
        oracles(start, STEP * STEPS_PER_RUN, STEPS_PER_RUN),
    ]
    for weight in (LIGHT, *HELD):
        starts = {
            UPSIDE_DOWN: pendulum(weight, True),
            HANGING: pendulum(weight, False),
            SYMMETRIC: symmetric(weight),
        }
        observed += [
            row(study=name, quantity=GROWTH, value=growth(start)) for name, start in starts.items()
        ]
    scanned = [(weight, CAYLEY) for weight in (QUICK_WEIGHTS if quick else WEIGHTS)]
    for weight, chart in (*scanned, *((HEAVY, chart) for chart in CHARTS)):
        report(named(weight, chart.name))
        run = galvi.integrate(
            galvi.problems.pendulum_3d(weight, inverted=True),
            method_on_group(make_method, N, chart),
            STEP,
            STEPS,
            **(LOOSE_OPTIONS if chart == CAYLEY and weight != LIGHT else {}),
        )
        completed = int(np.sum(np.isfinite(run.p[:, 0]))) - 1
        t, q = run.t[: completed + 1], run.q[: completed + 1]
        fine = curve_times(run)[: min(completed, SHOWN) * PER_STEP + 1]
        where = {"study": named(weight, chart.name), "status": failure(run)}
        observed += [
            row(quantity=DONE, value=completed, **where),
            *history(ENERGY, t, energy_errors(run)[: completed + 1], **where),
            *history(TURN, t[1:], turns(q[:-1], q[1:]), **where),
            *history(ENDS, t[: SHOWN + 1], q[: SHOWN + 1, :, 2], **where),
            *(history(CURVE, fine, run(fine)[:, :, 2], **where) if completed else ()),
        ]
    return table_of(observed)


def growth(start: Problem) -> float:
    """The largest distance of two motions in a time of 40, over the 1e-9 by which their initial
    velocities differ."""
    displaced = replace(start, v0=start.v0 + np.array([1e-9, 0.0, 0.0]))
    first, second = (TRUTH.run(motion, 40.0, {"samples": 40}).q for motion in (start, displaced))
    return float(np.max(abs(second - first))) / 1e-9


def read(table: DataFrame) -> dict[str, Measurement]:
    """Numbers of the runs in JUDGED, the range of weights for which H's statements hold, the growth
    of distances, and numbers of the single steps."""
    runs = {run: read_run(table, run) for run in JUDGED}
    scan = {weight: read_run(table, named(weight, CAYLEY.name)) for weight in WEIGHTS}
    beyond = [weight for weight, numbers in scan.items() if numbers[FARTHEST] > NEAR_ANGLE]
    complete = [weight for weight, numbers in scan.items() if numbers[DONE] == STEPS]
    return read_steps(table) | {
        ORACLES: number(table, quantity=ORACLES),
        f"least {GROWTH}, {UPSIDE_DOWN}": readings.smallest_of(table, study=UPSIDE_DOWN),
        **{
            f"largest {GROWTH}, {name}": readings.largest_of(table, study=name)
            for name in (HANGING, SYMMETRIC)
        },
        f"least m g of the scan with a step beyond {NEAR_ANGLE:.3g} rad": min(
            beyond, default=math.nan
        ),
        f"largest m g of the scan whose run does {STEPS} steps": max(complete, default=math.nan),
        **{f"{name}, {run}": runs[run][name] for run, names in JUDGED.items() for name in names},
    }


def read_run(table: DataFrame, run: str) -> dict[str, float]:
    """The steps done, the largest turn and energy error, and the fraction of the sum of |change of
    energy| over all steps that is due to steps that turn by more than NEAR."""
    energy, turned = (
        readings.values(table, "t", study=run, quantity=quantity) for quantity in (ENERGY, TURN)
    )
    jumps = abs(np.diff(energy))
    return {
        DONE: number(table, study=run, quantity=DONE),
        FARTHEST: readings.largest(turned),
        LARGEST: readings.largest(abs(energy)),
        SHARE: np.sum(jumps[turned > NEAR_ANGLE]) / np.sum(jumps) if np.any(jumps) else math.nan,
    }
