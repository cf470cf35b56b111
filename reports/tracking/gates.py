"""What got worse: status, counts and errors beyond their tolerances, times by rank and size.

A problem that is not the same on both sides is an alarm too. References solve the head's problem,
so that a wrong force in it would be in the truth as well, and the base would look wrong.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from benchmarks.statistics.rank_test import chance, growth, slower
from benchmarks.timings.truth import error_of
from reports.tables.number_format import plain
from reports.tracking.rounds import Pair

FAILS, PROBLEM, COUNTS, ERROR, TIME = "status", "problem", "counts", "error", "time"
SAME_WORK = ("steps",)  # counts that are what was asked for, not what it cost
# What rounding may change in a problem's functions: of the number, and of the largest beside it.
ROUNDED, CANCELLED = 1e-9, 1e-13


@dataclass
class Finding:
    """One benchmark: its numbers on both sides, and what got worse.

    base_error, head_error  NaN where they are not known
    moved     largest difference of a coordinate at the ends; 0 when equal to the bit
    times     median seconds of base and head, NaN where not timed
    growth    of the median time, of the first round
    chance    that equal code looks so
    alarms    gate -> sentence
    notes     sentences that are no alarm
    """

    name: str
    base_counts: dict[str, int] = field(default_factory=dict)
    head_counts: dict[str, int] = field(default_factory=dict)
    base_error: float = math.nan
    head_error: float = math.nan
    moved: float = math.nan
    times: tuple[float, float] = (math.nan, math.nan)
    growth: float = math.nan
    chance: float = math.nan
    compared: bool = False
    alarms: dict[str, str] = field(default_factory=dict)
    notes: list[str] = field(default_factory=list)


def suspects(pairs: Iterable[Pair], at: int = 0) -> set[str]:
    """Cases whose head is slower by rank and size in that round of samples."""
    timed = [pair for pair in pairs if pair.timed and len(pair.samples) > at]
    samples = {pair.case.name: pair.samples[at] for pair in timed}
    return slower(samples, {pair.case.name: pair.case.slower for pair in timed})


def judge(
    pairs: Sequence[Pair], truths: Mapping[str, Sequence[Any] | str], confirmed: set[str]
) -> list[Finding]:
    """A finding for each pair.

    truths     by case: what its ends should be, or why that is not known
    confirmed  cases that were slower in both rounds
    """
    findings = [_found(pair, truths[pair.case.name]) for pair in pairs]
    first = suspects(pairs)
    for pair, finding in zip(pairs, findings, strict=True):
        if not pair.timed:
            continue
        base, head = pair.samples[0]
        finding.times = (float(np.median(base)), float(np.median(head)))
        finding.growth, finding.chance = growth(base, head), chance(base, head)
        told = f"slower by {100 * finding.growth:.1f} % (p = {plain(finding.chance, 2)})"
        if pair.case.name in confirmed:
            again = growth(*pair.samples[-1])
            finding.alarms[TIME] = f"{told}, in a second round by {100 * again:.1f} %."
        elif pair.case.name in first:
            finding.notes.append(f"It looked {told}, which a second round did not confirm.")
    return findings


def _found(pair: Pair, truth: Sequence[Any] | str) -> Finding:
    finding = Finding(pair.case.name)
    base, head = pair.base, pair.head
    if "head" in pair.why and "base" not in pair.why:
        finding.alarms[FAILS] = f"The head cannot run it: {pair.why['head']}"
    elif pair.why:
        told = "; ".join(f"the {side}: {why}" for side, why in sorted(pair.why.items()))
        finding.notes.append(f"Not compared, as it cannot be run. {told[0].upper()}{told[1:]}")
    if base is None or head is None:
        finding.compared = bool(finding.alarms)
        return finding
    finding.compared = True
    finding.base_counts, finding.head_counts = base["counts"], head["counts"]
    if base["success"] and not head["success"]:
        finding.alarms[FAILS] = f"The head's run fails: {head['status']}"
    if not base["success"]:
        finding.notes.append(f"The base's run fails: {base['status']}")
        return finding
    _compare_problems(finding, base.get("problem", {}), head.get("problem", {}))
    _compare_counts(finding, pair)
    _compare_errors(finding, pair, truth)
    return finding


def _compare_problems(
    finding: Finding, base: Mapping[str, Sequence[Any]], head: Mapping[str, Sequence[Any]]
) -> None:
    """Numbers of the worker's `probed`, those that both sides have."""
    other = [name for name in base if name in head and _differ(base[name], head[name])]
    if other:
        named = ", ".join(name.replace("_", " ") for name in other)
        finding.alarms[PROBLEM] = (
            f"The problem itself is not the base's ({named}), and the truth is that of the head's "
            "problem: counts and errors do not compare."
        )


def _differ(one: Sequence[Any], other: Sequence[Any]) -> bool:
    """None stands for what is not finite."""
    if len(one) != len(other) or [x is None for x in one] != [x is None for x in other]:
        return True
    pairs = [(x, y) for x, y in zip(one, other, strict=True) if x is not None]
    scale = max((max(abs(x), abs(y)) for x, y in pairs), default=0.0)
    return any(abs(x - y) > ROUNDED * max(abs(x), abs(y)) + CANCELLED * scale for x, y in pairs)


def _compare_counts(finding: Finding, pair: Pair) -> None:
    more, alone = [], sorted(finding.head_counts.keys() ^ finding.base_counts.keys())
    if alone:
        named = ", ".join(name.replace("_", " ") for name in alone)
        finding.notes.append(f"Only one side counts {named}, so that cannot be compared.")
    for name, count in finding.head_counts.items():
        before = finding.base_counts.get(name, count)
        if name in SAME_WORK or count <= before * (1.0 + pair.case.count_tolerance):
            continue
        share = f", {100 * (count / before - 1):.2g} % more" if before else ""
        more.append(f"{name.replace('_', ' ')} {before} became {count}{share}")
    if more:
        finding.alarms[COUNTS] = f"{'; '.join(more)}."


def _compare_errors(finding: Finding, pair: Pair, truth: Sequence[Any] | str) -> None:
    assert pair.base and pair.head
    base, head = pair.base["ends"], pair.head["ends"]
    finding.moved = _moved(base, head)
    if isinstance(truth, str):
        finding.notes.append(f"Its error is not known: {truth}")
        return
    finding.base_error, finding.head_error = error_of(base, truth), error_of(head, truth)
    if not pair.head["success"]:
        return
    if math.isnan(finding.base_error):
        finding.notes.append("The base's ends are not finite, so that errors do not compare.")
        return
    allowed = max(finding.base_error * (1.0 + pair.case.error_tolerance), pair.case.rounding)
    if not finding.head_error <= allowed:
        finding.alarms[ERROR] = (
            f"error {plain(finding.base_error)} became {plain(finding.head_error)}, "
            f"more than {plain(allowed)}."
        )


def _moved(base: Sequence[Sequence[float | None]], head: Sequence[Sequence[float | None]]) -> float:
    """Largest difference, NaN when a number is missing on one side."""
    pairs = [pair for one, other in zip(base, head, strict=True) for pair in zip(one, other,
             strict=True)]  # fmt: skip
    if any(x is None or y is None for x, y in pairs):
        return math.nan
    return max((abs(x - y) for x, y in pairs), default=0.0)  # type: ignore[operator]
