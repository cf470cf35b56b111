"""The section on errors and times promised by `galvi.recommend`, and those measured."""

from __future__ import annotations

from functools import partial

from benchmarks.studies.recommendation import EXPLANATION, recommendation_table
from reports.results.section import Section
from reports.tables.study_table import readable_table

HEADINGS = {
    "problem": "problem",
    "asked": "error asked",
    "measured_over": "measured over",
    "degree": "degree",
    "step": "step",
    "predicted": "predicted",
    "found": "found",
    "evaluations": "force evaluations",
    "seconds": "time [s]",
    "scan_seconds": "time of the scan [s]",
    "promise": "promise",
}

RECOMMENDATION = Section(
    name="recommendation",
    title="Which degree and step for an error: promises and findings",
    text=EXPLANATION,
    measure=recommendation_table,
    table=partial(readable_table, headings=HEADINGS),
    compared=True,
    timed=True,
)
