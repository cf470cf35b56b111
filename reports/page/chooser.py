"""The table that answers which integrator reaches an error, and MuJoCo at its default step."""

from __future__ import annotations

from collections.abc import Mapping

import pandas as pd

from benchmarks.work_precision.dependable import dependable
from benchmarks.work_precision.fronts import fastest
from benchmarks.work_precision.labels import label_of
from references.mujoco.steps import DEFAULT_STEP, MUJOCO_RK4
from reports.figures.work_precision import at_step
from reports.page.site import Explained, Grid, grid
from reports.tables.comparison_tables import AMONG, heading, is_ours, readable_fastest
from reports.tables.number_format import TIMES, readable, seconds

OWN = {"error": "its error"}
COLUMNS = ("problem", "error asked", "among")
LIMITS = 1e-9, 1e-6  # errors that divide the answer


def chooser(fastest: pd.DataFrame) -> Grid | None:
    """Lines for each problem and error: the fastest of all, of galvi's, and of MuJoCo's."""
    if fastest.empty:
        return None
    return grid(_lines(fastest), dict.fromkeys(("time", *OWN.values()), "number"))


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


def default_step(runs: pd.DataFrame | None) -> Explained | None:
    """MuJoCo's RK4 at its default step: the answer in sentences, and a line for each problem; None
    without runs at this step."""
    errors, lines = {}, []
    for problem, rows in runs.groupby("problem", sort=False) if runs is not None else ():
        found = at_step(rows, MUJOCO_RK4.name, DEFAULT_STEP)
        if found is None:
            continue
        error, time = found
        counted = dependable(rows)
        ours = fastest(counted[counted["contender"].map(is_ours)], error)
        best = float("nan") if ours is None else float(ours["seconds"])
        title = label_of(str(problem)).title
        errors[title] = error
        lines.append(
            {
                "problem": title,
                "error": readable(error, 2),
                "quantity": str(rows["quantity"].iloc[0]),
                "time of MuJoCo's RK4": seconds(time),
                "galvi's time": seconds(best) or "not reached",
                "galvi is faster by": f"{readable(time / best, 2)}{TIMES}" if best == best else "",
            }
        )
    if not lines:
        return None
    numbers = ("error", "time of MuJoCo's RK4", "galvi's time", "galvi is faster by")
    text = (
        f"Its error at a step of {DEFAULT_STEP:g}. {_answer(errors)} Errors are those at the end "
        "of the comparison's run."
    )
    return Explained(text, grid(pd.DataFrame(lines), dict.fromkeys(numbers, "number")))


def _answer(errors: Mapping[str, float]) -> str:
    """The errors on each problem, by their size."""
    small, large = map(heading, LIMITS)
    groups: dict[str, list[str]] = {
        f"Below {small}": [], f"Between {small} and {large}": [], f"Above {large}": [],
    }  # fmt: skip
    for name, error in errors.items():
        place = sum(error >= limit for limit in LIMITS)
        list(groups.values())[place].append(f"{name} ({readable(error, 2)})")
    return " ".join(f"{words}: {'; '.join(names)}." for words, names in groups.items() if names)


def _lines(fastest: pd.DataFrame) -> pd.DataFrame:
    parts = []
    for problem in fastest["problem"].drop_duplicates():
        table = readable_fastest(fastest, problem)
        table.insert(0, "problem", label_of(str(problem)).title)
        parts.append(table)
    return pd.concat(parts, ignore_index=True).rename(columns=OWN)
