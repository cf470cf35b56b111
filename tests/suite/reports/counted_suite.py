"""A small suite that counts what it runs, and can be ended in any of its parts."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import pandas as pd

from benchmarks.checks.claim import Claim
from reports.cli.commands import run
from reports.results.section import Section
from reports.results.suite import Suite


class Killed(BaseException):
    """Nothing catches it."""


class Bench:
    """A suite of two claims, two problems, a cost and two studies, which counts what it runs.

    stop  the part in which the run ends; empty for none
    how   it ends there
    """

    def __init__(self, make_suite: Callable[..., Suite], make_claim: Callable[..., Claim]) -> None:
        self.calls: list[str] = []
        self.stop, self.date, self.commit = "", "2026-01-01 00:00 UTC", "abc"
        self.faults: list[str] = []
        self.how: type[BaseException] = Killed
        plain = make_suite()
        self.suite = make_suite(
            *(self._counted(make_claim(name)) for name in ("V1", "V3")),
            work_precision=self._raced(plain),
            problems=lambda quick: ("ball", "top"),
            cost=self._of("cost", plain.cost),
            sections=(
                *(
                    replace(one, measure=self._of("sky", one.measure), timed=True)
                    for one in plain.sections
                ),
                self._study(),
            ),
            faults=lambda: self.faults,
        )
        self.suite = replace(self.suite, provenance=self._provenance)

    def __call__(self, *words: str) -> tuple[int, list[str]]:
        """Run the command; its status, and the parts that it measured."""
        self.calls = []
        status = run(lambda: self.suite, list(words))
        return status, self.calls

    def _ran(self, name: str) -> None:
        self.calls.append(name)
        if name == "top":
            self.faults.append("It hung.")
        if name == self.stop:
            raise self.how

    def _provenance(self, command: str) -> dict[str, str]:
        return {"date": self.date, "commit": self.commit, "command": command}

    def _counted(self, claim: Claim) -> Claim:
        def study(make_method: object, quick: bool, report: Callable[[str], None]) -> pd.DataFrame:
            self._ran(claim.id)
            return claim.study(make_method, quick, report)

        return replace(claim, study=study, timed=True)

    def _raced(self, plain: Suite) -> Callable[..., pd.DataFrame]:
        def measure(quick: bool, report: Callable[[str], None], problem: str) -> pd.DataFrame:
            report("half of the contenders")
            self._ran(problem)
            return plain.work_precision(quick, report).assign(problem=problem)

        return measure

    def _of(self, name: str, measure: Callable[..., pd.DataFrame]) -> Callable[..., pd.DataFrame]:
        def counted(quick: bool, report: Callable[[str], None]) -> pd.DataFrame:
            self._ran(name)
            return measure(quick, report)

        return counted

    def _study(self) -> Section:
        frame = pd.DataFrame({"n": [1, 2], "date": ""})
        measure = self._of("study", lambda quick, report: frame)
        return Section(
            "study", "A study", "", measure, lambda rows: (rows.astype(str), {}), timed=True
        )
