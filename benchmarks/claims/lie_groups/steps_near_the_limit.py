"""Single steps of the 3D pendulum from exact states, whose rotations near pi, for L9.

They start along runs of DOP853 for several m g, early enough that rounding is not yet amplified:
neighbours part like e^(0.4 t).
"""

from __future__ import annotations

import pandas as pd

from benchmarks.claims.kit import *
from benchmarks.claims.lie_groups.cayley_curve import distance_of_polynomials, turned
from benchmarks.claims.lie_groups.pendulum_motion import TRUTH
from benchmarks.measures.errors import energy_errors
from galvi.charts import CHARTS

N, STEP = 20, 0.6
WEIGHTS, QUICK = tuple(range(20, 31)), (22, 24, 26, 28, 30)  # m g
COUNT = 50  # steps from each run: its first 30 units of time
DENSE = 160  # samples of the exact motion in a step
# In steps beyond 2.9 rad |xi| and |h xi'| exceed 16 and 200. Asked for round-off, galvi's iteration
# then ends or fails by the last bits: of 12 starts 1e-14 apart, 3 of m g = 22 and 8 of 23 failed in
# a step of about 3 rad. To changes of 1e-9 all were solved.
LOOSE = {"tolerance": 1e-9, "solver": "newton"}
TURN, CHANGE = "turn in a step", "change of energy in one step"
DISTANCE = "distance of polynomials from the exact motion"
SEEN = 1e-6  # distances whose square is well above rounding
BINS = np.linspace(2.6, 3.1, 6)  # rad; the median change below 2.6 is rounding


def one_step(chart: str) -> str:
    """The study of the single steps in a chart."""
    return f"one step, {chart} chart"


def upside_down(weight: float) -> Problem:
    """H's second start."""
    return galvi.problems.pendulum_3d(weight=weight, inverted=True)


def single_steps(make_method: MakeMethod, quick: bool) -> list[dict[str, Any]]:
    """TURN, CHANGE over |energy| (NaN where the step was not solved) and DISTANCE of each step."""
    methods = {chart.name: method_on_group(make_method, N, chart) for chart in CHARTS}
    found = []
    for weight in QUICK if quick else WEIGHTS:
        start = upside_down(weight)
        exact = TRUTH.run(start, STEP * COUNT, {"samples": COUNT * DENSE})
        v = start.system.velocity(exact.p)
        for k in range(COUNT):
            path, omega = (x[k * DENSE : (k + 1) * DENSE + 1] for x in (exact.q, v))
            turn = turned(path)
            away = distance_of_polynomials(path, omega, N - 1) if turn < np.pi else np.nan
            here = Problem(start.system, path[0], omega[0])
            for chart, method in methods.items():
                run = _solved(here, method)
                change = abs(float(energy_errors(run)[-1])) if run.success else np.nan
                values = {TURN: turn, CHANGE: change, DISTANCE: away}
                where = {"study": one_step(chart), "label": f"m g = {weight:g}", "n": N}
                found += rows(values, t=k * STEP, step=STEP, status=failure(run), **where)
    return found


def _solved(problem: Problem, method: Any) -> Trajectory:
    run = galvi.integrate(problem, method, STEP, 1)
    return run if run.success else galvi.integrate(problem, method, STEP, 1, **LOOSE)


def steps_of(table: pd.DataFrame, chart: str) -> pd.DataFrame:
    """Columns TURN, CHANGE and DISTANCE, one row for each step."""
    chosen = pick(table, study=one_step(chart))
    if chosen.empty:
        return pd.DataFrame({TURN: [], CHANGE: [], DISTANCE: []}, dtype=np.float64)
    wide = chosen.pivot(index=["label", "t"], columns="quantity", values="value")
    return wide.reindex(columns=[TURN, CHANGE, DISTANCE])


def medians(table: pd.DataFrame, chart: str) -> Array:
    """The median change of energy of the solved steps in each of BINS; NaN for an empty one."""
    steps = steps_of(table, chart).dropna(subset=[CHANGE])
    inside = pd.cut(steps[TURN], BINS, right=False)
    return steps.groupby(inside, observed=False)[CHANGE].median().to_numpy(np.float64)


def least_growth(table: pd.DataFrame, chart: str) -> float:
    """The least ratio of the median change in a bin to that in the bin before."""
    found = medians(table, chart)
    return float(np.min(found[1:] / found[:-1]))


def largest_change(table: pd.DataFrame, chart: str, turn: float) -> float:
    """The largest change of energy in steps that turn by more than `turn`; NaN if one failed."""
    steps = steps_of(table, chart)
    changes = steps[CHANGE][steps[TURN] > turn].to_numpy(np.float64)
    return float(np.max(changes)) if len(changes) else float("nan")


def least_unsolved(table: pd.DataFrame, chart: str) -> float:
    """The least turn of a step that was not solved; NaN when all were."""
    steps = steps_of(table, chart)
    return float(steps[TURN][steps[CHANGE].isna()].min())


def law(table: pd.DataFrame, chart: str) -> Estimate:
    """The power of DISTANCE with which CHANGE grows, over all steps farther than SEEN."""
    steps = steps_of(table, chart).dropna()
    steps = steps[(steps[DISTANCE] > SEEN) & (steps[CHANGE] > 0.0)]
    if len(steps) < 3:
        return Estimate(float("nan"))
    from scipy.stats import linregress  # a sixth of the import of a report

    line = linregress(np.log(steps[DISTANCE]), np.log(steps[CHANGE]))
    return Estimate(float(line.slope), float(line.stderr))
