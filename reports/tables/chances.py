"""What chances each code had on a problem: numbers of settings, gaps between them, overheads."""

from __future__ import annotations

import pandas as pd

from benchmarks.work_precision.asked import code_of
from benchmarks.work_precision.dependable import dependable
from benchmarks.work_precision.grid import gaps, unequal
from benchmarks.work_precision.participants import readable_setting
from benchmarks.work_precision.peers import PEERS
from reports.tables.comparison_tables import matched, readable_ratios, smallest
from reports.tables.number_format import readable

OVERHEAD = 0.02  # share of a timed call, above which it is said


def chances(runs: pd.DataFrame) -> tuple[str, ...]:
    """Sentences on one problem's rows of `benchmarks.work_precision.run`."""
    counted = dependable(runs)
    table = gaps(counted)
    each = ", ".join(f"{row['code']} {row['settings']}" for row in table.to_dict("records"))
    return tuple(filter(None, (f"Settings: {each}.", " ".join(unequal(counted)), overheads(runs))))


def overheads(runs: pd.DataFrame) -> str:
    """Where what a call costs besides its steps is more than OVERHEAD of the time, a sentence."""
    if "overhead" not in runs:
        return ""
    shares = runs["overhead"].groupby(runs["contender"].map(code_of), sort=False).max()
    above = [f"{code} {readable(100 * s, 2)} %" for code, s in shares.items() if s > OVERHEAD]
    return f"A call of one step takes, of the timed call: {', '.join(above)}." if above else ""


def elsewhere(runs: pd.DataFrame, problem: str) -> pd.DataFrame:
    """The readable table of another machine's rows on one problem."""
    counted = dependable(runs[runs["problem"] == problem])
    return readable_ratios(matched(counted), smallest(counted), problem)


def built() -> pd.DataFrame:
    """A line for each code: its options, closed and open, how it was compiled, and the source."""
    return pd.DataFrame(
        [
            {
                "code": code,
                "closed": readable_setting(peer.closed),
                "open": "; ".join(peer.open),
                "compiled": peer.built,
                "documented": peer.source.removeprefix("https://"),
            }
            for code, peer in PEERS.items()
        ]
    )
