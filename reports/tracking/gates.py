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
from reports.tracking.rounds import SIDES, Pair

FAILS, PROBLEM, COUNTS, ERROR, TIME = "status", "problem", "counts", "error", "time"
REPEATS, MEMORY = "not deterministic", "memory"
NOTE = ""  # not a gate: its sentences are not alarms
SAME_WORK = ("steps",)  # counts of the requested work, not of its cost
MUCH = 8e6  # bytes more that two calls leave in memory, which count
CALLS = 2  # of the worker from one of its answers on the memory to the next
PEAK = 50e6  # bytes more that a call needs meanwhile, which count
# Tolerances for rounding in a problem's functions: relative to a number, and to the largest one.
ROUNDED, CANCELLED = 1e-9, 1e-13


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
        both = len(self.pair.reached) == len(SIDES)
        return (both and bool(self.pair.reached["base"]["success"])) or bool(self.alarms)


def suspects(pairs: Iterable[Pair], at: int) -> set[str]:
    """Names of the benchmarks whose head is slower, by rank and size, in round `at` of samples."""
    timed = [pair for pair in pairs if len(pair.rounds) > at and not pair.why]
    samples = {pair.case.name: _samples(pair, at) for pair in timed}
    return slower(samples, {pair.case.name: pair.case.slower for pair in timed})


def judge(
    pairs: Sequence[Pair], truths: Mapping[str, Sequence[np.ndarray] | str]
) -> tuple[Finding, ...]:
    """A finding for each pair.

    truths  by benchmark: the exact end states, or the reason why they are unknown
    """
    slow = (suspects(pairs, 0), suspects(pairs, 1))
    timed = sum(bool(pair.rounds) and not pair.why for pair in pairs)
    return tuple(_finding(pair, truths[pair.case.name], slow, timed) for pair in pairs)


def _finding(
    pair: Pair, truth: Sequence[np.ndarray] | str, slow: tuple[set[str], set[str]], timed: int
) -> Finding:
    errors, moved, growth, p = (math.nan, math.nan), math.nan, math.nan, math.nan
    visible = math.nan
    said = [*_failures(pair), *_repeats(pair), *_memory(pair)]
    if len(pair.reached) == len(SIDES):
        base, head = (pair.reached[side] for side in SIDES)
        changed = _changed(base["problem"], head["problem"])
        if base.get("offered", "") != head.get("offered", ""):
            said.append((NOTE, _other_settings(base["offered"], head["offered"])))
        if base["success"] and np.shape(base["ends"]) == np.shape(head["ends"]):
            moved = _moved(base["ends"], head["ends"])
            if not isinstance(truth, str):
                errors = error_of(base["ends"], truth), error_of(head["ends"], truth)
        if not base["success"]:
            said.append((NOTE, f"The base's run fails: {base['status']}"))
        elif not head["success"]:
            said.append((FAILS, f"The head's run fails: {head['status']}"))
        elif changed:
            sentence = (
                f"The problem itself is not the base's ({_named(changed)}), and the truth is that "
                "of the head's problem: counts and errors do not compare."
            )
            said.append((PROBLEM, sentence))
        else:
            said += [*_counts(pair, base["counts"], head["counts"]), *_errors(pair, errors, truth)]
    if pair.rounds and not pair.why:
        growth, p = (how(*_samples(pair, 0)) for how in (relative_growth, p_value))
        said += _times(pair, growth, p, slow)
        visible = smallest_visible(pair.rounds[0]["base"], timed, pair.case.slower)
    alarms = {gate: sentence for gate, sentence in said if gate != NOTE}
    notes = pair.notes + tuple(sentence for gate, sentence in said if gate == NOTE)
    return Finding(pair, errors, moved, growth, p, visible, alarms, notes)


def _other_settings(base: str, head: str) -> str:
    return (
        f"The finest setting that the base offers is {base or 'none'}, that of the head "
        f"{head or 'none'}: both were run at the head's, so that a change of settings is not "
        f"in the numbers."
    )


def _samples(pair: Pair, at: int) -> tuple[list[float], list[float]]:
    return pair.rounds[at]["base"], pair.rounds[at]["head"]


def _failures(pair: Pair) -> Iterator[tuple[str, str]]:
    if set(pair.why) == {"head"}:
        yield FAILS, f"The head cannot run it: {pair.why['head']}"
    elif pair.why:
        reasons = "; ".join(f"the {side}: {why}" for side, why in sorted(pair.why.items()))
        yield NOTE, f"Not compared, as it cannot be run. {capital(reasons)}"


