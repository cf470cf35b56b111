"""A problem of one's own for checking external integrators, in place of those of the suite."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

import galvi
from benchmarks.applications.external.check_problems import CheckProblem
from benchmarks.applications.external.loading import ContenderError
from benchmarks.applications.external.long_runs import angular_momentum
from benchmarks.applications.external.own_problems import load_problem, require_sendable
from benchmarks.work_precision.truths import TRUTHS, truth_of
from galvi import Canonical, Problem, Trajectory
from galvi.arrays import Array
from references import reference

SAMPLES = 20  # states of the truth at which energy and angular momentum are compared
ROUND_OFF = 1e-14  # relative error that no truth is better than
SAME = 1000.0  # relative change of what is conserved, over the truth's own relative error
FLOOR = 10.0  # errors that show an order, over the truth's own
LINEAR = "oscillator, closed form"  # a truth of motions that show no order


def own_check_problem(path: str) -> CheckProblem:
    """The problem of the function at "package.module:function", for the checks.

    Its truth is that of `benchmarks.work_precision.truths`; energy and angular momentum are kept
    where this truth keeps them. The long run is as long as the function says. Raises ContenderError
    for anything else than a problem and its duration, for one that cannot be sent to another
    process, and for one that no code but galvi solves.
    """
    problem, duration = load_problem(path)
    require_sendable(problem)
    try:
        truth = truth_of(problem, duration, lambda sentence: None)
    except ValueError as error:
        raise ContenderError(str(error).rstrip(".")) from None
    assert truth.source is not None
    name = truth.source[0]
    contender, setting = reference(name), dict(TRUTHS)[name]
    run = contender.run(problem, duration, {"samples": SAMPLES, **setting})
    size = float(np.max(np.abs(run.q))) or 1.0
    error = max(truth.error / size, ROUND_OFF)
    formulas = {"energy": energy, "angular momentum": angular_momentum}
    kept = [word for word, formula in formulas.items() if _keeps(run, formula, SAME * error)]
    return CheckProblem(
        problem, duration, contender, setting,
        size=size, floor=max(1e-11, FLOOR * error), ordered=np.inf if name == LINEAR else 0.0,
        kept=tuple(kept), long=duration, energy=energy,
    )  # fmt: skip


def energy(problem: Problem, q: Array, p: Array) -> Array:
    """The energy (k,) of the problem's own functions at states (k, ...) of its start's time."""
    return galvi.energy(Trajectory(problem, np.full(len(q), problem.t0), q, p))


def _keeps(run: Trajectory, formula: Callable[[Problem, Array, Array], Array], most: float) -> bool:
    """Whether a quantity is defined, not 0, and changes by at most so much of its size."""
    system: Any = run.problem.system
    if getattr(system, "explicit_time", False) or not run.success:
        return False
    if formula is angular_momentum and isinstance(system, Canonical) and run.q.shape[1:] not in (
        (2,), (3,)
    ):  # fmt: skip
        return False
    try:
        values = np.reshape(formula(run.problem, run.q, run.p), (len(run.q), -1))
    except (AttributeError, IndexError, TypeError, ValueError):  # it has none
        return False
    start = float(np.linalg.norm(values[0]))
    change = float(np.max(np.linalg.norm(values - values[0], axis=-1)))
    return start > 0.0 and change <= most * start
