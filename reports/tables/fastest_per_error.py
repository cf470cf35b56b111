"""The fastest contender for each error, and its setting that reaches it."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from typing import Any

import pandas as pd

from benchmarks.work_precision.dependable import bounds
from benchmarks.work_precision.described import described
from benchmarks.work_precision.fronts import OURS as BEST
from benchmarks.work_precision.fronts import TRUTH, ratios
from reports.tables.matched_error import errors_of, heading, is_ours
from reports.tables.number_format import known, readable, seconds

NOBODY = "not reached"
ALL, OURS, ENGINE = "all", "galvi", "MuJoCo"  # groups of contenders
CHOICE = ("contender", "settings", "error", "seconds", "at_asked")
PASSES = " passes"  # ends the label of a frame with fewer passes than converge
AMONG = {ALL: ALL, OURS: "galvi's", ENGINE: "MuJoCo's"}


def fastest_per_error(frame: pd.DataFrame, errors: Sequence[float] | None = None) -> pd.DataFrame:
    """For each problem and error: the fastest contender of all, of galvi's, and, where they took
    part, of MuJoCo's integrators, by their times at that error as in `fronts.ratios`.

    A run that is the reference of the others counts as reaching every error; its own is unknown.
    Without `errors`, those at which the problem's contenders are compared.

    Columns problem, asked, of ("all", "galvi" or "MuJoCo"), contender, settings, error, seconds,
    at_asked, bound: its fastest run that reaches the error, its time at the error itself, and
    whether the run's error is a bound alone.
    """
    rows = []
    for problem, runs in frame.groupby("problem", sort=False):
        groups = {ALL: runs, OURS: _of(runs, is_ours), ENGINE: _of(runs, _is_mujoco)}
        if not groups[ENGINE]["seconds"].notna().any():
            del groups[ENGINE]
        asked = errors_of(runs) if errors is None else errors
        times = {of: ratios(among, asked) for of, among in groups.items()}
        rows += [
            {"problem": problem, "asked": error, "of": of}
            | _fastest(groups[of], times[of][times[of]["error"] == error], error)
            for error in asked
            for of in groups
        ]
    table = pd.DataFrame(rows, columns=["problem", "asked", "of", *CHOICE])
    return table.assign(bound=bounds(table, frame))


def readable_fastest(table: pd.DataFrame, problem: str) -> pd.DataFrame:
    """The rows of one problem as text: for each error a line for each choice, with those among
    whom it is the fastest, e.g. "all, galvi's".
    """
    lines = []
    rows = table[table["problem"] == problem]
    for (asked, _), chosen in rows.groupby(["asked", "contender"], sort=False):
        among = ", ".join(AMONG[of] for of in chosen["of"])
        lines.append(_line(heading(asked), among, chosen.iloc[0]))
    return pd.DataFrame(lines)


def of_mujoco(table: pd.DataFrame, problem: str) -> str:
    """A sentence on the fastest of MuJoCo's integrators at each error; empty without them."""
    rows = table[(table["problem"] == problem) & (table["of"] == ENGINE)]
    if rows.empty:
        return ""
    said = [
        f"{contender} for {', '.join(map(heading, chosen['asked']))}"
        for contender, chosen in rows.groupby("contender", sort=False)
        if contender != NOBODY
    ]
    none = [heading(asked) for asked in rows.loc[rows["contender"] == NOBODY, "asked"]]
    said += [f"none reaches {', '.join(none)}"] if none else []
    return f"Of MuJoCo's integrators, the fastest at an error: {'; '.join(said)}."


def _fastest(runs: pd.DataFrame, times: pd.DataFrame, asked: float) -> dict[str, Any]:
    """The CHOICE among these runs of one problem, with their times at this error."""
    times = times[(times["contender"] != BEST) & times["seconds"].notna()]
    if times.empty:
        return dict.fromkeys(CHOICE, float("nan")) | {"contender": NOBODY, "settings": ""}
    first = times.loc[times["seconds"].idxmin()]
    mine = runs[(runs["contender"] == first["contender"]) & (runs["seconds"] > 0)]
    good = mine[mine["error"] <= asked]
    good = good if len(good) else mine[mine["status"] == TRUTH]
    run = good.loc[good["seconds"].idxmin()]
    return {**run[list(CHOICE[:-1])], "at_asked": first["seconds"]}


def _of(runs: pd.DataFrame, belongs: Callable[[str], bool]) -> pd.DataFrame:
    return runs[runs["contender"].map(belongs)]


def _is_mujoco(contender: str) -> bool:
    return contender.startswith(ENGINE)


def _line(asked: str, what: str, row: pd.Series) -> dict[str, str]:
    return {
        "error asked": asked,
        "among": what,
        "contender": row["contender"],
        "time at that error": seconds(row["at_asked"]),
        "setting": _setting(row),
        "error": _error(row),
        "time": seconds(row["seconds"]),
    }


def _error(row: pd.Series) -> str:
    text = readable(row["error"], 2) or (TRUTH if known(row["seconds"]) else "")
    return f"{text} (bound)" if row["bound"] else text


def _setting(row: pd.Series) -> str:
    """With the unit of a step, and whether galvi's iteration ends before it has converged."""
    text, unit = str(row["settings"]), described(row["problem"]).time
    text = re.sub(r"(\bstep=\S+)", rf"\1 {unit}", text) if unit else text
    early = is_ours(row["contender"]) and ("tolerance=" in text or PASSES in row["contender"])
    return f"{text} (stopped early)" if early else text
