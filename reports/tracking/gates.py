"""Gates of a comparison: failed runs, other bits in a second run or process, grown counts, errors
or memory, times slower by rank and size.

A problem that differs between the sides is an alarm too: references solve the head's problem, so a
wrong force in it would be in the truth as well, and the base would look wrong.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from benchmarks.statistics.rank_test import p_value, relative_growth, slower, smallest_visible
from benchmarks.timings.truth import error_of
from reports.tables.number_format import capital, plain
from reports.tracking.rounds import FURTHER_PROCESSES, SECOND, SIDES, Pair

FAILS, PROBLEM, REPEATS, COUNTS = "status", "problem", "not deterministic", "counts"
ERROR, MEMORY, TIME = "error", "memory", "time"
GATES = (FAILS, PROBLEM, REPEATS, COUNTS, ERROR, MEMORY, TIME)
NOTE = "note"  # not a gate: its sentences are not alarms
SAME_WORK = ("steps",)  # counts of the requested work, not of its cost
LEAK, PEAK = 4.0, 50.0  # MB more that a call leaves in memory, or needs meanwhile, which count
CALLS = 2  # of the worker from one of its answers on the memory to the next
# Tolerances for rounding in a problem's functions: relative to a number, and to the largest one.
ROUNDED, CANCELLED = 1e-9, 1e-13

Truth = Sequence[np.ndarray] | str  # the exact end states, or the reason why they are unknown
Sentences = Iterator[tuple[str, str]]  # with the gate of each, or NOTE


@dataclass(frozen=True)
class Finding:
    """One benchmark: its numbers on both sides, and what got worse. NaN where unknown.

    errors  of base and head against the truth
    moved   largest difference of a number of the end, a coordinate or, of an integrator of a
            project, a momentum; 0 when bit-identical
    growth  relative growth of the median time in the first round
    p       probability that equal code looks this much slower
    visible smallest relative growth of times that would have counted in the first round
    alarms  gate -> sentence
    notes   sentences that are not alarms
    """

    pair: Pair
    errors: tuple[float, float]
    moved: float
    growth: float
    p: float
    visible: float
    alarms: Mapping[str, str]
    notes: tuple[str, ...]

    @property
    def name(self) -> str:
        """The name of the benchmark."""
        return self.pair.case.name

    @property
    def compared(self) -> bool:
        """Whether both sides ran it, the base to its end, or the head should have."""
        return (self.pair.complete and self.pair.reached["base"]["success"]) or bool(self.alarms)


def suspects(pairs: Iterable[Pair], at: int) -> set[str]:
    """Names of the benchmarks whose head is slower, by rank and size, in round `at` of samples."""
    timed = [pair for pair in pairs if pair.timed and len(pair.rounds) > at]
    samples = {pair.case.name: pair.samples(at) for pair in timed}
    return slower(samples, {pair.case.name: pair.case.slower for pair in timed})


def assess(pairs: Sequence[Pair], truths: Mapping[str, Truth]) -> tuple[Finding, ...]:
    """A finding for each pair; truths are by the names of the benchmarks."""
    slow = (suspects(pairs, 0), suspects(pairs, 1))
    timed = sum(pair.timed for pair in pairs)
    return tuple(_finding(pair, truths[pair.case.name], slow, timed) for pair in pairs)


def _finding(pair: Pair, truth: Truth, slow: tuple[set[str], set[str]], timed: int) -> Finding:
    errors, moved = (math.nan, math.nan), math.nan
    growth = p = visible = math.nan
    if pair.complete and pair.reached["base"]["success"]:
        base, head = (pair.reached[side]["ends"] for side in SIDES)
        if np.shape(base) == np.shape(head):
            moved = _largest_difference(base, head)
            if not isinstance(truth, str):
                errors = error_of(base, truth), error_of(head, truth)
    if pair.timed:
        samples = pair.samples(0)
        growth, p = relative_growth(*samples), p_value(*samples)
        visible = smallest_visible(*samples, timed, pair.case.slower)
    sentences = [
        *_runs(pair),
        *_repeats(pair),
        *_memory(pair),
        *_ends(pair, errors, truth),
        *_times(pair, growth, p, slow),
    ]
    alarms = {gate: sentence for gate, sentence in sentences if gate != NOTE}
    notes = pair.notes + tuple(sentence for gate, sentence in sentences if gate == NOTE)
    return Finding(pair, errors, moved, growth, p, visible, alarms, notes)


def _runs(pair: Pair) -> Sentences:
    if set(pair.why) == {"head"}:
        yield FAILS, f"The head cannot run it: {pair.why['head']}"
    elif pair.why:
        reasons = (f"{capital(side)}: {why.rstrip('.')}." for side, why in sorted(pair.why.items()))
        yield NOTE, f"Not compared, because it cannot be run. {' '.join(reasons)}"


def _repeats(pair: Pair) -> Sentences:
    differing = [side for side in pair.reached if pair.differs(side, SECOND)]
    for side in differing:
        first, second = (run["ends"] for run in pair.runs[side][:2])
        difference = plain(_largest_difference(first, second), 2) or "a number that is not finite"
        sentence = f"Two runs of the {side} differ by {difference}: it is not deterministic."
        yield REPEATS if differing == ["head"] else NOTE, sentence
    process_dependent = [side for side in pair.reached if pair.differs(side, FURTHER_PROCESSES)]
    for side in process_dependent if not differing else ():
        sentence = (
            f"Runs of the {side} in two processes differ: its result depends on the process, for "
            "example on the hash of a string, the order of a set, or an address."
        )
        yield REPEATS if process_dependent == ["head"] else NOTE, sentence


def _memory(pair: Pair) -> Sentences:
    """What a second run leaves in memory: neither compilation nor what other benchmarks took."""
    if not pair.complete or pair.first_calls == 1:
        return
    runs = [pair.runs[side][:2] for side in SIDES]
    left, head_left = ((second["memory"] - first["memory"]) / 1e6 / CALLS for first, second in runs)
    peak, head_peak = (second["need"] / 1e6 for _, second in runs)
    if head_left > max(left, 0.0) + LEAK:
        yield MEMORY, f"Each run leaves {head_left:.0f} MB in memory, up from {left:.0f} MB."
    elif head_peak > peak + PEAK:
        yield MEMORY, f"A run needs up to {head_peak:.0f} MB, up from {peak:.0f} MB."


def _ends(pair: Pair, errors: tuple[float, float], truth: Truth) -> Sentences:
    """What the runs of both sides reached."""
    if not pair.complete:
        return
    base, head = (pair.reached[side] for side in SIDES)
    if base["offered"] != head["offered"]:
        sentence = (
            f"The finest setting of the base is {base['offered'] or 'none'}, that of the head "
            f"{head['offered'] or 'none'}. Both ran at the head's, so the numbers do not show "
            "the change of settings."
        )
        yield NOTE, sentence
    if not base["success"]:
        yield NOTE, f"The base's run failed: {base['status']}"
    elif not head["success"]:
        yield FAILS, f"The head's run failed: {head['status']}"
    elif changed := _changed(base["problem"], head["problem"]):
        sentence = (
            f"The problem itself changed ({_named(changed)}). The truth is that of the head's "
            "problem, so counts and errors cannot be compared."
        )
        yield PROBLEM, sentence
    else:
        yield from _counts(base["counts"], head["counts"], pair.case.count_tolerance)
        yield from _errors(pair, errors, truth)


def _changed(base: Mapping[str, Any], head: Mapping[str, Any]) -> list[str]:
    """Names of the worker's `probed` values that both sides have and that differ."""
    return [name for name in base if name in head and _differ(base[name], head[name])]


