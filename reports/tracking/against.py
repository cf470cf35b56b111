"""`track --against REV`: run base and head alternately, and judge whether head got worse."""

from __future__ import annotations

import math
import statistics
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any

import numpy as np

from benchmarks.statistics.calibration import yardstick
from benchmarks.timings.case import Case
from benchmarks.timings.truth import true_ends
from reports.tracking.gates import judge, suspects
from reports.tracking.outcome import Outcome
from reports.tracking.project import Checkout
from reports.tracking.rounds import SIDES, first_calls, further_process, interleave, long_runs
from reports.tracking.together import FURTHER, judge_together, suspected
from reports.tracking.worker import SECONDS, Patience, Worker

YARDSTICKS = 3  # samples before and after, as of `make bench`


def compare(
    base: Checkout,
    head: Checkout,
    cases: Sequence[Case],
    studies: Any,
    limit: float = SECONDS,
) -> Outcome:
    """Make the first calls and one round of samples of all benchmarks, then run each in a further
    process, with a second round of samples where it looked slower, and further ones where all of
    an integrator did and none alone is slower already: the memory layout of a process alone can
    cost percents.

    studies  (name, title) -> a context that yields a progress callback
    limit    seconds for each answer of a side; after two that miss it, the side is not asked again
    """
    patience = {side: Patience(limit) for side in SIDES}
    truths = {}
    with studies("track", "truths") as report:
        for case in cases:
            report(case.name)
            truths[case.name] = _truth(case)
    timed_beside = yardstick(YARDSTICKS) if any(case.contender for case in cases) else []
    with studies("track", "first round") as report, workers(base, head, patience) as both:
        pairs = first_calls(both, cases, report)
        interleave(both, pairs, report)
        timed_beside += yardstick(YARDSTICKS) if timed_beside else []
        long = long_runs(both, pairs, limit, report)
    truths |= {pair.case.name: _truth(pair.case) for pair in long}
    slow = suspects(pairs, 0) | suspected(pairs, set())
    with studies("track", "second round") as report, workers(base, head, patience) as both:
        further_process(both, [pair for pair in pairs if pair.repeatable], report)
        interleave(both, [pair for pair in pairs if pair.case.name in slow], report)
    with studies("track", "further rounds") as report:
        red = suspects(pairs, 0) & suspects(pairs, 1)
        for number in range(1, FURTHER):
            doubtful = [pair for pair in pairs if number == 1 and pair.depends_on_process]
            slow = suspected(pairs, red)
            with workers(base, head, patience) as both:
                further_process(both, doubtful, report)
                interleave(both, [pair for pair in pairs if pair.case.name in slow], report)
    findings = judge([*pairs, *long], truths)
    seconds = statistics.median(timed_beside) if timed_beside else math.nan
    return Outcome(base.name, head.name, findings, judge_together(pairs), seconds)


@contextmanager
def workers(
    base: Checkout, head: Checkout, patience: Mapping[str, Patience]
) -> Iterator[dict[str, Worker]]:
    """A worker process for each side, whose patience it shares."""
    with Worker(base, patience["base"]) as one, Worker(head, patience["head"]) as other:
        yield dict(zip(SIDES, (one, other), strict=True))


def _truth(case: Case) -> Sequence[np.ndarray] | str:
    """The exact end states, or the reason why they are unknown."""
    try:
        return true_ends(case)
    except Exception as error:  # whatever the reference raises; the other gates need no truth
        return " ".join(str(error).split()) or type(error).__name__
