"""The checks of `verify` as items of pytest: it chooses them, and writes what CI services read."""

from __future__ import annotations

import os
from collections.abc import Callable, Generator, Iterator, Sequence
from pathlib import Path
from typing import Any

import pandas as pd
import pytest

from benchmarks.checks.claim import AGREEMENT, Claim
from reports.results.claim_results import ClaimResult
from reports.results.junit import JUnitCase

# Of pytest only what chooses items, runs them, remembers failures and writes JUnit files.
SETTINGS = (
    *("-c", os.devnull, "--capture=no", "--assert=plain", "--disable-plugin-autoload"),
    *(f"-pno:{name}" for name in ("terminal", "warnings", "logging", "faulthandler",
                                  "unraisableexception", "threadexception")),
)  # fmt: skip


class DifferentOutcome(Exception):
    """A check did not come out as expected; the message says how."""


class NoChecks(Exception):
    """Options chose none of the checks."""


class CheckItem(pytest.Item):
    """A check that becomes a case when its claim has been measured."""

    def __init__(self, *, claim: str, words: Sequence[str], **more: Any) -> None:
        super().__init__(**more)
        self.claim = claim
        self.extra_keyword_matches.update(words)
        self.case: JUnitCase | None = None

    def setup(self) -> None:
        """Raises DifferentOutcome for what should have been measured and was not."""
        if self.case is None:
            raise DifferentOutcome("the judge of its claim gave no such row")
        self.user_properties += self.case.properties
        if self.case.outcome == "error":
            raise DifferentOutcome(self.case.message)

    def runtest(self) -> None:
        """Raises DifferentOutcome for a failure, and pytest's exception for what is skipped."""
        case = self.case
        if case is not None and case.outcome == "failure":
            lines = (f"{name}: {text}" for name, text in case.properties)
            raise DifferentOutcome("\n".join([case.message, *lines]))
        if case is not None and case.outcome == "skipped":
            pytest.skip(case.message)

    def repr_failure(self, excinfo: pytest.ExceptionInfo[BaseException], style: Any = None) -> Any:
        """The sentence alone."""
        if isinstance(excinfo.value, DifferentOutcome):
            return str(excinfo.value)
        return super().repr_failure(excinfo, style)

    def reportinfo(self) -> tuple[Any, int | None, str]:
        """Its place, which is no file."""
        return self.nodeid.partition("::")[0], None, self.name


class CheckSession:
    """A run of pytest over the rows of claims, and what follows from all of them.

    claims   whose rows are items
    measure  the results of some of the claims
    cases    the cases of the rows of a result
    further  cases that all results make, where no options choose among the rows

    After `run`: `measured`, the results, and `judged`, the cases of the items that were chosen.
    """

    def __init__(
        self,
        claims: Sequence[Claim],
        measure: Callable[[Sequence[Claim]], Sequence[ClaimResult]],
        cases: Callable[[ClaimResult], Sequence[JUnitCase]],
        further: Callable[[Sequence[ClaimResult]], Sequence[JUnitCase]],
    ) -> None:
        self.claims, self.measure, self.cases, self.further = claims, measure, cases, further
        self.measured: Sequence[ClaimResult] = ()
        self.judged: list[JUnitCase] = []
        self.options: Sequence[str] = ()
        self.raised: BaseException | None = None

    def run(self, out: Path, title: str, options: Sequence[str] = ()) -> None:
        """Measure and judge what these options of pytest leave; write out/verify.xml.

        Raises NoChecks when nothing is left, and what was raised outside the studies.
        """
        self.options = options
        status = pytest.main(
            [
                *SETTINGS, f"--rootdir={out}", "-o", f"cache_dir={out / '.checks'}",
                "-o", f"junit_suite_name={title}", f"--junitxml={out / 'verify.xml'}", *options,
            ],
            plugins=[self],
        )  # fmt: skip
        if self.raised is not None:
            raise self.raised
        if status == pytest.ExitCode.NO_TESTS_COLLECTED:
            raise NoChecks(f"{' '.join(options)} leaves no check.")
        if status == pytest.ExitCode.USAGE_ERROR:
            raise NoChecks(f"{' '.join(options)} must be what pytest understands.")

    @pytest.hookimpl(tryfirst=True)
    def pytest_collection(self, session: pytest.Session) -> bool:
        """An item for each row that its claim's document has."""
        session.items = [item for claim in self.claims for item in self._rows_of(session, claim)]
        hook, config = session.config.hook, session.config
        hook.pytest_collection_modifyitems(session=session, config=config, items=session.items)
        hook.pytest_collection_finish(session=session)
        session.testscollected = len(session.items)
        return True

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtestloop(self, session: pytest.Session) -> None:
        """Measure the claims of all chosen items; rows that only a measurement shows, such as
        those of a user's integrator, and further cases become items, too."""
        items: list[Any] = session.items
        names = {item.claim for item in items}
        self.measured = self.measure([claim for claim in self.claims if claim.id in names])
        cases = [(one.claim.id, case) for one in self.measured for case in self.cases(one)]
        by_name = {(claim, case.name): case for claim, case in cases}
        for item in items:
            item.case = by_name.get((item.claim, item.name))
        if not self.options:
            listed = {(item.claim, item.name) for item in items}
            cases = [(claim, case) for claim, case in cases if (claim, case.name) not in listed]
            unlisted = {claim for claim, _ in cases}
            items[:] = [item for item in items if item.case or item.claim not in unlisted]
            for claim, case in [*cases, *(("", case) for case in self.further(self.measured))]:
                item = self._item(session, case.class_name, case.name, claim)
                item.case = case
                items.append(item)
        self.judged = [item.case for item in items if item.case]

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_makereport(self, item: Any) -> Generator[None, Any, Any]:
        """A row takes its share of the seconds of its claim's study."""
        report = yield
        if report.when == "call" and item.case is not None:
            report.duration = item.case.seconds
        return report

    def pytest_keyboard_interrupt(self, excinfo: pytest.ExceptionInfo[BaseException]) -> None:
        """Keep it for the caller."""
        self.raised = excinfo.value

    def pytest_internalerror(self, excinfo: pytest.ExceptionInfo[BaseException]) -> bool:
        """Keep it for the caller; pytest need not print it."""
        self.raised = excinfo.value
        return True

    def _rows_of(self, session: pytest.Session, claim: Claim) -> Iterator[CheckItem]:
        try:
            rows = claim.judge(pd.DataFrame())
        except Exception:  # it is judged, and told, when it has been measured
            rows = []
        names = [(row.quantity, row.source) for row in rows] or [(claim.title, "")]
        for quantity, source in names:
            yield self._item(session, f"{kind_of(source)}.{claim.id}", quantity, claim.id, source)

    def _item(
        self, session: pytest.Session, group: str, name: str, claim: str, source: str = ""
    ) -> CheckItem:
        nodeid = f"{group}::{name.replace('::', ': :')}"
        return CheckItem.from_parent(
            session, name=name, nodeid=nodeid, claim=claim, words=[claim, source]
        )


def kind_of(source: str) -> str:
    """The first word of a row's group: "agreement", or "claim" for what a paper says."""
    return source if source == AGREEMENT else "claim"
