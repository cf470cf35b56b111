"""Runs of an external integrator on the problems of `external.check_problems`, for
`verify`.

Rows of the tidy frame, the problem in `study` and the setting in `label`:

ERROR     largest component of the configuration's error at the end, at the coarsest, a middle and
          the finest of its settings; status when the run failed
OFF       largest error of q, and of p, there, at half time and at the end, relative to the largest
          distance of the truth from the start; for N bodies that of the worst body
CLAIMED   the error it claims there
REPEAT    largest difference of any number of two runs at the coarsest
ORDER     the same errors at intermediate steps, where it declares its order and offers steps
energy, angular momentum
          relative changes from the problem's start at times t of a long run, at its finest setting,
          at random steps, twice (n = 1, 2): evenly spaced ones may beat with the motion
FAILED    number of failed runs and answers; status names them
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd

from benchmarks.applications.external.check_problems import CheckProblem
from benchmarks.applications.external.integrator import ExternalIntegrator
from benchmarks.applications.external.worker import equal_steps
from benchmarks.checks.claim import MakeMethod, Report
from benchmarks.measures import independent_invariants
from benchmarks.store.frames import frame, row
from benchmarks.work_precision.participants import (
    FEWEST,
    offered_settings,
    readable_setting,
    sampled,
)
from galvi import NBody, Problem, Trajectory
from galvi.arrays import Array

ERROR, CLAIMED, ORDER, FAILED = "error", "claimed error", "error in between", "failed"
REPEAT = "difference of two equal runs"
OFF = {"configuration": "share of the way, q", "momenta": "share of the way, p"}
PARTS = 200  # equal parts of a long run, or up to OVER times as many
OVER, CHOICE = 20, 4  # one in CHOICE of their ends is looked at
SEEDS = (1, 2)
POINTS, LEAST, MOST = 9, 4.0, 2.0  # step sizes: number, least overall factor, largest ratio
COARSE, FEW = 1e-2, 10  # largest error and least number of steps in the search for longer steps


def check_runs(
    external: ExternalIntegrator,
    check_problems: Sequence[CheckProblem],
    make_method: MakeMethod,
    quick: bool,
    report: Report,
) -> pd.DataFrame:
    """The rows of every problem that it supports or fails to answer for; no run is by galvi."""
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
        if setting is halved[0] and run.success:
            again = _run(external, check.problem, check.duration, setting)
            apart = np.inf
            if again.success and again.q.shape == run.q.shape:
                apart = max(np.max(np.abs(run.q - again.q)), np.max(np.abs(run.p - again.p)))
            yield row(quantity=REPEAT, value=apart, status=_status(again), **known)
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
    """Errors at steps from its longest to its shortest, over a factor of at least LEAST.

    Where it offers no settings and the default equal steps are too short to show its order, they
    start from a longer step.
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
    """A number of steps so small that errors of the declared order stay above the floor.

    A failed run ends the search and is not a fault, since the step was not offered.
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
    offered = offered_settings(external, problem, check.long, PARTS)
    if not offered:
        return
    steps = round(check.long / offered[-1]["step"]) if "step" in offered[-1] else PARTS * OVER
    parts = PARTS * max(1, min(OVER, steps // PARTS))
    setting = sampled(check.long, offered[-1], parts)
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
        for seed in SEEDS:
            t, seen = at_random(run.t, change / size, seed)
            for time, error in zip(t, seen, strict=True):
                yield row(
                    study=check.problem.name, quantity=name, label=label, t=time, value=error,
                    n=seed, status=_status(run),
                )  # fmt: skip


def at_random(t: Array, values: Array, seed: int) -> tuple[Array, Array]:
    """One of each CHOICE successive values at random, and the middle of their times; all values
    where there are fewer than CHOICE in a part."""
    groups = (t.size - 1) // CHOICE  # the first is the start
    if groups * CHOICE <= PARTS:
        return t, values
    chosen = np.random.default_rng(seed).integers(CHOICE, size=groups)
    first = 1 + CHOICE * np.arange(groups)
    middle = np.mean(t[1 : 1 + CHOICE * groups].reshape(groups, CHOICE), axis=1)
    return middle, values[first + chosen]


def _run(
    external: ExternalIntegrator, problem: Problem, duration: float, setting: Mapping[str, Any]
) -> Trajectory:
    """A run that must succeed: a failure is a fault even where the contender reports it."""
    call = external.timed(problem, duration, setting)
    run = call()
    if not (run.success or call.failure):
        external.add_fault(problem, f"T = {duration:g}, {readable_setting(setting)}", run.status)
    return run


def _angular_momentum(problem: Problem, q: Array, p: Array) -> Array:
    system: Any = problem.system
    return independent_invariants.angular_momentum(problem, q, system.velocity(p))


def _off(problem: Problem, found: Array, truth: Array) -> float:
    """Largest distance from the truth over the truth's largest distance from the start."""
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
