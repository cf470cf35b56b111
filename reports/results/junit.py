"""JUnit XML for CI services: test cases as values, and the text of a file."""

from __future__ import annotations

import os
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal
from xml.etree import ElementTree as tree

from benchmarks.store.foreign_texts import visible

FORBIDDEN = re.compile("[^\t\n\r\u0020-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")  # in XML 1.0

MAX_ANNOTATIONS = 10  # annotations that GitHub shows of a step

Outcome = Literal["passed", "failure", "error", "skipped"]
TOTALS: Mapping[str, Outcome] = {"failures": "failure", "errors": "error", "skipped": "skipped"}


@dataclass(frozen=True)
class JUnitCase:
    """A test case of JUnit XML.

    Attributes
    ----------
    class_name
        what was checked; CI services group by it
    seconds
        duration; 0 if it was not measured
    outcome
        "failure": the answer is not as expected; "error": there is no answer
    message
        one sentence on an outcome other than "passed"
    details
        more text, for people, whatever the outcome
    properties
        (name, text) of each property, whatever the outcome
    defined_at
        file, relative to the root of the repository, and line of the checked code; "" if the file
        is unknown, and 0 for the file as a whole
    """

    class_name: str
    name: str
    seconds: float = 0.0
    outcome: Outcome = "passed"
    message: str = ""
    details: str = ""
    properties: tuple[tuple[str, str], ...] = ()
    defined_at: tuple[str, int] = ("", 0)


def junit_xml(title: str, suites: Mapping[str, Sequence[JUnitCase]]) -> str:
    """The text of a JUnit file; characters that XML forbids become "?".

    Parameters
    ----------
    title
        the command as the user called it, such as "galvi verify"
    suites
        name of a suite -> its cases
    """
    all_cases = [case for cases in suites.values() for case in cases]
    root = tree.Element("testsuites", _totals(all_cases), name=title)
    for name, cases in suites.items():
        suite = tree.SubElement(root, "testsuite", _totals(cases), name=name)
        for case in cases:
            _add(suite, case)
    tree.indent(root)
    text = tree.tostring(root, encoding="unicode", xml_declaration=True)
    return FORBIDDEN.sub("?", text) + "\n"


def github_annotations(cases: Sequence[JUnitCase]) -> list[str]:
    """Lines that make a job on GitHub show failures and errors, at most MAX_ANNOTATIONS; []
    elsewhere."""
    if os.environ.get("GITHUB_ACTIONS") != "true":
        return []
    return [
        f"::error {_command_properties(case)}::{_escaped(case.message)}"
        for case in cases
        if case.outcome in ("failure", "error")
    ][:MAX_ANNOTATIONS]


def _command_properties(case: JUnitCase) -> str:
    file, line = case.defined_at
    title = f"{case.class_name}: {case.name}"
    texts = {"file": file, "line": str(line or ""), "title": title}
    return ",".join(f"{name}={_escaped(text, ':,')}" for name, text in texts.items() if text)


def _escaped(text: str, extra: str = "") -> str:
    """The text, escaped for GitHub's workflow commands, with further characters to escape in
    `extra`."""
    signs = f"%\r\n{extra}"
    return visible("".join(f"%{ord(sign):02X}" if sign in signs else sign for sign in text))


def _totals(cases: Sequence[JUnitCase]) -> dict[str, str]:
    outcomes = [case.outcome for case in cases]
    counts = {name: str(outcomes.count(outcome)) for name, outcome in TOTALS.items()}
    seconds = sum(case.seconds for case in cases)
    return {"tests": str(len(cases)), **counts, "time": f"{seconds:.3f}"}


def _add(suite: tree.Element, case: JUnitCase) -> None:
    attributes = {"classname": case.class_name, "name": case.name, "time": f"{case.seconds:.3f}"}
    file, line = case.defined_at
    attributes |= {"file": file} if file else {}
    attributes |= {"line": str(line)} if line else {}
    element = tree.SubElement(suite, "testcase", attributes)
    if case.properties:
        properties = tree.SubElement(element, "properties")
        for name, text in case.properties:
            tree.SubElement(properties, "property", name=name, value=text)
    if case.outcome != "passed":
        explained = case.details or "\n".join(map(": ".join, case.properties))
        tree.SubElement(element, case.outcome, message=case.message).text = explained
    if case.details:
        tree.SubElement(element, "system-out").text = case.details
