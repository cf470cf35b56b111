"""`track --against REV`: run base and head alternately, and assess whether the head got worse."""

from __future__ import annotations

import math
import statistics
from collections.abc import Sequence
from typing import Any

from benchmarks.statistics.calibration import yardstick
from benchmarks.timings.case import Case
from benchmarks.timings.truth import true_ends
from reports.tracking.checkouts import Checkout
from reports.tracking.gates import Truth, assess, suspects
from reports.tracking.outcome import Outcome
from reports.tracking.rounds import Pair, interleave, long_runs, run_pairs
from reports.tracking.together import FURTHER_ROUNDS, growths_together, suspected
from reports.tracking.worker import ANSWER_SECONDS, Worker

# Samples of the yardstick before the first round and after it, as in `make bench`:
YARDSTICK_SAMPLES = 3


def compare(
    base: Checkout,
    head: Checkout,
    cases: Sequence[Case],
    studies: Any,
    limit: float = ANSWER_SECONDS,
) -> Outcome:
    """Compare base and head in several rounds of samples, each in fresh processes, since the memory
    layout of a process can change times by percents.

    The first round makes the first calls, and samples all benchmarks. The second one repeats all
    repeatable benchmarks, and samples those that looked slower; later ones repeat those whose
    result depended on the process, and sample the integrators that look slower by all of their
    benchmarks together, but by none of them alone.

    Parameters
    ----------
    studies
        (name, title) -> a context that yields a progress callback
    limit
        seconds for each answer of a side; after two timeouts a side is not asked again
    """
    count = YARDSTICK_SAMPLES if any(case.contender for case in cases) else 0
    pairs = [Pair(case) for case in cases]
    with Worker(base, limit) as base_worker, Worker(head, limit) as head_worker:
        workers = {"base": base_worker, "head": head_worker}
        with studies("track", "first round") as report:
            run_pairs(workers, pairs, report)
            seconds = yardstick(count)
            interleave(workers, pairs, report)
            seconds += yardstick(count)
            long = long_runs(workers, pairs, limit, report)
        with studies("track", "further rounds") as report:
            repeatable = [pair for pair in pairs if pair.repeatable]
            slow = suspects(pairs, 0) | suspected(pairs)
            for _ in range(FURTHER_ROUNDS):
                for worker in workers.values():
                    worker.stop()  # the next process has another memory layout
                run_pairs(workers, repeatable, report, further=True)
                interleave(workers, [pair for pair in pairs if pair.case.name in slow], report)
                repeatable = [
                    pair for pair in repeatable if pair.repeatable and pair.depends_on_process
                ]
                slow = suspected(pairs)
    with studies("track", "truths") as report:
        truths = {pair.case.name: _truth(pair.case) for pair in (*pairs, *long)}
    findings = assess([*pairs, *long], truths)
    yardstick_seconds = statistics.median(seconds) if seconds else math.nan
    return Outcome(base.name, head.name, findings, growths_together(pairs), yardstick_seconds)


def _truth(case: Case) -> Truth:
    try:
        return true_ends(case)
    except Exception as error:  # whatever the reference raises; the other gates need no truth
        return " ".join(str(error).split()) or type(error).__name__
