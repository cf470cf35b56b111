"""Checks of external integrators one by one, served to a process that does not import galvi.

The plugin of pytest starts this program by `galvi.command.serve_checks`. It reads requests and
writes answers, each a line of JSON:

{"contenders": [path, ...], "problems": [path, ...], "limit": seconds, "folders": [path, ...]}
                 the first one, without an answer; problems of one's own replace those of the suite.
                 Modules are looked for in these folders last
{"do": "list"}   "items": for each check its contender's path and name, the check's name, and the
                 problem's, "" for all problems together; or "usage": a sentence on a contender or
                 problem that cannot be loaded
an item          "outcome": passed, failed or skipped, and "text": the reason. An item is skipped
                 where no request was made, since answers to earlier items were late
"""

from __future__ import annotations

import json
import os
import signal
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

from benchmarks.applications.external.check_problems import CHECK_PROBLEMS, CheckProblem
from benchmarks.applications.external.check_runs import Runs
from benchmarks.applications.external.checks import (
    CHECKS,
    FAILURES,
    Check,
    ClaimRows,
    supported_and_faulty,
)
from benchmarks.applications.external.integrator import ExternalIntegrator
from benchmarks.applications.external.loading import ContenderError
from benchmarks.applications.external.own_check_problems import own_check_problem
from benchmarks.checks.bounds import ATTAINED, EXCEEDS, FINDING, HOLDS, NOT_RUN
from benchmarks.checks.claim import Row
from benchmarks.store.foreign_texts import visible
from benchmarks.store.tables import pick, table_of

PASSED, FAILED, SKIPPED = "passed", "failed", "skipped"
CONTENDER, PROBLEM, LIMIT = "--galvi", "--galvi-problem", "--galvi-timeout"  # options of pytest
SHOWN_LINES = 5  # lines of an integrator's output in the text of a failed item
NOTHING_MEASURED = (
    "It gives nothing to measure here, as its run or its settings failed, or has no step."
)
Item = Mapping[str, str]


@dataclass(eq=False)
class ServedChecks:
    """The checks of these integrators.

    Its methods raise ContenderError for an integrator or a problem that cannot be loaded.

    Attributes
    ----------
    contenders
        their paths, "package.module:Class"
    problems
        paths of problems in place of the suite's; empty: the suite's
    limit
        seconds for each answer of an integrator
    """

    contenders: Sequence[str]
    problems: Sequence[str]
    limit: float
    _open: dict[str, ExternalIntegrator] = field(default_factory=dict)
    _runs: dict[str, Runs] = field(default_factory=dict)
    _problem_lists: dict[str, tuple[list[CheckProblem], list[CheckProblem]]] = field(
        default_factory=dict
    )

    def items(self) -> list[Item]:
        """The items that `measured` takes, in the order of `verify`."""
        names = [self._external(path).name for path in self.contenders]
        for name in names:
            if names.count(name) > 1:
                raise ContenderError(f"{CONTENDER}: two are called {name!r}")
        return [item for path in self.contenders for item in self._items_of(path)]

    def measured(self, item: Item) -> tuple[str, str]:
        """Measure an item; returns PASSED, FAILED or SKIPPED, and the reason."""
        external = self._external(item["contender"])
        supported, _ = self._problems_of(external)
        (check,) = (check for check in (FAILURES, *CHECKS) if check.name == item["check"])
        if item["problem"]:
            problems = [problem for problem in self._problems if _name(problem) == item["problem"]]
        else:
            problems = check.problems(external, supported)
        external.forget_faults()
        runs = self._runs.get(external.path, Runs(external)).for_another_measurement()
        self._runs[external.path] = runs
        rows = [row for problem in problems for row in check.measure(runs, problem)]
        table = table_of([*rows, *map(runs.failures, problems)])
        claim_rows = ClaimRows(item["check"], external, self._problems)
        rows_checked = check.rows_of_all(claim_rows, table)
        for problem in problems:
            rows_of_it = pick(table, study=problem.problem.name)
            rows_checked += check.rows_on_problem(claim_rows, problem, rows_of_it)
            failures = claim_rows.failures(problem, rows_of_it) if check is not FAILURES else []
            rows_checked += [row for row in failures if row.verdict != row.expected]
        verdict, text = outcome(rows_checked)
        if verdict != FAILED:
            return verdict, text
        reason_not_asked = external.only_unasked
        if reason_not_asked and all(problem in supported for problem in problems):
            return SKIPPED, reason_not_asked
        if external.printed.lines:
            first_lines = "\n".join(external.printed.first[:SHOWN_LINES])
            text += (
                f"\nIt printed (lines: {external.printed.lines:,}; the first are shown):\n"
                f"{first_lines}"
            )
        return FAILED, text

    def close(self) -> None:
        """End the processes of the integrators."""
        for external in self._open.values():
            external.close()

    @cached_property
    def _problems(self) -> tuple[CheckProblem, ...]:
        problems: list[CheckProblem] = []
        for path in self.problems:
            try:
                problem = own_check_problem(path)
            except ContenderError as error:
                raise ContenderError(f"{PROBLEM} {path}: {error}") from None
            if _name(problem) in map(_name, problems):
                raise ContenderError(f"{PROBLEM}: two are called {_name(problem)!r}")
            problems.append(problem)
        return tuple(problems) or CHECK_PROBLEMS

    def _external(self, path: str) -> ExternalIntegrator:
        if path not in self._open:
            try:
                external = ExternalIntegrator.open(path, self.limit)
            except ContenderError as error:
                raise ContenderError(f"{CONTENDER} {path}: {error}") from None
            external.limit_option = LIMIT
            self._open[path] = external
        return self._open[path]

    def _problems_of(
        self, external: ExternalIntegrator
    ) -> tuple[list[CheckProblem], list[CheckProblem]]:
        """The problems that it supports, and those for which it does not answer."""
        if external.path not in self._problem_lists:
            self._problem_lists[external.path] = supported_and_faulty(external, self._problems)
        return self._problem_lists[external.path]

    def _items_of(self, path: str) -> list[Item]:
        external = self._external(path)
        supported, faulty = self._problems_of(external)
        items = []

        def add(check: Check, problem: str) -> None:
            items.append(
                {"contender": path, "name": external.name, "check": check.name, "problem": problem}
            )

        for problem in (*supported, *faulty):
            add(FAILURES, _name(problem))
        for check in CHECKS:
            problems = check.problems(external, supported)
            if check.jointly is None:
                for problem in problems:
                    add(check, _name(problem))
            elif self._is_judged_jointly(check, external, supported):
                add(check, "")
        return items

    def _is_judged_jointly(
        self, check: Check, external: ExternalIntegrator, supported: Sequence[CheckProblem]
    ) -> bool:
        """Whether a check of all problems together has an item: the order where it is declared and
        a problem is supported; declarations where no problem is supported, or where conserved
        quantities are declared and the problems are the suite's."""
        if check.name == "order":
            return external.order is not None and bool(supported)
        return not supported or (bool(external.conserves) and not self.problems)


