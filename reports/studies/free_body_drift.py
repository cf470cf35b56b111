"""The section on energy, momentum and attitude errors in long rotations of a free body."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from benchmarks.studies import free_body_drift
from reports.figures.style.decades import decades
from reports.figures.style.identities import CHART_LEGEND, identity, in_order
from reports.figures.style.layout import NoData, legend, mark_rounding, split
from reports.results.section import Figure, LongForm, Section
from reports.tables.number_format import capital, readable

PANELS = {
    "energy_error": "energy, relative",
    "momentum_error": "angular momentum in space, relative",
}
SMALLEST = 1e-17  # drawn in place of 0
ALIKE = 0.05  # relative difference of errors that share a line


def errors_over_turns(axes: Axes, frame: pd.DataFrame, *, problem: str) -> None:
    """The largest error since the previous mark against the number of turns, both logarithmic.

    Of several runs of a contender the longest is drawn, the newest of those; a failed run ends with
    a cross.
    """
    rows = frame[frame["problem"] == problem] if len(frame) else frame
    known = rows[rows["energy_error"].notna()] if len(rows) else rows
    if known.empty:
        raise NoData("no body turned.")
    shown = pd.concat([_run(part) for _, part in rows.groupby("contender", sort=False)])
    lines = together(shown, in_order(known["contender"]))
    places = split(axes, len(PANELS), ylabel="largest error since the last mark [1]")
    for one, (name, title) in zip(places, PANELS.items(), strict=True):
        one.set(xscale="log", yscale="log", xlabel="turns", title=title)
        for contender in lines.values():
            look = identity(contender)
            run = shown[shown["contender"] == contender]
            good = run[run[name].notna()]
            size = np.maximum(np.abs(good[name]), SMALLEST)
            one.plot(good["turn"], size, markersize=4.0, **look.style)
            if len(good) and len(good) < len(run):
                one.plot(good["turn"].iloc[-1], size.iloc[-1], "x", ms=11.0, color=look.color)
        decades(one.xaxis)
        decades(one.yaxis)
        mark_rounding(one)
    handles = [Line2D([], [], markersize=5.0, **identity(name).style) for name in lines.values()]
    legend(one, handles, lines)


def together(shown: pd.DataFrame, names: Sequence[str]) -> dict[str, str]:
    """Label -> contender of each line; contenders of one code whose errors differ by less than
    ALIKE at every mark share the line of the first.
    """
    lines: dict[str, list[str]] = {}
    errors = {
        name: np.abs(rows.sort_values("turn")[list(PANELS)].to_numpy(float))
        for name, rows in shown.groupby("contender", sort=False)
    }
    for name in names:
        like = (
            one for one in lines
            if one.split()[0] == name.split()[0] and errors[one].shape == errors[name].shape
            and np.all(np.abs(errors[one] - errors[name]) <= ALIKE * errors[name])
        )  # fmt: skip
        lines.setdefault(next(like, name), []).append(name)
    return {_label(some): first for first, some in lines.items()}


def _label(names: Sequence[str]) -> str:
    """E.g. MuJoCo implicit, discrete, free joint."""
    (code, *_), ends = names[0].split(), {name.partition(", ")[2] for name in names}
    if len(names) == 1 or len(ends) > 1:
        return "; ".join(names)
    short = (name.partition(", ")[0].removeprefix(f"{code} ") for name in names)
    return ", ".join(filter(None, (f"{code} {', '.join(short)}", *ends)))


def _run(rows: pd.DataFrame) -> pd.DataFrame:
    """The longest run of a contender, the newest of those."""
    longest = rows[rows["turns"] == rows["turns"].max()]
    return longest[longest["date"] == longest["date"].max()].sort_values("turn")


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
            caption=f"Blue: galvi; {CHART_LEGEND}; dashed: other codes, "
            "MuJoCo on a free joint; integrators that differ by less than 5 % share a line. A "
            "cross: the run failed after it.",
            size=(9.6, 4.2),
        ),
    ),
    table=free_body_drift_table,
    long_form=LongForm(free_body_drift.parts, free_body_drift.stored),
    open=True,
)
