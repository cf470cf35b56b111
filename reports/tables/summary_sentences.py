"""Sentences on which code is fastest at which error, and on what chances each had."""

from __future__ import annotations

import math
from itertools import groupby
from operator import itemgetter

import pandas as pd

from benchmarks.statistics.paired import TIE
from benchmarks.work_precision.asked import code_of
from benchmarks.work_precision.fronts import OURS
from benchmarks.work_precision.grid import gaps, unequal
from benchmarks.work_precision.labels import label_of
from reports.tables.comparison_tables import heading, is_ours
from reports.tables.number_format import known, readable

LEVEL = 1.1  # smaller ratios of times without an interval: neither wins
WON, NOBODY = "galvi is fastest", "nobody reaches"


def summary_sentences(table: pd.DataFrame) -> list[str]:
    """A sentence for each problem in a table of `reports.tables.comparison_tables`."""
    return [
        f"{label_of(problem).title}: {'; '.join(said)}."
        for problem in table["problem"].drop_duplicates()
        if (said := _said(table[table["problem"] == problem]))
    ]


def _said(rows: pd.DataFrame) -> list[str]:
    ours = rows[rows["contender"] == OURS].set_index("error")["seconds"]
    times = rows[(rows["contender"] != OURS) & rows["seconds"].notna()]
    seen = []
    for error in sorted(rows["error"].unique(), reverse=True):
        here = times[times["error"] == error]
        others = here[~here["contender"].map(is_ours)]
        best = others.loc[others["seconds"].idxmin()] if len(others) else None
        seen.append((*_outcome(ours.get(error), best), heading(error)))
    where: dict[str, list[str]] = {}
    for (what, remark), part in groupby(seen, key=itemgetter(0, 1)):
        some = list(part)
        note = remark.format(_span([factor for _, _, factor, _ in some]))
        where.setdefault(what, []).append(_errors([error for *_, error in some], what) + note)
    last = [what for what in (WON, NOBODY) if what in where]
    order = [what for what in where if what not in last] + last
    return [f"{what} {', '.join(where[what])}" for what in order]


def _outcome(mine: float | None, best: pd.Series | None) -> tuple[str, str, float]:
    """What is said at an error, a remark with a place for the factor, and the factor."""
    if best is None:
        return (WON if known(mine) else NOBODY), "", math.nan
    if not known(mine):
        return f"{best['contender']} wins", " (not reached by galvi)", math.nan
    factor, closer = 1.0 / best["ratio"], best.get("closer")
    beside = f" ({best['contender']} at its loosest is {{}} times as accurate as asked)"
    remark, times = (beside, closer) if known(closer) else ("", factor)
    if best["outcome"] == TIE:
        return f"galvi and {best['contender']} tie", remark, times
    if factor >= LEVEL:
        return f"{best['contender']} wins", " ({} times faster)", factor
    if factor * LEVEL <= 1.0:
        return WON, remark, times
    return f"galvi is within {100.0 * (LEVEL - 1.0):.0f} % of {best['contender']}", remark, times


def _errors(errors: list[str], what: str) -> str:
    """An error, or the range of consecutive ones, with its preposition."""
    if len(errors) == 1:
        return errors[0] if what == NOBODY else f"at {errors[0]}"
    text = f"{errors[0]} to {errors[-1]}"
    return text if what == NOBODY else f"from {text}"


def _span(factors: list[float]) -> str:
    """The least and the largest factor."""
    ends = (readable(min(factors), 2), readable(max(factors), 2))
    return " to ".join(dict.fromkeys(ends))


OVERHEAD = 0.02  # share of a timed call, above which it is said


def chances(runs: pd.DataFrame) -> tuple[str, ...]:
    """Sentences on one problem's rows of `benchmarks.work_precision.run`."""
    table = gaps(runs)
    each = ", ".join(f"{row['code']} {row['settings']}" for row in table.to_dict("records"))
    return tuple(filter(None, (f"Settings: {each}.", " ".join(unequal(runs)), overheads(runs))))


def overheads(runs: pd.DataFrame) -> str:
    """Where what a call costs besides its steps is more than OVERHEAD of the time, a sentence."""
    if "overhead" not in runs:
        return ""
    shares = runs["overhead"].groupby(runs["contender"].map(code_of), sort=False).max()
    above = [f"{code} {readable(100 * s, 2)} %" for code, s in shares.items() if s > OVERHEAD]
    return f"A call of one step takes, of the timed call: {', '.join(above)}." if above else ""
