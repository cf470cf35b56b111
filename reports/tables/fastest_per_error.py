"""The fastest contender and setting for each error, among the measured runs."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import pandas as pd

from benchmarks.work_precision.fronts import TRUTH
from reports.tables.matched_error import errors_of, heading, is_ours
from reports.tables.number_format import known, readable, seconds

NOBODY = "not reached"
ALL, OURS, ENGINE = "all", "galvi", "MuJoCo"  # groups of contenders
AMONG = {ALL: ALL, OURS: "galvi's", ENGINE: "MuJoCo's"}


def fastest_per_error(frame: pd.DataFrame, errors: Sequence[float] | None = None) -> pd.DataFrame:
    """For each problem and error: the fastest run of all, of galvi's, and, where they took part,
    of MuJoCo's integrators.

    A run that is the reference of the others counts as reaching every error; its own is unknown.
    Without `errors`, those at which the problem's contenders are compared.

    Columns problem, asked, of ("all", "galvi" or "MuJoCo"), contender, settings, error, seconds.
    """
    rows = []
    for problem, runs in frame.groupby("problem", sort=False):
        groups = {ALL: runs, OURS: _of(runs, is_ours), ENGINE: _of(runs, _is_mujoco)}
        if not groups[ENGINE]["seconds"].notna().any():
            del groups[ENGINE]
        for asked in errors_of(runs) if errors is None else errors:
            for of, among in groups.items():
                reached = (among["error"] <= asked) | (among["status"] == TRUTH)
                good = among[reached & (among["seconds"] > 0)]
                best = good.loc[good["seconds"].idxmin()] if len(good) else {}
                rows.append(
                    {
                        "problem": problem,
                        "asked": asked,
                        "of": of,
                        "contender": best.get("contender", NOBODY),
                        "settings": best.get("settings", ""),
                        "error": best.get("error", float("nan")),
                        "seconds": best.get("seconds", float("nan")),
                    }
                )
    columns = ["problem", "asked", "of", "contender", "settings", "error", "seconds"]
    return pd.DataFrame(rows, columns=columns)


def readable_fastest(table: pd.DataFrame, problem: str) -> pd.DataFrame:
    """The rows of one problem as text: a line for each error, and further lines for the best of
    galvi and of MuJoCo where another code is faster.
    """
    lines = []
    rows = table[table["problem"] == problem]
    for asked, chosen in rows.groupby("asked", sort=False):
        first = chosen[chosen["of"] == ALL].iloc[0]
        for _, row in chosen.iterrows():
            if row["of"] == ALL or row["contender"] != first["contender"]:
                lines.append(_line(heading(asked), AMONG[row["of"]], row))
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


def _of(runs: pd.DataFrame, belongs: Callable[[str], bool]) -> pd.DataFrame:
    return runs[runs["contender"].map(belongs)]


def _is_mujoco(contender: str) -> bool:
    return contender.startswith(ENGINE)


def _line(asked: str, what: str, row: pd.Series) -> dict[str, str]:
    return {
        "error asked": asked,
        "among": what,
        "contender": row["contender"],
        "setting": row["settings"],
        "error": readable(row["error"], 2) or (TRUTH if known(row["seconds"]) else ""),
        "time": seconds(row["seconds"]),
    }
