"""The true end states of a case, and the error of the computed ones."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

import galvi
from benchmarks.timings.case import Case
from benchmarks.timings.worker import starts
from references import reference


class Unknown(Exception):
    """There is no truth for a case; the message gives the reason."""


def true_ends(case: Case) -> list[np.ndarray]:
    """The true final configuration of each run of a case, flat, by the reference of the case; with
    momenta for a case with a contender.

    Raises
    ------
    Unknown
        When the case names no reference, or the reference's engine is missing or its run fails.
    """
    if not case.truth:
        raise Unknown("there is no truth but galvi's own.")
    truth = reference(case.truth)
    if truth.missing:
        raise Unknown(truth.missing)
    setting = {"samples": 1} | ({"tolerance": case.truth_tolerance} if case.truth_tolerance else {})
    ends = []
    unperturbed = getattr(galvi.problems, case.problem)(**case.arguments)
    for problem in starts(unperturbed, case.starts):
        run = truth.run(problem, case.step * case.steps, setting)
        if not run.success:
            raise Unknown(run.status)
        parts = (run.q[-1], run.p[-1]) if case.contender else (run.q[-1],)
        ends.append(np.concatenate([part.ravel() for part in parts]))
    return ends


def error_of(ends: Sequence[Sequence[float]], truth: Sequence[np.ndarray]) -> float:
    """RMS over the starts of the largest difference of a component at the end; NaN when a run
    failed."""
    largest = np.max(np.abs(np.subtract(ends, truth)), axis=1)
    return float(np.sqrt(np.mean(np.square(largest))))
