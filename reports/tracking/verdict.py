"""A comparison as one sentence and one table: for a terminal, in Markdown, in JSON."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

from rich.console import Console
from rich.table import Table
from rich.text import Text

from benchmarks.statistics.rank_test import LEVEL
from reports.tables.number_format import known, plain
from reports.tracking.gates import Finding
from reports.tracking.rounds import Pair

HEADINGS = ("benchmark", "time", "p", "counts", "error", "ends moved", "verdict")
WIDTH = 130  # where output is not a terminal


@dataclass(frozen=True)
class Verdict:
    """base and head as people name them, and a finding for each benchmark."""

    base: str
    head: str
    findings: tuple[Finding, ...]

    @property
    def worse(self) -> tuple[Finding, ...]:
        """Those with an alarm."""
        return tuple(finding for finding in self.findings if finding.alarms)

    def __str__(self) -> str:
        count = sum(finding.compared for finding in self.findings)
        many = f"{count} benchmark" + ("" if count == 1 else "s")
        left = len(self.findings) - count
        rest = f" {left} could not be compared." if left else ""
        if not count:
            return f"Nothing of {self.head} could be compared with {self.base}.{rest}"
        if not self.worse:
            return (
                f"{_capital(self.head)} is not worse than {self.base} in {many}: no count, no "
                f"error beyond its tolerance, and no time by rank and size.{rest}"
            )
        named = ", ".join(f"{one.name} ({', '.join(one.alarms)})" for one in self.worse)
        return (
            f"{_capital(self.head)} is worse than {self.base} in {len(self.worse)} of {many}: "
            f"{named}.{rest}"
        )


def lines(verdict: Verdict) -> list[tuple[str, ...]]:
    """The table as text, one line for each benchmark, the worse ones first."""
    ranked = sorted(verdict.findings, key=lambda finding: not finding.alarms)
    return [
        (
            one.name,
            f"{100 * one.growth:+.1f} %" if known(one.growth) else "-",
            plain(one.chance, 2) or "-",
            _change(*_sums(one.base_counts, one.head_counts)),
            _change(one.base_error, one.head_error),
            plain(one.moved, 2) or "-",
            f"worse: {', '.join(one.alarms)}" if one.alarms
            else "not worse" if one.compared else "not compared",
        )
        for one in ranked
    ]  # fmt: skip


def remarks(verdict: Verdict) -> list[str]:
    """Alarms, then notes, each with the benchmark's name."""
    found = [f"{one.name}: {told}" for one in verdict.worse for told in one.alarms.values()]
    return found + [f"{one.name}: {note}" for one in verdict.findings for note in one.notes]


def show(verdict: Verdict, console: Console | None = None) -> None:
    """Print table, remarks and the sentence."""
    console = console or Console()
    if not console.is_terminal:
        console.width = WIDTH
    table = Table(box=None, pad_edge=False, header_style="bold")
    for heading in HEADINGS:
        table.add_column(heading, justify="right" if heading in HEADINGS[1:6] else "left")
    for line in lines(verdict):
        style = "bold red" if line[-1].startswith("worse") else ""
        table.add_row(*line[:-1], Text(line[-1], style=style))
    console.print(table)
    for remark in remarks(verdict):
        console.print(Text(remark))
    console.print(Text(str(verdict)))


def as_markdown(verdict: Verdict, provenance: dict[str, str]) -> str:
    """For a forge's page of a change."""
    told = [f"**{verdict}**", ""]
    told += [f"| {' | '.join(HEADINGS)} |", "|" + " --- |" * len(HEADINGS)]
    told += [f"| {' | '.join(_cell(text) for text in line)} |" for line in lines(verdict)]
    told += ["", *(f"- {_cell(remark)}" for remark in remarks(verdict)), ""]
    told += [
        "Times are processor time, base and head in turns; p is the chance that equal code looks "
        f"so (Mann and Whitney, below {LEVEL} after Holm's correction), and a time is worse when "
        "its median grew by the benchmark's size too, in two rounds of fresh processes. Counts "
        "are added up for the table and compared one by one. Ends moved: the largest difference "
        "of a coordinate; 0 is equality to the bit.",
        "",
        "; ".join(f"{key}: {value}" for key, value in provenance.items()),
        "",
    ]
    return "\n".join(told)


def as_json(verdict: Verdict, pairs: Sequence[Pair], provenance: dict[str, str]) -> str:
    """Everything, raw samples too; null for what is not known."""
    raw = {pair.case.name: pair for pair in pairs}
    rows = []
    for finding in verdict.findings:
        pair = raw[finding.name]
        rows.append(
            asdict(finding)
            | {"case": pair.case.as_data(), "why": pair.why}
            | {
                "processor_seconds": [{"base": b, "head": h} for b, h in pair.samples],
                "wall_seconds": [{"base": b, "head": h} for b, h in pair.walls],
                "first_call": {
                    side: (told or {}).get("first_call")
                    for side, told in (("base", pair.base), ("head", pair.head))
                },
            }
        )
    whole = {
        "verdict": str(verdict),
        "worse": bool(verdict.worse),
        "base": verdict.base,
        "head": verdict.head,
        "provenance": provenance,
        "benchmarks": rows,
    }
    return json.dumps(_finite(whole), indent=1) + "\n"


def _sums(base: dict[str, int], head: dict[str, int]) -> tuple[float, float]:
    """Of the counts that both sides have; NaN when there are none."""
    shared = base.keys() & head.keys()
    if not shared:
        return math.nan, math.nan
    return float(sum(base[name] for name in shared)), float(sum(head[name] for name in shared))


def _change(base: float, head: float) -> str:
    if not known(base) or not known(head):
        return "-"
    if base == head:
        return "same"
    return f"{plain(base)} to {plain(head)}" if plain(base) != plain(head) else (
        f"{100 * (head / base - 1):+.1g} %"
    )  # fmt: skip


def _capital(text: str) -> str:
    """Names of commits stay as they are."""
    return text.replace("the working", "The working", 1)


def _cell(text: str) -> str:
    return text.replace("|", "\\|")


def _finite(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _finite(one) for key, one in value.items()}
    if isinstance(value, (list, tuple)):
        return [_finite(one) for one in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
