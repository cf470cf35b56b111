"""Runs of an external integrator on the problems of `external.check_problems`, for its checks.

Rows of the tidy table, the problem in `study` and the setting in `label`:

ERROR     largest component of the configuration's error at the end, at the coarsest, a middle and
          the finest setting; the status has the reason where the run failed
RELATIVE_ERRORS
          largest error of q, and of p, at half time and at the end of these runs, relative to the
          largest distance of the truth from the start. For N bodies it is that of the worst body;
          the error of a body at rest is divided by the distance of the whole system
CLAIMED   the error that the integrator claims for these runs
REPEAT    largest difference of a component of q or p between two runs at the coarsest setting
ELSEWHERE the same, where the second run is in another process
ORDER     errors at steps that show its order, see `external.order_runs`
energy, angular momentum, LONG, CUT
          relative changes at times t, one longest run, and one that is also started half way, see
          `external.long_runs`
REVERSED, ROUNDING
          a run forwards and back, see `external.reversed_runs`
NOT_REVERSED, NOT_CUT
          instead of REVERSED and CUT where such a run is not possible; the status has the reason
GROWTH    MB by which memory grows in repeated runs at the coarsest setting; NaN where they would
          take too long
FAILED    number of failed runs and answers; the status names them
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from benchmarks.applications.external.check_problems import CheckProblem
from benchmarks.applications.external.integrator import CheckedRun, ExternalIntegrator
from benchmarks.applications.external.long_runs import LongRun, cut_run, long_run, longest_run
from benchmarks.applications.external.order_runs import order_runs
from benchmarks.applications.external.reversed_runs import reversed_runs
from benchmarks.store.tables import failure, row
from benchmarks.work_precision.participants import FEWEST_STEPS, readable_setting, sampled
from galvi import NBody, Problem, Trajectory
from galvi.arrays import Array

ERROR, CLAIMED, FAILED, GROWTH = "error", "claimed error", "failed", "memory that its runs leave"
REPEAT = "difference of two equal runs"
ELSEWHERE = "difference of equal runs of two processes"
REPEATABLE_FRACTION = 1.0 / 3.0  # of the time limit: longer runs are not repeated
RELATIVE_REST = 1e-13  # change over the size of all states up to which a body rests: round-off
RELATIVE_ERRORS = {"configuration": "share of the way, q", "momenta": "share of the way, p"}

Rows = Iterator[dict[str, Any]]


@dataclass(eq=False)
class Runs:
    """The runs of an external integrator on problems that it supports.

    Each public method yields the rows of one check. Runs that several checks need are made once.
    """

    external: ExternalIntegrator
    _settings: dict[CheckProblem, Sequence[Mapping[str, Any]]] = field(default_factory=dict)
    _truths: dict[CheckProblem, Trajectory] = field(default_factory=dict)
    _coarsest: dict[CheckProblem, CheckedRun] = field(default_factory=dict)
    _long: dict[CheckProblem, LongRun | None] = field(default_factory=dict)

    def for_another_measurement(self) -> Runs:
        """Return empty runs that keep the truths, and the long runs that were requested."""
        long_runs = {
            check: long for check, long in self._long.items() if long and long.checked.requested
        }
        return replace(self, _settings={}, _coarsest={}, _long=long_runs)

    def settings(self, check: CheckProblem) -> Sequence[Mapping[str, Any]]:
        """Its settings on the problem, from coarse to fine; empty, with a fault, without an
        answer."""
        if check not in self._settings:
            self._settings[check] = self.external.settings(
                check.problem, check.duration, FEWEST_STEPS
            )
        return self._settings[check]

    def make_coarsest_run(self, check: CheckProblem) -> Rows:
        """Yield no rows: make the coarsest run where the problem is supported, so that `failures`
        counts the faults."""
        if self.external.supports(check.problem) and self.settings(check):
            self.coarsest(check)
        yield from ()

    def failures(self, check: CheckProblem) -> dict[str, Any]:
        """Return row FAILED, with the faults recorded on the problem until now."""
        return row(
            study=check.problem.name,
            quantity=FAILED,
            value=self.external.failures_on(check.problem),
            status=" ".join(self.external.faults_on(check.problem)),
        )

    def coarsest(self, check: CheckProblem) -> tuple[Mapping[str, Any], CheckedRun]:
        """Return the coarsest setting, with states half way and at the end, and its run."""
        setting = sampled(check.duration, self.settings(check)[0], 2)
        if check not in self._coarsest:
            self._coarsest[check] = self.external.checked(check.problem, check.duration, setting)
        return setting, self._coarsest[check]

    def errors(self, check: CheckProblem) -> Rows:
        """Rows ERROR, RELATIVE_ERRORS and CLAIMED."""
        settings, problem, duration = self.settings(check), check.problem, check.duration
        if not settings:
            return
        truth = self._truth(check)
        indices = sorted({0, len(settings) // 2, len(settings) - 1})
        halved = [sampled(duration, settings[k], 2) for k in indices]
        for label, setting in {
            readable_setting(chosen_setting): chosen_setting for chosen_setting in halved
        }.items():
            is_coarsest = setting is halved[0]
            checked = (
                self.coarsest(check)[1]
                if is_coarsest
                else (self.external.checked(problem, duration, setting))
            )
            run = checked.run
            columns = {"study": problem.name, "label": label, "t": duration}
            error = float(np.max(np.abs(run.q[-1] - truth.q[-1]))) if run.success else float("nan")
            yield row(quantity=ERROR, value=error, status=failure(run), **columns)
            for quantity, states, exact in zip(
                RELATIVE_ERRORS.values(), (run.q, run.p), (truth.q, truth.p), strict=True
            ):
                relative_error = (
                    _relative_error(problem, states, exact) if run.success else float("nan")
                )
                yield row(quantity=quantity, value=relative_error, status=failure(run), **columns)
            claimed = self.external.claimed_error(problem, duration, setting)
            if claimed is not None:
                yield row(quantity=CLAIMED, value=claimed, **columns)

    def repeated(self, check: CheckProblem) -> Rows:
        """Rows REPEAT and ELSEWHERE."""
        if not self.settings(check):
            return
        setting, checked = self.coarsest(check)
        run = checked.run
        if not run.success:
            return
        processes = ((REPEAT, self.external), (ELSEWHERE, self.external.twin()))
        for quantity, external in processes:
            again = external.checked(check.problem, check.duration, setting).run
            difference = np.inf
            if again.success and again.q.shape == run.q.shape:
                difference = max(np.max(np.abs(run.q - again.q)), np.max(np.abs(run.p - again.p)))
            yield row(
                study=check.problem.name,
                quantity=quantity,
                label=readable_setting(setting),
                t=check.duration,
                value=difference,
                status=failure(again),
            )

    def order(self, check: CheckProblem) -> Rows:
        """Rows ORDER."""
        if settings := self.settings(check):
            yield from order_runs(self.external, check, settings, self._truth(check).q[-1])

    def reversed(self, check: CheckProblem) -> Rows:
        """Rows REVERSED and ROUNDING, or NOT_REVERSED."""
        if settings := self.settings(check):
            yield from reversed_runs(self.external, check, settings, self._truth(check).q[-1])

    def memory(self, check: CheckProblem) -> Rows:
        """Row GROWTH."""
        if not self.settings(check):
            return
        setting, checked = self.coarsest(check)
        if not checked.run.success:
            return
        is_repeatable = (
            checked.seconds < REPEATABLE_FRACTION * self.external.limit
        )  # at least two more are made
        growth = (
            float("nan")
            if not is_repeatable
            else (self.external.memory_growth(check.problem, check.duration, setting))
        )
        if growth is not None:
            yield row(
                study=check.problem.name,
                quantity=GROWTH,
                label=readable_setting(setting),
                t=check.duration,
                value=growth / 1e6,
            )

    def conserved(self, check: CheckProblem) -> Rows:
        """Rows of the changes of conserved quantities over some twenty revolutions."""
        if long := self._long_run(check):
            yield from long.rows()

    def longest(self, check: CheckProblem) -> Rows:
        """Row LONG, and rows of the changes of conserved quantities in the longest run."""
        if long := self._long_run(check):
            yield from longest_run(self.external, long)

    def restarted(self, check: CheckProblem) -> Rows:
        """Row CUT or NOT_CUT."""
        yield from cut_run(self.external, check)

    def _truth(self, check: CheckProblem) -> Trajectory:
        if check not in self._truths:
            self._truths[check] = check.states()
        return self._truths[check]

    def _long_run(self, check: CheckProblem) -> LongRun | None:
        if check not in self._long:
            self._long[check] = long_run(self.external, check)
        return self._long[check]


def _relative_error(problem: Problem, states: Array, truth: Array) -> float:
    """Largest error of a body's states over the largest distance of its truth from the start.

    For a body at rest the divisor is the system's largest distance, or the size of its states
    where all bodies rest.
    """
    bodies = truth.shape[1] if isinstance(problem.system, NBody) else 1
    errors, extents = (
        np.max(np.abs(offset.reshape(len(truth), bodies, -1)), axis=(0, 2))
        for offset in (states - truth, truth - truth[0])
    )
    rest_limit = RELATIVE_REST * float(np.max(np.abs(truth)))
    system_extent = (
        float(np.max(extents))
        if np.max(extents) > rest_limit
        else rest_limit / RELATIVE_REST or 1.0
    )
    return float(np.max(errors / np.where(extents > rest_limit, extents, system_extent)))
