"""A problem of one's own for checking external integrators, in place of those of the suite."""

from __future__ import annotations

import numpy as np

import galvi
from benchmarks.applications.external.check_problems import CheckProblem
from benchmarks.applications.external.loading import CONSERVED, ContenderError
from benchmarks.applications.external.own_problems import load_problem, require_sendable
from benchmarks.measures.defects import invariants, kept_components
from benchmarks.work_precision.truths import truth_of, truth_setting
from galvi import Problem, Trajectory
from galvi.arrays import Array
from references import reference

SAMPLES = 20  # states of the truth at which energy and angular momentum are compared
ROUND_OFF = 1e-14  # smallest relative error of any truth
FLOOR_FACTOR = 10.0  # least ratio of errors that show an order to the truth's own
LINEAR_REFERENCE = "oscillator, closed form"  # reference whose motions show no order


def own_check_problem(path: str) -> CheckProblem:
    """The problem for checks that the function at "package.module:function" returns.

    Its truth is that of `benchmarks.work_precision.truths`; energy and angular momentum are checked
    where this truth conserves them. The long run has the function's duration.

    Raises
    ------
    ContenderError
        Where the function does not return a problem and its duration, and for a problem that cannot
        be sent to another process or that no code but galvi solves.
    """
    problem, duration = load_problem(path)
    require_sendable(problem)
    try:
        truth = truth_of(problem, duration, lambda sentence: None)
    except ValueError as error:
        raise ContenderError(str(error).rstrip(".")) from None
    name = truth.source[0]
    contender = reference(name)
    setting = truth_setting(contender, problem)
    run = contender.run(problem, duration, {"samples": SAMPLES, **setting})
    size = float(np.max(np.abs(run.q))) or 1.0
    error = max(truth.error / size, ROUND_OFF)
    conserved = [
        word
        for word, values in invariants(run).items()
        if word in CONSERVED and np.any(values[0]) and np.all(kept_components(run)[word])
    ]
    return CheckProblem(
        problem,
        duration,
        contender,
        setting,
        size=size,
        floor=max(1e-11, FLOOR_FACTOR * error),
        ordered=np.inf if name == LINEAR_REFERENCE else 0.0,
        conserved=tuple(conserved),
        long=duration,
        energy=energy,
    )


def energy(problem: Problem, q: Array, p: Array) -> Array:
    """The energy (k,) by the problem's own functions at states (k, ...), at the start's time."""
    return galvi.energy(Trajectory(problem, np.full(len(q), problem.t0), q, p))
