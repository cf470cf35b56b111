"""Run the studies that have sections on the page."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import partial

import pandas as pd

from reports.results.cache import BuildCache, Study, not_run
from reports.results.options import Options
from reports.results.section import Section
from reports.results.suite import Suite

STUDIES_FOLDER = "studies"  # subfolder of the report for rows of the long forms


@dataclass(frozen=True, eq=False)
class SectionResult:
    """A study with its rows.

    Attributes
    ----------
    table
        its rows, including those of the long form; None if there are none
    note
        a sentence on the long form, or on the missing engine without which it cannot run; or ""
    failure
        a sentence on the exception that it raised, or ""
    """

    section: Section
    table: pd.DataFrame | None
    note: str = ""
    failure: str = ""


def section_studies(sections: Iterable[Section], quick: bool) -> list[Study]:
    """The default forms of these studies; the names of their results are the sections' titles."""
    return [
        Study(section.title, "study", section.title, partial(section.measure, quick), section.timed)
        for section in sections
    ]


def runnable(sections: Sequence[Section]) -> list[Section]:
    """The studies whose engines are installed; the others are named on stderr, with the reason."""
    for section in sections:
        if absence := section.absent():
            print_progress(f"{section.title}: will not run. {absence}")
    return [section for section in sections if not section.absent()]


def measure_sections(
    suite: Suite,
    options: Options,
    sections: Sequence[Section],
    cache: BuildCache | None = None,
) -> list[SectionResult]:
    """Measure each study in its default form, and add the stored rows of its long form.

    A study whose engine is missing is not run; that is not a failure.
    """
    cache = cache or BuildCache()
    available = [section for section in sections if not section.absent()]
    errors = cache.measure(section_studies(available, options.quick))
    section_results = []
    for section in sections:
        cached, note = cache.entries.get(section.title), section.absent()
        tables = [_with_run(cached.table, suite, options, cached.run)] if cached else []
        if section.long_form is not None:
            tables.append(section.long_form.stored(options.out / STUDIES_FOLDER, print_progress))
            if not (len(tables[-1]) or note):
                note = "Short version: make studies runs the long one."
        tables = [table for table in tables if len(table)]
        rows = pd.concat(tables, ignore_index=True) if tables else None
        error = errors.get(section.title)
        failure = not_run(section.title, error) if error else ""
        section_results.append(SectionResult(section, rows, note, failure))
    return section_results


def _with_run(table: pd.DataFrame, suite: Suite, options: Options, run: str) -> pd.DataFrame:
    """The table with the commit and date of its run in those columns, if it has them.

    `run` is the start date of the run; "" for this run.
    """
    origin = suite.provenance(options.command)
    commit, plus, dirty = origin.get("commit", "").partition("+")
    run_columns = {
        "commit": f"{commit[:12]}{plus}{dirty}",
        "date": (run or origin.get("date", "")).partition(" ")[0],
    }
    return table.assign(**{name: text for name, text in run_columns.items() if name in table})


def print_progress(text: str) -> None:
    """Print on stderr."""
    print(text, file=sys.stderr)
