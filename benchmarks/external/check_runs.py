"""Runs of an external integrator on the problems of `benchmarks.external.check_problems`, for
`verify`.

Rows of the tidy frame, the problem in `study` and the setting in `label`:

ERROR     largest component of the configuration's error at the end, at the coarsest, a middle and
          the finest of its settings; status when the run failed
OFF       by how much q, and p, are off there at most, at half of the time and at the end, as a
          share of how far the truth of them gets from the start; of N bodies that of the worst
CLAIMED   the error that it claims there
ORDER     the same errors at steps in between, where it declares its order and offers steps
energy, angular momentum
          relative changes from the problem's start at times t of a long run, at its finest setting
FAILED    how many runs and answers failed; status says which
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd

from benchmarks.checks.claim import MakeMethod, Report
from benchmarks.external.check_problems import CheckProblem
from benchmarks.external.integrator import ExternalIntegrator
from benchmarks.external.worker import equal_steps
from benchmarks.measures import independent_invariants
from benchmarks.store.frames import frame, row
from benchmarks.work_precision.participants import FEWEST, finest, readable_setting, sampled
from galvi import NBody, Problem, Trajectory
from galvi.arrays import Array

ERROR, CLAIMED, ORDER, FAILED = "error", "claimed error", "error in between", "failed"
OFF = {"configuration": "share of the way, q", "momenta": "share of the way, p"}
PARTS = 200  # of a long run
POINTS, LEAST, MOST = 9, 4.0, 2.0  # steps: how many, over which factor at least, and their ratio
COARSE, FEW = 1e-2, 10  # an error, and a number of steps, up to which longer ones are looked for


def check_runs(
    external: ExternalIntegrator,
    check_problems: Sequence[CheckProblem],
    make_method: MakeMethod,
    quick: bool,
    report: Report,
) -> pd.DataFrame:
    """The rows of every problem that it supports, or cannot answer for; no run is galvi's."""
    rows = []
    for check in check_problems:
        report(check.problem.name)
        if external.supports(check.problem):
            settings = external.settings(check.problem, check.duration, FEWEST)
            if settings:
                truth = check.states()
                rows += _errors(external, check, settings, truth)
                rows += _in_between(external, check, settings, truth.q[-1])
                rows += _changes(external, check)
        elif not external.faults_on(check.problem):
            continue
        faults = external.faults_on(check.problem)
        rows.append(
            row(study=check.problem.name, quantity=FAILED,
                value=external.failures_on(check.problem), status=" ".join(faults))
        )  # fmt: skip
    return frame(rows)


def _errors(
    external: ExternalIntegrator,
    check: CheckProblem,
    settings: Sequence[Mapping[str, Any]],
    truth: Trajectory,
) -> Iterator[dict[str, Any]]:
    chosen = sorted({0, len(settings) // 2, len(settings) - 1})
    halved = [sampled(check.duration, settings[k], 2) for k in chosen]
    for label, setting in {readable_setting(one): one for one in halved}.items():
        run = _run(external, check.problem, check.duration, setting)
        known = {"study": check.problem.name, "label": label, "t": check.duration}
        yield row(quantity=ERROR, value=_error(run, truth.q[-1]), status=_status(run), **known)
        for quantity, found, exact in zip(
            OFF.values(), (run.q, run.p), (truth.q, truth.p), strict=True
        ):
            off = _off(check.problem, found, exact) if run.success else float("nan")
            yield row(quantity=quantity, value=off, status=_status(run), **known)
        claimed = external.claimed_error(check.problem, check.duration, setting)
        if claimed is not None:
            yield row(quantity=CLAIMED, value=claimed, **known)


def _in_between(
    external: ExternalIntegrator,
    check: CheckProblem,
    settings: Sequence[Mapping[str, Any]],
    end: Array,
) -> Iterator[dict[str, Any]]:
    """From its longest step to its shortest, or over a factor LEAST where that is more.

    Where it offers no settings of its own, and the equal steps are too short to show its order,
    from one that is long enough.
    """
    equal = [setting for setting in settings if "step" in setting]
    if external.order is None or not check.ordered or not equal:
        return
    numbers = [max(1, round(check.duration / setting["step"])) for setting in equal]
    few = min(numbers)
    if list(settings) == equal_steps(check.duration, FEWEST):
        few = _fewer(external, check, end, few)
    many = max(round(LEAST * few), *(numbers if few in numbers else [0]))
    ratio = min(MOST, (many / few) ** (1.0 / (POINTS - 1)))
    for steps in dict.fromkeys(round(few * ratio**k) for k in range(POINTS)):
        step = check.duration / steps
        setting = {**equal[0], "step": step, "save_every": steps}
        run = _run(external, check.problem, check.duration, setting)
        yield row(
            study=check.problem.name, quantity=ORDER, step=step, steps=steps,
            value=_error(run, end), status=_status(run),
        )  # fmt: skip


def _fewer(external: ExternalIntegrator, check: CheckProblem, end: Array, few: int) -> int:
    """So few steps that an error of the declared order is above the floor LEAST times further.

    A run that fails here ends the search, and is no fault: it was not offered.
    """
    assert external.order is not None
    least = min(COARSE, check.floor * LEAST ** min(external.order, 100.0))
    while few >= FEW:
        run = external.timed(
            check.problem, check.duration,
            {"step": check.duration / few, "save_every": few}, report=lambda why: None,
        )()  # fmt: skip
        if not run.success:
            return 2 * few
        if _error(run, end) >= least:
            return few
        few //= 2
    return 2 * few


def _changes(external: ExternalIntegrator, check: CheckProblem) -> Iterator[dict[str, Any]]:
    if not check.kept:
        return
    problem = check.watched or check.problem
    setting = finest(external, problem, check.long, PARTS)
    if setting is None:
        return
    label = readable_setting(setting)
    run = _run(external, problem, check.long, setting)
    q, p = (
        np.concatenate([start[None], states])
        for start, states in ((problem.q0, run.q), (problem.p0, run.p))
    )
    formulas = {"energy": check.energy, "angular momentum": _angular_momentum}
    for name in check.kept:
        start, *values = formulas[name](problem, q, p).reshape(len(q), -1)
        change, size = np.linalg.norm(values - start, axis=-1), np.linalg.norm(start)
        for t, error in zip(run.t, change / size, strict=True):
            yield row(
                study=check.problem.name, quantity=name, label=label, t=t, value=error,
                status=_status(run),
            )  # fmt: skip


def _run(
    external: ExternalIntegrator, problem: Problem, duration: float, setting: Mapping[str, Any]
) -> Trajectory:
    """A run that must come to its end: a fault even where the contender reports the failure."""
    call = external.timed(problem, duration, setting)
    run = call()
    if not (run.success or call.failure):
        external.add_fault(problem, f"T = {duration:g}, {readable_setting(setting)}", run.status)
    return run


def _angular_momentum(problem: Problem, q: Array, p: Array) -> Array:
    system: Any = problem.system
    return independent_invariants.angular_momentum(problem, q, system.velocity(p))


def _off(problem: Problem, found: Array, truth: Array) -> float:
    """The largest distance from the truth over the largest way of the truth."""
    bodies = truth.shape[1] if isinstance(problem.system, NBody) else 1
    off, way = (
        np.max(np.abs(apart.reshape(len(truth), bodies, -1)), axis=(0, 2))
        for apart in (found - truth, truth - truth[0])
    )
    return float(np.max(off / way))


def _error(run: Trajectory, end: Array) -> float:
    return float(np.max(np.abs(run.q[-1] - end))) if run.success else float("nan")


def _status(run: Trajectory) -> str:
    return "" if run.success else run.status
