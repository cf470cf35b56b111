"""Step sizes at which an integrator's measured order of convergence is its formal one."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from benchmarks.applications.kit.truths import Differences, Truth, distances, largest
from galvi import Problem

HALVINGS = 15  # of the time between two states of the truth, at most
CLOSE = 0.12  # of both measured orders to the expected one; tests may ask for 0.3
CLEAR = 100.0  # the smallest error over the stated error of the truth
SMALL = 1e-2  # the largest error over the largest entry: the order is that of short steps


@dataclass(frozen=True)
class Convergence:
    """The order, and three step sizes, each half of the one before, at which it was measured.

    Attributes
    ----------
    truth_index
        of the truth's time at which errors were measured, 0 for the first after the start
    """

    order: int
    truth_index: int
    steps: tuple[float, float, float]


@dataclass(frozen=True)
class Method:
    """A way to take equal steps, with the options of its setting."""

    contender: Any
    options: Mapping[str, Any]


def convergence(
    problem: Problem,
    truth: Truth,
    order: int,
    methods: tuple[Method, ...],
    differences: Differences = distances,
) -> Convergence | None:
    """The longest steps at which all these forms of an integrator have its order, at the latest
    time; None where there are none.

    Parameters
    ----------
    differences
        of positions (rows, ...) from those of the truth
    """
    last, errors, size = len(truth.t) - 1, [], float(np.max(np.abs(truth.q)))
    for k in range(HALVINGS):
        step = (truth.t[-1] - truth.t[0]) / (last * 2**k)
        setting = {"step": step, "save_every": 2**k}
        runs = [
            method.contender.run(problem, truth.t[-1] - truth.t[0], {**setting, **method.options})
            for method in methods
        ]
        errors.append(np.array([largest(differences(run.q, truth.q)) for run in runs])[:, 1:])
        clear = np.all(errors[-1] > CLEAR * truth.error_q[1:], axis=0)
        if k < 2 or not np.any(clear):
            continue
        with np.errstate(all="ignore"):
            measured = np.log2(np.array(errors[-3:-1]) / np.array(errors[-2:]))
        holds = clear & np.all(np.abs(measured - order) < CLOSE, axis=(0, 1))
        holds &= np.all(errors[-3] < SMALL * size, axis=0)
        if np.any(holds):
            latest = int(np.flatnonzero(holds)[-1])
            return Convergence(order, latest, (4.0 * step, 2.0 * step, step))
    return None
