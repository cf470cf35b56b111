"""Engines that were not installed where the comparisons were run, and what is missing for it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import pandas as pd

from benchmarks.checks.bounds import NOT_RUN
from benchmarks.checks.claim import Row
from reports.results.summary import many

PEERS = {"rebound": "REBOUND", "mujoco-core": "MuJoCo", "scipy": "SciPy", "heyoka": "heyoka"}
NOT_INSTALLED = "not installed"


@dataclass(frozen=True)
class Absent:
    """An engine that was not installed.

    text  a sentence on what is missing
    why   how it was told, with the remedy; empty where nobody asked for it
    """

    name: str
    text: str
    why: str


def peers(origin: Mapping[str, str]) -> str:
    """Those of PEERS that were installed, e.g. "REBOUND, MuJoCo and SciPy"."""
    *most, last = [name for key, name in PEERS.items() if origin.get(key) != NOT_INSTALLED]
    return f"{', '.join(most)} and {last}" if most else last


def absent(
    origin: Mapping[str, str],
    runs: pd.DataFrame | None,
    targets: pd.DataFrame,
    rows: Sequence[Row],
) -> tuple[Absent, ...]:
    """Those of PEERS that were not installed, by the versions in the origin of the comparisons."""
    names = [name for key, name in PEERS.items() if origin.get(key) == NOT_INSTALLED]
    return tuple(_absent(name, runs, targets, rows) for name in names)


def is_of(name: str, contender: str) -> bool:
    """Whether a contender is run by this engine."""
    return contender.split(",")[0].split(" ")[0] == name


def _absent(
    name: str, runs: pd.DataFrame | None, targets: pd.DataFrame, rows: Sequence[Row]
) -> Absent:
    asked = [is_of(name, one) for one in targets["against"]] if len(targets) else []
    unmet = int((targets[asked]["verdict"] == NOT_RUN).sum()) if any(asked) else 0
    ids = dict.fromkeys(row.id for row in rows if row.verdict == NOT_RUN and name in row.reason)
    why = "" if runs is None else next(
        (status for who, status in zip(runs["contender"], runs["status"], strict=True)
         if is_of(name, who) and status), "",
    )  # fmt: skip
    missing = ["its times", *([many(unmet, "target")] if unmet else [])]
    missing += [f"rows of {', '.join(ids)}"] if ids else []
    listed = " and ".join(filter(None, (", ".join(missing[:-1]), missing[-1])))
    text = (
        f"{name} was not installed for this build: {listed} are missing, and "
        f"rankings exclude {name}."
    )
    return Absent(name, text, why)
