"""`track --against REV`: base and head in one job, and whether the head got worse."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any

import numpy as np

from benchmarks.timings.case import Case
from benchmarks.timings.truth import true_ends
from reports.tracking.checkouts import Checkout
from reports.tracking.gates import judge, suspects
from reports.tracking.rounds import SIDES, first_calls, take_turns
from reports.tracking.verdict import Verdict
from reports.tracking.worker import Worker


def compare(base: Checkout, head: Checkout, cases: Sequence[Case], studies: Any) -> Verdict:
    """First calls and a round of samples of all benchmarks; a second round, in new processes, of
    those that look slower. Where a process lies in memory can alone cost some percent.

    studies  (name, title) -> a context that hands out a report of progress
    """
    truths = {}
    with studies("track", "truths") as report:
        for case in cases:
            report(case.name)
            truths[case.name] = _truth(case)
    with studies("track", "first round") as report, workers(base, head) as both:
        pairs = first_calls(both, cases, report)
        take_turns(both, pairs, report)
    slow = suspects(pairs, 0)
    with studies("track", "second round") as report, workers(base, head) as both:
        take_turns(both, [pair for pair in pairs if pair.case.name in slow], report)
    return Verdict(base.name, head.name, judge(pairs, truths))


@contextmanager
def workers(base: Checkout, head: Checkout) -> Iterator[dict[str, Worker]]:
    """A process for each side."""
    with Worker(base) as one, Worker(head) as other:
        yield dict(zip(SIDES, (one, other), strict=True))


def _truth(case: Case) -> Sequence[np.ndarray] | str:
    """What the ends should be, or why that is not known."""
    try:
        return true_ends(case)
    except Exception as error:  # of any reference; the other gates need no truth
        return " ".join(str(error).split()) or type(error).__name__
