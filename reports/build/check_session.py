"""The checks of `verify` as items of pytest, which chooses them and remembers what failed."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pandas as pd
import pytest

from benchmarks.checks.claim import AGREEMENT, Claim
from benchmarks.store.atomic import write
from reports.results.claim_results import ClaimResult
from reports.results.junit import JUnitCase, junit_xml

# Of pytest only what chooses items, runs them and remembers failures, and nothing of the project
# around. Its JUnit files have other names than the rows: it takes brackets for a test's parameters.
SETTINGS = (
    *("-c", os.devnull, "--capture=no", "--assert=plain", "--disable-plugin-autoload"),
    *("--noconftest", "-o", "cache_dir=.checks"),
    *(f"-pno:{name}" for name in ("terminal", "junitxml", "warnings", "logging", "faulthandler",
                                  "unraisableexception", "threadexception")),
)  # fmt: skip
VARIABLES = ("PYTEST_ADDOPTS", "PYTEST_PLUGINS")  # of the environment, for the project's own tests


class DifferentOutcome(Exception):
    """A check did not come out as expected, or was not measured; the message says how."""


class NoChecks(Exception):
    """Options chose none of the checks."""


class CheckItem(pytest.Item):
    """A check that becomes a case when its claim has been measured.

    whole  it stands for all checks of its claim, which only a measurement shows, such as those of a
           user's integrator
    """

    def __init__(
        self, *, claim: str, words: Sequence[str], whole: bool = False, **more: Any
    ) -> None:
        super().__init__(**more)
        self.claim, self.whole = claim, whole
        self.extra_keyword_matches.update(words)
        why = "the judge of its claim gave no such row"
        self.case = JUnitCase(self.nodeid.partition("::")[0], self.name, 0.0, "error", why)

    def runtest(self) -> None:
        """Raises DifferentOutcome for a failure or an error."""
        if self.case.outcome in ("failure", "error"):
            raise DifferentOutcome(self.case.message)

    def reportinfo(self) -> tuple[Any, int | None, str]:
        """Its place, which is no file."""
        return self.nodeid.partition("::")[0], None, self.name


class CheckSession:
    """A run of pytest over the rows of claims, and what follows from all of them.

    claims   whose rows are items
    measure  the results of some of the claims
    cases    the cases of the rows of a result
    further  cases that these results make together

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
        self.raised: BaseException | None = None

    def run(self, out: Path, title: str, options: Sequence[str] = ()) -> None:
        """Measure and judge what these options of pytest leave; write out/verify.xml.

        Raises NoChecks when nothing is left, and what was raised outside the studies.
        """
        with _without(VARIABLES):
            status = pytest.main(
                [*SETTINGS, f"--rootdir={out.resolve()}", *options], plugins=[self]
            )
        if self.raised is not None:
            raise self.raised
        if status == pytest.ExitCode.NO_TESTS_COLLECTED:
            raise NoChecks(
                f"{' '.join(options)} leaves no check; it takes words of names, ids and sources."
            )
        if status == pytest.ExitCode.USAGE_ERROR:
            raise NoChecks(f"{' '.join(options)} must be what pytest understands.")
        write(out / "verify.xml", junit_xml(title, {title: self.judged}))

    @pytest.hookimpl(tryfirst=True)
    def pytest_collection(self, session: pytest.Session) -> bool:
        """An item for each row that its claim's document has."""
        session.items = [item for claim in self.claims for item in self._rows_of(session, claim)]
        hook, config = session.config.hook, session.config
        try:
            hook.pytest_collection_modifyitems(session=session, config=config, items=session.items)
        except pytest.UsageError as refused:
            self.raised, session.items = NoChecks(f"{refused}."), []
        hook.pytest_collection_finish(session=session)
        session.testscollected = len(session.items)
        return True

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtestloop(self, session: pytest.Session) -> None:
        """Measure the claims of all chosen items; what only a measurement shows, rows of these
        claims that differ and were not chosen, and further cases become items, too."""
        items: list[Any] = session.items
        names = {item.claim for item in items}
        self.measured = self.measure([claim for claim in self.claims if claim.id in names])
        cases = [(result.claim.id, case) for result in self.measured for case in self.cases(result)]
        by_name = {(claim, case.name): case for claim, case in cases}
        whole = {item.claim for item in items if item.whole}
        items[:] = [item for item in items if not item.whole]
        for item in items:
            item.case = by_name.get((item.claim, item.name), item.case)
        chosen = {(item.claim, item.name) for item in items}
        new = [
            (claim, case)
            for claim, case in cases
            if claim in whole
            or (case.outcome in ("failure", "error") and (claim, case.name) not in chosen)
        ]
        if names:
            new += [("", case) for case in self.further(self.measured)]
        for claim, case in new:
            items.append(self._item(session, case.class_name, case.name, claim))
            items[-1].case = case
        self.judged = [item.case for item in items]

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
        for row in rows:
            group = f"{kind_of(row.source)}.{claim.id}"
            yield self._item(session, group, row.quantity, claim.id, row.source)
        if not rows:
            failed = session.config.cache.get("cache/lastfailed", {})
            ids = (nodeid for nodeid in failed if f".{claim.id}::" in nodeid)
            yield CheckItem.from_parent(
                session, name=claim.title, nodeid=next(ids, f"claim.{claim.id}::{claim.title}"),
                claim=claim.id, words=[claim.id], whole=True,
            )  # fmt: skip

    def _item(
        self, session: pytest.Session, group: str, name: str, claim: str, source: str = ""
    ) -> CheckItem:
        nodeid = f"{group}::{name.replace('::', ': :')}"
        return CheckItem.from_parent(
            session, name=name, nodeid=nodeid, claim=claim, words=[claim, source]
        )


@contextmanager
def _without(variables: Sequence[str]) -> Iterator[None]:
    """The environment without these variables."""
    values = {name: os.environ.pop(name) for name in variables if name in os.environ}
    try:
        yield
    finally:
        os.environ.update(values)


def kind_of(source: str) -> str:
    """The first word of a row's group: "agreement", or "claim" for what a paper says."""
    return source if source == AGREEMENT else "claim"
