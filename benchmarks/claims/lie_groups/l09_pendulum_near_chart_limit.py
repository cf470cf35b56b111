"""L9: the 3D pendulum from upside down, in steps that near the chart's limit (H 3.8 and 3.9)."""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd

import galvi
from benchmarks.checks.bounds import CONTRADICTED, AtLeast, AtMost, Bound, Within
from benchmarks.checks.claim import Claim, MakeMethod, Report, Row
from benchmarks.claims.lie_groups.pendulum_motion import BODY, TRUTH
from benchmarks.measures.errors import PER_STEP, curve_times, energy_errors
from benchmarks.measures.refinement import method_on_group
from benchmarks.measures.rotation_angle import turns
from benchmarks.statistics import readings
from benchmarks.store.frames import failure, frame, history, number, pick, row, rows
from galvi import Problem, Trajectory
from galvi.charts import CHARTS

N, STEP, STEPS = 20, 0.6, 200
LIGHT, HEAVY = 9.81, 29.43
CAYLEY = galvi.Cayley()
WIDE = tuple(chart for chart in CHARTS if chart.limit > CAYLEY.limit)
ENERGY, TURN, DONE = "energy error", "turn in a step", "steps done"
CURVE, ENDS = "centre of mass on the curve", "centre of mass at step ends"
CHANGE = "change of energy in one step"
SHOWN = 50  # steps whose curve is kept
SMALL, LARGE = 2.0, 2.4  # rad: steps far from the limit pi of Cayley's chart, and near it
LIMIT = 1e-12
JUMP = (
    f"energy change of single steps that turn by more than {LARGE:g} rad, largest, over that of "
    f"steps below {SMALL:g}"
)
JUMPS = 1e-4  # of the energy, in steps that near the limit
SETUP = (
    f"{BODY}, m g = %g (H gives none); R0 = diag(-1, 1, -1), body velocity (0.5, -0.5, 0.4); "
    f"Polynomials(n - 1), gauss(n) (H states no number of points), n = {N}, %s chart; "
    f"h = {STEP:g}, {STEPS} steps"
)


NEAR_PI = {"claimed": "some steps are almost through an angle of pi"}


def problem(weight: float) -> Problem:
    """From upside down."""
    return galvi.problems.pendulum_3d(weight=weight, inverted=True)


def named(weight: float, chart: str) -> str:
    """The study of a run."""
    return f"m g = {weight:g}, {chart} chart"


def one_step(chart: str) -> str:
    """The study of its single steps."""
    return f"one step, {chart} chart"


def study(make_method: MakeMethod, quick: bool, report: Report) -> pd.DataFrame:
    """Series of `named` runs, up to where each ends:

    'energy error'    relative, in time
    'turn in a step'  angle between the step's two ends, rad, in time
    'steps done'      with the status
    'centre of mass on the curve', '... at step ends'  its place, in time, of the first 50 steps

    'one step, ... chart' has the turn and the change of energy, over |energy|, of single steps
    from states of DOP853's run for m g = 29.43, by their time.
    """
    found = []
    for weight in (LIGHT, HEAVY):
        for chart in CHARTS:
            name = named(weight, chart.name)
            report(name)
            method = method_on_group(make_method, N, chart)
            run = galvi.integrate(problem(weight), method, STEP, STEPS)
            found += _run(name, chart.name, run)
    report("single steps")
    return frame(found + _single_steps(make_method, 80 if quick else STEPS))


def _run(study: str, chart: str, run: Trajectory) -> list[dict[str, Any]]:
    done = int(np.sum(np.isfinite(run.p[:, 0]))) - 1
    where = {"study": study, "label": chart, "n": N, "step": STEP, "status": failure(run)}
    t, q, shown = run.t[: done + 1], run.q[: done + 1], min(done, SHOWN)
    fine = curve_times(run)[: shown * PER_STEP + 1]
    return [
        row(quantity=DONE, value=float(done), **where),
        *history(ENERGY, t, energy_errors(run)[: done + 1], **where),
        *history(TURN, t[1:], turns(q[:-1], q[1:]), **where),
        *history(ENDS, t[: shown + 1], q[: shown + 1, :, 2], **where),
        *(history(CURVE, fine, run(fine)[:, :, 2], **where) if shown else ()),
    ]


