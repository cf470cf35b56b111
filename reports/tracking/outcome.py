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

    Attributes
    ----------
    together
        the times of each integrator's benchmarks together, where it is not galvi
    yardstick
        seconds of the fixed workload, timed beside the first round; NaN where it was not
    """

    base: str
    head: str
    findings: tuple[Finding, ...]
    together: tuple[Together, ...] = ()
    yardstick: float = math.nan

    @property
    def judged(self) -> tuple[Finding | Together, ...]:
        """The findings, and the times together: each has a name, alarms and notes."""
        return (*self.findings, *self.together)

    @property
    def red(self) -> bool:
        """Whether anything got worse."""
        return any(item.alarms for item in self.judged)

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
        pairs = [finding.pair for finding in self.findings]
        names = dict.fromkeys(pair.case.contender for pair in pairs)
        runs = {pair.case.contender for pair in pairs if set(pair.why) != {"base"}}
        return [name for name in names if name and name not in runs]

    def __str__(self) -> str:
        head = self.head.replace("the working", "The working", 1)
        benchmarks = many(self.compared, "benchmark")
        missing = len(self.findings) - self.compared
        ends = [
            f"{group.name}: {text}" for group in self.together for text in group.alarms.values()
        ]
        ends += [
            f"{name} is new: {self.base} has nothing that runs to compare it with."
            for name in self.new
        ]
        ends += [f"{missing} could not be compared."] if missing else []
        if not self.compared:
            text = f"Nothing of {self.head} could be compared with {self.base}."
        elif self.worse:
            named = ", ".join(f"{worse.name} ({', '.join(worse.alarms)})" for worse in self.worse)
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
        sizes = sorted(size for finding in self.findings if not math.isnan(size := finding.visible))
        ends = dict.fromkeys(_growth(size) for size in (*sizes[:1], *sizes[-1:]))
        return f" (smallest growth visible here: {' to '.join(ends)})" if ends else ""

    def table(self) -> pd.DataFrame:
        """A row of text for each benchmark, the worse ones first."""
        ranked = sorted(self.findings, key=lambda finding: not finding.alarms)
        return pd.DataFrame([_row(finding) for finding in ranked])

    def report(self) -> str:
        """Markdown: the table, then alarms and notes with the names of their benchmarks."""
        lines = [f"{item.name}: {text}" for item in self.judged for text in item.alarms.values()]
        lines += [f"{item.name}: {note}" for item in self.judged for note in item.notes]
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
        "benchmarks": [{"name": item.name} | asdict(item) for item in outcome.findings],
        "together": [
            {"name": item.name, "growth": item.growth, "alarms": item.alarms, "notes": item.notes}
            for item in outcome.together
        ],
    }
    return pd.Series(content).to_json(double_precision=15, indent=1) + "\n"


def as_junit(outcome: Outcome, title: str) -> str:
    """A JUnit file with a test case for each benchmark and family of gates.

    Parameters
    ----------
    title
        the command as the user called it, such as "galvi track"
    """
    cases = [
        _junit_case(finding, family, finding.compared and (family != "time" or finding.pair.timed))
        for finding in outcome.findings
        for family in FAMILIES
    ]
    cases += [_junit_case(group, TOGETHER, True) for group in outcome.together]
    return junit_xml(title, {f"{outcome.head} against {outcome.base}": cases})


def _junit_case(item: Finding | Together, family: str, compared: bool) -> JUnitCase:
    gates = FAMILIES.get(family, (TIME,))
    alarms = " ".join(item.alarms[gate] for gate in gates if gate in item.alarms)
    notes = " ".join(item.notes)
    if alarms:
        return JUnitCase(item.name, family, outcome="failure", message=alarms, details=notes)
    if not compared:
        return JUnitCase(item.name, family, outcome="skipped", message=notes or "Not compared.")
    return JUnitCase(item.name, family, details=notes)


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
