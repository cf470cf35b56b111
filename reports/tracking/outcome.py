"""What a comparison of two commits comes to."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass

import pandas as pd

from benchmarks.statistics.rank_test import LEVEL, POWER
from reports.results.junit import JUnitCase, junit_xml
from reports.results.summary import many
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

LEGEND = (
    "Times are processor time, base and head interleaved; p is the probability that equal code "
    f"looks so (Mann-Whitney; below {LEVEL} after Holm's correction it counts), and a time is "
    "worse when its median also grew by the benchmark's threshold, in two rounds of fresh "
    "processes. The times of an integrator's benchmarks together are worse at half of that growth, "
    "in five rounds. Visible from: the least growth of all times that would have counted in "
    f"{100 * POWER:.0f} % of the rounds with this scatter. Counts are summed for the table and "
    "compared one by one. Ends moved: the largest difference of a coordinate, or a momentum of an "
    "integrator's; 0 means bit-identical. Each side runs twice, and in a further process: all must "
    "have the same bits, and the second run leave and need no more memory than the base's."
)
FAMILIES = {  # of gates, as the test cases of a benchmark
    "runs": (FAILS, PROBLEM),
    "repeats its bits": (REPEATS,),
    "counts": (COUNTS,),
    "error": (ERROR,),
    "memory": (MEMORY,),
    "time": (TIME,),
}
TOGETHER = "time of all benchmarks together"


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

    @property
    def compared(self) -> int:
        """The number of benchmarks that were compared."""
        return sum(finding.compared for finding in self.findings)

    @property
    def new(self) -> list[str]:
        """Integrators of a project that the base lacks, or that the head mends."""
        names = dict.fromkeys(one.pair.case.contender for one in self.findings)
        runs = {one.pair.case.contender for one in self.findings if set(one.pair.why) != {"base"}}
        return [name for name in names if name and name not in runs]

    def __str__(self) -> str:
        head = self.head.replace("the working", "The working", 1)
        benchmarks = many(self.compared, "benchmark")
        missing = len(self.findings) - self.compared
        ends = [f"{group.name}: {group.alarm}" for group in self.together if group.alarm]
        ends += [
            f"{name} is new: {self.base} has nothing that runs to compare it with."
            for name in self.new
        ]
        ends += [f"{missing} could not be compared."] if missing else []
        if not self.compared:
            text = f"Nothing of {self.head} could be compared with {self.base}."
        elif self.worse:
            named = ", ".join(f"{one.name} ({', '.join(one.alarms)})" for one in self.worse)
            text = (
                f"{head} is worse than {self.base} in {len(self.worse)} of {benchmarks}: {named}."
            )
        elif self.red:
            text = f"{head} is worse than {self.base} by the times of {benchmarks} together."
        else:
            text = (
                f"{head} is not worse than {self.base} in {benchmarks}: no count, error or memory "
                f"grew beyond its tolerance, and no time by rank and size{self._power()}."
            )
        return " ".join([text, *ends])

    def _power(self) -> str:
        """What growth of times could have been seen, as a clause."""
        sizes = sorted(one.visible for one in self.findings if not math.isnan(one.visible))
        ends = dict.fromkeys(_growth(size) for size in (*sizes[:1], *sizes[-1:]))
        return f" (smallest growth visible here: {' to '.join(ends)})" if ends else ""

    def table(self) -> pd.DataFrame:
        """A row of text for each benchmark, the worse ones first."""
        ranked = sorted(self.findings, key=lambda finding: not finding.alarms)
        return pd.DataFrame([_row(finding) for finding in ranked])

    def report(self) -> str:
        """Markdown: the table, then alarms and notes with the names of their benchmarks."""
        lines = [f"{one.name}: {text}" for one in self.worse for text in one.alarms.values()]
        lines += [f"{one.name}: {one.alarm}" for one in self.together if one.alarm]
        lines += [f"{one.name}: {note}" for one in self.findings for note in one.notes]
        lines += [f"{one.name}: {one.note}" for one in self.together if one.note]
        return "\n".join([as_markdown(self.table()), *(f"- {line}" for line in lines)])


def summary(outcome: Outcome, provenance: Mapping[str, str]) -> str:
    """Markdown for the job summary of a pull request."""
    origin = "; ".join(f"{key}: {value}" for key, value in provenance.items())
    return "\n\n".join([f"**{outcome}**", outcome.report().strip(), LEGEND, origin]) + "\n"


def as_json(outcome: Outcome, provenance: Mapping[str, str]) -> str:
    """Everything as JSON, including raw samples; null where unknown."""
    content = {
        "verdict": str(outcome),
        "worse": outcome.red,
        "base": outcome.base,
        "head": outcome.head,
        "provenance": dict(provenance),
        "benchmarks": [{"name": one.name} | asdict(one) for one in outcome.findings],
        "together": [
            {"name": one.name, "growth": one.growth, "alarm": one.alarm, "note": one.note}
            for one in outcome.together
        ],
    }
    return pd.Series(content).to_json(double_precision=15, indent=1) + "\n"


def as_junit(outcome: Outcome, title: str) -> str:
    """A JUnit file with a test case for each benchmark and family of gates.

    title  the command as the user called it, such as "galvi track"
    """
    cases = [_junit_case(one, family) for one in outcome.findings for family in FAMILIES]
    cases += [
        JUnitCase(one.name, TOGETHER, outcome="failure" if one.alarm else "passed",
                  message=one.alarm, details=one.note)
        for one in outcome.together
    ]  # fmt: skip
    return junit_xml(title, {f"{outcome.head} against {outcome.base}": cases})


def _junit_case(finding: Finding, family: str) -> JUnitCase:
    alarms = " ".join(finding.alarms[gate] for gate in FAMILIES[family] if gate in finding.alarms)
    notes = " ".join(finding.notes)
    if alarms:
        return JUnitCase(finding.name, family, outcome="failure", message=alarms, details=notes)
    if not finding.compared or (family == "time" and not finding.pair.rounds):
        return JUnitCase(finding.name, family, outcome="skipped", message=notes or "Not compared.")
    return JUnitCase(finding.name, family, details=notes)


def _row(finding: Finding) -> dict[str, str]:
    outcome = "not worse" if finding.compared else "not compared"
    return {
        "benchmark": finding.name,
        "time": f"{100 * finding.growth:+.1f} %" if known(finding.growth) else "-",
        "p": plain(finding.p, 2) or "-",
        "visible from": "-" if math.isnan(finding.visible) else _growth(finding.visible),
        "counts": _change(*_sums(*(run["counts"] for run in finding.pair.reached.values()))),
        "error": _change(*finding.errors),
        "ends moved": plain(finding.moved, 2) or "-",
        "verdict": f"worse: {', '.join(finding.alarms)}" if finding.alarms else outcome,
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
