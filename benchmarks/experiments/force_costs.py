"""What a force costs: the time of a step with it over that without, in the same rounds.

    python -m benchmarks.experiments.force_costs

The Sun and the outer planets at degree 8 and 200 days, with forces of position and of velocity, and
with the former in the Kepler frame at 400 and in a clock at 0.4 of its units; REBOUND's WHFast with
REBOUNDx's forces, at 200 days; and an arm of three hinges with motors and servos. Each median is
that of ratios to the first of its group, with an interval.
"""

from __future__ import annotations

import time

import numpy as np

from benchmarks.statistics.paired import Interval, ratio
from benchmarks.timings.forced_runs import calls

ROUNDS = 15


def costs(rounds: int = ROUNDS) -> list[tuple[str, str, float, Interval]]:
    """(group, name, microseconds a step, over the first of the group)."""
    rows = []
    for group, members in calls().items():
        times: dict[str, list[float]] = {name: [] for name in members}
        for turn in range(rounds + 1):  # the first one compiles
            for name, (call, steps) in members.items():
                begin = time.perf_counter()
                call()
                if turn:
                    times[name].append((time.perf_counter() - begin) / steps)
        plain = next(iter(times.values()))
        rows += [(group, name, 1e6 * float(np.median(each)), ratio(each, plain))
                 for name, each in times.items()]  # fmt: skip
    return rows


if __name__ == "__main__":
    for group, name, microseconds, found in costs():
        print(f"{group:27} {name:12} {microseconds:9.2f} us a step  "
              f"{found.median:7.2f} ({found.low:.2f} to {found.high:.2f})")  # fmt: skip