def outcome(rows: Sequence[Row]) -> tuple[str, str]:
    """PASSED, FAILED or SKIPPED for an item with these rows of claims.csv, and the reason: for a
    failure a paragraph for each row that is not as expected."""
    differing = [row for row in rows if row.verdict != row.expected]
    if differing:
        return FAILED, "\n".join(map(_paragraph, differing))
    if any(row.verdict in (HOLDS, ATTAINED, EXCEEDS) for row in rows):
        return PASSED, ""
    reasons = [
        row.reason for verdict in (NOT_RUN, FINDING) for row in rows if row.verdict == verdict
    ]
    return SKIPPED, reasons[-1] if reasons else NOTHING_MEASURED


def _paragraph(row: Row) -> str:
    measured = "nothing" if row.measured is None else f"{row.measured:.4g}"
    if row.uncertainty is not None:
        measured += f" with a standard error of {row.uncertainty:.2g}"
    against = f", compared with {row.reference}" if row.reference else ""
    return (
        f"{row.quantity}: measured {measured}; bound: {row.bound}. {row.reason} "
        f"({row.setup}{against})"
    )


def _name(problem: CheckProblem) -> str:
    return visible(problem.problem.name)


def serve() -> None:
    """Answer requests until there are no more.

    The user's code has an empty standard input, and its output goes to the standard error.
    """
    requests = os.fdopen(os.dup(sys.stdin.fileno()), encoding="utf-8")
    empty_input = os.open(os.devnull, os.O_RDONLY)
    os.dup2(empty_input, sys.stdin.fileno())
    os.close(empty_input)
    answers = os.fdopen(os.dup(sys.stdout.fileno()), "w", encoding="utf-8")
    os.dup2(sys.stderr.fileno(), sys.stdout.fileno())
    signal.signal(signal.SIGINT, signal.SIG_DFL)  # without a traceback; integrators end with it
    first = json.loads(requests.readline())
    sys.path += [folder for folder in first.pop("folders") if folder not in sys.path]
    served = ServedChecks(**first)

    def answer(request: Any) -> dict[str, Any]:
        try:
            if request.get("do") == "list":
                return {"items": served.items()}
            return dict(zip(("outcome", "text"), served.measured(request), strict=True))
        except ContenderError as error:
            sentence = str(error)
            return {"usage": sentence if sentence.endswith((".", "?")) else f"{sentence}."}

    try:
        for line in requests:
            print(json.dumps(answer(json.loads(line))), file=answers, flush=True)
    finally:
        served.close()
