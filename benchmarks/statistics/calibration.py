"""A fixed workload, the yardstick, to compare timings across machines and load.

Times are divided by those of the yardstick. It must never change: numbers relative to another
yardstick form another series. It imports nothing of galvi, so that no commit can change it.
"""

from __future__ import annotations

import time

import numpy as np

from references.compiled import njit

NAME = "pulls of 24 points, 1"  # rename it when `work` changes
POINTS, PASSES = 24, 400


@njit()
def work(x, passes):  # type: ignore[no-untyped-def]
    """Sum the inverse-square attractions of all pairs and move the points slightly, `passes` times.

    Parameters
    ----------
    x : array, shape (n, 3)
        points, moved in place
    passes
        number of repetitions

    Returns
    -------
    float
        the sum
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
    """Processor times of the workload in seconds, each about 0.002; compilation excluded."""
    start = np.random.default_rng(0).standard_normal((POINTS, 3))
    work(start.copy(), 1)
    return [_timed(start.copy()) for _ in range(samples)]


def _timed(points: np.ndarray) -> float:
    start = time.process_time()
    work(points, PASSES)
    return time.process_time() - start
