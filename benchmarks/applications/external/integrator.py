"""Run an external integrator in its own process; crashes and time-outs become messages.

It takes part in every comparison. Times are measured inside its process, without the transfer of
states.
"""

from __future__ import annotations

import multiprocessing
import os
import signal
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

from pebble import CONSTS, ProcessExpired, ProcessPool

from benchmarks.applications.external.loading import ContenderError, NotAsked
from benchmarks.applications.external.printed import Printed
from benchmarks.applications.external.timed_run import TimedRun
from benchmarks.applications.external.worker import answer, prepare
from benchmarks.store.foreign_texts import visible
from benchmarks.work_precision.participants import readable_setting
from galvi import Problem, Trajectory
from galvi.repository import path_in_repository

TIME_LIMIT = 60.0  # time limit in seconds of an answer: a run, or the import
MOST_LATE_ANSWERS = 2  # late answers after which no further request is made
NAMELESS = "problem"
CONSTS.term_timeout = 0.5  # seconds for a process to end by itself


@dataclass(frozen=True, eq=False)
class CheckedRun:
    """A run of an external integrator.

    Attributes
    ----------
    seconds
        time of the run in its process; NaN without an answer
    requested
        False where the run was not requested, since earlier answers were late
    """

    run: Trajectory
    seconds: float
    requested: bool = True


class Fault(NamedTuple):
    """A problem's name and the reason; `requested` is False where the request was not made."""

    problem: str
    reason: str
    requested: bool


