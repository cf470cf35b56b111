"""Parsers of what CI services read of a job: JUnit files, annotations, and metrics."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import jsonschema
from junitparser import JUnitXml, Properties

COMMAND = re.compile(r"::(\w+)(?: ([^:]*))?::(.*)")  # of a workflow, as GitHub documents it
ESCAPES = {"%25": "%", "%0D": "\r", "%0A": "\n", "%3A": ":", "%2C": ","}
# Published at https://bencher.dev/bmf.json; the lengths are from bencher's reference page.
BENCHER_METRIC_FORMAT = {
    "$schema": "http://json-schema.org/draft-07/schema",
    "type": "object",
    "propertyNames": {"minLength": 1, "maxLength": 1024},
    "additionalProperties": {
        "type": "object",
        "propertyNames": {"pattern": "^[0-9a-z][0-9a-z-]{0,63}$"},
        "additionalProperties": {
            "type": "object",
            "properties": {
                name: {"type": "number"} for name in ("value", "lower_value", "upper_value")
            },
            "required": ["value"],
        },
    },
}


def annotations(printed: str) -> list[dict[str, str]]:
    """The workflow commands among printed lines: kind, properties, message."""
    commands = (COMMAND.fullmatch(line) for line in printed.splitlines())
    return [
        {
            "kind": command[1],
            **{
                name: unescaped(text)
                for name, _, text in (pair.partition("=") for pair in command[2].split(","))
            },
            "message": unescaped(command[3]),
        }
        for command in commands
        if command
    ]


def unescaped(text: str) -> str:
    return re.sub("%25|%0D|%0A|%3A|%2C", lambda sign: ESCAPES[sign[0]], text)


def junit_cases(path: Path) -> dict[tuple[str, str], dict[str, Any]]:
    """(class, name) of a test case -> its properties, the kinds of its results, file and line, as
    the publisher of unit test results parses them."""
    return {
        (case.classname, case.name): {
            **{entry.name: entry.value for entry in case.child(Properties) or ()},
            "results": [type(outcome).__name__ for outcome in case.result],
            "at": (case._elem.get("file"), case._elem.get("line")),
        }
        for suite in JUnitXml.fromfile(str(path))
        for case in suite
    }


def bencher_metrics(path: Path) -> dict[str, dict[str, dict[str, float]]]:
    """{benchmark: {measure: {"value": .., "lower_value": .., "upper_value": ..}}}.

    Raises ValidationError for another format, ValueError for NaN and infinities.
    """
    text = path.read_text(encoding="utf-8")
    content: dict[str, dict[str, dict[str, float]]] = json.loads(text, parse_constant=_refuse)
    jsonschema.validate(content, BENCHER_METRIC_FORMAT)
    return content


def _refuse(name: str) -> None:
    raise ValueError(f"{name} is no number of JSON")
