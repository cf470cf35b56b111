"""Fixed workload normalising timings across machines and load.

Times are divided by those of the workload, the yardstick. It is never changed: numbers over another
yardstick are another series. It imports nothing of galvi, since a commit must not change the
measure that it is held against.
"""

from __future__ import annotations

import time

import numpy as np
from numba import njit

NAME = "pulls of 24 points, 1"  # changes with the work
POINTS, PASSES = 24, 400


@njit(cache=True)
def work(x, passes):  # type: ignore[no-untyped-def]
    """Sum the inverse-square attractions of all pairs, moving the points a little, so many times.

    x  points, (n, 3), changed in place
    """
    total = 0.0
    for _ in range(passes):
        for i in range(x.shape[0]):
            for j in range(i):
                u, v, w = x[i, 0] - x[j, 0], x[i, 1] - x[j, 1], x[i, 2] - x[j, 2]
                square = u * u + v * v + w * w + 1e-3
                pull = 1.0 / (square * np.sqrt(square))
                total += pull * u
                x[i, 0] += 1e-12 * pull
    return total


def yardstick(samples: int = 5) -> list[float]:
    """Processor seconds of the workload, about two milliseconds each; it is compiled before."""
    start = np.random.default_rng(0).standard_normal((POINTS, 3))
    work(start.copy(), 1)
    return [_timed(start.copy()) for _ in range(samples)]


def _timed(points: np.ndarray) -> float:
    clock = time.process_time()
    work(points, PASSES)
    return time.process_time() - clock
