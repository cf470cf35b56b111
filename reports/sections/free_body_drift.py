"""The section on energy, momentum and attitude errors in long rotations of a free body."""

from __future__ import annotations

import numpy as np
import pandas as pd

from benchmarks.studies import free_body_drift, free_body_drift_long
from reports.figures.study_plots.free_body_drift import errors_over_turns
from reports.figures.style.chart_lines import LEGEND as CHART_LINES
from reports.results.figure import Figure
from reports.results.section import LongForm, Section
from reports.tables.number_format import capital, readable

KEYS = ["problem", "contender", "engine", "step", "turns", "commit"]
WORDS = ("body", "contender", "engine", "status", "commit", "date")
FEWEST = 4  # marks needed to fit a growth
ROUND_OFF = 1e-13  # smaller energy errors may be one random walk, which has no exponent


def free_body_drift_table(frame: pd.DataFrame) -> tuple[pd.DataFrame, dict[str, str]]:
    """A line for each run, and the CSS classes of the columns.

    Errors are those of the last mark, for a failed run the last one it reached (see its turns).
    The energy error grows as turns^x, fitted over the later half of the marks, where it is not
    round-off.
    """
    lines = []
    for (problem, contender, engine, step, turns, commit), rows in frame.groupby(
        KEYS, sort=False, dropna=False
    ):
        run = rows.sort_values("turn")
        known = run[run["energy_error"].notna()]
        last = (known if len(known) else run).iloc[-1]
        reached = last["turn"] if len(known) else turns
        lines.append(
            {
                "body": capital(problem),
                "contender": contender,
                "engine": engine,
                "step": readable(step),
                "turns": readable(reached),
                "energy, relative": readable(last["energy_error"], 2),
                "growth exponent (turns)": _growth(known),
                "angular momentum": readable(last["momentum_error"], 2),
                "attitude": readable(last["attitude_error"], 2),
                "status": run["status"].iloc[-1],
                "commit": commit,
                "date": run["date"].iloc[-1],
            }
        )
    table = pd.DataFrame(lines)
    if (table.groupby("contender")["engine"].nunique() == 1).all():
        table = table.drop(columns="engine")
    empty = [name for name in table if not (table[name] != "").any()]
    return table.drop(columns=empty), {
        name: "number" for name in table if name not in (*WORDS, *empty)
    }


def _growth(run: pd.DataFrame) -> str:
    """The log-log slope over the later half of the marks, as text."""
    later = run.iloc[len(run) // 2 :]
    size = np.abs(later["energy_error"].to_numpy(float))
    if len(later) < FEWEST:
        return ""
    if not np.max(size) > ROUND_OFF:
        return "round-off"
    return readable(float(np.polyfit(np.log(later["turn"]), np.log(size), 1)[0]), 2)


FREE_BODY_DRIFT = Section(
    name="free-spin",
    title="Energy and angular momentum in long rotations",
    text="H's free body over many turns, a "
    "turn being one rotation at the initial angular speed; MuJoCo in steps of 0.01. Also the free "
    "box of MuJoCo's own tests: 500 steps of 0.01 from the angular velocity (1, 2, 3). MuJoCo's "
    "implicitfast and discrete integrate rotation differently on ball and free joints; on free "
    "joints they are damped, as implicit is. Energy errors are E / E0 - 1 with their sign, "
    "momentum errors the length of the change in space; both are the largest since the previous "
    "mark (turns 1, 2, 5, 10 and so on). Attitudes are compared with the closed form at the end.",
    measure=free_body_drift.free_spin,
    figures=(
        Figure(
            name="free-spin",
            title="Free rigid body: energy and angular momentum over many turns",
            draw=errors_over_turns,
            options={"problem": "free rigid body"},
            caption=f"Blue: galvi; {CHART_LINES}; dashed: other codes, "
            "MuJoCo on a free joint, where some of its lines coincide. A cross: the run "
            "failed after it.",
            size=(9.6, 4.2),
        ),
    ),
    table=free_body_drift_table,
    long_form=LongForm(free_body_drift_long.parts, free_body_drift_long.stored),
    open=True,
)
