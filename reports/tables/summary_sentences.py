"""Sentences on which code is fastest at which error, and on what chances each had."""

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

LEVEL = 1.1  # smaller ratios of times without an interval: neither wins
WON, NOBODY = "galvi is fastest", "nobody reaches"


def summary_sentences(table: pd.DataFrame) -> list[str]:
    """A sentence for each problem in a table of `reports.tables.comparison_tables`."""
    return [
        f"{label_of(problem).title}: {'; '.join(_ranges(rows))}."
        for problem, rows in table.groupby("problem", sort=False)
    ]


def _ranges(rows: pd.DataFrame) -> list[str]:
    """For each outcome the ranges of errors at which it is so, galvi's successes last."""
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
        factor = _ends(*(readable(end, 2) for end in (min(factors), max(factors))))
        text = _errors(_ends(heading(errors[0]), heading(errors[-1])), outcome)
        ranges.setdefault(outcome, []).append(text + remark.format(factor))
    in_order = sorted(ranges, key=lambda outcome: (outcome == NOBODY, outcome == WON))
    return [f"{outcome} {', '.join(ranges[outcome])}" for outcome in in_order]


def _outcome(galvi_seconds: float | None, best: pd.Series | None) -> tuple[str, str, float]:
    """(outcome, remark with {} for the factor, factor) at one error."""
    if best is None:
        return (WON if is_finite(galvi_seconds) else NOBODY), "", math.nan
    if not is_finite(galvi_seconds):
        return f"{best['contender']} wins", " (not reached by galvi)", math.nan
    factor, closer = 1.0 / best["ratio"], best.get("closer")
    beside = f" ({best['contender']} at its loosest is {{}} times as accurate as asked)"
    remark, times = (beside, closer) if is_finite(closer) else ("", factor)
    if best["outcome"] == TIE:
        how = "tie" if best["low"] <= 1.0 <= best["high"] else f"are {UNRESOLVED} of each other"
        return f"galvi and {best['contender']} {how}", remark, times
    if factor >= LEVEL:
        return f"{best['contender']} wins", " ({} times faster)", factor
    if factor * LEVEL <= 1.0:
        return WON, remark, times
    return f"galvi is within {100.0 * (LEVEL - 1.0):.0f} % of {best['contender']}", remark, times


def _errors(text: str, outcome: str) -> str:
    """An error, or a range of them, with its preposition."""
    preposition = "from" if " to " in text else "at"
    return text if outcome == NOBODY else f"{preposition} {text}"


def _ends(first: str, last: str) -> str:
    """Both ends of a range, or the one where they are equal."""
    return first if first == last else f"{first} to {last}"


OVERHEAD = 0.02  # share of a timed call, from which it is reported


def chances(runs: pd.DataFrame) -> tuple[str, ...]:
    """Sentences on one problem's rows of `benchmarks.work_precision.run`."""
    table = gaps(runs)
    settings = ", ".join(f"{row['code']} {row['settings']}" for row in table.to_dict("records"))
    return tuple(
        filter(None, (f"Settings: {settings}.", " ".join(wide_gaps(runs)), overheads(runs)))
    )


def overheads(runs: pd.DataFrame) -> str:
    """A sentence on codes whose calls cost more than OVERHEAD besides their steps; or ""."""
    if "overhead" not in runs:
        return ""
    shares = runs["overhead"].groupby(runs["contender"].map(code_of), sort=False).max()
    above = [f"{code} {readable(100 * s, 2)} %" for code, s in shares.items() if s > OVERHEAD]
    return f"A call of one step takes, of the timed call: {', '.join(above)}." if above else ""
