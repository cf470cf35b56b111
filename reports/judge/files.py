"""The files of a judgement: its page, its numbers as JSON and CSV, and its test cases for CI."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import pandas as pd
from jinja2 import Environment, FileSystemLoader, StrictUndefined
from markupsafe import Markup

from benchmarks.applications.judging.judgement import Judgement
from benchmarks.applications.judging.truth import time_text
from benchmarks.store.atomic import write
from benchmarks.store.cells import as_csv
from galvi import NBody
from galvi.repository import path_in_repository
from reports.judge.pictures import pictures
from reports.judge.sentences import own_run, sentences, truth
from reports.results.junit import JUnitCase, Outcome
from reports.tables.html import html_table
from reports.tables.number_format import is_finite, readable, seconds
from reports.tables.number_format import plain as plain_number
from reports.tables.study_table import readable_table

TEMPLATE_FOLDER = Path(__file__).parent
MAX_PARTS = 30  # parts of a model that the page lists
MAX_MEETINGS = 50  # close encounters that the page lists


def write_judgement(
    judgement: Judgement, name: str, facts: Mapping[str, Any], folder: Path
) -> Path:
    """Write judge.html, judge.json and the tables; returns the page."""
    write(folder / "judge.json", json.dumps(as_json(judgement), indent=1) + "\n")
    write(folder / "integrators.csv", as_csv(judgement.table))
    write(folder / "parts.csv", as_csv(judgement.parts))
    return write(folder / "judge.html", page_html(judgement, name, facts))


def as_json(judgement: Judgement) -> dict[str, Any]:
    """The findings as values for `json`; a number that is not finite is None."""
    fields = ("passed", "truth_agreement", "trusted_until", "engines", "notes", "own", "own_errors",
              "parts", "table", "recommended", "encounters", "horizons")  # fmt: skip
    return plain(
        {
            "model": judgement.problem.name,
            "duration": judgement.duration,
            "error": judgement.error,
            "truth": judgement.source.label,
            **{name: getattr(judgement, name) for name in fields},
            "sources": [
                {
                    "source": agreement.source.label,
                    "largest": agreement.largest,
                    "until": agreement.t[-1],
                    "stopped": agreement.stopped,
                }
                for agreement in judgement.agreements
            ],
            "summary": sentences(judgement),
        }
    )


def plain(value: Any) -> Any:
    """A value in the types that `json` writes; a number that is not finite becomes None."""
    if isinstance(value, pd.DataFrame):
        value = value.to_dict("records")
    if isinstance(value, Mapping):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    value = value.item() if hasattr(value, "dtype") else value
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value


def page_html(judgement: Judgement, name: str, facts: Mapping[str, Any]) -> str:
    """The HTML of the page; `name` is the model's file, `facts` its provenance."""
    environment = Environment(
        loader=FileSystemLoader(TEMPLATE_FOLDER),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
    )
    environment.globals.update(readable=readable, seconds=seconds, table=table)
    return environment.get_template("judge.html.j2").render(
        css=Markup((TEMPLATE_FOLDER / "judge.css").read_text(encoding="utf-8")),
        name=name,
        facts=facts,
        judgement=judgement,
        sentences=sentences(judgement),
        pictures=[Markup(svg) for svg in pictures(judgement)],
        best=judgement.table.drop_duplicates("integrator"),  # the first is the best of each
        parts=judgement.parts.sort_values("largest_error", ascending=False),
        most_parts=MAX_PARTS,
        most_meetings=MAX_MEETINGS,
        part=judgement.kind.PART,
        length=judgement.kind.unit(judgement.problem, "length").strip(),
        time=judgement.kind.unit(judgement.problem, "time").strip(),
        at=partial(time_text, judgement.truth),
        until=lambda t: "beyond the end" if math.isnan(t) else time_text(judgement.truth, t),
        rebuilt=isinstance(judgement.problem.system, NBody),
    )


def table(
    rows: pd.DataFrame,
    caption: str,
    formats: Mapping[str, Callable[[float], str]],
    **headings: str,
) -> Markup:
    """The table as HTML; a column without an entry in `headings` has its name, in words, as
    heading."""
    names = {column: headings.get(column, column.replace("_", " ")) for column in rows}
    text, kinds = readable_table(rows, names, formats)
    return html_table(text, caption, kinds)


def junit_suites(
    judgement: Judgement, path: Path, error: float | None
) -> Mapping[str, Sequence[JUnitCase]]:
    """One suite, named after the file, with a case for the user's own run and one for the truth.

    The case of the truth is "skipped" if no second source confirms it to within the error.

    Parameters
    ----------
    error
        largest acceptable error; None for no limit, and then the run's case is "skipped"
    """
    file, text = path.name, " ".join(own_run(judgement))
    length = judgement.kind.unit(judgement.problem, "length")
    bound = "its error" if error is None else f"an error of at most {readable(error)}{length}"
    name = f"{judgement.own['integrator']}: {bound}"
    run_seconds = judgement.own["seconds"] if math.isfinite(judgement.own["seconds"]) else 0.0
    outcome: Outcome = "passed" if judgement.passed else "failure"
    if error is None:
        run = JUnitCase(file, name, run_seconds, "skipped", "No --error was asked for.", text)
    else:
        run = JUnitCase(file, name, run_seconds, outcome, "" if judgement.passed else text, text)
    text, name = truth(judgement), "the truth is confirmed by a second source"
    if judgement.truth_agreement <= judgement.error and math.isinf(judgement.trusted_until):
        source = JUnitCase(file, name, 0.0, "passed", "", text)
    else:
        source = JUnitCase(file, name, 0.0, "skipped", text, text)
    cases_and_numbers = (
        (run, judgement.own["error"], error, judgement.source.label),
        (source, judgement.truth_agreement, judgement.error, ", ".join(judgement.engines)),
    )
    location = path_in_repository(str(path)), 0
    cases = [
        replace(
            case,
            defined_at=location,
            properties=(
                (
                    "measured",
                    f"{plain_number(measured)}{length}" if is_finite(measured) else "nothing",
                ),
                ("bound", f"at most {plain_number(limit)}{length}" if is_finite(limit) else "none"),
                ("verdict", case.outcome),
                ("source", engines),
                ("reason", case.details),
            ),
        )
        for case, measured, limit, engines in cases_and_numbers
    ]
    return {file: cases}
