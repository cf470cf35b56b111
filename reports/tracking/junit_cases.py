"""A comparison of two commits as test cases for CI services."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from benchmarks.statistics.rank_test import p_value
from reports.results.junit import JUnitCase, junit_xml
from reports.tables.number_format import plain
from reports.tracking.gates import COUNTS, ERROR, GATES, TIME, Finding
from reports.tracking.outcome import Outcome, growth_in_words
from reports.tracking.together import Together


def as_junit(outcome: Outcome, cases: Sequence[JUnitCase], title: str) -> str:
    """The text of a JUnit file with the cases.

    Parameters
    ----------
    title
        the command as the user called it, such as "galvi track"
    """
    return junit_xml(title, {f"{outcome.head} against {outcome.base}": cases})


def junit_cases(outcome: Outcome) -> list[JUnitCase]:
    """A case for each benchmark and gate, and one for all times of each integrator together."""
    cases = [
        replace(
            _case(finding, gate, _compared(finding, gate), _measured(finding, gate)),
            defined_at=finding.pair.case.defined_at,
        )
        for finding in outcome.findings
        for gate in GATES
    ]
    benchmarks = [finding.pair.case for finding in outcome.findings]
    defined_at = {case.contender: case.defined_at for case in benchmarks}
    return cases + [
        replace(_case(group, TIME, True, _together(group)), defined_at=defined_at[group.name])
        for group in outcome.together
    ]


def _compared(finding: Finding, gate: str) -> bool:
    return finding.compared and (gate != TIME or finding.pair.timed)


def _case(
    item: Finding | Together, gate: str, compared: bool, measured: Mapping[str, str]
) -> JUnitCase:
    notes, alarm = " ".join(item.notes), item.alarms.get(gate, "")
    verdict = "worse" if alarm else "not worse" if compared else "not compared"
    texts = {**measured, "verdict": verdict, "reason": alarm or notes}
    case = JUnitCase(
        item.name, gate, details=notes, properties=tuple(pair for pair in texts.items() if pair[1])
    )
    if alarm:
        return replace(case, outcome="failure", message=alarm)
    if not compared:
        return replace(case, outcome="skipped", message=notes or "Not compared.", details="")
    return case


def _measured(finding: Finding, gate: str) -> dict[str, str]:
    """Name -> text of the numbers that a gate compares; "" for an unknown number."""
    pair, case = finding.pair, finding.pair.case
    if gate == ERROR:
        base, head = finding.errors
        allowed = plain(case.tolerated(base))
        bound = f"at most {allowed}" if allowed else ""
        return {"base": plain(base), "head": plain(head), "bound": bound, "source": case.truth}
    if gate == COUNTS:
        return {side: _listed(run["counts"]) for side, run in pair.reached.items()}
    if gate == TIME and pair.timed:
        base_seconds, head_seconds = map(np.median, pair.samples(0))
        return {
            "base": f"{plain(base_seconds)} s",
            "head": f"{plain(head_seconds)} s",
            "growth": _percent(finding.growth),
            "p": plain(finding.p),
            "bound": f"at most {_percent(case.slower)}",
            "detectable from": growth_in_words(finding.visible),
        }
    return {}


def _together(group: Together) -> dict[str, str]:
    return {
        "growth": ", ".join(map(_percent, group.growth)),
        "p": plain(p_value(*group.rounds[0])),
        "bound": f"at most {_percent(group.size)}",
    }


def _listed(counts: Mapping[str, int]) -> str:
    return ", ".join(f"{name.replace('_', ' ')} {count}" for name, count in counts.items())


def _percent(growth: float) -> str:
    return f"{100.0 * growth:.1f} %"
