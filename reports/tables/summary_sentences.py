"""Sentences on which code is fastest at which error, and on the settings that each code had."""

from __future__ import annotations

import math
from itertools import groupby
from operator import itemgetter

import pandas as pd

from benchmarks.statistics.paired import TIE, UNRESOLVED
from benchmarks.work_precision.asked import code_of
from benchmarks.work_precision.fronts import OURS
from benchmarks.work_precision.grid import gaps, wide_gaps
from benchmarks.work_precision.labels import label_of
from reports.tables.comparison_tables import heading, is_galvi
from reports.tables.number_format import is_finite, readable

# Ratio of two times, below which neither code wins, if the ratio has no interval:
WINNING_RATIO = 1.1
WON, NOBODY = "galvi is fastest", "nobody reaches"


def summary_sentences(table: pd.DataFrame) -> list[str]:
    """A sentence for each problem in a table of `reports.tables.comparison_tables`."""
    return [
        f"{label_of(problem).title}: {'; '.join(_ranges(rows))}."
        for problem, rows in table.groupby("problem", sort=False)
    ]


def _ranges(rows: pd.DataFrame) -> list[str]:
    """A clause for each outcome, with the ranges of errors at which it occurs.

    galvi's successes come after other outcomes, and errors that no code reaches come last.
    """
    galvi_seconds = rows[rows["contender"] == OURS].set_index("error")["seconds"]
    competitors = rows[~rows["contender"].map(is_galvi) & rows["seconds"].notna()]
    best = competitors.sort_values("seconds").drop_duplicates("error").set_index("error")
    outcomes = [
        (
            *_outcome(galvi_seconds.get(error), best.loc[error] if error in best.index else None),
            error,
        )
        for error in sorted(rows["error"].unique(), reverse=True)
    ]
    ranges: dict[str, list[str]] = {}
    for (outcome, remark), group in groupby(outcomes, key=itemgetter(0, 1)):
        _, _, factors, errors = zip(*group, strict=True)
        factor = _range_text(*(readable(end, 2) for end in (min(factors), max(factors))))
        text = _with_preposition(_range_text(heading(errors[0]), heading(errors[-1])), outcome)
        ranges.setdefault(outcome, []).append(text + remark.format(factor))
    in_order = sorted(ranges, key=lambda outcome: (outcome == NOBODY, outcome == WON))
    return [f"{outcome} {', '.join(ranges[outcome])}" for outcome in in_order]


def _outcome(galvi_seconds: float | None, best: pd.Series | None) -> tuple[str, str, float]:
    """(outcome, remark with {} for the factor, factor) at one error.

    Parameters
    ----------
    galvi_seconds
        time of galvi's fastest method
    best
        row of the fastest other code; None if none reaches the error
    """
    if best is None:
        return (WON if is_finite(galvi_seconds) else NOBODY), "", math.nan
    if not is_finite(galvi_seconds):
        return f"{best['contender']} wins", " (not reached by galvi)", math.nan
    factor, closer = 1.0 / best["ratio"], best.get("closer")
    accuracy_remark = f" ({best['contender']} at its loosest is {{}} times as accurate as asked)"
    remark, times = (accuracy_remark, closer) if is_finite(closer) else ("", factor)
    if best["outcome"] == TIE:
        tie_text = (
            "tie" if best["low"] <= 1.0 <= best["high"] else f"are {UNRESOLVED} of each other"
        )
        return f"galvi and {best['contender']} {tie_text}", remark, times
    if factor >= WINNING_RATIO:
        return f"{best['contender']} wins", " ({} times faster)", factor
    if factor * WINNING_RATIO <= 1.0:
        return WON, remark, times
    return (
        f"galvi is within {100.0 * (WINNING_RATIO - 1.0):.0f} % of {best['contender']}",
        remark,
        times,
    )


def _with_preposition(text: str, outcome: str) -> str:
    """An error or a range of errors with its preposition; without one for NOBODY."""
    preposition = "from" if " to " in text else "at"
    return text if outcome == NOBODY else f"{preposition} {text}"


def _range_text(first: str, last: str) -> str:
    """The ends of a range as text; a single one if they are equal."""
    return first if first == last else f"{first} to {last}"


MIN_OVERHEAD = 0.02  # fraction of a timed call above which an overhead is reported


def chances(runs: pd.DataFrame) -> tuple[str, ...]:
    """Sentences on the settings of the codes and on overheads, from one problem's rows of
    `benchmarks.work_precision.run`."""
    table = gaps(runs)
    settings = ", ".join(f"{row['code']} {row['settings']}" for row in table.to_dict("records"))
    return tuple(
        filter(None, (f"Settings: {settings}.", " ".join(wide_gaps(runs)), overheads(runs)))
    )


def overheads(runs: pd.DataFrame) -> str:
    """A sentence on codes for which a call of one step takes more than MIN_OVERHEAD of the timed
    call; or ""."""
    if "overhead" not in runs:
        return ""
    shares = runs["overhead"].groupby(runs["contender"].map(code_of), sort=False).max()
    above = [f"{code} {readable(100 * s, 2)} %" for code, s in shares.items() if s > MIN_OVERHEAD]
    return f"A call of one step takes, of the timed call: {', '.join(above)}." if above else ""
