"""Sentences on which code is fastest at which error, generated from the times."""

from __future__ import annotations

import pandas as pd

from benchmarks.work_precision.described import described
from benchmarks.work_precision.fronts import OURS
from reports.tables.matched_error import heading, is_ours
from reports.tables.number_format import known, readable

LEVEL = 1.1  # smaller ratios are within the scatter of the times: neither wins


def summary_sentences(table: pd.DataFrame) -> list[str]:
    """A sentence for each problem in a table of `reports.tables.matched_error`."""
    return [
        f"{described(problem).title}: {'; '.join(said)}."
        for problem in table["problem"].drop_duplicates()
        if (said := _said(table[table["problem"] == problem]))
    ]


def _said(rows: pd.DataFrame) -> list[str]:
    ours = rows[rows["contender"] == OURS].set_index("error")["seconds"]
    times = rows[(rows["contender"] != OURS) & rows["seconds"].notna()]
    others_win: dict[str, list[str]] = {}
    level: dict[str, list[str]] = {}
    won, nobody = [], []
    for error in sorted(rows["error"].unique(), reverse=True):
        here, text = times[times["error"] == error], heading(error)
        others = here[~here["contender"].map(is_ours)]
        best = others.loc[others["seconds"].idxmin()] if len(others) else None
        mine = ours.get(error)
        if best is None and not known(mine):
            nobody.append(text)
        elif best is None or (known(mine) and best["seconds"] >= LEVEL * mine):
            won.append(text)
        elif not known(mine):
            others_win.setdefault(best["contender"], []).append(f"{text} (galvi does not reach it)")
        elif mine >= LEVEL * best["seconds"]:
            factor = readable(mine / best["seconds"], 2)
            others_win.setdefault(best["contender"], []).append(f"{text} ({factor} times faster)")
        else:
            level.setdefault(best["contender"], []).append(text)
    said = [f"{other} wins at {', '.join(where)}" for other, where in others_win.items()]
    said += [f"galvi is level with {other} at {', '.join(where)}" for other, where in level.items()]
    said += [f"galvi is fastest at {', '.join(won)}"] if won else []
    return said + ([f"nobody reaches {', '.join(nobody)}"] if nobody else [])
