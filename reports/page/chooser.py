"""The table that answers which integrator reaches an error, and MuJoCo at its default step."""

from __future__ import annotations

import pandas as pd

from benchmarks.work_precision.described import described
from benchmarks.work_precision.fronts import front, seconds_at
from references.mujoco.steps import MUJOCO_RK4
from reports.figures.study_plots.headline import at_step
from reports.page.grid import Grid, grid
from reports.tables.fastest_per_error import AMONG, readable_fastest
from reports.tables.matched_error import heading, is_ours
from reports.tables.number_format import TIMES, readable, seconds

COLUMNS = ("problem", "error asked", "among")
DEFAULT_STEP = 0.002  # of MuJoCo, in the problem's unit of time


def chooser(fastest: pd.DataFrame) -> Grid | None:
    """Lines for each problem and error: the fastest of all, of galvi's, and of MuJoCo's."""
    if fastest.empty:
        return None
    return grid(_lines(fastest), dict.fromkeys(("time at that error", "error", "time"), "number"))


def filters(fastest: pd.DataFrame) -> list[tuple[int, str, list[str]]]:
    """(column, label, values) of each filter; errors from large to small."""
    if fastest.empty:
        return []
    table = _lines(fastest)
    values = (
        list(dict.fromkeys(table["problem"])),
        [heading(error) for error in sorted(set(fastest["asked"]), reverse=True)],
        [text for name, text in AMONG.items() if (fastest["of"] == name).any()],
    )
    return [
        (list(table).index(name), name, some) for name, some in zip(COLUMNS, values, strict=True)
    ]


def default_steps(runs: pd.DataFrame | None) -> Grid | None:
    """A line for each problem on which MuJoCo's RK4 was run at steps on both sides of its default.

    Error and time are interpolated between those two.
    """
    lines = []
    for problem, rows in runs.groupby("problem", sort=False) if runs is not None else ():
        found = at_step(rows, MUJOCO_RK4.name, DEFAULT_STEP)
        if found is None:
            continue
        error, time = found
        ours = front(rows[rows["contender"].map(is_ours)].assign(contender="galvi"))
        best = seconds_at(ours["error"].tolist(), ours["seconds"].tolist(), error)
        lines.append(
            {
                "problem": described(str(problem)).title,
                "error": readable(error, 2),
                "of the": str(rows["quantity"].iloc[0]),
                "time of MuJoCo's RK4": seconds(time),
                "galvi's time": seconds(best) or "not reached",
                "galvi is faster by": f"{readable(time / best, 2)}{TIMES}" if best == best else "",
            }
        )
    if not lines:
        return None
    numbers = ("error", "time of MuJoCo's RK4", "galvi's time", "galvi is faster by")
    return grid(pd.DataFrame(lines), dict.fromkeys(numbers, "number"))


def _lines(fastest: pd.DataFrame) -> pd.DataFrame:
    parts = []
    for problem in fastest["problem"].drop_duplicates():
        table = readable_fastest(fastest, problem)
        table.insert(0, "problem", described(str(problem)).title)
        parts.append(table)
    return pd.concat(parts, ignore_index=True)
