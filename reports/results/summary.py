"""The summary of a report's rows, and the job summary of GitHub."""

from __future__ import annotations

import os
import sys
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

from benchmarks.checks.bounds import EXCEEDS, FINDING, NOT_RUN, VERDICTS
from benchmarks.checks.claim import AGREEMENT, Row
from benchmarks.checks.coverage import coverage
from benchmarks.claims.statements import statements, unfounded
from reports.results.claim_results import ClaimResult

SUMMARY_VARIABLE = "GITHUB_STEP_SUMMARY"  # the path of the summary file


def write_job_summary(text: str) -> None:
    """Append to the summary file that SUMMARY_VARIABLE names, if any; print a warning if that
    fails.

    A line break is added after the text: without a blank line, Markdown after a </details> would be
    shown as it is written.
    """
    path = os.environ.get(SUMMARY_VARIABLE)
    if not path:
        return
    try:
        with open(path, "a", encoding="utf-8") as file:
            file.write(f"{text}\n")
    except OSError as error:
        print(f"The summary was not appended to ${SUMMARY_VARIABLE}: {error}.", file=sys.stderr)


@dataclass(frozen=True)
class Summary:
    """The rows of claims and their counts; `str()` gives one sentence.

    Attributes
    ----------
    differing
        rows whose verdict is not as expected
    """

    rows: tuple[Row, ...]

    @property
    def differing(self) -> tuple[Row, ...]:
        return tuple(row for row in self.rows if row.verdict != row.expected)

    @property
    def percent_expected(self) -> float:
        """Percent of the rows with the expected verdict, of those that were run or should have
        been; 0 without such rows."""
        counted = [row for row in self.rows if row.verdict != NOT_RUN or row.expected != NOT_RUN]
        expected = len(counted) - len(self.differing)
        return 100.0 * expected / len(counted) if counted else 0.0

    @property
    def unfounded(self) -> list[str]:
        """Sentences on statements of the papers that the rows do not support.

        Empty if a verdict is not the expected one, or if a claim that a statement names has no row
        or one that was not run.
        """
        needed = {claim for statement in statements() for claim in statement.claims}
        not_run = {row.id for row in self.rows if row.verdict == NOT_RUN}
        complete = needed <= {row.id for row in self.rows} - not_run
        return unfounded(statements(), self.rows) if complete and not self.differing else []

    def holds(self, fail_under: float = 100.0) -> bool:
        """Whether the checks hold: something was measured, at least `fail_under` percent of the
        verdicts are as expected, the stated errors of orders are plausible, and no statement of the
        papers is unfounded."""
        measured = any(row.verdict != NOT_RUN for row in self.rows)
        founded = coverage(self.rows).is_plausible and not self.unfounded
        return measured and self.percent_expected >= fail_under and founded

    def __str__(self) -> str:
        agreements = {row.id for row in self.rows if row.source == AGREEMENT}
        claims = {row.id for row in self.rows} - agreements
        kinds = ((len(claims), "claim"), (len(agreements), "agreement"))
        subjects = " and ".join(count_of(count, noun) for count, noun in kinds if count)
        counts = Counter(row.verdict for row in self.rows)
        counted = ", ".join(_verdict_count(counts[word], word) for word in VERDICTS if counts[word])
        if not self.rows:
            return "No claim was checked."
        checks = f"{subjects} in {count_of(len(self.rows), 'check')}: {counted}"
        if counts[NOT_RUN] == len(self.rows):
            return f"{checks}; nothing was measured."
        covered = coverage(self.rows)
        if covered.orders:
            errors = "cover" if covered.is_plausible else "are too small"
            checks += f". The stated errors {errors}: {covered}"
        if unfounded_statements := self.unfounded:
            checks += (
                f". {count_of(len(unfounded_statements), 'printed statement')} unfounded: "
                f"{unfounded_statements[0].removesuffix('.')}"
            )
        if not self.differing:
            return f"{checks}; every verdict is the expected one."
        differ = "differs" if len(self.differing) == 1 else "differ"
        ids = ", ".join(dict.fromkeys(row.id for row in self.differing))
        return f"{checks}; {len(self.differing)} {differ} from what was expected ({ids})."


def summary(checked: Sequence[ClaimResult]) -> Summary:
    """The summary of the rows of these claims."""
    return Summary(tuple(row for claim_result in checked for row in claim_result.rows))


def count_of(count: int, noun: str) -> str:
    """E.g. "1 claim", "2 claims"."""
    return f"{count} {noun}" if count == 1 else f"{count} {noun}s"


def _verdict_count(count: int, verdict: str) -> str:
    if verdict == EXCEEDS:
        return f"{count} exceeded"
    return count_of(count, verdict) if verdict == FINDING else f"{count} {verdict}"
