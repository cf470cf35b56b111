"""The outcome of a comparison of two commits, as a sentence, a table, Markdown and JSON."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass

import pandas as pd

from benchmarks.statistics.rank_test import GROWTHS, POWER, SIGNIFICANCE
from reports.results.summary import count_of
from reports.tables.writing import as_markdown
from reports.tracking.gates import MAX_LEAK_MB, MAX_PEAK_MB, NOTE, Finding
from reports.tracking.rounds import SIDES
from reports.tracking.together import Together

LARGEST_GROWTH = 100 * GROWTHS[-1]  # percent; the largest growth that `smallest_visible` tries
LEGEND = f"""
- **time**: growth of the median processor time; samples of base and head are taken in turn. A time
  is worse when p is below {SIGNIFICANCE} after Holm's correction and the growth exceeds the
  benchmark's threshold, in two rounds of fresh processes. All times of an integrator together are
  worse at half of that threshold, in five rounds.
- **p**: probability that equal code looks at least this much slower (one-sided Mann-Whitney test).
- **detectable from**: the smallest growth that a round with this scatter detects in
  {100 * POWER:.0f} % of cases.
- **more counts**: by how much the sum of all counts grew; they are compared one by one.
- **error of base, of head**: against the truth.
- **final state moved**: the largest change of a coordinate, or of a momentum of your integrator; 0
  means bit-identical.
- **not deterministic**: each side runs twice in one process, and once or more in others. The head's
  results must be bit-identical where the base's are.
- **memory**: a second run may leave {MAX_LEAK_MB:.0f} MB and need {MAX_PEAK_MB:.0f} MB
  more than the base's.
""".strip()


@dataclass(frozen=True)
class Outcome:
    """The outcome of a comparison: names of base and head, and a finding for each benchmark.

    Attributes
    ----------
    together
        for each integrator other than galvi, the times of all its benchmarks together
    yardstick
        seconds of the fixed workload, timed before and after the first round; NaN if it was not
    """

    base: str
    head: str
    findings: tuple[Finding, ...]
    together: tuple[Together, ...] = ()
    yardstick: float = math.nan

    @property
    def assessed(self) -> tuple[Finding | Together, ...]:
        """The findings and `together`; each of them has a name, alarms and notes."""
        return (*self.findings, *self.together)

    @property
    def has_alarms(self) -> bool:
        """Whether there is an alarm."""
        return any(item.alarms for item in self.assessed)

    @property
    def alarming(self) -> tuple[Finding, ...]:
        """The findings with an alarm."""
        return tuple(finding for finding in self.findings if finding.alarms)

    @property
    def compared(self) -> int:
        """The number of benchmarks that were compared."""
        return sum(finding.compared for finding in self.findings)

    @property
    def new(self) -> list[str]:
        """Integrators of a project that only the head can run."""
        pairs = [finding.pair for finding in self.findings]
        names = dict.fromkeys(pair.case.contender for pair in pairs)
        runs = {pair.case.contender for pair in pairs if set(pair.why) != {"base"}}
        return [name for name in names if name and name not in runs]

    def __str__(self) -> str:
        head = self.head.replace("the working", "The working", 1)
        benchmarks = count_of(self.compared, "benchmark")
        missing = len(self.findings) - self.compared
        if not self.compared:
            sentences = [f"Nothing of {self.head} could be compared with {self.base}."]
        elif self.alarming:
            named = ", ".join(
                f"{worse.name} ({', '.join(worse.alarms)})" for worse in self.alarming
            )
            count = f"{len(self.alarming)} of {benchmarks}"
            sentences = [f"{head} is worse than {self.base} in {count}: {named}."]
        elif self.has_alarms:
            sentences = [f"{head} is slower than {self.base} in {benchmarks} taken together."]
        else:
            sentences = [
                f"{head} is not worse than {self.base} in {benchmarks}: no count, error, memory or "
                f"time grew by more than is tolerated{self._power()}."
            ]
        sentences += [
            f"{group.name}: {text}" for group in self.together for text in group.alarms.values()
        ]
        sentences += [
            f"{name} is new: {self.base} has no version that runs to compare it with."
            for name in self.new
        ]
        sentences += [f"{missing} could not be compared."] if missing and self.compared else []
        return " ".join(sentences)

    def _power(self) -> str:
        """A clause on the growth of times that could have been detected; "" if no time was."""
        sizes = pd.Series([finding.visible for finding in self.findings]).dropna()
        ends = dict.fromkeys(map(growth_in_words, (sizes.min(), sizes.max()) if len(sizes) else ()))
        return f" (smallest detectable growth of a time: {' to '.join(ends)})" if ends else ""

    def table(self) -> pd.DataFrame:
        """A row for each benchmark, those with alarms first; unknown numbers are NaN."""
        ranked = sorted(self.findings, key=lambda finding: not finding.alarms)
        rows = pd.DataFrame([_row(finding) for finding in ranked])
        return rows.replace(math.inf, f"> {LARGEST_GROWTH:.0f}")

    def report(self) -> str:
        """Markdown: the table, then alarms and notes with the names of their benchmarks."""
        lines = [(item.name, *alarm) for item in self.assessed for alarm in item.alarms.items()]
        lines += [(item.name, NOTE, note) for item in self.assessed for note in item.notes]
        return "\n".join(
            [
                as_markdown(self.table()),
                *(f"- {name} ({gate}): {text}" for name, gate, text in lines),
            ]
        )


def summary(outcome: Outcome, provenance: Mapping[str, str]) -> str:
    """Markdown for the job summary of a pull request."""
    origin = "; ".join(f"{key}: {value}" for key, value in provenance.items())
    legend = f"<details><summary>What the columns mean</summary>\n\n{LEGEND}\n</details>"
    return "\n\n".join([f"**{outcome}**", outcome.report().strip(), legend, origin]) + "\n"


def as_json(outcome: Outcome, provenance: Mapping[str, str]) -> str:
    """The outcome as JSON, including raw samples; unknown numbers are null."""
    content = {
        "verdict": str(outcome),
        "worse": outcome.has_alarms,
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


def _row(finding: Finding) -> dict[str, object]:
    counts = {side: run["counts"] for side, run in finding.pair.reached.items()}
    shared = pd.DataFrame(counts, columns=list(SIDES), dtype=float).dropna()
    base_count, head_count = shared.sum(min_count=1)
    base_error, head_error = finding.errors
    outcome = "not worse" if finding.compared else "not compared"
    return {
        "benchmark": finding.name,
        "time [%]": round(100 * finding.growth, 1),
        "p": finding.p,
        "detectable from [%]": 100 * finding.visible,
        "more counts": head_count - base_count,
        "error of base": base_error,
        "error of head": head_error,
        "final state moved": finding.moved,
        "verdict": f"worse: {', '.join(finding.alarms)}" if finding.alarms else outcome,
    }


def growth_in_words(size: float) -> str:
    """A relative growth in percent; "more than ..." for infinity."""
    return f"more than {LARGEST_GROWTH:.0f} %" if math.isinf(size) else f"{100 * size:.0f} %"
