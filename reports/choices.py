"""Which contender, and which setting, for the error one needs: of the runs that were made."""

from __future__ import annotations

from collections.abc import Sequence

import pandas as pd

from benchmarks.fronts import TRUTH
from reports.matched import heading, is_ours
from reports.numerals import known, readable, seconds

NOBODY = "not reached"


def choices(frame: pd.DataFrame, errors: Sequence[float]) -> pd.DataFrame:
    """For each problem and error: the run of least time among all, and among galvi's.

    A run that is the truth of the others reaches every error; its own is not known.

    Columns problem, asked, of ("all" or "galvi"), contender, settings, error, seconds.
    """
    rows = []
    for problem, runs in frame.groupby("problem", sort=False):
        for asked in errors:
            for of, among in (("all", runs), ("galvi", runs[runs["contender"].map(is_ours)])):
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


def readable_choices(table: pd.DataFrame, problem: str) -> pd.DataFrame:
    """As text: a line for each error, and another for galvi's best where a peer is faster."""
    lines = []
    rows = table[table["problem"] == problem]
    for asked, pair in rows.groupby("asked", sort=False):
        first, ours = (pair[pair["of"] == of].iloc[0] for of in ("all", "galvi"))
        same = first["contender"] == ours["contender"]
        lines.append(_line(heading(asked), "all", first))
        if not same:
            lines.append(_line(heading(asked), "galvi's", ours))
    return pd.DataFrame(lines)


def _line(asked: str, what: str, row: pd.Series) -> dict[str, str]:
    return {
        "error asked": asked,
        "among": what,
        "contender": row["contender"],
        "setting": row["settings"],
        "error": readable(row["error"], 2) or (TRUTH if known(row["seconds"]) else ""),
        "time": seconds(row["seconds"]),
    }
