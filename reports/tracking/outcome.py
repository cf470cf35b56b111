"""What a comparison of two commits comes to."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import pandas as pd

from benchmarks.statistics.rank_test import LEVEL
from reports.results.junit import JUnitCase, junit_xml
from reports.tables.number_format import known, plain
from reports.tables.writing import as_markdown
from reports.tracking.gates import (
    COUNTS,
    ERROR,
    FAILS,
    MEMORY,
    PROBLEM,
    REPEATS,
    TIME,
    Finding,
)
from reports.tracking.together import Together

FILE = Path(__file__).with_name("known_changes.csv")
COLUMNS = ("benchmark", "quantity", "commit", "reason")
FEWEST = 7  # digits of a commit


@dataclass(frozen=True)
class KnownChange:
    """A change near a commit that has a reason; benchmark: part of its name, "" for all."""

    benchmark: str
    quantity: str
    commit: str
    reason: str

    def fits(self, benchmark: str, quantity: str, commit: str) -> bool:
        """Whether it explains this change."""
        alike = self.benchmark in benchmark and self.quantity == quantity
        return alike and commit.startswith(self.commit)


def known_changes(file: Path = FILE) -> tuple[KnownChange, ...]:
    """The rows of the file. Raises ValueError for a row without a reason or a full commit."""
    table = pd.read_csv(file, dtype=str, keep_default_na=False)
    if tuple(table) != COLUMNS:
        raise ValueError(f"{file.name} must have the columns {', '.join(COLUMNS)}.")
    found = tuple(KnownChange(**row) for row in table.to_dict("records"))  # type: ignore[misc]
    for one in found:
        if not one.reason.strip() or len(one.commit) < FEWEST:
            raise ValueError(
                f"{file.name}: a change needs a reason and at least {FEWEST} digits of its commit; "
                f"received {one}."
            )
    return found


def reason_of(known: Sequence[KnownChange], benchmark: str, quantity: str, commit: str) -> str:
    """Why a change is known; "" when it is not."""
    return next((one.reason for one in known if one.fits(benchmark, quantity, commit)), "")


LEGEND = (
    "Times are processor time, base and head interleaved; p is the probability that equal code "
    f"looks so (Mann-Whitney; below {LEVEL} after Holm's correction it counts), and a time is "
    "worse when its median also grew by the benchmark's threshold, in two rounds of fresh "
    "processes. The times of an integrator's benchmarks together are worse at half of that growth, "
    "in five rounds. Visible from: the least growth of all times that would have counted. Counts "
    "are summed for the table and compared one by one. Ends moved: the largest difference of a "
    "coordinate, or a momentum of an integrator's; 0 means bit-identical. Each side runs twice, "
    "and in a further process: all must have the same bits, and the second run leave and need no "
    "more memory than the base's."
)


@dataclass(frozen=True)
class Outcome:
    """Names of base and head, and a finding for each benchmark.

    together   the times of each integrator's benchmarks together, where it is not galvi
    yardstick  seconds of the fixed workload, timed beside the first round; NaN where it was not
    """

    base: str
    head: str
    findings: tuple[Finding, ...]
    together: tuple[Together, ...] = ()
    yardstick: float = math.nan

    @property
    def red(self) -> bool:
        """Whether anything got worse."""
        return bool(self.worse) or any(one.alarm for one in self.together)

    @property
    def worse(self) -> tuple[Finding, ...]:
        """The findings with an alarm."""
        return tuple(finding for finding in self.findings if finding.alarms)

    def __str__(self) -> str:
        head = self.head.replace("the working", "The working", 1)
        count = sum(finding.compared for finding in self.findings)
        many = f"{count} benchmark" + ("" if count == 1 else "s")
        left = len(self.findings) - count
        rest = f" {left} could not be compared." if left else ""
        if not count:
            return f"Nothing of {self.head} could be compared with {self.base}.{rest}"
        slower = "".join(f" {one.name}: {one.alarm}" for one in self.together if one.alarm)
        if slower and not self.worse:
            return (
                f"{head} is worse than {self.base} by the times of {many} together.{slower}{rest}"
            )
        if not self.worse:
            return (
                f"{head} is not worse than {self.base} in {many}: no count, error or memory grew "
                f"beyond its tolerance, and no time by rank and size{self._power()}.{rest}"
            )
        named = ", ".join(f"{one.name} ({', '.join(one.alarms)})" for one in self.worse)
        which = f"{len(self.worse)} of {many}: {named}"
        return f"{head} is worse than {self.base} in {which}.{slower}{rest}"

    def _power(self) -> str:
        """What growth of times could have been seen, as a clause."""
        sizes = [one.visible for one in self.findings if not math.isnan(one.visible)]
        if not sizes:
            return ""
        least, most = (_growth(size) for size in (min(sizes), max(sizes)))
        several = least if least == most else f"{least} to {most}"
        return f" (smallest growth visible here: {several})"

    def table(self) -> pd.DataFrame:
        """A row of text for each benchmark, the worse ones first."""
        ranked = sorted(self.findings, key=lambda finding: not finding.alarms)
        return pd.DataFrame([_row(finding) for finding in ranked])

    def report(self) -> str:
        """Markdown: the table, then alarms and notes with the names of their benchmarks."""
        said = [f"{one.name}: {text}" for one in self.worse for text in one.alarms.values()]
        said += [f"{one.name}: {one.alarm}" for one in self.together if one.alarm]
        said += [f"{one.name}: {note}" for one in self.findings for note in one.notes]
        said += [f"{one.name}: {one.note}" for one in self.together if one.note]
        return "\n".join([as_markdown(self.table()), *(f"- {sentence}" for sentence in said)])


def summary(outcome: Outcome, provenance: Mapping[str, str]) -> str:
    """Markdown for the job summary of a pull request."""
    origin = "; ".join(f"{key}: {value}" for key, value in provenance.items())
    return "\n\n".join([f"**{outcome}**", outcome.report().strip(), LEGEND, origin]) + "\n"


def as_json(outcome: Outcome, provenance: Mapping[str, str]) -> str:
    """Everything as JSON, including raw samples; null where unknown."""
    whole = {
        "verdict": str(outcome),
        "worse": outcome.red,
        "base": outcome.base,
        "head": outcome.head,
        "provenance": dict(provenance),
        "benchmarks": [{"name": one.name} | asdict(one) for one in outcome.findings],
        "together": [asdict(one) for one in outcome.together],
    }
    return json.dumps(_finite(whole), indent=1) + "\n"


FAMILIES = {  # of gates, as the test cases of a benchmark
    "runs": (FAILS, PROBLEM),
    "repeats its bits": (REPEATS,),
    "counts": (COUNTS,),
    "error": (ERROR,),
    "memory": (MEMORY,),
    "time": (TIME,),
}
TOGETHER = "time of all benchmarks together"


def as_junit(outcome: Outcome, title: str) -> str:
    """A JUnit file with a test case for each benchmark and family of gates.

    title  the command as the user called it, such as "galvi track"
    """
    cases = [_junit_case(one, *family) for one in outcome.findings for family in FAMILIES.items()]
    cases += [
        JUnitCase(one.name, TOGETHER, outcome="failure" if one.alarm else "passed",
                  message=one.alarm, details=one.note)
        for one in outcome.together
    ]  # fmt: skip
    return junit_xml(title, {f"{outcome.head} against {outcome.base}": cases})


def _junit_case(finding: Finding, family: str, gates: Sequence[str]) -> JUnitCase:
    said = " ".join(finding.alarms[gate] for gate in gates if gate in finding.alarms)
    notes = " ".join(finding.notes)
    if said:
        return JUnitCase(finding.name, family, outcome="failure", message=said, details=notes)
    if not finding.compared or (family == "time" and not finding.pair.rounds):
        why = "Not compared." if not finding.compared else "Its time is not compared."
        return JUnitCase(finding.name, family, outcome="skipped", message=notes or why)
    return JUnitCase(finding.name, family, details=notes)


def _row(one: Finding) -> dict[str, str]:
    outcome = "not worse" if one.compared else "not compared"
    return {
        "benchmark": one.name,
        "time": f"{100 * one.growth:+.1f} %" if known(one.growth) else "-",
        "p": plain(one.p, 2) or "-",
        "visible from": "-" if math.isnan(one.visible) else _growth(one.visible),
        "counts": _change(*_sums(*(run["counts"] for run in one.pair.reached.values()))),
        "error": _change(*one.errors),
        "ends moved": plain(one.moved, 2) or "-",
        "verdict": f"worse: {', '.join(one.alarms)}" if one.alarms else outcome,
    }


def _growth(size: float) -> str:
    return "more than 300 %" if math.isinf(size) else f"{100 * size:.0f} %"


def _sums(*counts: Mapping[str, int]) -> tuple[float, float]:
    """Sums over the counts that both sides have; NaN when there are none."""
    shared = counts[0].keys() & counts[1].keys() if len(counts) == 2 else ()
    if not shared:
        return math.nan, math.nan
    base, head = (float(sum(side[name] for name in shared)) for side in counts)
    return base, head


def _change(base: float, head: float) -> str:
    if not known(base) or not known(head):
        return "-"
    if base == head:
        return "same"
    if plain(base) != plain(head):
        return f"{plain(base)} to {plain(head)}"
    return f"{100 * (head / base - 1):+.1g} %"


def _finite(value: Any) -> Any:
    """The value with None in place of NaN and infinities, which JSON lacks."""
    if isinstance(value, dict):
        return {key: _finite(one) for key, one in value.items()}
    if isinstance(value, (list, tuple)):
        return [_finite(one) for one in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
