"""Single steps of the 3D pendulum from exact states, whose rotation angles approach pi, for L9.

They start from states of DOP853's runs for several m g, early enough that rounding is not amplified
much: the distance of neighbours grows like e^(0.4 t).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import pandas as pd

import galvi
from benchmarks.claims.kit import (
    CAYLEY,
    Estimate,
    MakeMethod,
    Measurement,
    failure,
    method_on_group,
    readings,
    rows,
)
from benchmarks.claims.lie_groups.cayley_curve import distance_of_polynomials, rotation_angle
from benchmarks.claims.lie_groups.pendulum_motion import TRUTH
from benchmarks.measures.errors import energy_errors
from galvi.charts import CHARTS

N, STEP = 20, 0.6
STEPS_PER_RUN = 50  # steps from states of each run, over its first 30 units of time
SAMPLES_PER_STEP = 160  # samples of the exact motion in a step
NEAR_ANGLE = 0.9 * np.pi  # "almost through an angle of pi": within a tenth of it
# In steps beyond 2.9 rad |xi| and |h xi'| exceed 16 and 200. Asked for round-off, galvi's iteration
# then ends or fails by the last bits: of 12 starts 1e-14 apart, 3 of m g = 22 and 8 of 23 failed in
# a step of about 3 rad. To changes of 1e-9 all were solved.
LOOSE_OPTIONS: Mapping[str, Any] = {"tolerance": 1e-9, "solver": "newton"}
TURN, CHANGE = "turn in a step", "change of energy in one step"
DISTANCE = "distance of polynomials from the exact motion"
WIDER_CHARTS = tuple(chart.name for chart in CHARTS if chart.limit > CAYLEY.limit)


def one_step(chart: str) -> str:
    """The study of the single steps in a chart."""
    return f"one step, {chart} chart"


def single_steps(make_method: MakeMethod, quick: bool) -> list[dict[str, Any]]:
    """Rows of TURN, of CHANGE over |energy|, NaN for an unsolved step, and of DISTANCE, NaN for a
    rotation by pi or more, for each step."""
    methods = {chart.name: method_on_group(make_method, N, chart) for chart in CHARTS}
    observed = []
    for weight in (22, 24, 26, 28, 30) if quick else range(20, 31):
        start = galvi.problems.pendulum_3d(weight, inverted=True)
        exact = TRUTH.run(
            start, STEP * STEPS_PER_RUN, {"samples": STEPS_PER_RUN * SAMPLES_PER_STEP}
        )
        v = start.system.velocity(exact.p)
        for k in range(STEPS_PER_RUN):
            path, omega = (
                x[k * SAMPLES_PER_STEP : (k + 1) * SAMPLES_PER_STEP + 1] for x in (exact.q, v)
            )
            values = {TURN: rotation_angle(path), DISTANCE: np.nan}
            if values[TURN] < np.pi:
                values[DISTANCE] = distance_of_polynomials(path, omega, N - 1)
            state = replace(start, q0=path[0], v0=omega[0])
            for chart, method in methods.items():
                run = galvi.integrate(state, method, STEP, 1)
                if not run.success:
                    run = galvi.integrate(state, method, STEP, 1, **LOOSE_OPTIONS)
                values[CHANGE] = abs(energy_errors(run)[-1]) if run.success else np.nan
                where = {"study": one_step(chart), "label": f"m g = {weight}", "t": k * STEP}
                observed += rows(values, status=failure(run), **where)
    return observed


def read_steps(table: pd.DataFrame) -> dict[str, Measurement]:
    """Numbers on the single steps: the growth of CHANGE with the turn and with DISTANCE in Cayley's
    chart, the latter for distances above 1e-6; the least turn of an unsolved step; and the largest
    change in the other charts."""
    steps = table[table["study"].str.startswith("one step")].pivot(
        index=["study", "label", "t"], columns="quantity", values="value"
    )
    cayley = steps.loc[one_step(CAYLEY.name)]
    bins = pd.cut(cayley[TURN], np.linspace(2.6, 3.1, 6), right=False)  # below, it is rounding
    medians = cayley.groupby(bins, observed=False)[CHANGE].median().to_numpy()
    above_rounding = cayley[(cayley[DISTANCE] > 1e-6) & (cayley[CHANGE] > 0.0)]
    beyond = steps[CHANGE][steps[TURN] > NEAR_ANGLE]
    return {
        f"least growth of the median {CHANGE} from 0.1 rad to the next, 2.6 to 3.1, Cayley": float(
            np.min(medians[1:] / medians[:-1])
        ),
        f"power of the distance of polynomials with which the {CHANGE} grows, Cayley": power(
            above_rounding
        ),
        "least turn of a single step that is not solved [rad], Cayley": float(
            cayley[TURN][cayley[CHANGE].isna()].min()
        ),
        **{
            f"largest {CHANGE} that turns by more than {NEAR_ANGLE:.3g} rad, {chart}": (
                readings.largest(beyond.loc[one_step(chart)].to_numpy())
            )
            for chart in WIDER_CHARTS
        },
    }


def power(steps: pd.DataFrame) -> Estimate:
    """The power of DISTANCE with which CHANGE grows, by least squares; NaN for fewer than 4
    steps."""
    if len(steps) < 4:
        return Estimate(np.nan)
    line, spread = np.polyfit(np.log(steps[DISTANCE]), np.log(steps[CHANGE]), 1, cov=True)
    return Estimate(float(line[0]), float(spread[0, 0] ** 0.5))
