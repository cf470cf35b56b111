"""What an outsider is asked for by `verify`: runs on the problems of `benchmarks.grounds`.

Rows of the tidy frame, the problem in `study` and the setting in `label`:

ERROR     largest component of the configuration's error at the end, at the coarsest, a middle and
          the finest of its settings; status when the run failed
CLAIMED   the error that it claims there
ORDER     the same errors at steps in between, where it says its order and offers steps
energy, angular momentum
          relative changes at times t of a long run, at its finest setting
FAILED    how many runs and answers failed; status says which
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd

from benchmarks import textbook
from benchmarks.claim import MakeMethod, Report
from benchmarks.grounds import Ground
from benchmarks.outsider import Outsider
from benchmarks.outsiders import FEWEST, finest, readable_setting
from benchmarks.tidy import frame, row
from galvi import Problem, Trajectory
from galvi.arrays import Array

ERROR, CLAIMED, ORDER, FAILED = "error", "claimed error", "error in between", "failed"
PARTS = 200  # of a long run
POINTS, LEAST, MOST = 9, 4.0, 2.0  # steps: how many, over which factor at least, and their ratio
FORMULAS = {"energy": textbook.energy, "angular momentum": textbook.angular_momentum}


def studied(
    outsider: Outsider,
    grounds: Sequence[Ground],
    make_method: MakeMethod,
    quick: bool,
    report: Report,
) -> pd.DataFrame:
    """The rows of every problem that it supports, or cannot answer for. Nothing here is galvi's."""
    rows = []
    for ground in grounds:
        report(ground.problem.name)
        if outsider.supports(ground.problem):
            settings = outsider.settings(ground.problem, ground.duration, FEWEST)
            if settings:
                end = ground.end()
                rows += _errors(outsider, ground, settings, end)
                rows += _in_between(outsider, ground, settings, end)
                rows += _changes(outsider, ground)
        elif not outsider.faults_on(ground.problem):
            continue
        faults = outsider.faults_on(ground.problem)
        rows.append(
            row(study=ground.problem.name, quantity=FAILED, value=len(faults),
                status=" ".join(faults))
        )  # fmt: skip
    return frame(rows)


def _errors(
    outsider: Outsider, ground: Ground, settings: Sequence[Mapping[str, Any]], end: Array
) -> Iterator[dict[str, Any]]:
    chosen = {0, len(settings) // 2, len(settings) - 1}
    told = {readable_setting(settings[k]): settings[k] for k in sorted(chosen)}
    for label, setting in told.items():
        run = _run(outsider, ground.problem, ground.duration, setting)
        known = {"study": ground.problem.name, "label": label, "t": ground.duration}
        yield row(quantity=ERROR, value=_error(run, end), status=_status(run), **known)
        claimed = outsider.claimed_error(ground.problem, ground.duration, setting)
        if claimed is not None:
            yield row(quantity=CLAIMED, value=claimed, **known)


def _in_between(
    outsider: Outsider, ground: Ground, settings: Sequence[Mapping[str, Any]], end: Array
) -> Iterator[dict[str, Any]]:
    """From its longest step to its shortest, or over a factor LEAST where that is more."""
    equal = [setting for setting in settings if "step" in setting]
    if outsider.order is None or not ground.ordered or not equal:
        return
    numbers = [max(1, round(ground.duration / setting["step"])) for setting in equal]
    few, many = min(numbers), max(*numbers, round(LEAST * min(numbers)))
    ratio = min(MOST, (many / few) ** (1.0 / (POINTS - 1)))
    for steps in dict.fromkeys(round(few * ratio**k) for k in range(POINTS)):
        step = ground.duration / steps
        run = outsider.run(
            ground.problem, ground.duration, {**equal[0], "step": step, "save_every": steps}
        )
        yield row(
            study=ground.problem.name, quantity=ORDER, step=step, steps=steps,
            value=_error(run, end), status=_status(run),
        )  # fmt: skip


def _changes(outsider: Outsider, ground: Ground) -> Iterator[dict[str, Any]]:
    if not ground.kept:
        return
    setting = finest(outsider, ground.problem, ground.long, PARTS)
    if setting is None:
        return
    label = readable_setting(setting)
    run = _run(outsider, ground.problem, ground.long, setting)
    velocity = run.problem.system.velocity(run.p)
    for name in ground.kept:
        values = FORMULAS[name](ground.problem, run.q, velocity)
        change, size = values - values[0], np.abs(values[0])
        if values.ndim > 1:
            change, size = np.linalg.norm(change, axis=-1), np.linalg.norm(values[0])
        for t, error in zip(run.t, change / size, strict=True):
            yield row(
                study=ground.problem.name, quantity=name, label=label, t=t, value=error,
                status=_status(run),
            )  # fmt: skip


def _run(
    outsider: Outsider, problem: Problem, duration: float, setting: Mapping[str, Any]
) -> Trajectory:
    """A run that must not fail, not even if it says so."""
    call = outsider.timed(problem, duration, setting)
    run = call()
    if not (run.success or call.failure):
        outsider.note(problem, f"T = {duration:g}, {readable_setting(setting)}", run.status)
    return run


def _error(run: Trajectory, end: Array) -> float:
    return float(np.max(np.abs(run.q[-1] - end))) if run.success else float("nan")


def _status(run: Trajectory) -> str:
    return "" if run.success else run.status
