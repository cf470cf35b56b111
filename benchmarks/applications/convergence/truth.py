"""The truth of an order table: passed by the user, by a named code, or the best one found."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from benchmarks.applications.convergence.methods import Methods
from benchmarks.applications.external.loading import describe_error
from benchmarks.work_precision.galvi_methods import Variational, gauss_collocation
from benchmarks.work_precision.own_problem import tolerances
from benchmarks.work_precision.participants import readable_setting
from benchmarks.work_precision.problem import EPS, Truth
from benchmarks.work_precision.truths import (
    LOOSER_FACTOR,
    TRUTHS,
    Report,
    best_truth,
    measure_of,
    truth_setting,
)
from galvi import Problem, input_checks
from galvi.arrays import Array
from galvi.interop.convergence import ConvergenceRequest
from references import named

DEGREE = 8  # of galvi's pair, where no method of a higher order is compared


def truth_of_request(request: ConvergenceRequest, methods: Methods, report: Report) -> Truth:
    """The true configuration at the end, with its error and its source.

    Raises
    ------
    ValueError
        For a function that raises or returns another shape, a code that takes equal steps or does
        not reach the end, and where there is no truth.
    ModuleNotFoundError
        For a code that is not installed.
    """
    problem, duration, truth = request.problem, request.duration, request.truth
    if isinstance(truth, str):
        return _of_code(problem, duration, truth, report)
    if truth is not None:
        end = _stated_end(problem, truth, problem.t0 + duration)
        return Truth(end, EPS * max(1.0, float(np.max(np.abs(end)))), "as given, taken as exact")
    galvi_methods = [
        contender.method for contender in methods.values() if isinstance(contender, Variational)
    ]
    usable = [
        candidate
        for candidate in (*galvi_methods, gauss_collocation(DEGREE).method)
        if not candidate.in_frame
    ]
    method = max(usable, key=lambda candidate: candidate.order)
    return best_truth(problem, duration, method, report)


def _stated_end(problem: Problem, truth: Array | Callable[[float], Any], end: float) -> Array:
    if not callable(truth):
        return truth
    try:
        value = truth(end)
    except Exception as error:  # a user's function may raise anything
        raise ValueError(f"truth({end:g}) raised {describe_error(error)}.") from None
    remedy = "It is a function of the time that returns a configuration."
    return input_checks.array(f"truth({end:g})", value, problem.q0.shape, remedy)


def _of_code(problem: Problem, duration: float, name: str, report: Report) -> Truth:
    """The end by a code at its tightest setting; its error is the difference from a looser one."""
    _, distance = measure_of(problem)
    contender: Any = named(name, problem)
    if contender.missing:
        raise ModuleNotFoundError(f"truth: {name} cannot run: {contender.missing}")
    if contender.fixed_step:
        raise ValueError(
            f"truth: {name} takes equal steps, so that its error is not known; name a code that "
            "chooses its steps, or give the configuration at the end."
        )
    report(f"truth: {contender.name}")
    has_setting = contender.name in TRUTHS
    tight = truth_setting(contender, problem) if has_setting else tolerances(contender)[-1]
    looser = {
        k: LOOSER_FACTOR * v for k, v in tight.items() if k in ("tolerance", "rtol", "epsilon")
    }
    runs = []
    for setting in ({**tight, **looser}, tight):
        run = contender.run(problem, duration, {"samples": 1, **setting})
        if not run.success:
            raise ValueError(f"truth: {contender.name} does not come to its end: {run.status}")
        runs.append(run)
    end = runs[-1].q[-1]
    error = max(distance(runs[0].q[-1], end), EPS * max(1.0, float(np.max(np.abs(end)))))
    how = (
        f"by its difference from itself at {LOOSER_FACTOR:g} times the tolerance"
        if looser
        else ("to rounding")
    )
    source = (contender.name, readable_setting({"samples": 1, **tight}))
    return Truth(end, error, f"{contender.name}, {how}", source, runs[-1].p[-1])