@dataclass(eq=False)
class ExternalIntegrator:
    """The contender at ``path``, "package.module:Class"; see `references.Contender`.

    The class is constructed without arguments and has

    name                            for tables; not that of galvi's own, which begin with "galvi"
    supports(problem)               whether it solves this `galvi.Problem`
    run(problem, duration, setting) -> `galvi.Trajectory` at the times given by the setting,
                                    {"step": h, "save_every": k} or {"samples": n}, the first
                                    one the problem's start; p are the conjugate momenta
    settings(problem, duration)     its settings (mappings) from coarse to fine; without this
                                    method, equal steps of four sizes

    and, for the checks of `benchmarks.applications.external.checks`, any of

    order                           order of convergence in the step
    conserves                       largest relative changes at its finest setting, without drift,
                                    e.g. {"energy": 1e-6, "angular momentum": 1e-12}
    symmetric                       True: a run back from the end returns to the start
    claimed_error(problem, duration, setting)
                                    the largest error of a component at the end

    `open` raises ContenderError when there is no such class, or it lacks a required member. `run`
    never raises for the integrator's errors: the run failed, and ``faults`` has a sentence. A
    process that ends, or does not answer within ``limit`` seconds, is replaced at the next request;
    after MOST_LATE_ANSWERS late answers every request fails at once (trials are counted
    separately), and messages name ``limit_option`` as the remedy. ``printed`` holds the output of
    its processes; ``defined_at`` is the file of its class, from the root of the repository, and
    the line: "" and 0 where its source is unknown or elsewhere.
    """

    path: str
    limit: float = TIME_LIMIT
    name: str = ""
    order: float | None = None
    conserves: Mapping[str, float] = field(default_factory=dict)
    symmetric: bool = False
    defined_at: tuple[str, int] = ("", 0)
    limit_option: str = "--timeout"
    exact: bool = False
    missing: str = ""
    printed: Printed = field(default_factory=Printed)
    _late: dict[bool, int] = field(default_factory=lambda: {False: 0, True: 0})
    _failed: dict[Fault, list[str]] = field(default_factory=dict)  # the requests of each fault
    _pool: ProcessPool | None = None
    _process: int = 0
    _twin: ExternalIntegrator | None = None

    @classmethod
    def open(cls, path: str, limit: float = TIME_LIMIT) -> ExternalIntegrator:
        """Start the process and import the integrator. Raises ContenderError."""
        external = cls(path, limit)
        try:
            external._declare(external._ask("metadata"))
            file, line = external._ask("definition")
            if path := path_in_repository(file):
                external.defined_at = path, line
        except BaseException:
            external.close()
            raise
        return external

    def _declare(self, metadata: tuple[str, float | None, Mapping[str, float], bool]) -> None:
        self.name, self.order, self.conserves, self.symmetric = metadata

    def twin(self) -> ExternalIntegrator:
        """Return the same integrator in a second process, which `close` ends too; both record
        their faults in one place."""
        if self._twin is None:
            self._twin = replace(self, _pool=None, _process=0)
        return self._twin

    def supports(self, problem: Problem) -> bool:
        """Whether it solves the problem; False, with a fault, when it does not answer. After
        MOST_LATE_ANSWERS late answers only the first unmade request is a fault."""
        if self._late[False] >= MOST_LATE_ANSWERS and self._unasked():
            return False
        return bool(
            self._ask_about(problem, "asked whether it supports the problem", "supports", problem)
        )

    def settings(
        self, problem: Problem, duration: float, fewest: int
    ) -> Sequence[Mapping[str, Any]]:
        """Its own settings, or multiples of `fewest` equal steps, from coarse to fine.

        Empty, and a fault, when it does not answer.
        """
        offered = self._ask_about(
            problem, "asked for its settings", "settings", problem, duration, fewest
        )
        return offered or []

    def claimed_error(
        self, problem: Problem, duration: float, setting: Mapping[str, Any]
    ) -> float | None:
        """The largest error that it claims; None when it claims none, and, with a fault, when it
        does not answer."""
        return self._ask_about(
            problem,
            "asked for the error that it claims",
            "claimed error",
            problem,
            duration,
            dict(setting),
        )

    def memory_growth(
        self, problem: Problem, duration: float, setting: Mapping[str, Any]
    ) -> float | None:
        """Bytes by which repeated runs make its process grow, see `external.worker.memory_growth`.

        NaN where a run takes too long to be repeated; None, with a fault, when it does not answer.
        """
        return self._ask_about(
            problem, "run repeatedly", "memory growth", problem, duration, dict(setting)
        )

    def run(self, problem: Problem, duration: float, setting: Mapping[str, Any]) -> Trajectory:
        """Run once in its process; a failed trajectory where there is no valid answer."""
        return self.timed(problem, duration, setting)()

    def trial(self, problem: Problem, duration: float, setting: Mapping[str, Any]) -> Trajectory:
        """A run at a setting that it did not offer; its failure is no fault."""
        return self.timed(problem, duration, setting, is_trial=True)()

    def timed(
        self,
        problem: Problem,
        duration: float,
        setting: Mapping[str, Any],
        is_trial: bool = False,
    ) -> TimedRun:
        """A run that measures its own time; see `benchmarks.statistics.timing`.

        Parameters
        ----------
        is_trial
            whether the integrator did not offer the setting, so that a failure is no fault
        """
        setting_text = " ".join(
            f"{name}={value:.6g}" if isinstance(value, float) else f"{name}={value}"
            for name, value in setting.items()
        )

        def ask(repeats: int) -> Any:
            run = problem, duration, dict(setting), repeats
            return self._ask("timed run", *run, is_trial=is_trial)

        def report(error: ContenderError) -> None:
            if not is_trial:
                self.add_fault(problem, f"T = {duration:g}, {setting_text}", error)

        return TimedRun(self.name, problem, duration, dict(setting), ask, report)

    def checked(
        self, problem: Problem, duration: float, setting: Mapping[str, Any], is_trial: bool = False
    ) -> CheckedRun:
        """Run once; unless `is_trial`, a run that returns as failed is a fault too."""
        requested = self._late[is_trial] < MOST_LATE_ANSWERS
        call = self.timed(problem, duration, setting, is_trial)
        run = call()
        if not (run.success or call.failure or is_trial):
            self.add_fault(problem, f"T = {duration:g}, {readable_setting(setting)}", run.status)
        return CheckedRun(run, call.seconds_of_last_call, requested)

    @property
    def faults(self) -> list[str]:
        """A sentence for each problem and reason, and one for all requests that were not made."""
        unasked = self._unasked()
        sentences = [
            f"{self.name}, {fault.problem}, {_first(requests_of_fault)}: {fault.reason}"
            for fault, requests_of_fault in self._failed.items()
            if fault.requested
        ]
        if unasked:
            requests = [request for fault in unasked for request in self._failed[fault]]
            problems = _first(list(dict.fromkeys(fault.problem for fault in unasked)))
            sentences.append(f"{self.name}, {problems}, {_first(requests)}: {unasked[0].reason}")
        return sentences

    def faults_on(self, problem: Problem) -> list[str]:
        """The faults on one problem, without its name."""
        return [
            f"{_first(requests)}: {fault.reason}"
            for fault, requests in self._failed.items()
            if fault.problem == (problem.name or NAMELESS)
        ]

    def failures_on(self, problem: Problem) -> int:
        """The number of failed runs and answers on one problem."""
        name = problem.name or NAMELESS
        return sum(
            len(requests) for fault, requests in self._failed.items() if fault.problem == name
        )

    def add_fault(self, problem: Problem, request: str, reason: str | ContenderError) -> None:
        """Record that this request failed on the problem, for this reason."""
        requested = not isinstance(reason, NotAsked)
        fault = Fault(problem.name or NAMELESS, visible(str(reason)), requested)
        self._failed.setdefault(fault, []).append(visible(request))

    def forget_faults(self) -> None:
        """Clear the recorded faults and printed lines, before a further measurement."""
        self._failed.clear()
        self.printed.forget()

    @property
    def only_unasked(self) -> str:
        """Why requests were not made, where these are the only faults; "" where there are other
        faults, or none."""
        return self._unasked()[0].reason if len(self._unasked()) == len(self._failed) > 0 else ""

    def _unasked(self) -> list[Fault]:
        """Faults of requests that were not made, since earlier answers were late."""
        return [fault for fault in self._failed if not fault.requested]

    def close(self) -> None:
        """End its processes and their child processes; the next request starts another."""
        if self._twin is not None:
            self._twin.close()
        pool, self._pool = self._pool, None
        if pool is None:
            return
        pool.stop()
        pool.join()
        if os.name == "posix" and self._process:
            with suppress(ProcessLookupError, PermissionError):  # its group is empty
                os.killpg(self._process, signal.SIGKILL)
        self._process = 0
        self.printed.wait()

    def _ask_about(self, problem: Problem, request: str, question: str, *arguments: Any) -> Any:
        """The answer to a request; None, and a fault, when there is none."""
        try:
            return self._ask(question, *arguments)
        except ContenderError as error:
            self.add_fault(problem, request, error)
            return None

    def _ask(self, question: str, *arguments: Any, is_trial: bool = False) -> Any:
        """The answer of the process. Raises ContenderError.

        Parameters
        ----------
        is_trial
            whether the integrator did not offer the setting; late answers to such requests are
            counted separately
        """
        if self._late[is_trial] >= MOST_LATE_ANSWERS:
            raise NotAsked(
                f"It was not asked: {MOST_LATE_ANSWERS} answers before took longer than "
                f"{self.limit:g} s. Give a longer {self.limit_option}, in seconds, if it is "
                "only slow."
            )
        try:
            if self._pool is None:
                self._start()
            request = (self.path, question, *arguments)
            return self._pool.schedule(answer, request, timeout=self.limit).result()
        except TimeoutError:
            self.close()
            self._late[is_trial] += 1
            reason = f"It did not answer within {self.limit:g} s, and was stopped."
        except ProcessExpired as end:
            self.close()
            reason = f"Its process ended, with status {end.exitcode}."
        except RuntimeError:  # from the pool, whose process ended between requests
            self.close()
            reason = "Its process ended between two answers."
        raise ContenderError(reason)

    def _start(self) -> None:
        spawn = multiprocessing.get_context("spawn")
        output, end = spawn.Pipe(duplex=False)
        self.printed.read(output)
        with end:
            self._pool = ProcessPool(1, initializer=prepare, initargs=(end,), context=spawn)
            self._process = self._pool.schedule(os.getpid, timeout=self.limit).result()


def _first(requests: Sequence[str]) -> str:
    first, *following = requests
    return f"{first} and {len(following)} more" if following else first
