"""Compare wall clock and processor clock: `python -m benchmarks.experiments.clock_comparison`.

The same work is timed by wall clock and by processor clock, while other processes keep this
machine's processors busy. Shown are the spread of single samples, (90 % - 10 %) / median, and the
largest ratio of two medians of 12 interleaved samples, which a comparison of equal code would
report. Only the processor clock stays within the 10 % that a comparison calls a change.
"""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np
import pandas as pd

from benchmarks.statistics.calibration import yardstick
from benchmarks.timings.worker import sample

CLOCKS = ("wall", "processor")
SIDE = 12  # samples of each side of a comparison
COMPARISONS = 6
BUSY = "while True: sum(range(100000))"


@contextmanager
def busy(processes: int) -> Iterator[None]:
    """Run this many busy processes, and end them afterwards."""
    others = [subprocess.Popen([sys.executable, "-c", BUSY]) for _ in range(processes)]
    try:
        yield
    finally:
        for other in others:
            other.kill()
            other.wait()


def clock_table(comparisons: int = COMPARISONS) -> pd.DataFrame:
    """A row for each number of busy processes and each clock."""
    processors = os.cpu_count() or 1
    yardstick(1)
    rows = []
    for others in (0, 1, processors, 2 * processors):
        with busy(others):
            samples = [sample(lambda: yardstick(1), 4) for _ in range(2 * SIDE * comparisons)]
        for clock in CLOCKS:
            times = np.array([one[clock] for one in samples])
            low, middle, high = np.percentile(times, (10, 50, 90))
            groups = times.reshape(comparisons, SIDE, 2)
            ratios = np.median(groups[:, :, 0], axis=1) / np.median(groups[:, :, 1], axis=1)
            rows.append(
                {
                    "busy processes": others,
                    "clock": clock,
                    "spread": (high - low) / middle,
                    "largest ratio": float(np.max(np.maximum(ratios, 1.0 / ratios))),
                }
            )
    return pd.DataFrame(rows)


if __name__ == "__main__":
    print(clock_table().to_string(index=False, float_format="%.3f"))
