"""The numbers of the head of a comparison, for services that plot them over time."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from reports.results.metrics import Metric
from reports.tracking.gates import WORK_COUNTS
from reports.tracking.outcome import Outcome


def head_metrics(outcome: Outcome) -> Iterator[Metric]:
    """Times, errors and counts of each benchmark that the head ran to its end.

    A time is the median of the first round, with half the interquartile range as its spread. It is
    also given as a multiple of the yardstick's, since runners differ in speed.
    """
    for finding in outcome.findings:
        head = finding.pair.reached.get("head")
        if head is None or not head["success"]:
            continue
        if finding.pair.timed:
            _, samples = finding.pair.samples(0)
            low, median, high = map(float, np.quantile(samples, (0.25, 0.5, 0.75)))
            spread = (high - low) / 2.0
            yield Metric(finding.name, "latency", 1e9 * median, "ns", 1e9 * spread)
            if math.isfinite(outcome.yardstick):
                relative, relative_spread = median / outcome.yardstick, spread / outcome.yardstick
                yield Metric(
                    finding.name, "time over yardstick", relative, "yardsticks", relative_spread
                )
        yield Metric(finding.name, "error", float(finding.errors[1]))
        for name, count in head["counts"].items():
            if name not in WORK_COUNTS:
                yield Metric(finding.name, name.replace("_", " "), float(count))
