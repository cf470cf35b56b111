"""Runs of an external integrator on the problems of `external.check_problems`, for `verify`.

Rows of the tidy frame, the problem in `study` and the setting in `label`:

ERROR     largest component of the configuration's error at the end, at the coarsest, a middle and
          the finest of its settings; status when the run failed
OFF       largest error of q, and of p, there, at half time and at the end, relative to the largest
          distance of the truth from the start; for N bodies that of the worst body
CLAIMED   the error it claims there
REPEAT    largest difference of any number of two runs at the coarsest
ELSEWHERE the same, the second run in another process
ORDER     errors at steps that show its order, see `external.order_runs`
energy, angular momentum, LONG, CUT
          relative changes at times t, one longest run, and one that is also started half way, see
          `external.long_runs`
PRINTED   number of lines that it printed, of no problem; status has the first ones
FAILED    number of failed runs and answers; status names them
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pandas as pd

from benchmarks.applications.external.check_problems import CheckProblem
from benchmarks.applications.external.integrator import ExternalIntegrator
from benchmarks.applications.external.long_runs import LongRun, cut_run, long_run, longest_run
from benchmarks.applications.external.order_runs import order_runs
from benchmarks.checks.claim import MakeMethod, Report
from benchmarks.store.frames import failure, frame, row
from benchmarks.work_precision.participants import FEWEST, readable_setting, sampled
from galvi import NBody, Problem, Trajectory
from galvi.arrays import Array

ERROR, CLAIMED, FAILED, PRINTED = "error", "claimed error", "failed", "printed"
REPEAT = "difference of two equal runs"
ELSEWHERE = "difference of equal runs of two processes"
OFF = {"configuration": "share of the way, q", "momenta": "share of the way, p"}


def check_runs(
    external: ExternalIntegrator,
    check_problems: Sequence[CheckProblem],
    make_method: MakeMethod,
    quick: bool,
    report: Report,
) -> pd.DataFrame:
    """The rows of every problem that it supports or fails to answer for; no run is by galvi."""
    runs = _Runs(external)
    for check in check_problems:
        report(check.problem.name)
        runs.make(check)
    return frame([*runs.rows, *runs.ends()])


@dataclass(eq=False)
class _Runs:
    """The runs on one problem after another.

    coarsest  for each problem its setting and its run at the coarsest
    long      the long runs
    asked     the problems that it supports or fails to answer for
    """

    external: ExternalIntegrator
    rows: list[dict[str, Any]] = field(default_factory=list)
    coarsest: dict[CheckProblem, tuple[Mapping[str, Any], Trajectory]] = field(default_factory=dict)
    long: list[LongRun] = field(default_factory=list)
    asked: list[CheckProblem] = field(default_factory=list)

    def make(self, check: CheckProblem) -> None:
        """All runs on a problem but those of `ends`."""
        external, problem = self.external, check.problem
        if external.supports(problem):
            self.asked.append(check)
            if settings := external.settings(problem, check.duration, FEWEST):
                truth = check.states()
                self.rows += self._errors(check, settings, truth)
                self.rows += order_runs(external, check, settings, truth.q[-1])
                if long := long_run(external, check):
                    self.long.append(long)
                    self.rows += long.rows()
        elif external.faults_on(problem):
            self.asked.append(check)

    def ends(self) -> Iterator[dict[str, Any]]:
        """The longest run, runs started half way, the same runs in another process, and what failed
        or was printed."""
        external = self.external
        if first := next((one for one in self.long if one.check.kept), next(iter(self.long), None)):
            yield from longest_run(external, first)
        for check in self.coarsest:
            if getattr(check.problem.system, "explicit_time", False):
                yield from cut_run(external, check)
        external.close()
        for check, (setting, run) in self.coarsest.items():
            yield self._repeated(ELSEWHERE, check, setting, run)
        for check in self.asked:
            yield row(
                study=check.problem.name, quantity=FAILED,
                value=external.failures_on(check.problem),
                status=" ".join(external.faults_on(check.problem)),
            )  # fmt: skip
        printed = external.printed
        yield row(quantity=PRINTED, value=printed.lines, status=" / ".join(printed.first))

    def _errors(
        self, check: CheckProblem, settings: Sequence[Mapping[str, Any]], truth: Trajectory
    ) -> Iterator[dict[str, Any]]:
        external, problem, duration = self.external, check.problem, check.duration
        chosen = sorted({0, len(settings) // 2, len(settings) - 1})
        halved = [sampled(duration, settings[k], 2) for k in chosen]
        for label, setting in {readable_setting(one): one for one in halved}.items():
            run = external.checked(problem, duration, setting).run
            where = {"study": problem.name, "label": label, "t": duration}
            if setting is halved[0] and run.success:
                self.coarsest[check] = setting, run
                yield self._repeated(REPEAT, check, setting, run)
            off = float(np.max(np.abs(run.q[-1] - truth.q[-1]))) if run.success else float("nan")
            yield row(quantity=ERROR, value=off, status=failure(run), **where)
            for quantity, states, exact in zip(
                OFF.values(), (run.q, run.p), (truth.q, truth.p), strict=True
            ):
                share = _off(problem, states, exact) if run.success else float("nan")
                yield row(quantity=quantity, value=share, status=failure(run), **where)
            claimed = external.claimed_error(problem, duration, setting)
            if claimed is not None:
                yield row(quantity=CLAIMED, value=claimed, **where)

    def _repeated(
        self, quantity: str, check: CheckProblem, setting: Mapping[str, Any], run: Trajectory
    ) -> dict[str, Any]:
        again = self.external.checked(check.problem, check.duration, setting).run
        apart = np.inf
        if again.success and again.q.shape == run.q.shape:
            apart = max(np.max(np.abs(run.q - again.q)), np.max(np.abs(run.p - again.p)))
        return row(
            study=check.problem.name, quantity=quantity, label=readable_setting(setting),
            t=check.duration, value=apart, status=failure(again),
        )  # fmt: skip


def _off(problem: Problem, found: Array, truth: Array) -> float:
    """Largest distance from the truth over the truth's largest distance from the start."""
    bodies = truth.shape[1] if isinstance(problem.system, NBody) else 1
    off, way = (
        np.max(np.abs(apart.reshape(len(truth), bodies, -1)), axis=(0, 2))
        for apart in (found - truth, truth - truth[0])
    )
    return float(np.max(off / way))