def _single_steps(make_method: MakeMethod, count: int) -> list[dict[str, Any]]:
    start = problem(HEAVY)
    exact = TRUTH.run(start, STEP * STEPS, {"samples": STEPS})
    v = start.system.velocity(exact.p)
    found = []
    for chart in CHARTS:
        method = method_on_group(make_method, N, chart)
        for k in range(0, STEPS, STEPS // count):
            here = Problem(start.system, exact.q[k], v[k])
            run = galvi.integrate(here, method, STEP, 1)
            where = {"study": one_step(chart.name), "label": chart.name, "n": N, "step": STEP}
            values = {
                TURN: float(turns(exact.q[k : k + 1], exact.q[k + 1 : k + 2])[0]),
                CHANGE: abs(float(energy_errors(run)[-1])) if run.success else float("nan"),
            }
            found += rows(values, t=exact.t[k], status=failure(run), **where)
    return found


def single_steps(table: pd.DataFrame, chart: str) -> pd.DataFrame:
    """Columns turn and change, one row for each step that was done from a state of DOP853."""
    rows = pick(table, study=one_step(chart))
    if rows.empty:
        return pd.DataFrame({"turn": [], "change": []})
    wide = rows.pivot(index="t", columns="quantity", values="value")
    return wide.rename(columns={TURN: "turn", CHANGE: "change"})[["turn", "change"]].dropna()


def judge(table: pd.DataFrame) -> list[Row]:
    """Energy, how far steps turn, how far the runs come, and what nearing the limit costs."""
    light, heavy = (LIGHT, CAYLEY.name), (HEAVY, CAYLEY.name)
    return [
        _row(
            light,
            "largest energy error",
            AtMost(LIMIT),
            _largest(table, light, ENERGY),
            reason="No step comes near the limit: 20 basis functions resolve it to round-off.",
        ),
        _row(
            light,
            "largest turn in a step [rad]",
            Within(2.8, np.pi),
            _largest(table, light, TURN),
            expected=CONTRADICTED,
            reason="This weight turns the body by at most 2.2 in a step: H's figure is of a larger "
            "m g.",
            **NEAR_PI,
        ),
        _row(
            heavy,
            "largest energy error before the run ends",
            AtMost(JUMPS),
            _largest(table, heavy, ENERGY),
            reason="What is lost is lost in the steps that turn by more than 2.4.",
        ),
        _row(
            heavy,
            "steps done",
            AtLeast(STEPS),
            number(table, study=named(*heavy), quantity=DONE),
            claimed="a long run of steps almost through an angle of pi",
            expected=CONTRADICTED,
            reason="The run ends at a step of 3.09 radians, also when it starts from a run with "
            "smaller steps: near half a turn xi = 2 tan(angle / 2) grows without bound, here to "
            "75.",
        ),
        _row(
            heavy,
            JUMP,
            AtLeast(1e3),
            _jump(table, CAYLEY.name),
            claimed="the large jumps belong to steps that almost exceed the chart",
            reason="The nearer to half a turn, the worse polynomials approximate tan(angle / 2).",
        ),
        *(row for chart in WIDE for row in _beyond(table, chart.name)),
    ]


def _beyond(table: pd.DataFrame, chart: str) -> list[Row]:
    """A chart whose limit is a whole turn."""
    wide = (HEAVY, chart)
    return [
        _row(
            wide,
            "largest turn in a step [rad]",
            Within(2.8, np.pi),
            _largest(table, wide, TURN),
            reason="With three times the weight steps reach half a turn; measured with a chart "
            "whose limit is a whole one.",
            **NEAR_PI,
        ),
        _row(
            wide,
            "largest energy error",
            AtMost(LIMIT),
            _largest(table, wide, ENERGY),
            reason="For this chart half a turn is far from the limit, 2 pi: no jumps.",
        ),
        _row(
            wide,
            "steps done",
            AtLeast(20),
            number(table, study=named(*wide), quantity=DONE),
            claimed="not in H",
            reason=f"The {chart} chart goes on where Cayley's ends.",
        ),
        _row(
            wide,
            JUMP,
            AtMost(100.0),
            _jump(table, chart),
            claimed="not in H",
            reason=f"Nothing happens to the {chart} chart at half a turn: round-off in both.",
        ),
    ]


def _row(run: tuple[float, str], quantity: str, bound: Bound, measured: float, **own: str) -> Row:
    """Of the run with this weight and chart; of its energy, unless it says otherwise."""
    texts = {"setup": SETUP % run, "claimed": "energy nearly conserved", **own}
    if "energy" not in quantity:
        texts = {"source": "H fig. 3.8", "reference": "angle between the ends of a step", **texts}
    return L9.row(f"{quantity}, {named(*run)}", bound, measured, **texts)


def _largest(table: pd.DataFrame, run: tuple[float, str], quantity: str) -> float:
    return readings.largest(abs(readings.values(table, study=named(*run), quantity=quantity)))


def _jump(table: pd.DataFrame, chart: str) -> float:
    """The largest change of energy in a step that turns far, over that in one that does not."""
    steps = single_steps(table, chart)
    near = steps["change"][steps["turn"] > LARGE].max()
    far = steps["change"][steps["turn"] < SMALL].max()
    return float(near / far) if far > 0.0 else float("nan")


L9 = Claim(
    "L9",
    "3D pendulum from upside down: energy, and steps near the chart's limit",
    study,
    judge,
    ("H fig. 3.8", "H fig. 3.9"),
    source="H fig. 3.9",
    reference="initial energy",
)
