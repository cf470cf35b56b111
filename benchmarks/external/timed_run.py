"""A run of somebody else's contender that takes its own time, and never raises for what it does."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from benchmarks.external.worker import asked_times
from galvi import Problem, Trajectory
from galvi.arrays import read_only

MOST = 10**6  # states of a run that failed, beyond which it has those at the ends


class Faulty(Exception):
    """What is wrong with the contender, in a sentence."""


@dataclass(eq=False)
class TimedRun:
    """A run of an outsider that knows how long it took.

    noted    whether what goes wrong is kept by the outsider
    took     seconds of the last call, inside its process
    failure  what went wrong, or nothing
    """

    outsider: Any  # ExternalIntegrator
    problem: Problem
    duration: float
    setting: dict[str, Any]
    noted: bool = True
    took: float = float("nan")
    failure: str = ""

    def __call__(self) -> Trajectory:
        """Run it once; a failed run when there is none."""
        try:
            parts, self.took = self._ask("run")
        except Faulty as fault:
            return self._failed(str(fault))
        arrays = {name: read_only(parts.pop(name)) for name in ("t", "q", "p")}
        return Trajectory(self.problem, **arrays, **parts, method=self.outsider.name)

    def seconds(self, repeats: int) -> float:
        """Of a call, the mean of several in its process; NaN from the first failure on."""
        if self.failure:
            return float("nan")
        try:
            return float(self._ask("seconds", repeats))
        except Faulty as fault:
            self._failed(str(fault))
            return float("nan")

    def _ask(self, what: str, *more: Any) -> Any:
        asked = (self.problem, self.duration, self.setting, *more)
        return self.outsider._ask(self.problem, what, *asked)

    def _failed(self, why: str) -> Trajectory:
        self.failure = why
        setting = " ".join(f"{name}={value:.6g}" if isinstance(value, float) else f"{name}={value}"
                           for name, value in self.setting.items())  # fmt: skip
        if self.noted:
            self.outsider.note(self.problem, setting, why)
        try:
            t = asked_times(self.problem, self.duration, self.setting)
        except (KeyError, TypeError, ValueError, OverflowError, MemoryError):  # it asks for none
            t = np.empty(0)
        if not 0 < len(t) <= MOST:
            t = self.problem.t0 + np.array([0.0, self.duration])
        q, p = (np.full((len(t), *x.shape), np.nan) for x in (self.problem.q0, self.problem.v0))
        return Trajectory(
            self.problem, *map(read_only, (t, q, p)), success=False, status=why, failed_step=1,
            method=self.outsider.name,
        )  # fmt: skip
