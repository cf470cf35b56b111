"""`track --against REV`: run base and head alternately, and judge whether head got worse."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any

import numpy as np

from benchmarks.timings.case import Case
from benchmarks.timings.truth import true_ends
from reports.tracking.gates import judge, suspects
from reports.tracking.outcome import Outcome
from reports.tracking.project import Checkout
from reports.tracking.rounds import SIDES, first_calls, interleave
from reports.tracking.worker import Worker


def compare(base: Checkout, head: Checkout, cases: Sequence[Case], studies: Any) -> Outcome:
    """Time the first calls and one round of samples of all benchmarks, and a second round, in new
    processes, of those that look slower: the memory layout of a process alone can cost percents.

    studies  (name, title) -> a context that yields a progress callback
    """
    truths = {}
    with studies("track", "truths") as report:
        for case in cases:
            report(case.name)
            truths[case.name] = _truth(case)
    with studies("track", "first round") as report, workers(base, head) as both:
        pairs = first_calls(both, cases, report)
        interleave(both, pairs, report)
    slow = suspects(pairs, 0)
    with studies("track", "second round") as report, workers(base, head) as both:
        interleave(both, [pair for pair in pairs if pair.case.name in slow], report)
    return Outcome(base.name, head.name, judge(pairs, truths))


@contextmanager
def workers(base: Checkout, head: Checkout) -> Iterator[dict[str, Worker]]:
    """A worker process for each side."""
    with Worker(base) as one, Worker(head) as other:
        yield dict(zip(SIDES, (one, other), strict=True))


def _truth(case: Case) -> Sequence[np.ndarray] | str:
    """The exact end states, or the reason why they are unknown."""
    try:
        return true_ends(case)
    except Exception as error:  # whatever the reference raises; the other gates need no truth
        return " ".join(str(error).split()) or type(error).__name__
