"""Somebody else's contender, in a process of its own: what it breaks or hangs is a sentence.

It stands beside ours in every comparison. Its times are taken inside its process, so that handing
states over is not counted.
"""

from __future__ import annotations

import multiprocessing
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from benchmarks.external.timed_run import Faulty, TimedRun
from benchmarks.external.worker import serve
from benchmarks.external.worker_life import end
from galvi import Problem, Trajectory

START_LIMIT = 60.0  # seconds for Python to start and the contender to be imported
LIMIT = 60.0  # seconds for a run
STRIKES = 2  # losses of its process after which it is not run any more
NAMELESS = "problem"
RUNGS = (1, 4, 16, 64)  # numbers of equal steps, in the fewest of an arena, where it offers none


def equal_steps(duration: float, fewest: int) -> list[dict[str, Any]]:
    """What it is run with where it offers no settings, from coarse to fine."""
    return [{"step": duration / n, "save_every": n} for n in (fewest * k for k in RUNGS)]


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

    `open` raises Faulty with a sentence when there is no such class, or it lacks one of these.
    `run` never raises for what the contender does: its run failed, and ``faults`` has a sentence.
    """

    path: str
    limit: float = LIMIT
    name: str = ""
    order: float | None = None
    conserves: Mapping[str, float] = field(default_factory=dict)
    exact: bool = False
    missing: str = ""
    made_of: Sequence[str] = ()  # files and package folders, see `benchmarks.external.code_digest`
    strikes: int = 0
    _noted: dict[tuple[str, str], list[str]] = field(default_factory=dict)
    _slow: set[str] = field(default_factory=set)
    _ran: set[tuple[Any, ...]] = field(default_factory=set)
    _process: Any = None
    _connection: Any = None

    @classmethod
    def open(cls, path: str, limit: float | None = None) -> ExternalIntegrator:
        """Start the process and import the contender."""
        outsider = cls(path, LIMIT if limit is None else limit)
        outsider._start()
        return outsider

    def supports(self, problem: Problem) -> bool:
        """As it says; False, and a fault, when it cannot say."""
        try:
            return bool(self._ask(problem, "supports", problem))
        except Faulty as fault:
            self.note(problem, "asked whether it supports the problem", str(fault))
            return False

    def settings(
        self, problem: Problem, duration: float, fewest: int
    ) -> Sequence[Mapping[str, Any]]:
        """What to run it with: its own offers, or multiples of the fewest steps that others take.

        None at all, and a fault, when it cannot say.
        """
        try:
            offered = self._ask(problem, "settings", problem, duration)
        except Faulty as fault:
            self.note(problem, "asked for its settings", str(fault))
            return []
        if offered is not None:
            return list(offered)
        return equal_steps(duration, fewest)

    def claimed_error(
        self, problem: Problem, duration: float, setting: Mapping[str, Any]
    ) -> float | None:
        """The largest error that it claims; None, and a fault, when it cannot say."""
        try:
            claimed: float | None = self._ask(
                problem, "claimed_error", problem, duration, dict(setting)
            )
        except Faulty as fault:
            self.note(problem, "asked for the error that it claims", str(fault))
            return None
        return claimed

    def run(self, problem: Problem, duration: float, setting: Mapping[str, Any]) -> Trajectory:
        """Once, in its process; a failed run when it did anything else than return one."""
        return self.timed(problem, duration, setting)()

    def timed(
        self, problem: Problem, duration: float, setting: Mapping[str, Any], noted: bool = True
    ) -> TimedRun:
        """A run that takes its own time; see `benchmarks.statistics.timing`."""
        return TimedRun(self, problem, duration, dict(setting), noted)

    @property
    def faults(self) -> list[str]:
        """A sentence for each problem and each thing that went wrong on it."""
        return [
            f"{self.name}, {problem}, {_doing(doings)}: {why}"
            for (problem, why), doings in self._noted.items()
        ]

    def faults_on(self, problem: Problem) -> list[str]:
        """Those of one problem, without its name."""
        return [
            f"{_doing(doings)}: {why}"
            for (name, why), doings in self._noted.items()
            if name == (problem.name or NAMELESS)
        ]

    def failures_on(self, problem: Problem) -> int:
        """How many runs and answers went wrong on it."""
        return sum(
            len(doings)
            for (name, _), doings in self._noted.items()
            if name == (problem.name or NAMELESS)
        )

    def close(self, gently: bool = True) -> None:
        """End its process, and what that started; see `benchmarks.external.worker_life.end`."""
        if self._process is not None:
            end(self._process, self._connection, gently)
            self._process = self._connection = None

    def _start(self) -> None:
        context = multiprocessing.get_context("spawn")
        self._connection, theirs = context.Pipe()
        self._process = context.Process(target=serve, args=(theirs, self.path), daemon=True)
        self._process.start()
        theirs.close()
        try:
            known = self._answer(("open",), START_LIMIT)
            self.name, self.order, self.conserves, self.made_of = known
        except Faulty:
            self.close()
            raise

    def _ask(self, problem: Problem, *request: Any) -> Any:
        """The answer to a request; the process is started anew when it was lost.

        What ran before is timed whatever was lost since, until such a run is lost itself.
        """
        run = _run_of(request)
        if run not in self._ran:
            if self.strikes >= STRIKES:
                raise Faulty(f"Not tried: its process was lost {self.strikes} times before.")
            if problem.name in self._slow:
                raise Faulty("Not tried: its process was lost on this problem before.")
        if self._process is None:
            self._start()
        try:
            answer = self._answer(request, self.limit)
        finally:
            if self._process is None:
                self.strikes += 1
                self._slow.add(problem.name)
                if run in self._ran:
                    self._ran.clear()
        if run:
            self._ran.add(run)
        return answer

    def _answer(self, request: tuple[Any, ...], limit: float) -> Any:
        try:
            self._connection.send(request)
            if not self._connection.poll(limit):
                self.close(gently=False)
                raise Faulty(f"It did not answer within {limit:g} s, and was stopped.")
            kind, value = self._connection.recv()
        except (EOFError, OSError):
            self._process.join(1.0)
            status = self._process.exitcode
            self.close()
            raise Faulty(f"Its process ended, with status {status}.") from None
        if kind == "fault":
            raise Faulty(value)
        return value

    def note(self, problem: Problem, doing: str, why: str) -> None:
        """Keep a sentence on what went wrong, and at what."""
        self._noted.setdefault((problem.name or NAMELESS, why), []).append(doing)


def _run_of(request: tuple[Any, ...]) -> tuple[Any, ...]:
    """Which run is asked for: problem, duration and setting; nothing when none is."""
    what, problem, *arguments = request
    if what not in ("run", "seconds"):
        return ()
    duration, setting, *_ = arguments
    return problem.name, duration, *sorted(map(repr, setting.items()))


def _doing(doings: Sequence[str]) -> str:
    first, *others = doings
    return f"{first} and {len(others)} more" if others else first
