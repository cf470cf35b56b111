"""verify.xml: verdicts as JUnit XML for CI services, one test case per row."""

from __future__ import annotations

import re
from collections.abc import Sequence
from xml.etree import ElementTree as tree

from benchmarks.checks.claim import Row
from reports.results.claim_results import NOT_RUN, ClaimResult
from reports.results.engines import Engines
from reports.tables.number_format import plain

FORBIDDEN = re.compile("[^\t\n\r\u0020-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")  # in XML 1.0


def junit(checked: Sequence[ClaimResult], engines: Engines) -> str:
    """One test suite per claim and one for the engines, as XML text.

    failure  a verdict other than the expected one, or a missing required engine
    error    a row that should have been measured but was not
    skipped  a missing row or engine that is not required
    """
    root = tree.Element("testsuites", name="python -m reports verify")
    for one in checked:
        cases = [_case(row, one.seconds / len(one.rows)) for row in one.rows]
        _suite(root, f"{one.claim.id} {one.claim.title}", cases)
    _suite(root, "engines", [_engine(name, engines) for name in engines.absence])
    for name in ("tests", "failures", "errors", "skipped"):
        root.set(name, str(sum(int(suite.get(name, "0")) for suite in root)))
    tree.indent(root)
    return tree.tostring(root, encoding="unicode", xml_declaration=True) + "\n"


def details(row: Row) -> str:
    """The measured value, the bound and the verdicts, one line each."""
    measured = plain(row.measured, 6) or "nothing"
    error = plain(row.uncertainty, 2)
    return "\n".join(
        (
            f"measured: {measured}{f' -+ {error}' if error else ''}",
            f"bound: {row.bound or 'none'}",
            f"verdict: {row.verdict}; expected: {row.expected or 'a verdict'}",
            f"against: {row.reference}",
            f"setup: {row.setup}",
            f"reason: {row.reason}",
        )
    )


def _case(row: Row, seconds: float) -> tree.Element:
    case = tree.Element(
        "testcase",
        classname=f"{row.source if row.source == 'agreement' else 'claim'}.{_clean(row.id)}",
        name=_clean(row.quantity),
        time=f"{seconds:.3f}",
    )
    if row.verdict == NOT_RUN:
        kind = "skipped" if row.expected == NOT_RUN else "error"
        tree.SubElement(case, kind, message=_clean(f"not run: {row.reason}"))
    elif row.verdict != row.expected:
        message = (
            f"{row.verdict}, expected was {row.expected}: measured {plain(row.measured, 6)}, "
            f"bound {row.bound}"
        )
        tree.SubElement(case, "failure", message=_clean(message)).text = _clean(details(row))
    tree.SubElement(case, "system-out").text = _clean(details(row))
    return case


def _engine(name: str, engines: Engines) -> tree.Element:
    case = tree.Element("testcase", classname="engines", name=name, time="0.000")
    if engines.absence[name]:
        kind = "failure" if name in engines.required else "skipped"
        tree.SubElement(case, kind, message=_clean(f"{name} is absent: {engines.absence[name]}"))
    return case


def _suite(root: tree.Element, name: str, cases: Sequence[tree.Element]) -> None:
    def count(kind: str) -> str:
        return str(sum(case.find(kind) is not None for case in cases))

    seconds = sum(float(case.get("time", "0")) for case in cases)
    suite = tree.SubElement(
        root, "testsuite", name=_clean(name), tests=str(len(cases)), failures=count("failure"),
        errors=count("error"), skipped=count("skipped"), time=f"{seconds:.3f}",
    )  # fmt: skip
    suite.extend(cases)


def _clean(text: str) -> str:
    return FORBIDDEN.sub("?", text)
