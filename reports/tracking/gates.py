"""The gates of a comparison: failed runs, results that are not deterministic, grown counts, errors
or memory, and times that are slower by a rank test and by their size.

A problem that differs between the sides is an alarm, too: references solve the head's problem, so
that a wrong force would also be in the truth, and the base would look wrong.
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
NOTE = "note"  # in place of a gate, for sentences that are not alarms
WORK_COUNTS = ("steps",)  # counts of the requested work, not of its cost
MAX_LEAK_MB = 4.0  # MB that a call may leave in memory beyond those of the base
MAX_PEAK_MB = 50.0  # MB that a call may need beyond those of the base
CALLS_BETWEEN_ANSWERS = 2  # calls of the worker between two of its answers on the memory
# Tolerances for rounding in a problem's functions:
RELATIVE_TOLERANCE = 1e-9  # relative to the number itself
TOLERANCE_OF_LARGEST = 1e-13  # relative to the largest of the numbers

Truth = Sequence[np.ndarray] | str  # the exact end states, or the reason why they are unknown
Sentences = Iterator[tuple[str, str]]  # (gate or NOTE, sentence)


@dataclass(frozen=True)
class Finding:
    """The result of a benchmark. Unknown numbers are NaN.

    Attributes
    ----------
    errors
        errors of base and head against the truth
    moved
        largest difference of the final states: of a coordinate, or, for an integrator of a
        project, also of a momentum; 0 if they are bit-identical
    growth
        relative growth of the median time in the first round
    p
        probability that equal code looks at least this much slower
    visible
        smallest relative growth of times that would be detected in the first round
    alarms
        gate -> sentence on what got worse
    notes
        sentences that are not alarms
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
        """Whether both sides ran the benchmark, the base to its end, or there is an alarm."""
        return (self.pair.complete and self.pair.reached["base"]["success"]) or bool(self.alarms)


def suspects(pairs: Iterable[Pair], round_index: int) -> set[str]:
    """Names of the benchmarks that are slower in the head, by a rank test and by size, in round
    `at` of the samples."""
    timed = [pair for pair in pairs if pair.timed and len(pair.rounds) > round_index]
    samples = {pair.case.name: pair.samples(round_index) for pair in timed}
    return slower(samples, {pair.case.name: pair.case.slower for pair in timed})


def assess(pairs: Sequence[Pair], truths: Mapping[str, Truth]) -> tuple[Finding, ...]:
    """A finding for each pair; `truths` maps the names of the benchmarks to their truths."""
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
    """Sentences on the memory of a second run, which neither compilation nor other benchmarks
    affect."""
    if not pair.complete or pair.first_calls == 1:
        return
    runs = [pair.runs[side][:2] for side in SIDES]
    base_leak, head_leak = (
        (second["memory"] - first["memory"]) / 1e6 / CALLS_BETWEEN_ANSWERS for first, second in runs
    )
    base_peak, head_peak = (second["need"] / 1e6 for _, second in runs)
    if head_leak > max(base_leak, 0.0) + MAX_LEAK_MB:
        yield MEMORY, f"Each run leaves {head_leak:.0f} MB in memory, up from {base_leak:.0f} MB."
    elif head_peak > base_peak + MAX_PEAK_MB:
        yield MEMORY, f"A run needs up to {head_peak:.0f} MB, up from {base_peak:.0f} MB."


def _ends(pair: Pair, errors: tuple[float, float], truth: Truth) -> Sentences:
    """Sentences on settings, failures, problems, counts and errors of the runs of both sides."""
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
    """Names of the worker's `probed` values that differ; those of one side alone are ignored."""
    return [name for name in base if name in head and _differ(base[name], head[name])]


def _differ(base: Sequence[float], head: Sequence[float]) -> bool:
    if np.shape(base) != np.shape(head):
        return True
    largest = np.max(np.abs(base), where=np.isfinite(base), initial=0.0)
    return not np.allclose(
        head, base, RELATIVE_TOLERANCE, TOLERANCE_OF_LARGEST * largest, equal_nan=True
    )


def _counts(base: Mapping[str, int], head: Mapping[str, int], tolerance: float) -> Sentences:
    if one_sided := sorted(head.keys() ^ base.keys()):
        yield NOTE, f"Only one side reports {_named(one_sided)}, which cannot be compared."
    grown = []
    for name in head.keys() & base.keys() - set(WORK_COUNTS):
        if head[name] > base[name] * (1.0 + tolerance):
            growth_text = f" (+{100 * (head[name] / base[name] - 1):.2g} %)" if base[name] else ""
            grown.append(f"{_named([name])} rose from {base[name]} to {head[name]}{growth_text}")
    if grown:
        yield COUNTS, f"{capital('; '.join(sorted(grown)))}."


def _errors(pair: Pair, errors: tuple[float, float], truth: Truth) -> Sentences:
    base, head = errors
    tolerated = pair.case.tolerated(base)
    finite = {side: np.isfinite(pair.reached[side]["ends"]).all() for side in SIDES}
    if not finite["base"]:
        yield NOTE, "The base's final state is not finite, so errors cannot be compared."
    elif not finite["head"]:
        yield ERROR, "The head's final state is not finite."
    elif isinstance(truth, str):
        yield NOTE, f"Its error is unknown: {truth}"
    elif math.isnan(base):
        yield ERROR, "The head's final state has another shape than the base's."
    elif not head <= tolerated:
        sentence = (
            f"The error rose from {plain(base)} to {plain(head) or 'infinity'}, which is more "
            f"than the {plain(tolerated)} tolerated."
        )
        yield ERROR, sentence


def _times(pair: Pair, growth: float, p: float, slow: tuple[set[str], set[str]]) -> Sentences:
    name, text = pair.case.name, f"{100 * growth:.1f} % slower (p = {plain(p, 2)})"
    if name in slow[0] and name in slow[1]:
        second_growth = relative_growth(*pair.samples(1))
        yield TIME, f"It is {text}, and {100 * second_growth:.1f} % in a second round."
    elif name in slow[0]:
        yield NOTE, f"It looked {text}; a second round did not confirm it."


def _largest_difference(base: Sequence[Sequence[float]], head: Sequence[Sequence[float]]) -> float:
    with np.errstate(invalid="ignore"):
        return float(np.max(np.abs(np.subtract(base, head))))


def _named(names: Iterable[str]) -> str:
    return ", ".join(name.replace("_", " ") for name in names)
