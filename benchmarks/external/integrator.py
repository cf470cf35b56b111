"""Somebody else's contender, in a process of its own: its crashes and time-outs become messages.

It stands beside galvi in every comparison. Its times are taken inside its process, so that handing
states over is not counted.
"""

from __future__ import annotations

import multiprocessing
import os
import signal
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from typing import Any

from pebble import ProcessExpired, ProcessPool

from benchmarks.external.loading import ContenderError
from benchmarks.external.timed_run import TimedRun
from benchmarks.external.worker import answer, prepare
from galvi import Problem, Trajectory

LIMIT = 60.0  # seconds for an answer: a run, or its import
NAMELESS = "problem"


@dataclass(eq=False)
class ExternalIntegrator:
    """The contender at ``path``, "package.module:Class"; see `references.Contender`.

    The class is made without arguments and has

    name                            for tables; not that of galvi's own, which begin with "galvi"
    supports(problem)               whether it solves this `galvi.Problem`
    run(problem, duration, setting) -> `galvi.Trajectory` at the times that the setting asks for:
                                    {"step": h, "save_every": k} or {"samples": n}, the first
                                    of them the problem's start, p the conjugate momenta
    settings(problem, duration)     the mappings that it is run with, from coarse to fine; where it
                                    has none, equal steps of four lengths

    and, for the checks of `benchmarks.external.checks`, any of

    order                           of its convergence in the step
    conserves                       largest relative changes, {"energy": 1e-6, "angular momentum":
                                    1e-12}, that it claims at its finest setting, without a drift
    claimed_error(problem, duration, setting)
                                    the largest error that it claims, of a component at the end

    `open` raises ContenderError when there is no such class, or it lacks one of these. `run` never
    raises for what the contender does: its run failed, and ``faults`` has a sentence. A process
    that ends, or does not answer within ``limit`` seconds, is replaced at the next question.
    """

    path: str
    limit: float = LIMIT
    name: str = ""
    order: float | None = None
    conserves: Mapping[str, float] = field(default_factory=dict)
    exact: bool = False
    missing: str = ""
    _failed: dict[tuple[str, str], list[str]] = field(default_factory=dict)
    _pool: ProcessPool | None = None
    _process: int = 0

    @classmethod
    def open(cls, path: str, limit: float = LIMIT) -> ExternalIntegrator:
        """Start the process and import the contender."""
        external = cls(path, limit)
        try:
            external.name, external.order, external.conserves = external._ask("metadata")
        except BaseException:
            external.close()
            raise
        return external

    def supports(self, problem: Problem) -> bool:
        """Its answer; False, and a fault, where it gives none."""
        return bool(
            self._ask_about(problem, "asked whether it supports the problem", "supports", problem)
        )

    def settings(
        self, problem: Problem, duration: float, fewest: int
    ) -> Sequence[Mapping[str, Any]]:
        """What to run it with: its own offers, or multiples of the fewest steps that others take.

        None at all, and a fault, where it gives no answer.
        """
        offered = self._ask_about(
            problem, "asked for its settings", "settings", problem, duration, fewest
        )
        return offered or []

    def claimed_error(
        self, problem: Problem, duration: float, setting: Mapping[str, Any]
    ) -> float | None:
        """The largest error that it claims; None, and a fault, where it gives no answer."""
        claimed: float | None = self._ask_about(
            problem, "asked for the error that it claims", "claimed error", problem, duration,
            dict(setting),
        )  # fmt: skip
        return claimed

    def run(self, problem: Problem, duration: float, setting: Mapping[str, Any]) -> Trajectory:
        """One run in its process; a failed one where it returned none."""
        return self.timed(problem, duration, setting)()

    def timed(
        self,
        problem: Problem,
        duration: float,
        setting: Mapping[str, Any],
        report: Callable[[str], None] | None = None,
    ) -> TimedRun:
        """A run that takes its own time; see `benchmarks.statistics.timing`.

        report  called with a sentence on each failure; None adds it to the faults
        """
        words = " ".join(f"{name}={value:.6g}" if isinstance(value, float) else f"{name}={value}"
                         for name, value in setting.items())  # fmt: skip

        def ask(repeats: int) -> Any:
            return self._ask("timed run", problem, duration, dict(setting), repeats)

        def add_fault(why: str) -> None:
            self.add_fault(problem, words, why)

        return TimedRun(self.name, problem, duration, dict(setting), ask, report or add_fault)

    @property
    def faults(self) -> list[str]:
        """A sentence for each problem and each thing that went wrong on it."""
        return [
            f"{self.name}, {problem}, {_first(doings)}: {why}"
            for (problem, why), doings in self._failed.items()
        ]

    def faults_on(self, problem: Problem) -> list[str]:
        """Those of one problem, without its name."""
        return [
            f"{_first(doings)}: {why}"
            for (name, why), doings in self._failed.items()
            if name == (problem.name or NAMELESS)
        ]

    def failures_on(self, problem: Problem) -> int:
        """How many runs and answers went wrong on it."""
        name = problem.name or NAMELESS
        return sum(len(doings) for (on, _), doings in self._failed.items() if on == name)

    def add_fault(self, problem: Problem, doing: str, why: str) -> None:
        """Keep a sentence on what went wrong, and at what."""
        self._failed.setdefault((problem.name or NAMELESS, why), []).append(doing)

    def close(self) -> None:
        """End its process, and what that started."""
        pool, self._pool = self._pool, None
        if pool is None:
            return
        pool.stop()
        pool.join()
        if os.name == "posix" and self._process:
            with suppress(ProcessLookupError, PermissionError):  # nobody is left in its group
                os.killpg(self._process, signal.SIGKILL)
        self._process = 0

    def _ask_about(self, problem: Problem, doing: str, question: str, *arguments: Any) -> Any:
        """The answer; None, and a fault, when there is none."""
        try:
            return self._ask(question, *arguments)
        except ContenderError as error:
            self.add_fault(problem, doing, str(error))
            return None

    def _ask(self, question: str, *arguments: Any) -> Any:
        """The answer of its process. Raises ContenderError."""
        try:
            if self._pool is None:
                spawn = multiprocessing.get_context("spawn")
                self._pool = ProcessPool(1, initializer=prepare, context=spawn)
                self._process = self._pool.schedule(os.getpid, timeout=self.limit).result()
            asked = (self.path, question, *arguments)
            return self._pool.schedule(answer, asked, timeout=self.limit).result()
        except TimeoutError:
            self.close()
            why = f"It did not answer within {self.limit:g} s, and was stopped."
        except ProcessExpired as end:
            self.close()
            why = f"Its process ended, with status {end.exitcode}."
        except RuntimeError:  # of the pool, whose process ended while nothing was asked
            self.close()
            why = "Its process ended between two answers."
        raise ContenderError(why)


def _first(doings: Sequence[str]) -> str:
    first, *others = doings
    return f"{first} and {len(others)} more" if others else first
