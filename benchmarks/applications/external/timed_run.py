"""A run of an external integrator that measures its own time and turns errors into failed runs."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from benchmarks.applications.external.loading import ContenderError
from benchmarks.applications.external.validation import MOST_STATES, saved_times
from galvi import Problem, Trajectory
from galvi.arrays import read_only


@dataclass(eq=False)
class TimedRun:
    """A callable that runs an external integrator once and records the time.

    Attributes
    ----------
    ask
        number of runs -> arrays and counts of the last one, mean seconds; raises ContenderError
    report
        called with the error of each failure
    took
        time of the last call that succeeded, inside its process
    failure
        reason why a call failed; "" if none did
    """

    name: str
    problem: Problem
    duration: float
    setting: dict[str, Any]
    ask: Callable[[int], tuple[dict[str, Any], float]]
    report: Callable[[ContenderError], None]
    seconds_of_last_call: float = float("nan")
    failure: str = ""

    def __call__(self) -> Trajectory:
        """Run once; a failed trajectory where `ask` raises ContenderError."""
        try:
            parts, self.seconds_of_last_call = self.ask(1)
        except ContenderError as error:
            self._fail(error)
            return self._failed_run()
        arrays = {name: read_only(parts.pop(name)) for name in ("t", "q", "p")}
        return Trajectory(self.problem, **arrays, **parts, method=self.name)

    def seconds(self, repeats: int) -> float:
        """Mean seconds of a run over `repeats` runs in its process; NaN after a failure."""
        if self.failure:
            return float("nan")
        try:
            return self.ask(repeats)[1]
        except ContenderError as error:
            self._fail(error)
            return float("nan")

    def _fail(self, error: ContenderError) -> None:
        self.failure = str(error)
        self.report(error)

    def _failed_run(self) -> Trajectory:
        """A failed trajectory: NaN at the requested times, or at start and end where these are
        invalid or more than MOST_STATES."""
        try:
            t = saved_times(self.problem, self.duration, self.setting)
        except (TypeError, ValueError, OverflowError, MemoryError):
            t = np.empty(0)
        if not 0 < len(t) <= MOST_STATES:
            t = self.problem.t0 + np.array([0.0, self.duration])
        q, p = (np.full((len(t), *x.shape), np.nan) for x in (self.problem.q0, self.problem.v0))
        return Trajectory(
            self.problem,
            *map(read_only, (t, q, p)),
            success=False,
            status=self.failure,
            failed_step=1,
            method=self.name,
        )
