"""Step sizes at which an integrator's measured order of convergence is its formal one."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from benchmarks.applications.kit.truths import Differences, Truth, distances, largest
from galvi import Problem

HALVINGS = 15  # largest number of halvings of the time between two states of the truth
ORDER_TOLERANCE = 0.12  # of both measured orders; tests of other projects may allow 0.3
SMALLEST_ERROR_RATIO = 100.0  # least ratio of an error to the stated error of the truth
LARGEST_RELATIVE_ERROR = (
    1e-2  # of errors, to the largest entry: larger ones are not in the asymptotic range
)


@dataclass(frozen=True)
class Convergence:
    """The order, and three step sizes, each half of the one before, at which it was measured.

    Attributes
    ----------
    truth_index
        index of the truth's time at which errors were measured, 0 for the first after the start
    """

    order: int
    truth_index: int
    steps: tuple[float, float, float]


@dataclass(frozen=True)
class Method:
    """A contender that takes equal steps, with the further options of its settings."""

    contender: Any
    options: Mapping[str, Any]


def convergence(
    problem: Problem,
    truth: Truth,
    order: int,
    methods: tuple[Method, ...],
    differences: Differences = distances,
) -> Convergence | None:
    """The longest three steps at which all `methods`, forms of one integrator, show its order.

    Of the times of the truth at which they do, the latest is taken. None where they show it at
    none.

    Parameters
    ----------
    differences
        function (positions, true positions), both (rows, ...), that returns their differences
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
        is_clear = np.all(errors[-1] > SMALLEST_ERROR_RATIO * truth.error_q[1:], axis=0)
        if k < 2 or not np.any(is_clear):
            continue
        with np.errstate(all="ignore"):
            measured = np.log2(np.array(errors[-3:-1]) / np.array(errors[-2:]))
        holds = is_clear & np.all(np.abs(measured - order) < ORDER_TOLERANCE, axis=(0, 1))
        holds &= np.all(errors[-3] < LARGEST_RELATIVE_ERROR * size, axis=0)
        if np.any(holds):
            latest = int(np.flatnonzero(holds)[-1])
            return Convergence(order, latest, (4.0 * step, 2.0 * step, step))
    return None