def _repeats(pair: Pair) -> Iterator[tuple[str, str]]:
    first = {side: pair.reached[side]["ends"] for side in pair.again}
    second = {side: again["ends"] for side, again in pair.again.items()}
    apart = [side for side in first if not np.array_equal(first[side], second[side], True)]
    for side in apart:
        far = plain(_moved(first[side], second[side]), 2) or "a number that is not finite"
        gate = REPEATS if side == "head" and "base" not in apart else NOTE
        yield gate, f"Two runs of the {side} differ by {far}: it is not deterministic."
    if apart:
        return
    apart = [side for side in first if pair.differs(side)]
    for side in apart:
        gate = REPEATS if side == "head" and "base" not in apart else NOTE
        sentence = (
            f"Runs of the {side} in two processes differ: its result depends on the process, as on "
            "the hash of a text, the order of a set, or an address."
        )
        yield gate, sentence


def _memory(pair: Pair) -> Iterator[tuple[str, str]]:
    """What a second run leaves in memory: neither compilation nor what other benchmarks took."""
    left = {
        side: again.get("memory", math.nan) - pair.reached[side].get("memory", math.nan)
        for side, again in pair.again.items()
    }
    base, head = (left.get(side, math.nan) for side in SIDES)
    if head > max(base, 0.0) + MUCH:
        base, head = (each / CALLS / 1e6 for each in (base, head))
        yield MEMORY, f"a run leaves {head:.0f} MB in memory, where it left {base:.0f}."
        return
    base, head = (pair.again.get(side, {}).get("need", math.nan) for side in SIDES)
    if head > base + PEAK:
        yield MEMORY, f"a run needs {head / 1e6:.0f} MB at most, where it needed {base / 1e6:.0f}."


def _changed(base: Mapping[str, Any], head: Mapping[str, Any]) -> list[str]:
    """Names of the worker's `probed` values that both sides have and that differ."""
    return [name for name in base if name in head and _differ(base[name], head[name])]


def _differ(base: Sequence[float], head: Sequence[float]) -> bool:
    one, other = np.asarray(base), np.asarray(head)
    if one.shape != other.shape or np.any(np.isfinite(one) != np.isfinite(other)):
        return True
    one, other = one[np.isfinite(one)], other[np.isfinite(other)]
    size = np.maximum(np.abs(one), np.abs(other))
    allowed = ROUNDED * size + CANCELLED * np.max(size, initial=0.0)
    return bool(np.any(np.abs(one - other) > allowed))


def _counts(
    pair: Pair, base: Mapping[str, int], head: Mapping[str, int]
) -> Iterator[tuple[str, str]]:
    more, alone = [], sorted(head.keys() ^ base.keys())
    if alone:
        yield NOTE, f"Only one side counts {_named(alone)}, so that cannot be compared."
    for name, count in head.items():
        before = base.get(name, count)
        if name in SAME_WORK or count <= before * (1.0 + pair.case.count_tolerance):
            continue
        share = f", {100 * (count / before - 1):.2g} % more" if before else ""
        more.append(f"{_named([name])} {before} became {count}{share}")
    if more:
        yield COUNTS, f"{'; '.join(more)}."


def _errors(
    pair: Pair, errors: tuple[float, float], truth: Sequence[np.ndarray] | str
) -> Iterator[tuple[str, str]]:
    base, head = errors
    allowed = base * (1.0 + pair.case.error_tolerance) + pair.case.rounding
    finite = {side: np.isfinite(pair.reached[side]["ends"]).all() for side in SIDES}
    if not finite["base"]:
        yield NOTE, "The base's ends are not finite, so that errors do not compare."
    elif isinstance(truth, str):
        yield NOTE, f"Its error is not known: {truth}"
        if not finite["head"]:
            yield ERROR, "the head's ends are not finite."
    elif math.isnan(base):
        yield ERROR, "the head's ends have another shape than the base's."
    elif not head <= allowed:
        now = plain(head) or "not a number"
        yield ERROR, f"error {plain(base)} became {now}, more than {plain(allowed)}."


def _times(
    pair: Pair, growth: float, p: float, slow: tuple[set[str], set[str]]
) -> Iterator[tuple[str, str]]:
    name, text = pair.case.name, f"slower by {100 * growth:.1f} % (p = {plain(p, 2)})"
    if name in slow[0] and name in slow[1]:
        again = relative_growth(*_samples(pair, 1))
        yield TIME, f"{text}, in a second round by {100 * again:.1f} %."
    elif name in slow[0]:
        yield NOTE, f"It looked {text}, which a second round did not confirm."


def _moved(base: Sequence[Sequence[float]], head: Sequence[Sequence[float]]) -> float:
    with np.errstate(invalid="ignore"):
        return float(np.max(np.abs(np.subtract(base, head))))


def _named(names: Iterable[str]) -> str:
    return ", ".join(name.replace("_", " ") for name in names)