def _differ(base: Sequence[float], head: Sequence[float]) -> bool:
    if np.shape(base) != np.shape(head):
        return True
    largest = np.max(np.abs(base), where=np.isfinite(base), initial=0.0)
    return not np.allclose(head, base, ROUNDED, CANCELLED * largest, equal_nan=True)


def _counts(base: Mapping[str, int], head: Mapping[str, int], tolerance: float) -> Sentences:
    if lacking := sorted(head.keys() ^ base.keys()):
        yield NOTE, f"Only one side reports {_named(lacking)}, which cannot be compared."
    grown = []
    for name in head.keys() & base.keys() - set(SAME_WORK):
        if head[name] > base[name] * (1.0 + tolerance):
            share = f" (+{100 * (head[name] / base[name] - 1):.2g} %)" if base[name] else ""
            grown.append(f"{_named([name])} rose from {base[name]} to {head[name]}{share}")
    if grown:
        yield COUNTS, f"{capital('; '.join(sorted(grown)))}."


def _errors(pair: Pair, errors: tuple[float, float], truth: Truth) -> Sentences:
    base, head = errors
    allowed = pair.case.tolerated(base)
    finite = {side: np.isfinite(pair.reached[side]["ends"]).all() for side in SIDES}
    if not finite["base"]:
        yield NOTE, "The base's final state is not finite, so errors cannot be compared."
    elif not finite["head"]:
        yield ERROR, "The head's final state is not finite."
    elif isinstance(truth, str):
        yield NOTE, f"Its error is unknown: {truth}"
    elif math.isnan(base):
        yield ERROR, "The head's final state has another shape than the base's."
    elif not head <= allowed:
        sentence = (
            f"The error rose from {plain(base)} to {plain(head) or 'infinity'}, which is more "
            f"than the {plain(allowed)} tolerated."
        )
        yield ERROR, sentence


def _times(pair: Pair, growth: float, p: float, slow: tuple[set[str], set[str]]) -> Sentences:
    name, text = pair.case.name, f"{100 * growth:.1f} % slower (p = {plain(p, 2)})"
    if name in slow[0] and name in slow[1]:
        again = relative_growth(*pair.samples(1))
        yield TIME, f"It is {text}, and {100 * again:.1f} % in a second round."
    elif name in slow[0]:
        yield NOTE, f"It looked {text}; a second round did not confirm it."


def _largest_difference(base: Sequence[Sequence[float]], head: Sequence[Sequence[float]]) -> float:
    with np.errstate(invalid="ignore"):
        return float(np.max(np.abs(np.subtract(base, head))))


def _named(names: Iterable[str]) -> str:
    return ", ".join(name.replace("_", " ") for name in names)
